//! `taxel selftest`: what must be soldered.

mod live;
mod report;

use std::path::{Path, PathBuf};

use clap::ArgGroup;
use taxel::selftest::{SelfTest, SelfTestOptions, SelfTestResult, Unusable};
use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;
use taxel_io::{FrameSource, ReadOptions, open_counts};
use taxel_plot::{FaultMap, Format};

use super::positive::positive;
use crate::error::Error;
use crate::outputs::Files;
use crate::progress::Progress;
use crate::{Exit, out, recorded};
use report::Report;
use taxel_app::frames::show;
use taxel_app::sensor_source;
use taxel_io::sensor_file;

/// Test a sensor: open, shorted, stuck, noisy and flickering lines and taxels
///
/// From a recording without a load and one of a hand rubbed over the whole mat, or live, asking for both. Looks for
/// settling that is too short, mains hum and converter codes that never occur as well, and lists what to solder, the
/// most taxels first. docs/selftest.md says what each test does. Exit code 3: something was found.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("from").required(true).args(["empty", "live"]))]
pub(crate) struct Args {
    /// Recording of the sensor without a load (.mcap, .parquet, .txt, .csv, .npy, .npz)
    #[arg(long, value_name = "FILE", requires = "rubbed")]
    empty: Option<PathBuf>,
    /// Recording of a hand rubbed over the whole mat
    #[arg(long, value_name = "FILE", requires = "empty")]
    rubbed: Option<PathBuf>,
    /// Record both from here: serial:/dev/ttyACM0?baud=2000000, udp:0.0.0.0:9000, tcp:host:port, rpi:board.toml,
    /// sim:econe?blobs
    #[arg(long, value_name = "ADDRESS")]
    live: Option<Address>,
    /// Sensor file, or the name of a preset; simulated sensors and .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Where to draw the array with what was found (.png, .svg, .pdf)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How long each of the two live recordings is
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = positive, requires = "live")]
    seconds: f64,
    /// Where the two live recordings stay, as empty.mcap and rubbed.mcap; without it they are removed
    #[arg(long, value_name = "FOLDER", requires = "live")]
    keep: Option<PathBuf>,
    /// Begin without waiting for Enter
    #[arg(long, requires = "live")]
    yes: bool,
    /// Frames a second, for recordings without times (for mains hum)
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", value_parser = positive, conflicts_with = "live")]
    frames_per_second: Option<f64>,
    /// The recordings have rows and columns swapped
    #[arg(long, conflicts_with = "live")]
    transpose: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    // Before any work: a name that is no picture's.
    let format = args.output.as_ref().map(Format::from_extension);
    let format = format.transpose()?;
    Files::default()
        .maybe_input("recording", args.empty.as_ref())
        .maybe_input("recording", args.rubbed.as_ref())
        .maybe_sensor(args.sensor.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .check()?;
    let (sensor, result) = match (&args.live, &args.empty, &args.rubbed) {
        (Some(address), _, _) => {
            let (sensor, file) = sensor_source::of(address, args.sensor.as_deref())?;
            let recordings = live::record(args, address, &sensor, &file)?;
            let result = test(args, &sensor, &recordings.empty, &recordings.rubbed)?;
            (sensor, result)
        }
        (None, Some(empty), Some(rubbed)) => {
            let sensor = match &args.sensor {
                Some(file) => sensor_file::load(file)?,
                None => sensor_source::of_recording(empty)?.0,
            };
            recorded::needs_readings(&sensor)?;
            let result = test(args, &sensor, empty, rubbed)?;
            (sensor, result)
        }
        _ => {
            return Err(Error::Arguments {
                what: "a self-test takes two recordings".to_owned(),
                hint: "give --empty and --rubbed, or --live",
            });
        }
    };
    let report = Report::new(&sensor, &result);
    if let (Some(file), Some(format)) = (&args.output, format) {
        let map = FaultMap::of(&result).title(report.title());
        let picture = map.pitch_mm(sensor.array().pitch_mm).picture();
        out::file(file, &picture.render(format)?)?;
        out::note(&format!("wrote {}", file.display()));
    }
    // Last: whoever reads may stop reading, and the picture is to be whole.
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    Ok(if result.is_good() {
        Exit::Good
    } else {
        Exit::Found
    })
}

/// Both recordings, once each and frame by frame.
fn test(
    args: &Args,
    sensor: &Sensor,
    empty: &Path,
    rubbed: &Path,
) -> Result<SelfTestResult, Error> {
    let mut options = SelfTestOptions::of(sensor);
    options.frames_per_second = args.frames_per_second;
    let mut test = SelfTest::new(
        sensor.rows(),
        sensor.columns(),
        sensor.max_count(),
        &options,
    )
    .with_circuit(sensor);
    pass(args, sensor, empty, |frame| test.observe_empty(frame))?;
    pass(args, sensor, rubbed, |frame| test.observe_rubbed(frame))?;
    test.finish().map_err(|why| unusable(&why, empty, rubbed))
}

fn pass(
    args: &Args,
    sensor: &Sensor,
    file: &Path,
    mut see: impl FnMut(&Frame<Counts>) -> Result<(), taxel::Error>,
) -> Result<(), Error> {
    let mut options = ReadOptions::of(sensor);
    options.transpose = args.transpose;
    let mut source = open_counts(file, options)?;
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    let progress = Progress::new("testing");
    while source.next_into(&mut frame)? {
        see(&frame)?;
        show(&source, &progress);
    }
    Ok(())
}

/// Says which file cannot be tested.
fn unusable(why: &Unusable, empty: &Path, rubbed: &Path) -> Error {
    let file = match why {
        Unusable::LoadInEmpty { .. } => empty,
        Unusable::TooFewFrames { recording, .. } if *recording == "empty" => empty,
        _ => rubbed,
    };
    let text = why.to_string();
    let what = text.split("\nhint: ").next().unwrap_or_default();
    Error::Arguments {
        what: format!("{}: {what}", file.display()),
        hint: why.hint(),
    }
}
