//! All points of a plan on all cores; each result is written as it comes.
//!
//! ```text
//!   points ─► next, next, ... ─► a thread each ─► results ─► the journal, in the order of completion
//!      └─ known already: not done again                └──► in the order of the points: what is returned
//! ```

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

use super::evaluate::Evaluator;
use super::journal::Journal;
use super::point::Point;
use super::record::Record;
use crate::error::Result;

/// How many threads the machine runs at once.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Evaluates the points that the journal does not know, and gives the results of all, in the order of the points.
///
/// `done` is called once for each point that was evaluated now.
///
/// # Errors
/// The first point that cannot be evaluated, or a journal that cannot be written; what was finished before is kept.
pub fn run(
    evaluator: &Evaluator,
    points: &[Point],
    mut journal: Option<&mut Journal>,
    threads: usize,
    mut done: impl FnMut(&Record),
) -> Result<Vec<Record>> {
    let keys: Vec<String> = points.iter().map(Point::key).collect();
    let mut results: Vec<Option<Record>> =
        keys.iter().map(|key| journal.as_ref().and_then(|j| j.known(key).cloned())).collect();
    let open: Vec<usize> = (0..points.len()).filter(|&index| results[index].is_none()).collect();
    let mut waiting: BTreeMap<String, usize> = BTreeMap::new();
    for &index in &open {
        *waiting.entry(Evaluator::stage_name(&points[index])).or_default() += 1;
    }
    let waiting = Mutex::new(waiting);
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel::<(usize, Result<Record>)>();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, open.len().max(1)) {
            let sender = sender.clone();
            let (open, waiting, next, stop) = (&open, &waiting, &next, &stop);
            scope.spawn(move || {
                while let Some(&index) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if stop.load(Ordering::Relaxed) {
                        return;
                    }
                    let result = evaluator.evaluate(&points[index]);
                    release(evaluator, waiting, &points[index]);
                    if sender.send((index, result)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut take = |index: usize, result: Result<Record>| -> Result<()> {
            let record = result?;
            if let Some(journal) = &mut journal {
                journal.append(&record)?;
            }
            done(&record);
            results[index] = Some(record);
            Ok(())
        };
        let mut failure = Ok(());
        for (index, result) in receiver {
            // What was finished beside a failure is written all the same.
            let taken = take(index, result);
            if taken.is_err() && failure.is_ok() {
                stop.store(true, Ordering::Relaxed);
                failure = taken;
            }
        }
        failure
    })?;
    Ok(results.into_iter().flatten().collect())
}

/// Forgets what the point shared when it was the last one to need it.
fn release(evaluator: &Evaluator, waiting: &Mutex<BTreeMap<String, usize>>, point: &Point) {
    let name = Evaluator::stage_name(point);
    // A thread that panicked while it held the lock has ended the run anyway.
    let mut waiting = waiting.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    if let Some(count) = waiting.get_mut(&name) {
        *count -= 1;
        if *count == 0 {
            evaluator.forget(&name);
        }
    }
}
