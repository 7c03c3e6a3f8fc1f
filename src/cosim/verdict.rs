//! Reads what a testbench prints about its run.
//!
//! ```text
//! mismatch: beat=5 clock=17            what is wrong, the first of each kind
//! total: beats=9 clocks=21 mismatches=2 accepted=9
//! measured: latency=3 stalled=0
//! FAIL
//! ```

use super::{Failure, Stimulus};
use std::collections::BTreeMap;

/// A testbench's own judgement.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Verdict {
    pub passed: bool,
    pub clocks: u64,
    pub mismatches: u64,
    pub latency: Option<i64>,
    /// All but the wrong values: those are compared again in Rust, which knows the lanes.
    pub failures: Vec<Failure>,
}

impl Verdict {
    /// `None` when there is neither PASS nor FAIL: the simulation did not come to its end.
    pub(super) fn read(text: &str, stimulus: &Stimulus) -> Option<Verdict> {
        let mut verdict = Verdict::default();
        let mut ended = false;
        for line in text.lines().map(str::trim) {
            if line == "PASS" || line == "FAIL" {
                (ended, verdict.passed) = (true, line == "PASS");
            } else if let Some((kind, rest)) = line.split_once(": ") {
                verdict.read_line(kind, &Fields::of(rest), stimulus);
            }
        }
        ended.then_some(verdict)
    }

    fn read_line(&mut self, kind: &str, fields: &Fields, stimulus: &Stimulus) {
        let signal = || fields.0.get("signal").unwrap_or(&"").to_string();
        let (clock, beat) = (fields.number("clock"), fields.number("beat"));
        let failure = match kind {
            "unstable" => Failure::Unstable { signal: signal(), clock, beat },
            "unknown" => Failure::Unknown { signal: signal(), clock, beat },
            "extra" => Failure::Extra { clock, beat },
            "hang" => Failure::Hang {
                clock,
                quiet: fields.number("quiet"),
                accepted: fields.number("accepted"),
                inputs: stimulus.input.len() as u64,
                received: beat,
                outputs: stimulus.expected.len() as u64,
            },
            "latency" => Failure::Latency {
                expected: fields.number("expected"),
                measured: fields.signed("measured"),
                clock,
            },
            "clocks" => {
                Failure::Clocks { expected: fields.number("expected"), measured: fields.number("measured") }
            }
            "total" => {
                self.clocks = fields.number("clocks");
                self.mismatches = fields.number("mismatches");
                return;
            }
            "measured" => {
                self.latency = Some(fields.signed("latency"));
                return;
            }
            _ => return,
        };
        self.failures.push(failure);
    }
}

/// `name=value` pairs apart by spaces.
struct Fields<'a>(BTreeMap<&'a str, &'a str>);

impl<'a> Fields<'a> {
    fn of(text: &'a str) -> Self {
        Fields(text.split_whitespace().filter_map(|pair| pair.split_once('=')).collect())
    }
    fn number(&self, name: &str) -> u64 {
        self.0.get(name).and_then(|text| text.parse().ok()).unwrap_or(0)
    }
    fn signed(&self, name: &str) -> i64 {
        self.0.get(name).and_then(|text| text.parse().ok()).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_run_is_read() {
        let stimulus = Stimulus::new(Vec::new(), Vec::new());
        let text = "mismatch: beat=5 clock=17\n\
                    unstable: signal=m_axis_tdata clock=19 beat=6\n\
                    total: beats=9 clocks=21 mismatches=2 accepted=9\n\
                    measured: latency=-3 stalled=0\nFAIL\n- x.v:1: Verilog $finish\n";
        let unstable = Failure::Unstable { signal: "m_axis_tdata".into(), clock: 19, beat: 6 };
        assert_eq!(
            Verdict::read(text, &stimulus),
            Some(Verdict {
                passed: false,
                clocks: 21,
                mismatches: 2,
                latency: Some(-3),
                failures: vec![unstable]
            })
        );
    }

    #[test]
    fn a_run_without_its_last_word_is_no_verdict() {
        let stimulus = Stimulus::new(Vec::new(), Vec::new());
        assert_eq!(Verdict::read("total: beats=9\nsegmentation fault\n", &stimulus), None);
    }
}
