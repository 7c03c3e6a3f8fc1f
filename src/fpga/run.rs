//! Runs a tool and tells how far it is.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::cosim::{Settings, process};
use crate::error::Result;

/// What a tool is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    Synthesis,
    Placement,
    /// By this program, between the other two.
    DetailedPlacement,
    Routing,
}

/// Is told each stage when it begins.
pub type Progress<'a> = &'a (dyn Fn(Stage) + Sync);

/// Runs a line in a folder; what it prints goes to `log` there.
///
/// # Errors
/// As [`process::run`].
pub(super) fn run(
    line: &[String],
    folder: &Path,
    first: Stage,
    settings: &Settings,
    progress: Progress,
) -> Result<()> {
    run_within(None, line, folder, first, settings, progress).map(drop)
}

/// The same, but the router has only so many iterations; whether it came to its end with them.
///
/// # Errors
/// As [`process::run`].
pub(super) fn run_within(
    iterations: Option<u32>,
    line: &[String],
    folder: &Path,
    first: Stage,
    settings: &Settings,
    progress: Progress,
) -> Result<bool> {
    let log = folder.join("log");
    let done = AtomicBool::new(false);
    progress(first);
    std::thread::scope(|scope| {
        if first == Stage::Placement {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    if routes(&log) {
                        progress(Stage::Routing);
                        return;
                    }
                    std::thread::park_timeout(Duration::from_millis(300));
                }
            });
        }
        let within = || iterations.is_none_or(|most| iterations_of(&log) <= most);
        let result = process::run_while(line, folder, &log, settings, &within);
        done.store(true, Ordering::Relaxed);
        // It may have ended before anybody looked.
        Ok(result? && within())
    })
}

/// Iterations that the first router says that it has made, in a table of which each line begins with them.
fn iterations_of(log: &Path) -> u32 {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let made = |line: &str| line.strip_prefix("Info:")?.split_once('|')?.0.trim().parse().ok();
    text.lines().rev().find_map(made).unwrap_or(0)
}

/// Whether nextpnr says that it routes.
fn routes(log: &Path) -> bool {
    std::fs::read(log).is_ok_and(|text| text.windows(9).any(|window| window == b"Routing.."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_router_that_needs_too_many_iterations_is_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let runs = |script: &str| {
            let line: Vec<String> = ["/bin/sh", "-c", script].map(String::from).into();
            let settings = Settings { timeout: Duration::from_secs(60), ..Settings::default() };
            run_within(Some(7000), &line, folder.path(), Stage::Routing, &settings, &|_| {}).unwrap()
        };
        assert!(runs("echo 'Info: 6000 | 3 |'; echo 'Info: 7000 | 3 |'; echo 'Info: Routing complete.'"));
        // One that would go on for longer than anybody waits, and one that has ended meanwhile.
        assert!(!runs("echo 'Info:   8000 |  3 |'; sleep 50"));
        assert!(!runs("echo 'Info:   8000 |  3 |'; echo 'Info: Routing complete.'"));
    }
}
