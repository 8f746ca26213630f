//! Long calls that leave Python to others, and that Ctrl-C ends.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use taxel::Executor;
use taxel::parallel::Step;
use taxel_app::executor::Threads;
use taxel_app::reporter::{Reporter, Stage};

/// How often Python is asked whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(20);

/// Set once the caller wants no more.
#[derive(Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

/// What unwinds the work that nobody wants any more.
struct Stopped;

impl Stop {
    /// Ends the work here if nobody wants it any more. No panic: nothing is printed.
    pub(crate) fn check(&self) {
        if self.is_set() {
            resume_unwind(Box::new(Stopped));
        }
    }

    /// Whether nobody wants the work any more.
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Ends work between its steps.
    pub(crate) fn step(&self) -> Step {
        let stop = self.clone();
        Step::new(move || stop.check())
    }

    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// As many threads as cores, until nobody wants the work any more.
pub(crate) struct StoppableThreads<'a>(pub(crate) &'a Stop);

impl Executor for StoppableThreads<'_> {
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        Threads.each(jobs, &|i| {
            // The others' jobs are left out too; what lacks is never looked at, as the last line tells.
            if self.0.is_set() {
                return;
            }
            // A thread that ends by unwinding would be taken for one that panicked.
            match catch_unwind(AssertUnwindSafe(|| job(i))) {
                Err(other) if !other.is::<Stopped>() => resume_unwind(other),
                _ => {}
            }
        });
        self.0.check();
    }

    fn step(&self) {
        self.0.check();
    }
}

/// Hears how work goes on, and ends it once nobody wants it any more.
pub(crate) struct StoppableStages<'a>(pub(crate) &'a Stop);

impl Reporter for StoppableStages<'_> {
    fn stage(&self, _: &str) -> Box<dyn Stage + '_> {
        self.0.check();
        Box::new(StoppableStages(self.0))
    }
}

impl Stage for StoppableStages<'_> {
    fn step(&self) {
        self.0.check();
    }
}

/// Does work on a thread of its own, while the caller's listens for Ctrl-C and other threads of Python run.
///
/// # Errors
/// `KeyboardInterrupt`, or what else a signal's handler raises; the work has then ended, too.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<T> {
    let stop = Stop::default();
    let ended = py.detach(|| watch(&stop, work));
    match ended {
        Ok(Ok(result)) => Ok(result),
        Ok(Err(panic)) => resume_unwind(panic),
        Err(signal) => Err(signal),
    }
}

type Ended<T> = Result<T, Box<dyn Any + Send>>;

fn watch<T: Send>(stop: &Stop, work: impl FnOnce(&Stop) -> T + Send) -> PyResult<Ended<T>> {
    std::thread::scope(|scope| {
        let (send, receive) = channel();
        scope.spawn(move || {
            let ended = catch_unwind(AssertUnwindSafe(|| work(stop)));
            // The other end waits for it.
            let _ = send.send(ended);
        });
        loop {
            match receive.recv_timeout(LOOK) {
                Ok(ended) => return Ok(ended),
                Err(RecvTimeoutError::Disconnected) => unreachable!("the work always sends"),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = Python::attach(|py| py.check_signals()) {
                        stop.set();
                        return Err(signal);
                    }
                }
            }
        }
    })
}
