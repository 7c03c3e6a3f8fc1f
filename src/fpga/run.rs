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
        let result = process::run(line, folder, &log, settings);
        done.store(true, Ordering::Relaxed);
        result
    })
}

/// Whether nextpnr says that it routes.
fn routes(log: &Path) -> bool {
    std::fs::read(log).is_ok_and(|text| text.windows(9).any(|window| window == b"Routing.."))
}
