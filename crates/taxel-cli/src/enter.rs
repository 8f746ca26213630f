//! The Enter key, while something else may end the wait.

use std::io::{self, BufRead};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use taxel_acquire::Address;

use crate::error::Error;
use crate::interrupt;

/// How often is looked whether Ctrl-C was pressed.
const TURN: Duration = Duration::from_millis(50);

/// Why nobody pressed Enter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoEnter {
    /// Standard input has ended.
    Ended,
    /// Ctrl-C, or what does the same.
    Stopped,
}

/// Refuses a recording where a sensor is to be operated; `hint`: what to do with it instead.
pub(crate) fn refuse_recording(address: &Address, hint: &'static str) -> Result<(), Error> {
    match address {
        Address::File { path, .. } => Err(Error::Arguments {
            what: format!("{} is a recording, not a live sensor", path.display()),
            hint,
        }),
        _ => Ok(()),
    }
}

/// Refuses frames from where the Enter key is listened to.
pub(crate) fn refuse_stdin(address: &Address, hint: &'static str) -> Result<(), Error> {
    match address {
        Address::Stdin { .. } => Err(Error::Arguments {
            what: "standard input cannot be both the sensor and the Enter key".to_owned(),
            hint,
        }),
        _ => Ok(()),
    }
}

/// Lines of standard input, read aside: Ctrl-C must end the wait for one.
pub(crate) struct Enter {
    lines: Receiver<String>,
}

impl Enter {
    /// Begins to listen.
    pub(crate) fn listen() -> Self {
        let (send, lines) = mpsc::channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            while matches!(io::stdin().lock().read_line(&mut line), Ok(count) if count > 0) {
                if send.send(std::mem::take(&mut line)).is_err() {
                    return;
                }
            }
        });
        Self { lines }
    }

    /// A line, where there is one now.
    ///
    /// # Errors
    /// [`NoEnter::Ended`] where there will be none.
    pub(crate) fn line(&self) -> Result<Option<String>, NoEnter> {
        match self.lines.try_recv() {
            Ok(line) => Ok(Some(line)),
            Err(mpsc::TryRecvError::Empty) => Ok(None),
            Err(mpsc::TryRecvError::Disconnected) => Err(NoEnter::Ended),
        }
    }

    /// Waits for it.
    pub(crate) fn wait(&self) -> Result<(), NoEnter> {
        loop {
            match self.lines.recv_timeout(TURN) {
                Ok(_) => return Ok(()),
                Err(RecvTimeoutError::Disconnected) => return Err(NoEnter::Ended),
                Err(RecvTimeoutError::Timeout) if interrupt::asked() => {
                    return Err(NoEnter::Stopped);
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }
}
