//! What a simulation has shown.

use super::{Beat, Coverage, Failure};
use crate::{Error, Kind};
use std::path::PathBuf;

/// The verdict of one simulator over one stimulus.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Name and version of the simulator.
    pub name: String,
    pub version: String,
    /// Output beats received.
    pub beats: u64,
    /// Clocks from the release of reset to the last output beat.
    pub clocks: u64,
    /// The clock and the beat, in the order received.
    pub received: Vec<(u64, Beat)>,
    /// Beats that differ, are missing or are too many.
    pub mismatches: u64,
    /// Clocks from the input beat that [`super::Latency`] names to the first valid output.
    pub latency: Option<i64>,
    /// What is wrong, earliest first; at most one of each kind.
    pub failures: Vec<Failure>,
    /// The waveform around the first failure, if one was wanted and something failed.
    pub vcd: Option<PathBuf>,
    /// Where the simulator's files were kept, if that was wanted.
    pub folder: Option<PathBuf>,
    /// Seconds to compile, or to find the compiled simulator in the cache.
    pub build_seconds: f64,
    /// Seconds to write the vectors, simulate, read back and compare.
    pub run_seconds: f64,
    /// Whether the compiled simulator was there already.
    pub cached: bool,
    /// Measured where [`super::Settings::coverage`] asks for it.
    pub coverage: Option<Coverage>,
}

impl Outcome {
    pub fn passed(&self) -> bool {
        self.failures.is_empty()
    }

    /// The first failure as an error of kind [`Kind::Mismatch`]; `locate` turns the index of an output
    /// beat into the user's terms.
    pub fn error(&self, locate: &dyn Fn(u64) -> String) -> Option<Error> {
        let first = self.failures.first()?;
        let others = match self.mismatches {
            0 | 1 => String::new(),
            count => format!(" ({count} beats are wrong or missing)"),
        };
        let what = format!("{}: {}{others}", self.name, first.describe(locate));
        let error = Error::new(Kind::Mismatch, what);
        Some(match &self.vcd {
            Some(vcd) => error.help(format!("look at the waveform: gtkwave {}", vcd.display())),
            None => error,
        })
    }

    /// Whether a received beat has a wrong value.
    pub(super) fn value_differs(&self) -> bool {
        self.failures.iter().any(|failure| matches!(failure, Failure::Value { .. }))
    }

    /// Puts the failures in the order of their clocks; the figures of the whole run come last.
    pub(super) fn sort_failures(&mut self) {
        let whole = |failure: &Failure| matches!(failure, Failure::Latency { .. } | Failure::Clocks { .. });
        self.failures.sort_by_key(|failure| (whole(failure), failure.clock()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_an_error_of_exit_status_1_in_the_users_terms() {
        let failure = |clock| Failure::Unknown { signal: "m_axis_tdata".into(), clock, beat: 9 };
        let mut outcome = Outcome {
            name: "icarus".into(),
            mismatches: 4,
            failures: vec![Failure::Clocks { expected: 1, measured: 2 }, failure(30), failure(20)],
            vcd: Some("wave.vcd".into()),
            ..Outcome::default()
        };
        outcome.sort_failures();
        let error = outcome.error(&|beat| format!("patch {}", beat / 3)).unwrap();
        assert_eq!(error.exit_status(), 1);
        assert_eq!(
            error.what,
            "icarus: beat 9 (patch 3): m_axis_tdata has unknown bits (x) at clock 20 \
             (4 beats are wrong or missing)"
        );
        assert_eq!(error.help.as_deref(), Some("look at the waveform: gtkwave wave.vcd"));
    }
}
