//! What can be wrong with a core, as data; the words come last.
//!
//! ```text
//! beat 137 (patch 17, strip 3, index 5), left.y: expected 0x0012a4 (4772), got 0x0012a3 (4771), clock 402
//! ```

use num_bigint::BigInt;
use std::fmt;

/// The bits of one lane or signal, as seen or as expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Number {
    /// Without `0x`, as many digits as the width needs.
    pub hex: String,
    /// Lanes are signed; `tdata` outside of the lanes, `tkeep`, `tuser` and `tlast` are not.
    pub value: BigInt,
}

/// One thing that is wrong. Beats are counted from 0 at the output, clocks from the release of reset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The first beat that differs, and where.
    Value {
        beat: u64,
        clock: u64,
        /// Name of the lane (`left.x`), else `tdata[15:8]`, `tkeep`, `tuser`, `tlast`.
        signal: String,
        expected: Number,
        got: Number,
        /// Whether it looks as if beats were lost or repeated.
        shift: Option<Shift>,
    },
    /// `m_axis_tvalid` fell, or the beat changed, before it was taken.
    Unstable { signal: String, clock: u64, beat: u64 },
    /// A bit is neither 0 nor 1 where it matters (Icarus only; the others know no such bits).
    Unknown { signal: String, clock: u64, beat: u64 },
    /// A beat came after the last expected one.
    Extra { clock: u64, beat: u64 },
    /// No transfer for `quiet` clocks, with work left.
    Hang { clock: u64, quiet: u64, accepted: u64, inputs: u64, received: u64, outputs: u64 },
    /// Everything right but too early or too late.
    Latency { expected: u64, measured: i64, clock: u64 },
    /// Everything right but it took another number of clocks.
    Clocks { expected: u64, measured: u64 },
}

/// What the beats after the first wrong one suggest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shift {
    Lost,
    Repeated,
}

impl Failure {
    /// The clock at which it shows.
    pub fn clock(&self) -> u64 {
        match *self {
            Failure::Value { clock, .. }
            | Failure::Unstable { clock, .. }
            | Failure::Unknown { clock, .. }
            | Failure::Extra { clock, .. }
            | Failure::Hang { clock, .. }
            | Failure::Latency { clock, .. } => clock,
            Failure::Clocks { measured, .. } => measured.saturating_sub(1),
        }
    }

    /// The clocks worth looking at: 32 before, 8 after; for a hang around the last transfer.
    pub fn window(&self) -> std::ops::RangeInclusive<u64> {
        let clock = match *self {
            Failure::Hang { clock, quiet, .. } => clock.saturating_sub(quiet),
            _ => self.clock(),
        };
        clock.saturating_sub(32)..=clock + 8
    }

    /// The output beat it concerns.
    pub fn beat(&self) -> Option<u64> {
        match *self {
            Failure::Value { beat, .. }
            | Failure::Unstable { beat, .. }
            | Failure::Unknown { beat, .. }
            | Failure::Extra { beat, .. } => Some(beat),
            Failure::Hang { received, .. } => Some(received),
            Failure::Latency { .. } | Failure::Clocks { .. } => None,
        }
    }

    /// In words; `locate` turns the index of a beat into the user's terms ("patch 17, strip 3, index 5")
    /// or into an empty text.
    pub fn describe(&self, locate: &dyn Fn(u64) -> String) -> String {
        let beat = |index: u64| match locate(index) {
            place if place.is_empty() => format!("beat {index}"),
            place => format!("beat {index} ({place})"),
        };
        match self {
            Failure::Value { beat: index, clock, signal, expected, got, shift } => {
                let hint = match shift {
                    Some(Shift::Lost) => "; as if a beat was lost here",
                    Some(Shift::Repeated) => "; as if the beat before came twice",
                    None => "",
                };
                let place = beat(*index);
                format!("{place}, {signal}: expected {expected}, got {got}, clock {clock}{hint}")
            }
            Failure::Unstable { signal, clock, beat: index } if signal.ends_with("tvalid") => {
                format!("{}: {signal} fell at clock {clock} before tready took it", beat(*index))
            }
            Failure::Unstable { signal, clock, beat: index } => {
                format!("{}: {signal} changed at clock {clock} before tready took it", beat(*index))
            }
            Failure::Unknown { signal, clock, beat: index } => {
                format!("{}: {signal} has unknown bits (x) at clock {clock}", beat(*index))
            }
            Failure::Extra { clock, beat: index } => {
                format!("a beat too many at clock {clock}: only {index} are expected")
            }
            Failure::Hang { clock, quiet, accepted, inputs, received, outputs } => format!(
                "hangs: no transfer for {quiet} clocks up to clock {clock}, with {accepted} of \
                 {inputs} input beats accepted and {received} of {outputs} output beats received"
            ),
            Failure::Latency { expected, measured, .. } => {
                format!("the first output came after {measured} clocks, its latency is {expected}")
            }
            Failure::Clocks { expected, measured } => {
                format!("every beat is right, but it took {measured} clocks instead of {expected}")
            }
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{} ({})", self.hex, self.value)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.describe(&|_| String::new()))
    }
}
