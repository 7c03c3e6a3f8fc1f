//! Work in numbered pieces on every core; the results stand in the order of the pieces, so that they do
//! not depend on how many threads there were.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// `work(0), .., work(count - 1)`, on `threads` threads.
pub fn map<T: Send>(threads: usize, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    map_with(threads, count, || (), |(), index| work(index))
}

/// The same with something that each thread makes once and uses for all its pieces.
pub fn map_with<T: Send, S>(
    threads: usize,
    count: usize,
    start: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let share = || {
        let (mut state, mut done) = (start(), Vec::new());
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return done;
            }
            done.push((index, work(&mut state, index)));
        }
    };
    let mut pieces: Vec<(usize, T)> = if threads <= 1 || count <= 1 {
        share()
    } else {
        thread::scope(|scope| {
            let workers: Vec<_> = (0..threads.min(count)).map(|_| scope.spawn(share)).collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect()
        })
    };
    pieces.sort_by_key(|(index, _)| *index);
    pieces.into_iter().map(|(_, piece)| piece).collect()
}

/// As many threads as the machine runs at once.
pub fn available() -> usize {
    thread::available_parallelism().map_or(1, |n| n.get())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_order_is_that_of_the_pieces() {
        let squares: Vec<usize> = (0..100).map(|i| i * i).collect();
        for threads in [1, 2, 7] {
            assert_eq!(super::map(threads, 100, |i| i * i), squares);
        }
    }
}
