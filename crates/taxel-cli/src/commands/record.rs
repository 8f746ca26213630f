//! `taxel record`: from a source to a file, without a viewer.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use taxel_acquire::Address;
use taxel_acquire::transport::State;

use super::positive::positive;
use crate::error::Error;
use crate::outputs::check_ending;
use crate::{Exit, interrupt, out, recorded};
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{RecordTopics, SavedRecording, Session, SessionOptions};

/// Record a sensor
///
/// Raw counts always, with the device's and the host's time, and the sensor file; on request the compensated loads.
/// Ctrl-C ends the recording. Exit code 3: frames were lost, corrupt, or the recording ended early; 1: no frame came,
/// and no file is left.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where frames come from: serial:/dev/ttyACM0?baud=2000000, udp:0.0.0.0:9000, tcp:host:port, file:run.txt,
    /// stdin:, sim:econe?hand
    address: Address,
    /// Where to write (.mcap); an existing file is never overwritten
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Sensor file, or the name of a preset; simulated sensors and .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// How loads are found
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Record the compensated loads too
    #[arg(long)]
    loads: bool,
    /// Record the loads as images and the total as a wrench besides, which ROS 2 and Rerun know
    #[arg(long, requires = "loads")]
    images: bool,
    /// Record total force, peak pressure, contact area and centre of pressure too
    #[arg(long)]
    figures: bool,
    /// Keep in the header of what is written what a file of another program says of persons, and names of files; left out else
    #[arg(long)]
    with_names: bool,
    /// End after this many seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    secs: Option<f64>,
    /// End after this many frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
}

const LOOK: Duration = Duration::from_millis(20);
/// About thirty years.
const MAX_SECS: f64 = 1e9;
/// A source that says nothing for this long is told of.
const SILENCE: Duration = Duration::from_secs(10);

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if args
        .secs
        .is_some_and(|secs| !(secs > 0.0 && secs <= MAX_SECS))
    {
        return Err(Error::Arguments {
            what: format!("--secs {}: no time", args.secs.unwrap_or_default()),
            hint: "a number above 0",
        });
    }
    check_recording("-o", &args.output)?;
    let (sensor, sensor_file) = sensor_source::of(&args.address, args.sensor.as_deref())?;
    let sensor = recorded::named_of(&args.address, sensor, args.with_names)?;
    interrupt::listen();
    let mut options = SessionOptions::new(args.address.clone(), sensor, sensor_file);
    options.method = args.method.clone();
    options.topics = RecordTopics {
        loads: args.loads,
        figures: args.figures,
        images: args.images,
    };
    options.record = Some(args.output.clone());
    options.max_frames = args.frames;
    let mut session = Session::start(options)?;
    wait_for_end(args, &session);
    session.end();
    let ended = session.ended();
    if ended.iter().any(|saved| saved.frames > 0) {
        return conclude(&session);
    }
    match ended
        .into_iter()
        .find_map(|saved| Some((saved.error?, saved.path)))
    {
        Some((why, path)) => Err(taxel_app::Error::RecordingEnded {
            name: path.display().to_string(),
            frames: 0,
            why,
        }
        .into()),
        None => Err(Error::NothingCame {
            address: args.address.to_string(),
            reason: session.state().1,
        }),
    }
}

/// Refuses a name that is no recording's.
pub(crate) fn check_recording(option: &str, file: &Path) -> Result<(), Error> {
    let hint = "`taxel convert` makes other formats of a recording";
    check_ending(option, file, &["mcap"], hint)
}

/// Until there is enough, or no more comes; says how the source stands.
fn wait_for_end(args: &Args, session: &Session) {
    let (begun, mut said) = (Instant::now(), false);
    let mut told = String::new();
    loop {
        let (state, text) = session.state();
        if text != told {
            out::note(&text);
            told = text;
        }
        let recording = session.recording();
        // Ended before its time: why is told below.
        let failed = recording
            .as_ref()
            .is_none_or(|recording| recording.error.is_some());
        let frames = recording.map_or(0, |recording| recording.frames);
        let enough = args
            .secs
            .is_some_and(|secs| begun.elapsed().as_secs_f64() >= secs)
            || args.frames.is_some_and(|wanted| frames >= wanted);
        if enough || failed || state == State::Ended || interrupt::asked() {
            return;
        }
        if session.link_stats().frames == 0 && begun.elapsed() > SILENCE && !said {
            said = true;
            out::note(&format!(
                "no frame from {} for {} s; Ctrl-C ends it",
                args.address,
                SILENCE.as_secs()
            ));
        }
        std::thread::sleep(LOOK);
    }
}

/// What became of the recordings, on standard error; exit code 3 when something is missing in one of them.
pub(crate) fn conclude(session: &Session) -> Result<Exit, Error> {
    for line in session.take_messages() {
        out::note(&line);
    }
    let whole = |saved: &SavedRecording| saved.error.is_none() && saved.missing().is_empty();
    Ok(if session.ended().iter().all(whole) {
        Exit::Good
    } else {
        Exit::DataLost
    })
}
