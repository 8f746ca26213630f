//! Shuttle's, under the names that the session's files use.

pub(super) use shuttle::sync::atomic::{AtomicU8, Ordering};
pub(super) use shuttle::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel,
};
pub(super) use shuttle::sync::{Condvar, Mutex, MutexGuard};
pub(super) use shuttle::thread::{Builder, JoinHandle};

/// Unit tests run where the system's threads are.
macro_rules! unit_tests {
    ($($tests:item)*) => {};
}
pub(super) use unit_tests;
