//! A thread a core for the library's longer work.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};

use taxel::Executor;

/// As many threads as the machine has cores, each taking the next job.
pub struct Threads;

/// How many threads can run at once, as the system allows this program.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

impl Executor for Threads {
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                if i >= jobs {
                    break;
                }
                job(i);
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..cores().min(jobs) {
                scope.spawn(work);
            }
            work();
        });
    }
}
