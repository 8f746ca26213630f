//! Work that can be done in parallel: the library starts no threads, its caller may.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Workers that a caller brings, for the few things that take seconds.
///
/// ```
/// use taxel::parallel::{Serial, par_map};
/// assert_eq!(par_map(&Serial, vec![1, 2, 3], |n| Some(n * n)), Some(vec![1, 4, 9]));
/// assert_eq!(par_map(&Serial, vec![1, 2, 3], |n| (n != 2).then_some(n)), None);
/// ```
pub trait Executor: Sync {
    /// Does every job from 0 to `jobs` − 1 once, in any order, on any thread; returns when all are done.
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync));

    /// Called by jobs between their steps, on their thread: who wants no more of them unwinds here.
    fn step(&self) {}
}

/// What is called between the steps of long work that is done on one thread: who wants no more of it unwinds there. Nothing by
/// default.
#[derive(Clone, Default)]
pub struct Step(Option<Arc<dyn Fn() + Send + Sync>>);

impl Step {
    /// Nothing is called.
    pub const NONE: Self = Self(None);

    /// Calls this.
    pub fn new(call: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(call)))
    }

    /// A step is done.
    pub fn done(&self) {
        if let Some(call) = &self.0 {
            call();
        }
    }
}

impl fmt::Debug for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() {
            "Step"
        } else {
            "Step::NONE"
        })
    }
}

/// An executor of one: the caller's own thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl Executor for Serial {
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).for_each(job);
    }
}

/// Does something to every item; answers keep the order of the items. Nothing as soon as one item has no answer.
/// What an item gives must not depend on the others, so that the size of the executor cannot matter.
pub fn par_map<I: Send, T: Send>(
    executor: &dyn Executor,
    items: Vec<I>,
    work: impl Fn(I) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    let slots: Vec<Mutex<(Option<I>, Option<T>)>> = items
        .into_iter()
        .map(|item| Mutex::new((Some(item), None)))
        .collect();
    let failed = AtomicBool::new(false);
    executor.each(slots.len(), &|i| {
        if failed.load(Ordering::Relaxed) {
            return;
        }
        let mut slot = slots[i].lock().unwrap_or_else(PoisonError::into_inner);
        slot.1 = slot.0.take().and_then(&work);
        if slot.1.is_none() {
            failed.store(true, Ordering::Relaxed);
        }
    });
    slots
        .into_iter()
        .map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner).1)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Executor, Serial, par_map};

    /// Does the last job first.
    struct Backwards;

    impl Executor for Backwards {
        fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            (0..jobs).rev().for_each(job);
        }
    }

    #[test]
    fn answers_keep_the_order_of_the_items() {
        let squares = par_map(&Backwards, (0..100).collect(), |i: u32| Some(i * i));
        assert_eq!(squares, Some((0..100).map(|i| i * i).collect()));
    }

    #[test]
    fn one_item_without_an_answer_leaves_none() {
        let answers = par_map(&Serial, (0..100).collect(), |i: u32| (i != 57).then_some(i));
        assert_eq!(answers, None);
    }
}
