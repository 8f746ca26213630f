//! Links to devices: opened, read, and opened again when they break.

mod link;

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use taxel::{Counts, Frame};

use crate::protocol::{Decoder, LinkStats};
use crate::{Address, Error};

use link::Link;

/// How it stands with the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Frames come.
    Live,
    /// The link is open, but nothing has come for a while.
    Waiting,
    /// The link is broken and is tried again.
    Lost,
    /// There will be no more.
    Ended,
}

impl State {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            State::Live => "live",
            State::Waiting => "waiting",
            State::Lost => "lost",
            State::Ended => "ended",
        }
    }
}

/// Who receives. Called on the reading thread: it must not wait for anything.
pub trait Receiver {
    /// A whole frame, and when it was complete.
    fn frame(&mut self, frame: &Frame<Counts>, at: SystemTime);
    /// The device's state has changed, or the words for it.
    fn state(&mut self, state: State, text: &str);
    /// Frames so far, lost ones and corrupt ones; a few times a second.
    fn link_stats(&mut self, link_stats: LinkStats);
    /// Whether to stop reading.
    fn stopped(&self) -> bool;
}

/// Longest wait for bytes before looking around.
const PATIENCE: Duration = Duration::from_millis(50);
/// A silence after which a half-received frame is given up.
const PAUSE: Duration = Duration::from_millis(250);
/// A silence that is told.
const SILENCE: Duration = Duration::from_secs(1);
/// A silence after which a connection is opened again: where the link is lost, nobody says that it has ended.
const DEAD: Duration = Duration::from_secs(if cfg!(test) { 1 } else { 10 });
/// Waits between attempts to open a link: doubled from the first to the last.
const FIRST_WAIT: Duration = Duration::from_millis(250);
const LAST_WAIT: Duration = Duration::from_secs(5);

/// Serial ports of this machine.
///
/// # Errors
/// [`Error::Ports`].
pub fn serial_ports() -> Result<Vec<PathBuf>, Error> {
    let mut ports =
        serial2::SerialPort::available_ports().map_err(|source| Error::Ports { source })?;
    ports.sort();
    Ok(ports)
}

/// Receives from a device until it is stopped, or the device says that there is no more. A link that cannot be
/// opened or breaks is tried again, less and less often. Of datagrams those of one sender are taken: of the first whose
/// datagrams made a frame, as long as it goes on.
pub fn receive(address: &Address, decoder: &mut dyn Decoder, receiver: &mut dyn Receiver) {
    let mut wait = FIRST_WAIT;
    let mut watch = Watch::default();
    while !receiver.stopped() {
        let broken = match Link::open(address, PATIENCE) {
            Ok(link) => {
                let before = decoder.link_stats().frames;
                let place = link.place(address);
                let ended = read(link, &place, decoder, &mut watch, receiver);
                if decoder.link_stats().frames > before {
                    wait = FIRST_WAIT;
                }
                match ended {
                    Ended::Stopped => return receiver.link_stats(watch.link_stats(decoder)),
                    Ended::NoMore => {
                        decoder.forget();
                        receiver.link_stats(watch.link_stats(decoder));
                        return receiver.state(State::Ended, &ended_words(address, decoder));
                    }
                    Ended::Broken(error) => error,
                }
            }
            Err(error) => error,
        };
        decoder.forget();
        watch.away();
        receiver.link_stats(watch.link_stats(decoder));
        receiver.state(
            State::Lost,
            &format!(
                "{address}: {broken}; trying again in {:.1} s",
                wait.as_secs_f64()
            ),
        );
        let until = Instant::now() + wait;
        while Instant::now() < until && !receiver.stopped() {
            std::thread::sleep(PATIENCE.min(until - Instant::now().min(until)));
        }
        wait = (2 * wait).min(LAST_WAIT);
    }
}

enum Ended {
    Stopped,
    NoMore,
    Broken(io::Error),
}

/// What is known of a device beyond its bytes: when it spoke, and who it is.
#[derive(Default)]
struct Watch {
    /// The first frame and the last.
    first: Option<Instant>,
    last: Option<Instant>,
    frames: u64,
    /// It was there and is away.
    is_away: bool,
    outages: u64,
    strangers: u64,
    /// Whose datagrams are taken, and when one came last.
    sender: Option<SocketAddr>,
    datagram: Option<Instant>,
}

impl Watch {
    fn link_stats(&self, decoder: &dyn Decoder) -> LinkStats {
        let own = LinkStats {
            outages: self.outages,
            strangers: self.strangers,
            ..LinkStats::default()
        };
        decoder.link_stats().and(&own)
    }

    /// Whether a datagram is the device's, and how long after the one before it came.
    fn admit(&mut self, from: SocketAddr, now: Instant) -> Option<Duration> {
        let after = self.datagram.map_or(Duration::ZERO, |before| now - before);
        if self.sender.is_some_and(|sender| sender != from) && after < SILENCE {
            self.strangers += 1;
            return None;
        }
        self.sender = self.sender.filter(|sender| *sender == from);
        self.datagram = Some(now);
        Some(after)
    }

    /// Looks whether frames have come.
    fn see(&mut self, frames: u64, from: Option<SocketAddr>, now: Instant) {
        if frames == self.frames {
            return;
        }
        self.frames = frames;
        self.first.get_or_insert(now);
        self.last = Some(now);
        self.sender = self.sender.or(from);
        self.outages += u64::from(std::mem::take(&mut self.is_away));
    }

    fn away(&mut self) {
        self.is_away = self.last.is_some();
    }

    /// Frames come: the last not much longer ago than between others.
    fn is_live(&self, now: Instant) -> bool {
        let (Some(first), Some(last)) = (self.first, self.last) else {
            return false;
        };
        let between = (last - first).div_f64(self.frames.max(2) as f64 - 1.0);
        now - last < SILENCE.max(4 * between)
    }
}

fn read(
    mut link: Link,
    address: &Address,
    decoder: &mut dyn Decoder,
    watch: &mut Watch,
    receiver: &mut dyn Receiver,
) -> Ended {
    let mut bytes = vec![0; 1 << 16];
    let opened = Instant::now();
    let mut heard = opened;
    let mut told = opened;
    let mut last = None;
    receiver.state(State::Waiting, &format!("{address} is open, nothing yet"));
    loop {
        if receiver.stopped() {
            return Ended::Stopped;
        }
        match link.read(&mut bytes) {
            Ok((0, _)) => return Ended::NoMore,
            Ok((count, from)) => {
                if take(&bytes[..count], from, decoder, watch, receiver) {
                    heard = Instant::now();
                }
            }
            Err(error) if is_silence(&error) => {
                if heard.elapsed() > PAUSE {
                    decoder.forget();
                }
                // One that never said anything may have nothing to say yet.
                if link.can_die_unseen() && heard > opened && heard.elapsed() > DEAD {
                    let why = format!("nothing has come for {} s", DEAD.as_secs());
                    return Ended::Broken(io::Error::new(io::ErrorKind::TimedOut, why));
                }
            }
            Err(error) => return Ended::Broken(error),
        }
        if told.elapsed() > PATIENCE {
            told = Instant::now();
            receiver.link_stats(watch.link_stats(decoder));
            let state = if watch.is_live(told) {
                State::Live
            } else {
                State::Waiting
            };
            if state == State::Waiting
                && last
                    .as_ref()
                    .is_some_and(|(state, _)| *state == State::Live)
            {
                watch.away();
            }
            let silent = heard.elapsed() > SILENCE;
            let words = words(state, silent, address, decoder, watch);
            if last.as_ref() != Some(&(state, words.clone())) {
                receiver.state(state, &words);
                last = Some((state, words));
            }
        }
    }
}

/// Hands bytes to the decoder, unless they are another sender's.
fn take(
    bytes: &[u8],
    from: Option<SocketAddr>,
    decoder: &mut dyn Decoder,
    watch: &mut Watch,
    receiver: &mut dyn Receiver,
) -> bool {
    let now = Instant::now();
    if let Some(from) = from {
        match watch.admit(from, now) {
            None => return false,
            Some(after) => decoder.datagram(after),
        }
    }
    decoder.feed(bytes, &mut |frame| {
        receiver.frame(frame, SystemTime::now());
    });
    watch.see(decoder.link_stats().frames, from, now);
    true
}

fn words(
    state: State,
    silent: bool,
    address: &Address,
    decoder: &dyn Decoder,
    watch: &Watch,
) -> String {
    let others = match watch.strangers {
        0 => "",
        _ => "; what other senders send is left out",
    };
    match (state, silent, decoder.last_fault()) {
        (State::Live, ..) => format!("{address} speaks {}{others}", decoder.name()),
        (_, true, _) => format!(
            "{address} is open, but nothing has come for more than {} s",
            SILENCE.as_secs()
        ),
        (_, false, Some(fault)) => format!("{address} is open, but sends {fault}"),
        (_, false, None) => format!("{address} is open, but no frame is whole yet"),
    }
}

/// A source without a frame says why.
fn ended_words(address: &Address, decoder: &dyn Decoder) -> String {
    match (decoder.link_stats().frames, decoder.last_fault()) {
        (0, Some(fault)) => format!("{address} has ended; it sent {fault}"),
        (0, None) => format!("{address} has ended without a frame"),
        _ => format!("{address} has ended"),
    }
}

fn is_silence(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests;
