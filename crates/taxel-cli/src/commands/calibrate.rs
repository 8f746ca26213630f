//! `taxel calibrate`: from labelled presses to a sensor file with everything a parts list does not say.

mod live;
mod pairs;
mod series;
mod totals;
mod uniform;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::ValueEnum;
use taxel::Sensor;
use taxel::calibrate::{Calibration, CalibrationOptions, CalibrationReport, LawChoice};
use taxel_io::{Press, recordings_named_in, recordings_of};
use taxel_plot::Format;

use super::positive::positive;
use crate::error::Error;
use crate::outputs::{Files, check_ending, check_sensor_ending};
use crate::progress::{Progress, Terminal};
use crate::{Exit, out, recorded};
use taxel_app::calibration_certificate::{self, CalibrationOrigin};
use taxel_app::executor::Threads;
use taxel_app::frames::carries_sensor;
use taxel_app::session::time_stamp;
use taxel_app::{calibration_picture, fingerprint, presses, residuals, sensor_source};

/// Fit switch resistances and load law to labelled presses
///
/// Reads the parts list (sensor.toml) and presses of known load, and writes the sensor file with the fitted
/// numbers, their origin and their errors. The report goes to standard output. The error reported is of presses held out: of
/// those that neither fitted nor chose what judges them; where that can't be had, the report says who chose. Ends with
/// code 3 where the file is written but should not be used as it is, and where labels were left out because the others
/// contradict them. With --totals, the load law alone, by what all taxels carry together. With --series, also what the material
/// remembers: creep and hysteresis. With --live it says which taxel to press
/// with what, on a page or with --terminal, sees by itself that the press stands, and ends with a certificate: docs/calibrate.md.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file (the parts list), or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    #[arg(long, value_name = "FILE", required_unless_present_any = ["pairs", "series", "equilibration", "totals", "live"])]
    presses: Option<PathBuf>,
    /// Frames under the same load everywhere: CSV with recording, frame, load_g; without presses they tell law and gains alone
    #[arg(long, value_name = "FILE", conflicts_with = "pairs")]
    equilibration: Option<PathBuf>,
    /// Fit the load law alone, to pairs of conductance (or resistance) and load
    #[arg(long, value_name = "FILE", conflicts_with = "presses")]
    pairs: Option<PathBuf>,
    /// Frames of known total load (a scale below, a person's weight): CSV with recording, frame, load_g (0: empty), perhaps group; tell the law alone
    #[arg(long, value_name = "FILE", conflicts_with_all = ["presses", "pairs", "equilibration", "series"])]
    totals: Option<PathBuf>,
    /// Instead: a recording whose loads are known all the time, from rest; finds creep and hysteresis too
    #[arg(long, value_name = "FILE", requires = "loads", conflicts_with_all = ["presses", "pairs", "equilibration"])]
    series: Option<PathBuf>,
    /// The load of every taxel in every frame of the series, g
    #[arg(long, value_name = "FILE", requires = "series")]
    loads: Option<PathBuf>,
    /// Seconds between frames of the series, where it tells no times
    #[arg(long, value_name = "SECONDS", requires = "series", value_parser = positive)]
    period: Option<f64>,
    /// Lags (creep) to fit to the series
    #[arg(long, value_name = "N", default_value_t = 3, requires = "series", value_parser = clap::value_parser!(u8).range(0..=8))]
    lags: u8,
    /// Plays (hysteresis) to fit to the series
    #[arg(long, value_name = "N", default_value_t = 3, requires = "series", value_parser = clap::value_parser!(u8).range(0..=8))]
    plays: u8,
    /// Where to write the sensor with the best static law of the series, to compare with
    #[arg(long, value_name = "FILE", requires = "series")]
    static_output: Option<PathBuf>,
    /// Where to write the calibrated sensor
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The load law; `auto` leaves the power law only where presses clearly tell another
    #[arg(long, value_enum, default_value_t)]
    law: Law,
    /// Fit one switch resistance per line, even without equilibration frames
    #[arg(long)]
    per_line: bool,
    /// Fit the amplifier's open-loop gain
    #[arg(long)]
    fit_gain: bool,
    /// Fit the source resistor
    #[arg(long)]
    fit_source: bool,
    /// Look for resistance along the lines on large arrays as well (minutes)
    #[arg(long, conflicts_with_all = ["pairs", "series"])]
    line_resistance: bool,
    /// What the labelled loads themselves are off by, such as 2% or 0.02: taken out of what the sensor is uncertain by
    #[arg(long, value_name = "SHARE", value_parser = share, default_value = "0", conflicts_with_all = ["pairs", "series"])]
    label_error: f64,
    /// Where to write what is read of each press beside its label, by fits without it and by the fit of all (.csv)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["pairs", "series"])]
    residuals: Option<PathBuf>,
    /// Where to draw residuals, how many their intervals hold, gain of each taxel and load law (.png, .svg, .pdf)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["pairs", "series"])]
    picture: Option<PathBuf>,
    /// Where to write the certificate: how far off it is, by what, and of which files (.html, .pdf)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["pairs", "series", "totals", "live"])]
    certificate: Option<PathBuf>,
    /// Folds of the cross-validation by press; of --totals that are all one load, stretches of frames held out
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..))]
    folds: u16,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    live: live::LiveArgs,
}

/// The words of `--law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Law {
    /// The power law, or another that presses clearly tell
    #[default]
    Auto,
    /// Power law with offset
    Power,
    /// Power law of a load that saturates
    Saturating,
    /// Monotone spline
    Spline,
}

impl From<Law> for LawChoice {
    fn from(law: Law) -> Self {
        match law {
            Law::Auto => LawChoice::Auto,
            Law::Power => LawChoice::Power,
            Law::Saturating => LawChoice::Saturating,
            Law::Spline => LawChoice::Spline,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let format = check(args)?;
    if let Some(address) = &args.live.live {
        return live::run(args, address);
    }
    let sensor = sensor_of(args)?;
    recorded::needs_readings(&sensor)?;
    if let (Some(recording), Some(loads)) = (&args.series, &args.loads) {
        return series::run(args, &sensor, recording, loads);
    }
    if let Some(table) = &args.totals {
        return totals::run(args, &sensor, table);
    }
    let Some(table) = &args.presses else {
        return match &args.equilibration {
            Some(table) => uniform::run(args, &sensor, table),
            None => pairs::run(args, sensor),
        };
    };
    let (data, labelled) = presses::read_labelled(
        table,
        args.equilibration.as_deref(),
        args.transpose,
        &sensor,
        &Terminal,
    )?;
    let options = options_of(args, table);
    let progress = Progress::new("fitting");
    let mut show = |stage: &str, share| progress.stage(stage, share);
    let calibration = taxel::calibrate::calibrate_with(
        &sensor, &data, &options, &Threads, &mut show,
    )
    .map_err(|source| taxel_app::Error::InFile {
        file: table.clone(),
        source,
    })?;
    drop(progress);
    write(args, format, &calibration, &labelled)?;
    let report = &calibration.report;
    if args.json {
        out::json(report)?
    } else {
        out::result(&report.to_string())?
    }
    let exit = doubt(report, table, &labelled);
    out::note(&format!("wrote {}", args.output.display()));
    Ok(exit)
}

/// Refuses, before any work, what cannot be written. With it, what the picture is to be.
fn check(args: &Args) -> Result<Option<Format>, Error> {
    Files::default()
        .maybe_sensor(args.sensor.as_ref())
        .maybe_table("table of presses", args.presses.as_ref())
        .maybe_table("table of uniform loads", args.equilibration.as_ref())
        .maybe_table("table of totals", args.totals.as_ref())
        .maybe_input("table of pairs", args.pairs.as_ref())
        .maybe_input("recording", args.series.as_ref())
        .maybe_input("file of loads", args.loads.as_ref())
        .output("-o", &args.output)
        .maybe_output("--static-output", args.static_output.as_ref())
        .maybe_output("--residuals", args.residuals.as_ref())
        .maybe_output("--picture", args.picture.as_ref())
        .maybe_output("--certificate", args.certificate.as_ref())
        .check()?;
    if let Some(file) = &args.certificate {
        super::report::check_name(file)?;
    }
    check_sensor_ending("-o", &args.output)?;
    if let Some(file) = &args.residuals {
        check_ending("--residuals", file, &["csv"], "the table is text")?;
    }
    let format = args.picture.as_ref().map(Format::from_extension);
    let format = format.transpose()?;
    if let Some(file) = &args.static_output {
        check_sensor_ending("--static-output", file)?;
    }
    Ok(format)
}

/// The sensor, and beside it what else is asked for.
fn write(
    args: &Args,
    format: Option<Format>,
    calibration: &Calibration,
    labelled: &[Press],
) -> Result<(), Error> {
    out::file(&args.output, calibration.sensor.to_toml().as_bytes())?;
    if let Some(file) = &args.residuals {
        let text = residuals::table(&calibration.residuals, labelled);
        out::file(file, text.as_bytes())?;
        out::note(&format!("wrote {}", file.display()));
    }
    if let Some(file) = &args.certificate {
        let origin = origin_of(args)?;
        let footer = calibration_certificate::footer(&origin);
        let certificate = calibration_certificate::of(calibration, origin)?;
        super::report::write_signed(&certificate, file, footer)?;
    }
    if let (Some(file), Some(format)) = (&args.picture, format) {
        let picture = calibration_picture::of(calibration)?;
        out::file(file, &picture.render(format)?)?;
        out::note(&format!("wrote {}", file.display()));
    }
    Ok(())
}

/// What the calibration came from, for its certificate.
fn origin_of(args: &Args) -> Result<CalibrationOrigin, Error> {
    let mut origin = CalibrationOrigin::default();
    let files = [
        ("parts list", args.sensor.as_ref()),
        ("presses", args.presses.as_ref()),
        ("uniform loads", args.equilibration.as_ref()),
    ];
    for (what, file) in files {
        // A preset is no file; standard input is read already.
        if let Some(file) = file.filter(|file| file.is_file()) {
            let (_, print) = fingerprint::of_file(file)?;
            origin.files.push((what.to_owned(), print));
        }
    }
    Ok(origin)
}

/// Refuses what needs single presses; `why` these do without.
fn refuse_what_needs_presses(args: &Args, why: &str) -> Result<(), Error> {
    for (given, flag) in [
        (args.per_line, "--per-line"),
        (args.fit_gain, "--fit-gain"),
        (args.fit_source, "--fit-source"),
        (args.line_resistance, "--line-resistance"),
        (args.residuals.is_some(), "--residuals"),
        (args.picture.is_some(), "--picture"),
        (args.certificate.is_some(), "--certificate"),
    ] {
        if given {
            return Err(Error::Arguments {
                what: format!("{flag} needs --presses: {why}"),
                hint: "leave it out, or label single presses",
            });
        }
    }
    Ok(())
}

fn options_of(args: &Args, table: &Path) -> CalibrationOptions {
    let beside = args
        .equilibration
        .as_deref()
        .filter(|other| *other != table);
    let names = [Some(table), beside];
    let names = names.iter().flatten();
    let mut options = CalibrationOptions::default();
    options.law = args.law.into();
    options.per_line = args.per_line;
    options.open_loop_gain = args.fit_gain;
    options.r_source = args.fit_source;
    options.line_resistance = args.line_resistance;
    options.label_share = args.label_error;
    options.folds = args.folds.into();
    options.date = today();
    options.files = names.map(|file| file.display().to_string()).collect();
    options
}

/// A share of one, or per cent.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let share = number.trim().parse().ok().map(|x: f64| x * unit);
    share
        .filter(|share| (0.0..0.5).contains(share))
        .ok_or_else(|| "a share from 0 to below a half is needed, such as 2% or 0.02".to_owned())
}

/// The sensor that is given, else the one that the recordings carry.
fn sensor_of(args: &Args) -> Result<Sensor, Error> {
    if let Some(file) = &args.sensor {
        let (sensor, _) = recorded::needed_sensor(Some(file), None)?;
        // What is read once is left to who reads it, and what is wrong with a table as well.
        let tables = [&args.presses, &args.equilibration, &args.totals];
        let can_be_read_twice = tables.into_iter().flatten().all(|table| table.is_file());
        let recordings = can_be_read_twice.then(|| named_recordings(args));
        for recording in recordings.and_then(Result::ok).unwrap_or_default() {
            recorded::doubt_other_sensor(&recording, &sensor, file);
        }
        return Ok(sensor);
    }
    let recordings = named_recordings(args)?;
    let mut carrying = recordings.iter().filter(|file| carries_sensor(file));
    let Some(first) = carrying.next() else {
        return Ok(recorded::needed_sensor(None, recordings.first().map(PathBuf::as_path))?.0);
    };
    let (sensor, _) = recorded::needed_sensor(None, Some(first))?;
    for other in carrying {
        if sensor_source::carried(other)?.is_some_and(|found| found.to_toml() != sensor.to_toml()) {
            return Err(Error::Arguments {
                what: format!(
                    "{} and {} carry different sensors",
                    first.display(),
                    other.display()
                ),
                hint: "--sensor says which is to be calibrated",
            });
        }
    }
    Ok(sensor)
}

/// The recordings that are calibrated by, as far as they are known before they are read.
fn named_recordings(args: &Args) -> Result<Vec<PathBuf>, Error> {
    let tables = args.presses.as_ref().or(args.equilibration.as_ref());
    Ok(match (&args.series, tables) {
        (None, None) => match &args.totals {
            Some(table) => recordings_named_in(table)?,
            None => Vec::new(),
        },
        (Some(recording), _) => vec![recording.clone()],
        // Standard input is read once.
        (None, Some(table)) if table.as_os_str() != "-" => recordings_of(table)?,
        _ => Vec::new(),
    })
}

/// Names labels that the others contradict, by their lines, and says what speaks against using the fit.
fn doubt(report: &CalibrationReport, table: &Path, labelled: &[Press]) -> Exit {
    for suspect in &report.suspects {
        out::warn(&format!(
            "{}, line {}: {suspect}",
            table.display(),
            labelled[suspect.press].line
        ));
    }
    for doubt in &report.doubts {
        out::warn(doubt);
    }
    if report.doubts.is_empty() && report.suspects.iter().all(|s| !s.left_out) {
        Exit::Good
    } else {
        Exit::DataLost
    }
}

/// The date in UTC, ISO 8601.
pub(super) fn today() -> String {
    let mut stamp = time_stamp(SystemTime::now());
    // The time of day follows the ten characters of the date.
    stamp.truncate(10);
    stamp
}
