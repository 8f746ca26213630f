//! Work that several threads share, block by block, and whose results come back in order.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What is to be done before, in and after the threads.
pub trait Work<B>: Sync {
    /// What one thread needs for itself.
    type Worker: Send;

    /// Does one block.
    fn work(&self, worker: &mut Self::Worker, block: &mut B);
}

/// Blocks through workers, each on a thread. The caller's thread has one of them; it fills blocks, one after the other, until `fill`
/// says that there is no more, takes them back in the same order, and works where it would have to wait: so there are as many
/// threads as workers, and none of them rests while there is work. What a worker makes of a block may hang on the block alone:
/// then the results are the same whatever the number of workers is.
///
/// `blocks` is the memory: so many are under way at once, and each is used again.
///
/// # Errors
/// What `fill` and `take` say; what is under way is then dropped.
///
/// # Panics
/// When a worker does, and without workers or blocks.
pub fn in_order<B: Send, W: Work<B>, E>(
    work: &W,
    workers: &mut [W::Worker],
    blocks: Vec<B>,
    mut fill: impl FnMut(&mut B) -> Result<bool, E>,
    mut take: impl FnMut(&mut B) -> Result<(), E>,
) -> Result<(), E> {
    assert!(!blocks.is_empty());
    let (own, others) = workers.split_first_mut().expect("there is a worker");
    let jobs = Jobs::new();
    let (done, results) = channel::<Option<(u64, B)>>();
    std::thread::scope(|scope| {
        for worker in others {
            let (jobs, done) = (&jobs, Done(done.clone()));
            scope.spawn(move || {
                while let Some((place, mut block)) = jobs.wait() {
                    work.work(worker, &mut block);
                    if done.0.send(Some((place, block))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        let _ends_with_this = Closing(&jobs);
        let (mut free, mut early) = (blocks, BTreeMap::new());
        let (mut filled, mut taken, mut ended) = (0, 0, false);
        loop {
            while let Ok(found) = results.try_recv() {
                // Nothing, where a worker has panicked: told when it is waited for.
                let Some((place, block)) = found else {
                    return Ok(());
                };
                early.insert(place, block);
            }
            while let Some(mut block) = early.remove(&taken) {
                take(&mut block)?;
                free.push(block);
                taken += 1;
            }
            if !ended && let Some(mut block) = free.pop() {
                ended = !fill(&mut block)?;
                if !ended {
                    jobs.push((filled, block));
                    filled += 1;
                }
            } else if taken == filled {
                return Ok(());
            } else if let Some((place, mut block)) = jobs.next() {
                work.work(own, &mut block);
                early.insert(place, block);
            } else {
                let Ok(Some((place, block))) = results.recv() else {
                    return Ok(());
                };
                early.insert(place, block);
            }
        }
    })
}

/// Where a worker sends what it has done; and nothing, where it panics.
struct Done<T>(Sender<Option<T>>);

impl<T> Drop for Done<T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let _ = self.0.send(None);
        }
    }
}

/// What is to be done by whoever comes first; `None` in place of it: no more will come.
struct Jobs<T> {
    left: Mutex<Option<VecDeque<T>>>,
    more: Condvar,
}

impl<T> Jobs<T> {
    fn new() -> Self {
        Self {
            left: Mutex::new(Some(VecDeque::new())),
            more: Condvar::new(),
        }
    }

    fn left(&self) -> MutexGuard<'_, Option<VecDeque<T>>> {
        self.left.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, job: T) {
        if let Some(left) = &mut *self.left() {
            left.push_back(job);
        }
        self.more.notify_one();
    }

    /// The next one, if there is one.
    fn next(&self) -> Option<T> {
        self.left().as_mut()?.pop_front()
    }

    /// The next one, waited for; `None` where no more will come.
    fn wait(&self) -> Option<T> {
        let mut left = self.left();
        loop {
            if let Some(job) = left.as_mut()?.pop_front() {
                return Some(job);
            }
            left = (self.more.wait(left)).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Tells those who wait, when it is dropped, that no more will come.
struct Closing<'a, T>(&'a Jobs<T>);

impl<T> Drop for Closing<'_, T> {
    fn drop(&mut self) {
        *self.0.left() = None;
        self.0.more.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    struct Square;

    impl Work<Vec<u64>> for Square {
        type Worker = u64;

        fn work(&self, done: &mut u64, block: &mut Vec<u64>) {
            *done += 1;
            block.iter_mut().for_each(|x| *x *= *x);
        }
    }

    fn squares(workers: usize, blocks: usize, most: u64, fails_at: u64) -> Result<Vec<u64>, u64> {
        let (mut next, mut got) = (0, Vec::new());
        let mut workers = vec![0; workers];
        in_order(
            &Square,
            &mut workers,
            vec![Vec::new(); blocks],
            |block: &mut Vec<u64>| {
                block.clear();
                block.extend(next..(next + 3).min(most));
                next += 3;
                if block.contains(&fails_at) {
                    return Err(fails_at);
                }
                Ok(!block.is_empty())
            },
            |block| {
                got.extend(block.iter());
                Ok(())
            },
        )?;
        Ok(got)
    }

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        let wanted: Vec<u64> = (0..100).map(|x| x * x).collect();
        for (workers, blocks) in [(1, 1), (1, 3), (2, 1), (2, 5), (7, 16)] {
            assert_eq!(squares(workers, blocks, 100, 1000), Ok(wanted.clone()));
        }
        assert_eq!(squares(3, 4, 0, 1000), Ok(Vec::new()));
    }

    #[test]
    fn an_error_ends_it() {
        for (workers, blocks) in [(1, 1), (2, 5)] {
            assert_eq!(squares(workers, blocks, 100, 50), Err(50));
        }
    }

    /// The third of three, when it has work; the others wait for that.
    #[test]
    #[should_panic(expected = "a scoped thread panicked")]
    fn a_worker_that_panics_is_heard() {
        struct Panics(AtomicBool);
        impl Work<u8> for Panics {
            type Worker = u8;
            fn work(&self, worker: &mut u8, _: &mut u8) {
                if *worker == 2 {
                    self.0.store(true, Ordering::Release);
                    std::panic::resume_unwind(Box::new("no"));
                }
                while !self.0.load(Ordering::Acquire) {
                    std::thread::yield_now();
                }
            }
        }
        let work = Panics(AtomicBool::new(false));
        let fill = |_: &mut u8| -> Result<bool, ()> { Ok(true) };
        let _ = in_order(&work, &mut [0, 1, 2], vec![0; 4], fill, |_| Ok(()));
    }
}
