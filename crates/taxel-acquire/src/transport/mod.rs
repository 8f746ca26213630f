//! Links to devices: opened, read, and opened again when they break.

mod link;

use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use taxel::{Counts, Frame};

use crate::protocol::{Decoder, Tally};
use crate::{Address, Error};

pub use link::Link;

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
    fn tally(&mut self, tally: Tally);
    /// Whether to stop reading.
    fn stopped(&self) -> bool;
}

/// Longest wait for bytes before looking around.
const PATIENCE: Duration = Duration::from_millis(50);
/// A silence after which a half-received frame is given up.
const PAUSE: Duration = Duration::from_millis(250);
/// A silence that is told.
const SILENCE: Duration = Duration::from_secs(1);
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
/// opened or breaks is tried again, less and less often.
pub fn receive(address: &Address, decoder: &mut dyn Decoder, receiver: &mut dyn Receiver) {
    let mut wait = FIRST_WAIT;
    while !receiver.stopped() {
        let broken = match Link::open(address, PATIENCE) {
            Ok(link) => {
                let before = decoder.tally().frames;
                let ended = read(link, address, decoder, receiver);
                if decoder.tally().frames > before {
                    wait = FIRST_WAIT;
                }
                match ended {
                    Ended::Stopped => return,
                    Ended::NoMore => {
                        receiver.tally(decoder.tally());
                        return receiver.state(State::Ended, &format!("{address} has ended"));
                    }
                    Ended::Broken(error) => error,
                }
            }
            Err(error) => error,
        };
        decoder.forget();
        receiver.tally(decoder.tally());
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

fn read(
    mut link: Link,
    address: &Address,
    decoder: &mut dyn Decoder,
    receiver: &mut dyn Receiver,
) -> Ended {
    let mut bytes = vec![0; 1 << 16];
    let mut heard = Instant::now();
    let mut told = Instant::now();
    let mut last = None;
    receiver.state(State::Waiting, &format!("{address} is open, nothing yet"));
    loop {
        if receiver.stopped() {
            return Ended::Stopped;
        }
        match link.read(&mut bytes) {
            Ok(0) => return Ended::NoMore,
            Ok(count) => {
                heard = Instant::now();
                decoder.feed(&bytes[..count], &mut |frame| {
                    receiver.frame(frame, SystemTime::now());
                });
            }
            Err(error) if is_silence(&error) => {
                if heard.elapsed() > PAUSE {
                    decoder.forget();
                }
            }
            Err(error) => return Ended::Broken(error),
        }
        if told.elapsed() > PATIENCE {
            told = Instant::now();
            receiver.tally(decoder.tally());
            let state = judge(decoder, heard);
            let words = words(state, address, decoder);
            if last.as_ref() != Some(&words) {
                receiver.state(state, &words);
                last = Some(words);
            }
        }
    }
}

fn judge(decoder: &dyn Decoder, heard: Instant) -> State {
    let frames = decoder.tally().frames > 0;
    match frames && heard.elapsed() < SILENCE {
        true => State::Live,
        false => State::Waiting,
    }
}

fn words(state: State, address: &Address, decoder: &dyn Decoder) -> String {
    match (state, decoder.last_fault()) {
        (State::Live, _) => format!("{address} speaks {}", decoder.name()),
        (_, Some(fault)) => format!("{address} is open, but sends {fault}"),
        _ => format!("{address} is open, but nothing comes"),
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
