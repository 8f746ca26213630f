//! `taxel analyse`: values over time of some taxels of a recording, before and after screening.

mod place;
mod series;

use std::path::PathBuf;

use serde::Serialize;
use taxel::Sensor;
use taxel::evaluate::creep::MIN_DRIFT_SECS;
use taxel::stats::Line as Straight;
use taxel::stats::{mean, standard_deviation};
use taxel_io::{Column, ReadOptions, shape_of, write_columns};
use taxel_plot::report::{Cell, Table};
use taxel_plot::{Format, Line, LineStyle, Series, cells};

use super::positive::{lines, positive};
use super::taxel_address::TaxelAddress;
use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::values;
use crate::{Exit, out, recorded};
use place::{RegionWanted, Wanted};
use series::{Taken, take};
use taxel_app::measure::recording_regions_of_file;
use taxel_app::methods::MethodName;
use taxel_app::units::Unit;

/// Taxels whose lines stand in the table one by one.
const LISTED: usize = 20;
/// Lines that a picture shows at most; of a larger region, the mean.
const DRAWN: usize = 128;

/// Look at taxels of a recording over time: a taxel, a row, a column, a region
///
/// Values before and after screening, the share that is filtered, mean, standard deviation and drift; a plot and a table for a
/// spreadsheet on request. Reads every format that the program reads. Labels as on the rig's table (C7: column C, row 7)
/// follow the sensor file's `labels`. Exit code 3: frames were left out, or the recording tells of frames that are
/// missing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording (.mcap, .parquet, .txt, .csv, .npy, .npz)
    recording: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// A taxel: its row and column from 0, or its label; several are several lines
    #[arg(long, value_name = "ROW,COLUMN|C7", required_unless_present_any = ["row", "column", "region"])]
    taxel: Vec<TaxelAddress>,
    /// All taxels of a row
    #[arg(long, value_name = "N", conflicts_with_all = ["column", "region"])]
    row: Option<usize>,
    /// All taxels of a column
    #[arg(long, value_name = "N", conflicts_with = "region")]
    column: Option<usize>,
    /// All taxels of a region: rows, columns, ends included; or the name of one of the sensor file, or of --regions
    #[arg(long, value_name = "R..R,C..C|NAME")]
    region: Option<RegionWanted>,
    /// Named regions (.toml): a [[region]] each, as in a sensor file; without it those of the sensor file
    #[arg(
        long,
        value_name = "FILE",
        requires = "region",
        conflicts_with = "rows"
    )]
    regions: Option<PathBuf>,
    /// Unit of the values; other than counts they need a sensor
    #[arg(long, value_parser = values::unit())]
    unit: Option<Unit>,
    /// How loads are found: auto, exact, newton, raw, or the file of a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t, requires = "unit")]
    method: MethodName,
    /// Rows of a frame, where there is no sensor
    #[arg(long, value_name = "N", conflicts_with = "sensor", value_parser = lines)]
    rows: Option<usize>,
    /// Frames a second, where the recording tells no times
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", value_parser = positive)]
    frames_per_second: Option<f64>,
    /// Where to write a plot (.png, .svg, .pdf)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where to write the values: before screening, and after it with empty cells for what is filtered (.csv, .xlsx, .parquet)
    #[arg(long, value_name = "FILE")]
    export: Option<PathBuf>,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// Leave the recording's tare on
    #[arg(long)]
    no_tare: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Everything that is printed.
#[derive(Debug, Serialize)]
struct Report {
    file: String,
    unit: &'static str,
    frames: usize,
    /// Readings that are filtered, % of all.
    filtered_percent: f64,
    taxels: Vec<Figures>,
    skipped_frames: usize,
}

/// What is said of one taxel, or of the mean of many.
#[derive(Debug, Serialize)]
struct Figures {
    name: String,
    readings: usize,
    filtered_percent: f64,
    least: f64,
    most: f64,
    /// Of all readings.
    mean_before: f64,
    standard_deviation_before: f64,
    /// Of those that are not filtered.
    mean: f64,
    standard_deviation: f64,
    /// Of those that are not filtered, in % of their mean; an hour where there are times, else a hundred frames. None of
    /// less than a minute: what seconds do says nothing of an hour.
    drift_percent: Option<f64>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let format = args
        .output
        .as_deref()
        .map(Format::from_extension)
        .transpose()?;
    check(args)?;
    let carried = args.rows.is_none().then_some(args.recording.as_path());
    let sensor = recorded::sensor(args.sensor.as_deref(), carried)?;
    let sensor = sensor.map(|(sensor, _)| sensor);
    if let (Some(unit), None) = (args.unit, &sensor) {
        return Err(Error::Arguments {
            what: format!(
                "--unit {} needs a sensor: the recording holds counts",
                unit.word()
            ),
            hint: "--sensor takes a sensor file or the name of a preset",
        });
    }
    let options = options(args, sensor.as_ref())?;
    let labels = sensor
        .as_ref()
        .and_then(|sensor| sensor.array().labels.clone());
    let regions = match (&sensor, &args.regions) {
        (Some(sensor), Some(file)) => recording_regions_of_file(file, sensor)?,
        (Some(sensor), None) => sensor.regions().to_vec(),
        (None, _) => Vec::new(),
    };
    let wanted = Wanted {
        taxels: &args.taxel,
        row: args.row,
        column: args.column,
        region: args.region.as_ref(),
        regions: &regions,
    };
    wanted.tell_if_it_moves()?;
    let places = wanted.places(options.rows, options.columns, labels.as_deref())?;
    let taken = take(args, sensor.as_ref(), options, &places)?;
    let report = report(args, &taken);
    if let Some(file) = &args.export {
        write_columns(file, &columns(&taken))?;
        out::note(&format!("wrote {}", file.display()));
    }
    if let (Some(file), Some(format)) = (&args.output, format) {
        out::file(file, &picture(args, &taken, &report)?.render(format)?)?;
        out::note(&format!("wrote {}", file.display()));
    }
    for skipped in &taken.skipped {
        out::warn(skipped);
    }
    // Last: whoever reads may stop reading, and the files are to be whole.
    if args.json {
        out::json(&report)?
    } else {
        out::result(&text(&report, &taken))?
    }
    let is_missing = recorded::tell_missing(&args.recording, &taken.integrity);
    Ok(if taken.skipped_frames == 0 && !is_missing {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// Refuses, before any work, what cannot be written.
fn check(args: &Args) -> Result<(), Error> {
    if let Some(file) = &args.export {
        check_ending(
            "--export",
            file,
            &["csv", "xlsx", "parquet"],
            "a table is written as text, as a sheet or as Parquet",
        )?;
    }
    Files::default()
        .input("recording", &args.recording)
        .maybe_sensor(args.sensor.as_ref())
        .maybe_input("model", args.method.file().as_ref())
        .maybe_output("-o", args.output.as_ref())
        .maybe_output("--export", args.export.as_ref())
        .check()
}

fn options(args: &Args, sensor: Option<&Sensor>) -> Result<ReadOptions, Error> {
    let mut options = match sensor {
        Some(sensor) => ReadOptions::of(sensor),
        None => {
            let guess = shape_of(&args.recording)?;
            let rows = args.rows.or(guess.rows).ok_or_else(|| Error::Arguments {
                what: format!(
                    "{} does not say how many rows a frame has",
                    args.recording.display()
                ),
                hint: "give --sensor or --rows",
            })?;
            let columns = guess.columns.unwrap_or(1);
            if args.transpose {
                ReadOptions::new(columns, rows)
            } else {
                ReadOptions::new(rows, columns)
            }
        }
    };
    options.transpose = args.transpose;
    options.keep_going = args.keep_going;
    options.accept_damage = true;
    Ok(options)
}

fn report(args: &Args, taken: &Taken) -> Report {
    let taxels: Vec<Figures> = (0..taken.names.len()).map(|i| figures(taken, i)).collect();
    let filtered = taken
        .marked
        .iter()
        .flatten()
        .filter(|&&marked| marked)
        .count();
    let all = taken.frames() * taken.names.len();
    Report {
        file: args.recording.display().to_string(),
        unit: args.unit.map_or("counts", Unit::symbol),
        frames: taken.frames(),
        filtered_percent: percent(filtered, all),
        taxels,
        skipped_frames: taken.skipped_frames,
    }
}

fn percent(part: usize, all: usize) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

fn figures(taken: &Taken, taxel: usize) -> Figures {
    let (values, marked) = (&taken.values[taxel], &taken.marked[taxel]);
    let good: Vec<(f64, f64)> = (0..values.len())
        .filter(|&n| !marked[n])
        .map(|n| (taken.position(n), values[n]))
        .collect();
    let kept: Vec<f64> = good.iter().map(|p| p.1).collect();
    let (mean, standard_deviation) = mean_and_deviation(&kept);
    let (mean_before, standard_deviation_before) = mean_and_deviation(values);
    // An hour of seconds, or a hundred frames.
    let (span, least) = match taken.secs {
        Some(_) => (3600.0, MIN_DRIFT_SECS),
        None => (100.0, 0.0),
    };
    let length = good
        .last()
        .zip(good.first())
        .map_or(0.0, |(z, a)| z.0 - a.0);
    let drift = Straight::fit(&good)
        .filter(|_| length >= least)
        .map(|line| 100.0 * span * line.slope / mean.abs());
    Figures {
        name: taken.names[taxel].clone(),
        readings: values.len(),
        filtered_percent: percent(marked.iter().filter(|&&m| m).count(), values.len()),
        least: values.iter().copied().fold(f64::INFINITY, f64::min),
        most: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        mean_before,
        standard_deviation_before,
        mean,
        standard_deviation,
        drift_percent: drift.filter(|drift| drift.is_finite()),
    }
}

/// Mean, and standard deviation; NaN of too few.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let mean = mean(values.iter().copied());
    (
        mean.unwrap_or(f64::NAN),
        standard_deviation(values).unwrap_or(f64::NAN),
    )
}

fn text(report: &Report, taken: &Taken) -> String {
    let drift = match taken.secs {
        Some(_) => "drift, %/h",
        None => "drift, %/100 frames",
    };
    let mut table = Table::new(
        format!(
            "{}: {} frames, {} {}, {}; {:.2} % filtered",
            report.file,
            report.frames,
            report.taxels.len(),
            if report.taxels.len() == 1 {
                "taxel"
            } else {
                "taxels"
            },
            report.unit,
            report.filtered_percent
        ),
        &[
            "taxel",
            "filtered, %",
            "least",
            "most",
            "mean before",
            "SD before",
            "mean",
            "SD",
            drift,
        ],
    );
    for of in report.taxels.iter().take(LISTED) {
        table.push(cells![
            of.name.as_str(),
            of.filtered_percent,
            of.least,
            of.most,
            of.mean_before,
            of.standard_deviation_before,
            of.mean,
            of.standard_deviation,
            of.drift_percent,
        ]);
    }
    let mut text = table.to_string();
    if report.taxels.len() > LISTED {
        let more = report.taxels.len() - LISTED;
        text += &format!("  and {more} more; --json and --export have them all\n");
    }
    text
}

/// Frame, time, and of every taxel its values before and after screening.
fn columns(taken: &Taken) -> Vec<Column> {
    let column = |name: String, values: Vec<f64>| Column { name, values };
    let frames = taken.sequence.iter().map(|&n| n as f64).collect();
    let mut columns = vec![column("frame".to_owned(), frames)];
    columns.extend(
        taken
            .secs
            .clone()
            .map(|secs| column("time_secs".to_owned(), secs)),
    );
    for (name, (values, marked)) in taken
        .names
        .iter()
        .zip(taken.values.iter().zip(&taken.marked))
    {
        columns.push(column(name.clone(), values.clone()));
        columns.push(column(
            format!("{name}, screened"),
            screened(values, marked),
        ));
    }
    columns
}

fn screened(values: &[f64], marked: &[bool]) -> Vec<f64> {
    let each = values.iter().zip(marked);
    each.map(|(&value, &marked)| if marked { f64::NAN } else { value })
        .collect()
}

fn picture(args: &Args, taken: &Taken, report: &Report) -> Result<taxel_plot::Picture, Error> {
    let (x_label, x) = match &taken.secs {
        Some(secs) => ("time (s)", secs.clone()),
        None => ("frame", taken.sequence.iter().map(|&n| n as f64).collect()),
    };
    let mut lines = Vec::new();
    if taken.names.len() <= DRAWN {
        for (name, (values, marked)) in taken
            .names
            .iter()
            .zip(taken.values.iter().zip(&taken.marked))
        {
            lines.push(Line::new(name.clone(), screened(values, marked)));
        }
    } else {
        lines.push(Line::new(
            format!("mean of {} taxels", taken.names.len()),
            taken.mean_screened(),
        ));
    }
    // Of one taxel, what was filtered is shown too.
    if let ([values], [marked]) = (&taken.values[..], &taken.marked[..])
        && marked.contains(&true)
    {
        let away = values.iter().zip(marked);
        let away = away
            .map(|(&value, &marked)| if marked { value } else { f64::NAN })
            .collect();
        lines.push(
            Line::new("filtered", away)
                .style(LineStyle::Points)
                .colour(3),
        );
    }
    let (quantity, unit) = match args.unit {
        Some(unit) => (unit.quantity(), unit.symbol()),
        None => ("reading", "counts"),
    };
    let title = format!(
        "{}, {} filtered",
        args.recording
            .file_name()
            .unwrap_or_default()
            .to_string_lossy(),
        Cell::from(report.filtered_percent).to_string() + " %"
    );
    let series = Series::new(x_label, x, lines)?;
    Ok(series
        .title(title)
        .quantity(quantity)
        .unit(unit)
        .order("taxel")
        .picture()?)
}
