//! Who does work that can be shared out: the library starts no threads, its caller may.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Workers that a caller brings, for the few things that take seconds.
///
/// ```
/// use taxel::crew::{OneByOne, shared_out};
/// assert_eq!(shared_out(&OneByOne, vec![1, 2, 3], |n| Some(n * n)), Some(vec![1, 4, 9]));
/// assert_eq!(shared_out(&OneByOne, vec![1, 2, 3], |n| (n != 2).then_some(n)), None);
/// ```
pub trait Crew: Sync {
    /// Does every job from 0 to `jobs` − 1 once, in any order, on any thread; returns when all are done.
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync));
}

/// A crew of one: the caller's own thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct OneByOne;

impl Crew for OneByOne {
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).for_each(job);
    }
}

/// Does something to every item; answers keep the order of the items. Nothing as soon as one item has no answer.
/// What an item gives must not depend on the others, so that the size of the crew cannot matter.
pub fn shared_out<I: Send, T: Send>(
    crew: &dyn Crew,
    items: Vec<I>,
    work: impl Fn(I) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    let slots: Vec<Mutex<(Option<I>, Option<T>)>> = items
        .into_iter()
        .map(|item| Mutex::new((Some(item), None)))
        .collect();
    let failed = AtomicBool::new(false);
    crew.each(slots.len(), &|i| {
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
    use super::{Crew, OneByOne, shared_out};

    /// Does the last job first.
    struct Backwards;

    impl Crew for Backwards {
        fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            (0..jobs).rev().for_each(job);
        }
    }

    #[test]
    fn answers_keep_the_order_of_the_items() {
        let squares = shared_out(&Backwards, (0..100).collect(), |i: u32| Some(i * i));
        assert_eq!(squares, Some((0..100).map(|i| i * i).collect()));
    }

    #[test]
    fn one_item_without_an_answer_leaves_none() {
        let answers = shared_out(&OneByOne, (0..100).collect(), |i: u32| {
            (i != 57).then_some(i)
        });
        assert_eq!(answers, None);
    }
}
