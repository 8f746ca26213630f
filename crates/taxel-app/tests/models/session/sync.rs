//! Shuttle's, under the names that the session's files use.

pub(super) use shuttle::sync::atomic::{AtomicU8, Ordering};
pub(super) use shuttle::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel,
};
pub(super) use shuttle::sync::{Condvar, Mutex, MutexGuard};

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::Result as Joined;

/// Shuttle's handles do not tell whether their thread has ended; these do.
pub(super) struct JoinHandle<T> {
    inner: shuttle::thread::JoinHandle<T>,
    ended: Arc<AtomicBool>,
}

impl<T> JoinHandle<T> {
    pub(super) fn is_finished(&self) -> bool {
        self.ended.load(std::sync::atomic::Ordering::SeqCst)
    }

    pub(super) fn join(self) -> Joined<T> {
        self.inner.join()
    }
}

/// Says that its thread has ended, however that ends.
struct Ends(Arc<AtomicBool>);

impl Drop for Ends {
    fn drop(&mut self) {
        self.0.store(true, std::sync::atomic::Ordering::SeqCst);
    }
}

pub(super) struct Builder(shuttle::thread::Builder);

impl Builder {
    pub(super) fn new() -> Self {
        Self(shuttle::thread::Builder::new())
    }

    pub(super) fn name(self, name: String) -> Self {
        Self(self.0.name(name))
    }

    pub(super) fn spawn<F, T>(self, run: F) -> io::Result<JoinHandle<T>>
    where
        F: FnOnce() -> T + Send + 'static,
        T: Send + 'static,
    {
        let ended = Arc::new(AtomicBool::new(false));
        let ends = Ends(ended.clone());
        let inner = self.0.spawn(move || {
            let _ends = ends;
            run()
        })?;
        Ok(JoinHandle { inner, ended })
    }
}

/// Unit tests run where the system's threads are.
macro_rules! unit_tests {
    ($($tests:item)*) => {};
}
pub(super) use unit_tests;
