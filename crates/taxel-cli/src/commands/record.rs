//! `taxel record`: from a source to a file, without a viewer.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use taxel_acquire::Address;
use taxel_acquire::transport::State;

use super::positive::positive;
use crate::error::Error;
use crate::live::{Options, Session, Wanted};
use crate::outputs::check_ending;
use crate::unit::MethodName;
use crate::{Exit, interrupt, live_sensor, out};

/// Record a sensor
///
/// Raw counts always, with the device's and the host's time, and the sensor file; on request the compensated loads.
/// Ctrl-C ends the recording. Exit code 3: frames were lost, corrupt, or the recording ended early.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where frames come from: serial:/dev/ttyACM0?baud=2000000, udp:0.0.0.0:9000, tcp:host:port, file:run.txt,
    /// stdin:, sim:econe?hand
    address: Address,
    /// Where to write (.mcap); an existing file is never overwritten
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Sensor file, or the name of a preset; simulated sensors and MCAP recordings bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// How loads are found
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Record the compensated loads too
    #[arg(long)]
    loads: bool,
    /// Record total force, peak pressure, contact area and centre of pressure too
    #[arg(long)]
    figures: bool,
    /// End after this many seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    secs: Option<f64>,
    /// End after this many frames
    #[arg(long, value_name = "N")]
    frames: Option<u64>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check_ending(
        "-o",
        &args.output,
        &["mcap"],
        "`taxel convert` makes other formats of a recording",
    )?;
    let (sensor, sensor_file) = live_sensor::of(&args.address, args.sensor.as_deref())?;
    interrupt::listen();
    let mut session = Session::start(Options {
        address: args.address.clone(),
        sensor,
        sensor_file,
        method: args.method.clone(),
        folder: PathBuf::new(),
        wanted: Wanted {
            loads: args.loads,
            figures: args.figures,
        },
        server: None,
        record: Some(args.output.clone()),
    })?;
    let begun = Instant::now();
    let mut told = String::new();
    loop {
        let (state, text) = session.state();
        if text != told {
            out::note(&text);
            told = text;
        }
        let frames = session.recording().map_or(0, |recording| recording.frames);
        let failed = session
            .recording()
            .is_some_and(|recording| recording.error.is_some());
        let enough = args
            .secs
            .is_some_and(|secs| begun.elapsed().as_secs_f64() >= secs)
            || args.frames.is_some_and(|wanted| frames >= wanted);
        if enough || failed || state == State::Ended || interrupt::asked() {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    session.end();
    conclude(&session)
}

/// What became of the recording, on standard error; exit code 3 when something is missing.
pub(crate) fn conclude(session: &Session) -> Result<Exit, Error> {
    let tally = session.tally();
    let mut missing = Vec::new();
    for (count, what) in [
        (tally.lost, "lost"),
        (tally.corrupt, "corrupt"),
        (tally.repeated, "repeated"),
    ] {
        if count > 0 {
            missing.push(format!("{count} {what}"));
        }
    }
    let Some(recording) = session.recording() else {
        return Ok(Exit::Good);
    };
    if let Some(why) = recording.error {
        return Err(Error::RecordingEnded {
            name: recording.name,
            frames: recording.frames,
            why,
        });
    }
    let trouble = match missing.is_empty() {
        true => String::new(),
        false => format!("; {}", missing.join(", ")),
    };
    out::note(&format!(
        "{}: {} frames{trouble}",
        recording.name, recording.frames
    ));
    Ok(match missing.is_empty() {
        true => Exit::Good,
        false => Exit::DataLost,
    })
}
