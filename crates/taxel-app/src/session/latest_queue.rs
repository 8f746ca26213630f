//! A queue that never makes its writer wait: when it is full, the oldest goes.

use std::collections::VecDeque;
use std::sync::PoisonError;

use super::sync::{Condvar, Mutex, MutexGuard, unit_tests};

struct Held<T> {
    items: VecDeque<T>,
    closed: bool,
    /// Whether the reader works on what it took last.
    in_work: bool,
}

/// The newest few of a stream.
pub(super) struct LatestQueue<T> {
    held: Mutex<Held<T>>,
    changed: Condvar,
    taken: Condvar,
    most: usize,
}

impl<T> LatestQueue<T> {
    pub(super) fn new(most: usize) -> Self {
        Self {
            held: Mutex::new(Held {
                items: VecDeque::with_capacity(most),
                closed: false,
                in_work: false,
            }),
            changed: Condvar::new(),
            taken: Condvar::new(),
            most,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Held<T>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an item; whether the oldest had to go for it.
    pub(super) fn push(&self, item: T) -> bool {
        let mut held = self.lock();
        let full = held.items.len() == self.most;
        if full {
            held.items.pop_front();
        }
        held.items.push_back(item);
        drop(held);
        self.changed.notify_one();
        full
    }

    /// Adds an item when there is room for it.
    pub(super) fn push_waiting(&self, item: T) {
        let mut held = self.lock();
        while held.items.len() == self.most && !held.closed {
            held = self
                .taken
                .wait(held)
                .unwrap_or_else(PoisonError::into_inner);
        }
        held.items.push_back(item);
        drop(held);
        self.changed.notify_one();
    }

    /// Whether nothing waits, and the reader has come back for more.
    pub(super) fn is_idle(&self) -> bool {
        let held = self.lock();
        held.items.is_empty() && !held.in_work
    }

    /// The oldest there is, waiting for one; `None` when it is closed and empty. What was taken before is done.
    pub(super) fn pop(&self) -> Option<T> {
        let mut held = self.lock();
        held.in_work = false;
        loop {
            if let Some(item) = held.items.pop_front() {
                held.in_work = true;
                self.taken.notify_one();
                return Some(item);
            }
            if held.closed {
                return None;
            }
            held = self
                .changed
                .wait(held)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// No more will come.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
        self.taken.notify_all();
    }
}

unit_tests! {
    mod tests {
        use super::*;

        #[test]
        fn the_newest_stay_and_nobody_waits() {
            let queue = LatestQueue::new(2);
            assert!(!queue.push(1));
            assert!(!queue.push(2));
            assert!(queue.push(3));
            queue.close();
            assert_eq!(
                [queue.pop(), queue.pop(), queue.pop()],
                [Some(2), Some(3), None]
            );
        }

        #[test]
        fn it_is_idle_once_what_was_taken_last_is_done() {
            let queue = LatestQueue::new(2);
            assert!(queue.is_idle());
            queue.push(1);
            assert!(!queue.is_idle());
            assert_eq!(queue.pop(), Some(1));
            assert!(!queue.is_idle());
            queue.close();
            assert_eq!(queue.pop(), None);
            assert!(queue.is_idle());
        }
    }
}
