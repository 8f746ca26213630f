//! `taxel measure`: forces of a recording over time, in all and by region, and what each trial amounts to.

mod picture;
mod report;

use std::path::{Path, PathBuf};

use taxel::Sensor;
use taxel::metric::CONTACT_NEWTONS;
use taxel::sensor::Region;
use taxel_io::write_columns;
use taxel_plot::Format;

use super::positive::positive;
use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::Terminal;
use crate::{Exit, out, recorded};
use report::Report;
use taxel_app::measure::{
    FoundKind, FoundRegions, Measured, Settings, TrialsBy, finds_regions,
    recording_regions_of_file, regions_to_toml,
};
use taxel_app::methods::MethodName;

/// Measure forces over time: total, grip, fingers; peak, plateau, fatigue of each trial
///
/// Frame by frame: total normal force with half of its 95 % interval, grip force (what a dynamometer shows, of sensors around a
/// handle), highest pressure, area, centre of pressure, the share of the taxels that was measured, and the same of each
/// named region. Trial by trial: largest force, time to it, rate of loading, impulse, plateau with its variation and slope. Loads
/// are not cut off at zero, so that noise adds up to nothing. Exit code 3: frames were left out, have no answer, or
/// readings at the end of the converter's range.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts (.mcap, .parquet, .txt, .csv, .npy, .npz)
    recording: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Where to write a line a frame (.csv, .parquet, .xlsx, .json)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where to write the forces over time as a picture (.png, .svg, .pdf)
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// File of named regions (.toml), or `auto`: palm, thumb and fingers of a hand, heel to toes of feet on a flat sensor, else
    /// contacts; `phalanges`: the same with each finger cut at its joints; without it those of the sensor file
    #[arg(long, value_name = "FILE|auto|phalanges")]
    regions: Option<PathBuf>,
    /// Where to write the regions that were found, to be renamed and redrawn (.toml)
    #[arg(long, value_name = "FILE", requires = "regions")]
    write_regions: Option<PathBuf>,
    /// Where trials begin and end: `force` (where it rises and falls), `marks` (set while it was recorded), `whole`, or from
    /// when to when, in seconds since the first frame
    #[arg(
        long,
        value_name = "force|marks|whole|FROM..TO,…",
        default_value = "force"
    )]
    trials: TrialsBy,
    /// A trial is where the total force is above this, newtons; without it above a tenth of the largest
    #[arg(long, value_name = "NEWTONS", value_parser = positive)]
    trial_force: Option<f64>,
    /// Length of the plateau, seconds; shorter in a trial that stays above half of its force for less than 8 s
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = positive)]
    plateau: f64,
    /// A taxel counts as touched above this, newtons: for area and centre of pressure
    #[arg(long, value_name = "NEWTONS", default_value_t = CONTACT_NEWTONS, value_parser = positive)]
    touched: f64,
    /// Seconds since the first frame in which nothing presses: their mean is taken off every taxel
    #[arg(long, value_name = "FROM..TO", value_parser = window)]
    zero: Option<Window>,
    /// Find no intervals: many times faster
    #[arg(long)]
    no_intervals: bool,
    /// Frames a second, in place of the times that the recording tells, or where it tells none
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", value_parser = positive)]
    frames_per_second: Option<f64>,
    /// How loads are found: auto (what suits the read-out), exact, newton, raw (no compensation), or the file of
    /// a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// Replace what was not measured by the median of its neighbours
    #[arg(long, conflicts_with = "no_repair")]
    repair: bool,
    /// Replace nothing, even if the sensor file asks for it: what was not measured is missing from the sums
    #[arg(long)]
    no_repair: bool,
    /// Leave the recording's tare on
    #[arg(long)]
    no_tare: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Threads that share the work, with the same results; as many as there are cores where it is not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// From when to when, seconds.
#[derive(Debug, Clone, Copy)]
struct Window([f64; 2]);

fn window(text: &str) -> Result<Window, String> {
    match text.parse::<TrialsBy>() {
        Ok(TrialsBy::Times(times)) if times.len() == 1 => Ok(Window(times[0])),
        _ => Err("must be seconds as 0..2, ending after it begins".to_owned()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let format = args.picture.as_deref().map(Format::from_extension);
    let format = format.transpose()?;
    check(args)?;
    let (sensor, sensor_file) =
        recorded::needed_sensor(args.sensor.as_deref(), Some(&args.recording))?;
    let settings = settings(args);
    let regions = regions(args, &settings, &sensor, &sensor_file)?;
    let measured = Measured {
        recording: &args.recording,
        sensor: &sensor,
        sensor_file: &sensor_file,
        regions: &regions,
    };
    let measurement = measured.measure(&settings, &Terminal, &|| false)?;
    let report = Report::new(args, &measured, &settings, &measurement);
    report.tell();
    if let Some(file) = &args.output {
        write_columns(file, &measurement.series.columns())?;
        out::note(&format!("wrote {}", file.display()));
    }
    if let (Some(file), Some(format)) = (&args.picture, format) {
        let picture = picture::forces(&args.recording, &sensor, &measurement)?;
        out::file(file, &picture.render(format)?)?;
        out::note(&format!("wrote {}", file.display()));
    }
    // Last: whoever reads may stop reading, and the files are to be whole.
    if args.json {
        out::json(&report)?;
    } else {
        out::result(&report.to_string())?;
    }
    Ok(if measurement.is_whole() {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// Those of a file, of the sensor file, or found.
fn regions(
    args: &Args,
    settings: &Settings,
    sensor: &Sensor,
    sensor_file: &Path,
) -> Result<Vec<Region>, Error> {
    let Some(file) = &args.regions else {
        return Ok(sensor.regions().to_vec());
    };
    if finds_regions(file).is_none() {
        return Ok(recording_regions_of_file(file, sensor)?);
    }
    let all = Measured {
        recording: &args.recording,
        sensor,
        sensor_file,
        regions: &[],
    };
    let found = all.find_regions(settings, &Terminal, &|| false)?;
    let regions = Region::of_recording(&found.regions, sensor)?;
    out::note(&words(&found, &regions));
    if let Some(file) = &args.write_regions {
        out::file(file, regions_to_toml(&found.regions).as_bytes())?;
        out::note(&format!("wrote {}", file.display()));
    }
    Ok(regions)
}

/// What was found, and how sure that is.
fn words(found: &FoundRegions, regions: &[Region]) -> String {
    let what = match found.kind {
        FoundKind::Hand => "a hand",
        FoundKind::Feet => "a footprint or more",
        _ => "no hand and no foot; regions",
    };
    let names: Vec<&str> = regions.iter().map(Region::name).collect();
    let least = regions
        .iter()
        .filter_map(Region::confidence)
        .reduce(f64::min);
    let sure = least.map_or(String::new(), |c| {
        format!(", with a confidence of {c} or more")
    });
    let moves = match found.windows {
        0 | 1 => String::new(),
        windows => format!("; it moves, and is cut into {windows} windows of time"),
    };
    let names = names.join(", ");
    format!("{what}{sure}: {names}{moves}; --write-regions keeps them to be looked at")
}

fn settings(args: &Args) -> Settings {
    let mut settings = Settings::default();
    settings.method = args.method.clone();
    settings.trials = args.trials.clone();
    settings.hold.threshold_newtons = args.trial_force;
    settings.hold.plateau_secs = args.plateau;
    settings.touched_newtons = args.touched;
    settings.intervals = !args.no_intervals;
    settings.zero = args.zero.map(|Window(secs)| secs);
    settings.frames_per_second = args.frames_per_second;
    settings.repair = (args.repair || args.no_repair).then_some(args.repair);
    settings.no_tare = args.no_tare;
    settings.transpose = args.transpose;
    settings.keep_going = args.keep_going;
    settings.threads = args.threads.map(usize::from);
    settings.phalanges = args.regions.as_deref().and_then(finds_regions) == Some(true);
    settings
}

/// Refuses, before any work, what cannot be written.
fn check(args: &Args) -> Result<(), Error> {
    if let Some(file) = &args.output {
        let hint = "a table is written as text, as a sheet, as Parquet or as JSON";
        check_ending("-o", file, &["csv", "parquet", "xlsx", "json"], hint)?;
    }
    let is_auto = args.regions.as_deref().and_then(finds_regions).is_some();
    if let Some(file) = &args.write_regions {
        check_ending(
            "--write-regions",
            file,
            &["toml"],
            "regions are kept as TOML",
        )?;
        if !is_auto {
            return Err(Error::Arguments {
                what: "--write-regions writes what `--regions auto` finds".to_owned(),
                hint: "a file of regions is there already",
            });
        }
    }
    Files::default()
        .input("recording", &args.recording)
        .maybe_sensor(args.sensor.as_ref())
        .maybe_input("regions", args.regions.as_ref().filter(|_| !is_auto))
        .maybe_input("model", args.method.file().as_ref())
        .maybe_output("-o", args.output.as_ref())
        .maybe_output("--picture", args.picture.as_ref())
        .maybe_output("--write-regions", args.write_regions.as_ref())
        .check()
}
