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

/// The same, but the first router is stopped where it gets on with too many iterations for an arc; whether it came to
/// its end.
///
/// # Errors
/// As [`process::run`].
pub(super) fn run_within(
    iterations_an_arc: Option<u64>,
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
        let within = || iterations_an_arc.is_none_or(|most| gets_on(&log, most));
        let result = process::run_while(line, folder, &log, settings, &within);
        done.store(true, Ordering::Relaxed);
        // It may have ended before anybody looked.
        Ok(result? && within())
    })
}

/// Iterations after which it shows how the first router gets on.
const ENOUGH_TO_TELL: u64 = 50_000;

/// Whether the first router needs no more iterations for each arc that it has done, by all lines of its table, so that it
/// does not matter when somebody looks:
///
/// ```text
/// Routing 181505 arcs.
///   IterCnt |  w/ripup   wo/ripup |  w/r  wo/r |      arcs| batch(sec) total(sec)|
///    120000 |    36113      83886 |  234   766 |    161629|       5.98     257.28|
/// ```
///
/// An iteration routes an arc, but may take others away that have to be routed again; and the more of them are, the longer
/// it takes.
fn gets_on(log: &Path, most: u64) -> bool {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let lines = || text.lines().filter_map(|line| line.strip_prefix("Info:"));
    let all = |line: &str| line.trim().strip_prefix("Routing ")?.strip_suffix(" arcs.")?.parse().ok();
    let all: u64 = lines().find_map(all).unwrap_or(0);
    lines().all(|line| {
        let column = |at: usize| line.split('|').nth(at)?.trim().parse::<u64>().ok();
        let (Some(made), Some(left)) = (column(0), column(3)) else { return true };
        made < ENOUGH_TO_TELL || made <= most * all.saturating_sub(left)
    })
}

/// Whether nextpnr says that it routes.
fn routes(log: &Path) -> bool {
    std::fs::read(log).is_ok_and(|text| text.windows(9).any(|window| window == b"Routing.."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_router_that_does_not_get_on_is_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let runs = |lines: &[[u32; 2]], then: &str| {
            let line =
                |[made, left]: &[u32; 2]| format!("echo 'Info: {made} | 3 7 | 1 9 | {left}| 1.2 3.4|';");
            let lines: String = lines.iter().map(line).collect();
            let script = format!("echo 'Info: Routing 90000 arcs.'; {lines} {then}");
            let line: Vec<String> = ["/bin/sh", "-c", &script].map(String::from).into();
            let settings = Settings { timeout: Duration::from_secs(60), ..Settings::default() };
            run_within(Some(2), &line, folder.path(), Stage::Routing, &settings, &|_| {}).unwrap()
        };
        let complete = "echo 'Info: Routing complete.'";
        // Slow at first, and two for an arc.
        assert!(runs(&[[1000, 90_000], [50_000, 65_000], [180_000, 0]], complete));
        // More, though the end is near, and one that goes on for longer than anybody waits; it may have ended meanwhile.
        assert!(!runs(&[[50_000, 65_000], [180_000, 10]], "sleep 50"));
        assert!(!runs(&[[50_000, 65_001]], "sleep 50"));
        assert!(!runs(&[[50_000, 91_000], [60_000, 0]], complete));
    }
}
