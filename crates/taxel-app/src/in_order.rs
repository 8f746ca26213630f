//! Work that several threads share, block by block, and whose results come back in order.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, PoisonError};

/// What is to be done before, in and after the threads.
pub trait Work<B>: Sync {
    /// What one thread needs for itself.
    type Worker: Send;

    /// Does one block.
    fn work(&self, worker: &mut Self::Worker, block: &mut B);
}

/// Blocks through workers, a thread each. The caller's thread fills blocks, one after the other, until `fill` says that there is no
/// more; and takes them back in the same order. What a worker makes of a block may hang on the block alone: then the results are the
/// same whatever the number of workers is.
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
    assert!(!workers.is_empty() && !blocks.is_empty());
    if let [worker] = workers
        && blocks.len() == 1
    {
        let mut block = blocks.into_iter().next().expect("there is one");
        while fill(&mut block)? {
            work.work(worker, &mut block);
            take(&mut block)?;
        }
        return Ok(());
    }
    let (jobs, queue) = channel::<(u64, B)>();
    let (done, results) = channel::<(u64, B)>();
    let queue = Mutex::new(queue);
    std::thread::scope(|scope| {
        for worker in workers {
            let (queue, done) = (&queue, done.clone());
            scope.spawn(move || {
                while let Some((place, mut block)) = next(queue) {
                    work.work(worker, &mut block);
                    if done.send((place, block)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        // Dropped with this closure, also where it ends early: that ends the workers.
        let jobs = jobs;
        let (mut free, mut early) = (blocks, BTreeMap::new());
        let (mut filled, mut taken, mut ended) = (0, 0, false);
        loop {
            while !ended && let Some(mut block) = free.pop() {
                ended = !fill(&mut block)?;
                if !ended {
                    // Nobody hears where all workers have panicked: told by the results below.
                    let _ = jobs.send((filled, block));
                    filled += 1;
                }
            }
            if taken == filled {
                return Ok(());
            }
            let Ok((place, block)) = results.recv() else {
                return Ok(());
            };
            early.insert(place, block);
            while let Some(mut block) = early.remove(&taken) {
                take(&mut block)?;
                free.push(block);
                taken += 1;
            }
        }
    })
}

fn next<T>(queue: &Mutex<Receiver<T>>) -> Option<T> {
    let queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
    queue.recv().ok()
}

#[cfg(test)]
mod tests {
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

    #[test]
    #[should_panic(expected = "a scoped thread panicked")]
    fn a_worker_that_panics_is_heard() {
        struct Panics;
        impl Work<u8> for Panics {
            type Worker = ();
            fn work(&self, _: &mut (), _: &mut u8) {
                std::panic::resume_unwind(Box::new("no"));
            }
        }
        let _: Result<(), ()> =
            in_order(&Panics, &mut [(), ()], vec![0, 0], |_| Ok(true), |_| Ok(()));
    }
}
