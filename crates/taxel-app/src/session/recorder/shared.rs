//! What both ends of the recorder see.

use std::sync::{Arc, PoisonError};

use taxel_io::Tare;

use super::super::status::SessionStatus;
use super::super::sync::{AtomicU8, Mutex, MutexGuard, Ordering};

/// How the recording stands, for those who have something for it.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    Idle,
    /// The file is there; what comes does not belong to it yet.
    Beginning,
    /// Everything is taken.
    Recording,
    /// It has its last frame: only the loads of its frames are still taken.
    Closing,
    /// As `Closing`, and nothing is missing any more.
    Complete,
    /// The queue was full: the disk is too slow. What waits is still written.
    Overrun,
    /// The thread is gone.
    Dead,
}

/// What both ends see.
pub(super) struct Shared {
    pub(super) phase: AtomicU8,
    pub(super) status: Arc<SessionStatus>,
    /// What is taken off now: a recording that begins has it too.
    pub(super) tare: Mutex<Option<Tare>>,
}

impl Shared {
    pub(super) fn tare(&self) -> MutexGuard<'_, Option<Tare>> {
        self.tare.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn phase(&self) -> Phase {
        match self.phase.load(Ordering::Acquire) {
            0 => Phase::Idle,
            1 => Phase::Beginning,
            2 => Phase::Recording,
            3 => Phase::Closing,
            4 => Phase::Complete,
            5 => Phase::Overrun,
            _ => Phase::Dead,
        }
    }

    pub(super) fn set(&self, phase: Phase) {
        self.phase.store(phase as u8, Ordering::Release);
    }

    /// Goes on from one phase to the next; false where it was another one.
    pub(super) fn go(&self, from: Phase, to: Phase) -> bool {
        self.phase
            .compare_exchange(from as u8, to as u8, Ordering::AcqRel, Ordering::Acquire)
            .is_ok()
    }
}
