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

/// The same, but the first router is stopped where it is going to need more iterations than so many; whether it came to
/// its end.
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
        let within = || iterations.is_none_or(|most| iterations_needed(&log) <= most);
        let result = process::run_while(line, folder, &log, settings, &within);
        done.store(true, Ordering::Relaxed);
        // It may have ended before anybody looked.
        Ok(result? && within())
    })
}

/// Iterations after which the share of arcs that the first router has done tells how many it will need.
const ENOUGH_TO_TELL: u32 = 50_000;

/// Iterations that the first router is going to need, by the worst line of its table:
///
/// ```text
/// Routing 181505 arcs.
///   IterCnt |  w/ripup   wo/ripup |  w/r  wo/r |      arcs| batch(sec) total(sec)|
///    120000 |    36113      83886 |  234   766 |    161629|       5.98     257.28|
/// ```
///
/// An iteration routes an arc, but may take others away that have to be routed again. All lines count, so that it does
/// not matter when somebody looks.
fn iterations_needed(log: &Path) -> u32 {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let lines = || text.lines().filter_map(|line| line.strip_prefix("Info:"));
    let all =
        lines().find_map(|line| line.trim().strip_prefix("Routing ")?.strip_suffix(" arcs.")?.parse().ok());
    let all: u64 = all.unwrap_or(0);
    let needed = lines().filter_map(|line| {
        let columns: Vec<&str> = line.split('|').map(str::trim).collect();
        let [made, left]: [u64; 2] = [columns.first()?.parse().ok()?, columns.get(3)?.parse().ok()?];
        let done = all.saturating_sub(left).max(1);
        let needed = if made < u64::from(ENOUGH_TO_TELL) { made } else { made.max(made * all / done) };
        Some(u32::try_from(needed).unwrap_or(u32::MAX))
    });
    needed.max().unwrap_or(0)
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
        let runs = |lines: &[[u32; 2]], then: &str| {
            let lines: String = lines
                .iter()
                .map(|[made, left]| format!("echo 'Info: {made} | 3 7 | 1 9 | {left}| 1.2 3.4|';"))
                .collect();
            let script = format!("echo 'Info: Routing 9000 arcs.'; {lines} {then}");
            let line: Vec<String> = ["/bin/sh", "-c", &script].map(String::from).into();
            let settings = Settings { timeout: Duration::from_secs(60), ..Settings::default() };
            run_within(Some(70_000), &line, folder.path(), Stage::Routing, &settings, &|_| {}).unwrap()
        };
        let complete = "echo 'Info: Routing complete.'";
        // Slow at first, and as many as it may need.
        assert!(runs(&[[1000, 9000], [50_000, 2500], [70_000, 0]], complete));
        // More, though the end is near, and one that goes on for longer than anybody waits; it may have ended meanwhile.
        assert!(!runs(&[[71_000, 10]], "sleep 50"));
        assert!(!runs(&[[50_000, 2600]], "sleep 50"));
        assert!(!runs(&[[50_000, 9100], [60_000, 0]], complete));
    }
}
