//! The device under test and what is asked of it: any core with one AXI4-Stream in and one out.
//!
//! ```text
//!              ┌───────────── Dut ─────────────┐
//! s_axis_* ──► │ files, top module, two shapes │ ──► m_axis_*        aclk, aresetn (active low)
//!              └───────────────────────────────┘
//! ```

use super::{Beat, Port, Stall};
use crate::{Error, Result};
use std::path::PathBuf;

/// A core as Verilog text and the shapes of its two streams.
#[derive(Clone, Debug)]
pub struct Dut {
    /// Name of the top module.
    pub top: String,
    /// File name and text; those that do not end in `.v` only lie beside the others (include files,
    /// contents of ROMs).
    pub files: Vec<(String, String)>,
    /// `s_axis_tdata`, `s_axis_tkeep`, `s_axis_tuser`, `s_axis_tlast`, where present.
    pub input: Port,
    /// `m_axis_tdata`, `m_axis_tkeep`, `m_axis_tuser`, `m_axis_tlast`, where present.
    pub output: Port,
    /// Asserted by the testbench when given.
    pub latency: Option<Latency>,
}

/// Clocks from the acceptance of one input beat to the first valid output, while nothing stalls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latency {
    /// Index of the input beat, from 0: usually the last one of the first packet.
    pub beat: u64,
    /// Output valid at clock `t + clocks` when that beat was accepted at clock `t`.
    pub clocks: u64,
}

impl Dut {
    /// Refuses what no testbench could be written for.
    pub fn check(&self) -> Result<()> {
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !self.top.starts_with(|c: char| c.is_ascii_alphabetic()) || !self.top.chars().all(word) {
            return Err(Error::usage(format!("'{}' is no name for a module", self.top)));
        }
        let plain = |c: char| word(c) || c == '.' || c == '-';
        for (name, _) in &self.files {
            if !name.starts_with(word) || !name.chars().all(plain) {
                return Err(Error::usage(format!("'{name}' is no plain file name")));
            }
        }
        self.input.check("s_axis")?;
        self.output.check("m_axis")
    }

    /// The names of the Verilog sources, in the order given.
    pub(super) fn sources(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(name, _)| name.as_str()).filter(|name| name.ends_with(".v"))
    }
}

/// What goes in, what must come out, and under which stalls.
#[derive(Clone, Debug)]
pub struct Stimulus {
    pub input: Vec<Beat>,
    /// Bytes whose `tkeep` is 0 here are not compared.
    pub expected: Vec<Beat>,
    /// When the testbench holds back its next input beat.
    pub gaps: Stall,
    /// When the testbench refuses an output beat.
    pub back_pressure: Stall,
    /// Seed of both patterns.
    pub seed: u64,
    /// Clocks from the release of reset to the last output beat; a core that needs another number
    /// fails, however right its values are.
    pub expected_clocks: Option<u64>,
    /// Clocks without any transfer after which the core counts as hanging.
    pub patience: u64,
    /// Where to write the waveform around the first failure.
    pub vcd: Option<PathBuf>,
}

impl Stimulus {
    /// No stalls, no expected number of clocks, no waveform.
    pub fn new(input: Vec<Beat>, expected: Vec<Beat>) -> Self {
        Stimulus {
            input,
            expected,
            gaps: Stall::None,
            back_pressure: Stall::None,
            seed: 0,
            expected_clocks: None,
            patience: 20_000,
            vcd: None,
        }
    }

    /// Refuses beats that do not have the shape of their port.
    pub(super) fn check(&self, dut: &Dut) -> Result<()> {
        let streams = [("input", &self.input, &dut.input), ("expected", &self.expected, &dut.output)];
        for (name, beats, port) in streams {
            if let Some(at) = beats.iter().position(|beat| !port.fits(beat)) {
                return Err(Error::usage(format!("{name} beat {at} does not have its port's shape"))
                    .help("words of 64 bits, the bits above the width zero; see cosim::Beat"));
            }
        }
        Ok(())
    }

    /// For each clock of the pattern, whether an input beat may be offered.
    pub fn offer_pattern(&self) -> Vec<bool> {
        self.gaps.pattern(self.seed.wrapping_mul(2))
    }

    /// For each clock of the pattern, whether `m_axis_tready` is high.
    pub fn ready_pattern(&self) -> Vec<bool> {
        self.back_pressure.pattern(self.seed.wrapping_mul(2).wrapping_add(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(top: &str, file: &str) -> Result<()> {
        let port = Port { data: 8, ..Port::default() };
        let files = vec![(file.to_string(), String::new())];
        Dut { top: top.into(), files, input: port.clone(), output: port, latency: None }.check()
    }

    #[test]
    fn names_that_would_lead_elsewhere_are_refused() {
        assert!(named("loop_fd", "loop_fd-2.v").is_ok());
        for (top, file) in [("loop-fd", "a.v"), ("", "a.v"), ("a", "../a.v"), ("a", "-o"), ("a", "")] {
            assert!(named(top, file).is_err(), "{top}, {file}");
        }
    }

    #[test]
    fn a_beat_of_another_shape_is_refused_with_its_index() {
        let port = Port { data: 8, ..Port::default() };
        let dut =
            Dut { top: "a".into(), files: vec![], input: port.clone(), output: port.clone(), latency: None };
        let mut stimulus = Stimulus::new(vec![port.beat(); 3], Vec::new());
        assert!(stimulus.check(&dut).is_ok());
        stimulus.input[2].data[0] = 0x100;
        assert!(stimulus.check(&dut).unwrap_err().what.starts_with("input beat 2"));
    }
}
