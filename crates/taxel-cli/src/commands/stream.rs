//! `taxel stream`: every frame of a live source as a line of JSON, or its counts as a packet.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;
use taxel_acquire::protocol::taxel1::{Header, encode};
use taxel_app::exported::exported_words;
use taxel_app::json_line::json_line;
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{CountsObserver, FrameObserver, Session, SessionOptions};

use crate::error::Error;
use crate::sending::{Out, packet_bits};
use crate::{Exit, interrupt, out};

/// Send every frame of a live source as a line of JSON
///
/// For programs of your own, sound and games: total force, highest pressure, area, centre of pressure and the load of every taxel
/// (newtons; null where nothing was measured), a line a frame, as soon as it is solved. Who reads more slowly than frames come
/// misses some, and is told how many at the end (exit code 3). With --counts the counts as they came, in protocol taxel-1, for
/// another computer that compensates them: a small one reads the sensor, `taxel live` on a laptop does the rest.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where frames come from: serial:, udp:, tcp:, stdin:, sim:, file:, rpi:
    #[arg(value_name = "SOURCE", default_value = "sim:econe")]
    address: Address,
    /// Where lines go: - for standard output, udp:HOST:PORT, tcp:HOST:PORT, or listen:HOST:PORT, to whoever connects there
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
    /// Send the counts as they came, in protocol taxel-1, and no loads: `taxel live udp:…` or `tcp:…` takes them
    #[arg(long, conflicts_with_all = ["sums", "method"])]
    counts: bool,
    /// Record the counts here as well (.mcap): what is lost on the way is not lost in the file
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// End after this many lines
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
}

/// Lines that may wait for who reads them.
const WAITING: usize = 64;
/// How often it looks whether it is to end.
const LOOK: Duration = Duration::from_millis(50);

/// What is to be sent, from the threads that have it to the one that sends.
#[derive(Clone)]
struct Outbox {
    send: SyncSender<Vec<u8>>,
    missed: Arc<AtomicU64>,
}

impl Outbox {
    fn put(&self, bytes: Vec<u8>) {
        if self.send.try_send(bytes).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Loads as lines.
    fn lines(self, with_loads: bool) -> FrameObserver {
        Box::new(move |frame| self.put(json_line(frame, with_loads).into_bytes()))
    }

    /// Counts as packets.
    fn packets(self, sensor: &Sensor) -> CountsObserver {
        let bits = packet_bits(sensor);
        Box::new(move |frame| {
            if !fits(frame, bits) {
                self.missed.fetch_add(1, Ordering::Relaxed);
                return;
            }
            let header = Header {
                bits,
                sensor_id: 0,
                sequence: frame.sequence as u32,
                time_us: (1e6 * frame.time_secs.unwrap_or_default()).max(0.0) as u64,
            };
            let mut bytes = Vec::new();
            encode(frame, &header, &mut bytes);
            self.put(bytes);
        })
    }
}

/// Whether a packet can hold these counts: means of several readings have fractions.
fn fits(frame: &Frame<Counts>, bits: u8) -> bool {
    let most = f64::from(1u32 << bits);
    let mut counts = frame.values().iter();
    counts.all(|count| count.fract() == 0.0 && (0.0..most).contains(count))
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if let Some(file) = &args.record {
        super::record::check_recording("--record", file)?;
    }
    let (sensor, sensor_file) = sensor_source::of(&args.address, args.sensor.as_deref())?;
    let mut to = Out::open(&args.to)?;
    if let Some(words) = exported_words(&sensor) {
        out::note(&words);
    }
    interrupt::listen();
    let (send, receive) = sync_channel(WAITING);
    let outbox = Outbox {
        send,
        missed: Arc::default(),
    };
    let missed = outbox.missed.clone();
    let mut options = SessionOptions::new(args.address.clone(), sensor, sensor_file);
    options.record = args.record.clone();
    if args.counts {
        // Nobody wants loads: the least that an engine can do.
        options.method = MethodName::Raw;
        options.counts_observer = Some(outbox.packets(&options.sensor));
    } else {
        options.method = args.method.clone();
        options.observer = Some(outbox.lines(!args.sums));
    }
    let mut session = Session::start(options)?;
    let mut sent = 0;
    let ended = send_all(args, &session, &receive, &mut to, &mut sent);
    session.end();
    ended?;
    let missed = match args.frames {
        // Those that came while it ended are nobody's loss.
        Some(most) if sent >= most => 0,
        _ => missed.load(Ordering::Relaxed) + to.missed(),
    };
    let what = if args.counts { "packets" } else { "lines" };
    out::note(&format!(
        "{sent} {what}, {missed} frames that nobody took in time"
    ));
    let recorded = super::record::conclude(&session)?;
    Ok(if missed == 0 {
        recorded
    } else {
        Exit::DataLost
    })
}

/// Sends what comes, until there is enough or no more; counts what was sent.
fn send_all(
    args: &Args,
    session: &Session,
    receive: &Receiver<Vec<u8>>,
    to: &mut Out,
    sent: &mut u64,
) -> Result<(), Error> {
    let mut told = String::new();
    loop {
        // Asked first: what was solved before it is there by then.
        let has_ended = session.has_ended();
        match receive.recv_timeout(LOOK) {
            Ok(bytes) => match to.send(&bytes) {
                Ok(is_sent) => *sent += u64::from(is_sent),
                // Whoever read has read enough.
                Err(Error::Stdout(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                    return Ok(());
                }
                Err(error) => return Err(error),
            },
            Err(RecvTimeoutError::Timeout) if has_ended => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        for line in to.take_news().into_iter().chain(session.take_messages()) {
            out::note(&line);
        }
        // Lines go to programs that are told nothing else; who looks after a small computer wants to know.
        if args.counts {
            let (_, text) = session.state();
            if text != told {
                out::note(&text);
                told = text;
            }
        }
        if interrupt::asked() || args.frames.is_some_and(|most| *sent >= most) {
            return Ok(());
        }
    }
}
