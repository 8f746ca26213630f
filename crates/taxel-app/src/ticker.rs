//! A thread that does the same thing again and again until it is told to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::error::Error;

/// The thread. Dropped, it ends.
pub(crate) struct Ticker {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Ticker {
    /// Starts it: `tick`, a pause, and so on.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub(crate) fn start(
        name: &str,
        pause: Duration,
        mut tick: impl FnMut() + Send + 'static,
    ) -> Result<Self, Error> {
        let ends = Arc::new(AtomicBool::new(false));
        let asked = ends.clone();
        let thread = std::thread::Builder::new().name(name.to_owned());
        let thread = thread.spawn(move || {
            while !asked.load(Ordering::Relaxed) {
                tick();
                std::thread::sleep(pause);
            }
        });
        Ok(Self {
            ends,
            thread: Some(thread.map_err(Error::Thread)?),
        })
    }

    /// Waits for the tick that goes on; there is none after it.
    pub(crate) fn end(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Ticker {
    fn drop(&mut self) {
        self.end();
    }
}
