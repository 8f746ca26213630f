//! What the queue and the recorder wait by. `tests/models` puts shuttle's in its place, which tries the ways in which
//! threads can take turns; the two files are compiled there as they are here.

pub(super) use std::sync::atomic::{AtomicU8, Ordering};
pub(super) use std::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel,
};
pub(super) use std::sync::{Condvar, Mutex, MutexGuard};
pub(super) use std::thread::{Builder, JoinHandle};

/// The unit tests of a file, which know the time; there are none of them among the models.
macro_rules! unit_tests {
    ($($tests:item)*) => { $(#[cfg(test)] $tests)* };
}
pub(super) use unit_tests;
