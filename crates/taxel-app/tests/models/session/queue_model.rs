//! The drop-oldest queue: nobody waits for ever, what goes is counted, and the newest always arrives.

use std::sync::Arc;

use shuttle::thread;

use super::latest_queue::LatestQueue;

/// What a reader gets until the queue is closed.
fn all_of(queue: &LatestQueue<u32>) -> Vec<u32> {
    std::iter::from_fn(|| queue.pop()).collect()
}

#[test]
fn what_does_not_arrive_is_counted_and_the_newest_arrives() {
    let model = || {
        const PUSHED: u32 = 4;
        let queue = Arc::new(LatestQueue::new(2));
        let writer = queue.clone();
        let writer = thread::spawn(move || {
            let gone = (0..PUSHED).filter(|&i| writer.push(i)).count();
            writer.close();
            gone
        });
        let arrived = all_of(&queue);
        let gone = writer.join().unwrap();
        assert_eq!(arrived.len() + gone, PUSHED as usize);
        assert!(arrived.is_sorted_by(|a, b| a < b), "{arrived:?}");
        assert_eq!(arrived.last(), Some(&(PUSHED - 1)));
    };
    // In order; there are too many for all.
    shuttle::check_dfs(model, Some(20_000));
}

#[test]
fn writers_that_wait_lose_nothing() {
    let model = || {
        let queue = Arc::new(LatestQueue::new(1));
        let writers = [0, 10].map(|first| {
            let queue = queue.clone();
            thread::spawn(move || (first..first + 3).for_each(|i| queue.push_waiting(i)))
        });
        let reader = queue.clone();
        let reader = thread::spawn(move || all_of(&reader));
        for writer in writers {
            writer.join().unwrap();
        }
        queue.close();
        let mut arrived = reader.join().unwrap();
        arrived.sort_unstable();
        assert_eq!(arrived, [0, 1, 2, 10, 11, 12]);
    };
    shuttle::check_random(model, 5000);
    shuttle::check_pct(model, 5000, 3);
}

/// A session that ends closes the queue while somebody waits at either end.
#[test]
fn a_close_wakes_whoever_waits() {
    let model = || {
        let queue = Arc::new(LatestQueue::new(1));
        let (writer, reader) = (queue.clone(), queue.clone());
        let writer = thread::spawn(move || (0..3).for_each(|i| writer.push_waiting(i)));
        let reader = thread::spawn(move || reader.pop());
        queue.close();
        writer.join().unwrap();
        let _ = reader.join().unwrap();
    };
    shuttle::check_random(model, 5000);
    shuttle::check_pct(model, 5000, 3);
}
