//! `taxel stream`: every frame of a live source as a line of JSON.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use taxel_acquire::Address;
use taxel_acquire::transport::State;
use taxel_app::exported::exported_words;
use taxel_app::json_line::json_line;
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{Session, SessionOptions};

use crate::error::Error;
use crate::sending::Out;
use crate::{Exit, interrupt, out};

/// Send every frame of a live source as a line of JSON
///
/// For programs of your own, sound and games: total force, highest pressure, area, centre of pressure and the load of every taxel
/// (newtons; null where nothing was measured), a line a frame, as soon as it is solved. Who reads more slowly than frames come
/// misses some, and is told how many at the end (exit code 3).
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where frames come from: serial:, udp:, tcp:, stdin:, sim:, file:, rpi:
    #[arg(value_name = "SOURCE", default_value = "sim:econe")]
    address: Address,
    /// Where lines go: - for standard output, udp:HOST:PORT, tcp:HOST:PORT
    #[arg(long, value_name = "ADDRESS", default_value = "-")]
    to: String,
    /// Sensor file, or the name of a preset; simulated sensors and recordings bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// How loads are found
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Leave the loads of taxels out: sums alone
    #[arg(long)]
    sums: bool,
    /// End after this many lines
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
}

/// Lines that may wait for who reads them.
const WAITING: usize = 64;
/// How often it looks whether it is to end.
const LOOK: Duration = Duration::from_millis(50);

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let (sensor, sensor_file) = sensor_source::of(&args.address, args.sensor.as_deref())?;
    let mut to = Out::open(&args.to)?;
    if let Some(words) = exported_words(&sensor) {
        out::note(&words);
    }
    interrupt::listen();
    let (send, receive) = sync_channel::<String>(WAITING);
    let missed = Arc::new(AtomicU64::new(0));
    let (counted, with_loads) = (missed.clone(), !args.sums);
    let mut options = SessionOptions::new(args.address.clone(), sensor, sensor_file);
    options.method = args.method.clone();
    options.observer = Some(Box::new(move |frame| {
        if send.try_send(json_line(frame, with_loads)).is_err() {
            counted.fetch_add(1, Ordering::Relaxed);
        }
    }));
    let mut session = Session::start(options)?;
    let mut sent = 0;
    let ended = loop {
        match receive.recv_timeout(LOOK) {
            Ok(line) => match to.send(line.as_bytes()) {
                Ok(()) => sent += 1,
                // Whoever read has read enough.
                Err(Error::Stdout(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                    break Ok(());
                }
                Err(error) => break Err(error),
            },
            Err(RecvTimeoutError::Timeout) if session.state().0 == State::Ended => break Ok(()),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break Ok(()),
        }
        if interrupt::asked() || args.frames.is_some_and(|most| sent >= most) {
            break Ok(());
        }
    };
    session.end();
    ended?;
    let missed = match args.frames {
        // Those that came while it ended are nobody's loss.
        Some(most) if sent >= most => 0,
        _ => missed.load(Ordering::Relaxed),
    };
    out::note(&format!(
        "{sent} lines, {missed} frames that came faster than they were read"
    ));
    Ok(if missed == 0 {
        Exit::Good
    } else {
        Exit::DataLost
    })
}
