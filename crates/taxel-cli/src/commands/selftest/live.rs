//! The two recordings, made now.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use taxel::simulate::{Pattern, PatternKind};
use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::simulated::Simulated;
use taxel_acquire::transport::{Receiver, State};
use taxel_io::McapWriter;
use taxel_io::mcap::About;

use super::Args;
use crate::enter::{Enter, NoEnter, refuse_recording, refuse_stdin};
use crate::error::Error;
use crate::{interrupt, out};
use taxel_app::sensor_source;
use taxel_app::session::{SavedRecording, Session, SessionOptions};

/// How long a device may take for its first frame; one that was reset by opening its port starts anew.
const PATIENCE: Duration = Duration::from_secs(15);
/// A week: nobody rubs a mat for longer.
const MAX_SECS: f64 = 7.0 * 86_400.0;
const LOOK: Duration = Duration::from_millis(20);

/// Where the recordings are; removed at the end unless they are to be kept.
pub(super) struct Recordings {
    pub(super) empty: PathBuf,
    pub(super) rubbed: PathBuf,
    folder: Option<PathBuf>,
}

impl Drop for Recordings {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            let _ = fs::remove_dir_all(folder);
        }
    }
}

/// What is to happen on the mat.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Empty,
    Rubbed,
}

/// Asks for both, and records both.
pub(super) fn record(
    args: &Args,
    address: &Address,
    sensor: &Sensor,
    sensor_file: &Path,
) -> Result<Recordings, Error> {
    check(address, args)?;
    // Before there is anything to leave behind.
    interrupt::listen();
    let folder = match &args.keep {
        Some(folder) => folder.clone(),
        None => std::env::temp_dir().join(format!("taxel-selftest-{}", std::process::id())),
    };
    fs::create_dir_all(&folder).map_err(|error| Error::Arguments {
        what: format!("cannot make the folder {}: {error}", folder.display()),
        hint: "--keep takes a folder in which you may write",
    })?;
    if args.keep.is_none() {
        interrupt::remove_at_end(&folder);
    }
    let recordings = Recordings {
        empty: folder.join("empty.mcap"),
        rubbed: folder.join("rubbed.mcap"),
        folder: args.keep.is_none().then_some(folder),
    };
    // With nobody to press it, standard input is left alone.
    let enter = (!args.yes).then(Enter::listen);
    for (phase, file) in [
        (Phase::Empty, &recordings.empty),
        (Phase::Rubbed, &recordings.rubbed),
    ] {
        ask(phase, enter.as_ref())?;
        out::note(&format!("recording for {} s", args.seconds));
        let length = Duration::from_secs_f64(args.seconds.min(MAX_SECS));
        match address {
            Address::Sim { .. } => simulate(address, sensor, phase, length, file)?,
            _ => receive(address, sensor, sensor_file, length, file)?,
        }
        if interrupt::asked() {
            return Err(stopped());
        }
    }
    Ok(recordings)
}

/// Refuses what is no live sensor.
fn check(address: &Address, args: &Args) -> Result<(), Error> {
    refuse_recording(address, "give two recordings with --empty and --rubbed")?;
    if args.yes {
        return Ok(());
    }
    let hint = "record both with `taxel record stdin:` and give --empty and --rubbed";
    refuse_stdin(address, hint)
}

/// Says what to do, and waits for Enter.
fn ask(phase: Phase, enter: Option<&Enter>) -> Result<(), Error> {
    let requirements = match phase {
        Phase::Empty => "take everything off the mat",
        Phase::Rubbed => "rub a hand over the whole mat until every taxel was pressed",
    };
    let Some(enter) = enter else {
        out::note(requirements);
        return Ok(());
    };
    out::note(&format!("{requirements}, then Enter"));
    enter.wait().map_err(|why| match why {
        NoEnter::Ended => Error::Arguments {
            what: "no Enter came: standard input has ended".to_owned(),
            hint: "run it in a terminal, or with --yes, which does not wait",
        },
        NoEnter::Stopped => stopped(),
    })
}

fn stopped() -> Error {
    Error::Arguments {
        what: "the self-test was stopped by Ctrl-C".to_owned(),
        hint: "it needs both recordings whole",
    }
}

/// From a device, by the chain that records.
fn receive(
    address: &Address,
    sensor: &Sensor,
    sensor_file: &Path,
    length: Duration,
    file: &Path,
) -> Result<(), Error> {
    let mut options = SessionOptions::new(address.clone(), sensor.clone(), sensor_file);
    options.record = Some(file.to_owned());
    let mut session = Session::start(options)?;
    let (begun, mut first) = (Instant::now(), None);
    let mut told = String::new();
    loop {
        let (state, text) = session.state();
        if text != told {
            out::note(&text);
            told = text;
        }
        let recording = session.recording().unwrap_or_default();
        if recording.frames > 0 {
            first.get_or_insert_with(Instant::now);
        }
        let enough = first.is_some_and(|first: Instant| first.elapsed() >= length);
        let failed = recording.error.is_some();
        if enough || failed || state == State::Ended || interrupt::asked() {
            break;
        }
        if first.is_none() && begun.elapsed() > PATIENCE {
            return Err(Error::Arguments {
                what: format!("no frame came from {address} in {} s", PATIENCE.as_secs()),
                hint: "look at it with `taxel live`, and check the sensor file's rows and columns",
            });
        }
        std::thread::sleep(LOOK);
    }
    session.end();
    is_whole(&session, address)
}

/// An error where the recording is not what it should be.
fn is_whole(session: &Session, address: &Address) -> Result<(), Error> {
    match session.ended().pop() {
        Some(SavedRecording {
            error: Some(why),
            path,
            frames,
            ..
        }) => Err(taxel_app::Error::RecordingEnded {
            name: path.display().to_string(),
            frames,
            why,
        }
        .into()),
        Some(saved) if saved.frames > 0 => Ok(()),
        _ => Err(Error::NothingCame {
            address: address.to_string(),
            reason: session.state().1,
        }),
    }
}

/// From a virtual sensor: its pattern rubs, nothing does while it is to be empty.
fn simulate(
    address: &Address,
    sensor: &Sensor,
    phase: Phase,
    length: Duration,
    file: &Path,
) -> Result<(), Error> {
    let Address::Sim {
        sensor: named,
        pattern,
        frames_per_second,
        seed,
    } = address
    else {
        return Ok(());
    };
    let pattern = match phase {
        Phase::Empty => Pattern::new(PatternKind::Uniform).with_peak_g(0.0),
        Phase::Rubbed => Pattern::named(pattern).expect("the address was checked"),
    };
    // The hand does not repeat the noise of the empty mat.
    let seed = seed.wrapping_add(u64::from(phase == Phase::Empty));
    let scanned = sensor_source::simulated(named, sensor)?;
    let source = Simulated::new(&scanned, pattern, seed, *frames_per_second)?;
    let about = About {
        sensor: sensor.clone(),
        program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
        source: address.to_string(),
    };
    let mut keeper = Keeper {
        writer: McapWriter::create(file, &about)?,
        until: Instant::now() + length,
        failed: None,
    };
    source.run(&mut keeper);
    match keeper.failed {
        Some(error) => Err(error.into()),
        None => Ok(keeper.writer.finish()?),
    }
}

/// Writes what comes.
struct Keeper {
    writer: McapWriter,
    until: Instant,
    failed: Option<taxel_io::Error>,
}

impl Receiver for Keeper {
    fn frame(&mut self, frame: &Frame<Counts>, at: SystemTime) {
        if let Err(error) = self.writer.write_counts(frame, at) {
            self.failed.get_or_insert(error);
        }
    }

    fn state(&mut self, _: State, _: &str) {}

    fn link_stats(&mut self, _: LinkStats) {}

    fn stopped(&self) -> bool {
        Instant::now() >= self.until || self.failed.is_some() || interrupt::asked()
    }
}
