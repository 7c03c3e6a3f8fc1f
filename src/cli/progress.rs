//! Progress on standard error, while a command works: only on a terminal, and never with `--quiet`.
//!
//! What is shown disappears when the work is done, so that nothing but the result remains.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::{
    borrow::Cow,
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

static QUIET: AtomicBool = AtomicBool::new(false);

pub(super) fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// A line on standard error that stays; not with `--quiet`.
pub(super) fn note(line: impl std::fmt::Display) {
    if !QUIET.load(Ordering::Relaxed) {
        eprintln!("{line}");
    }
}

/// One piece of work that is shown until it is dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// Work of unknown length: "building with verilator".
    pub fn waiting(work: impl Into<Cow<'static, str>>) -> Self {
        let bar = Self::start(
            ProgressBar::with_draw_target(None, target()),
            "{spinner} {msg} {elapsed:.dim}",
            work,
        );
        bar.0.enable_steady_tick(Duration::from_millis(100));
        bar
    }

    /// Work in `steps` steps.
    pub fn counting(work: impl Into<Cow<'static, str>>, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), target());
        Self::start(bar, "{msg} {bar:30} {human_pos}/{human_len} {eta:.dim}", work)
    }

    fn start(bar: ProgressBar, template: &str, work: impl Into<Cow<'static, str>>) -> Self {
        // The templates are the two above, and the tests draw both.
        bar.set_style(ProgressStyle::with_template(template).expect("a fixed template"));
        bar.set_message(work);
        Progress(bar)
    }

    pub fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }

    /// Says what is being done now.
    pub fn say(&self, work: impl Into<Cow<'static, str>>) {
        self.0.set_message(work);
    }

    /// Prints a line above what is shown; it stays.
    pub fn remark(&self, text: impl AsRef<str>) {
        self.0.println(text);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// The terminal behind standard error; indicatif hides the progress by itself where there is none.
fn target() -> ProgressDrawTarget {
    if QUIET.load(Ordering::Relaxed) { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_can_be_shown() {
        let waiting = Progress::waiting("building");
        waiting.remark("warm cache");
        let counting = Progress::counting("patches", 3);
        counting.advance(2);
        assert_eq!((counting.0.position(), counting.0.length()), (2, Some(3)));
    }
}
