//! Co-simulation: the same vectors through every simulator, every bit compared.
//!
//! ```text
//!            ┌─► verilator            C++ harness, fast ──────┐
//! Dut ───────┼─► verilator-testbench  the emitted testbench ──┤
//! Stimulus   ├─► icarus               the emitted testbench ──┼─► Outcome: beats, clocks, failures
//!            └─► builtin              a Clocked model ────────┘
//! ```
//!
//! All of them stall on the same clocks, make the same checks (values, order, `tlast`, `tuser`, `tkeep`,
//! stability under stall, unknown bits, latency, number of clocks, hanging) and say what is wrong in
//! the same words.
//!
//! ```
//! use subdiv_rtl::cosim::{Beat, Builtin, Clocked, Dut, Handshake, Port, Simulator, Stimulus};
//!
//! /// Passes every beat on in the same clock.
//! struct Wire;
//! impl Clocked for Wire {
//!     fn reset(&mut self) {}
//!     fn clock(&mut self, input: Option<&Beat>, output_ready: bool) -> Handshake {
//!         Handshake { input_ready: output_ready, output: input.cloned() }
//!     }
//!     fn trace(&mut self, _: Option<&std::path::Path>, _: u64) -> subdiv_rtl::Result<()> {
//!         Ok(())
//!     }
//! }
//!
//! let port = Port::of_lanes([("x", 16)]);
//! let dut = Dut {
//!     top: "wire_core".into(),
//!     files: vec![], // the Verilog, for the external simulators
//!     input: port.clone(),
//!     output: port.clone(),
//!     latency: None,
//! };
//! let stimulus = Stimulus {
//!     back_pressure: "one-in-3".parse()?,
//!     ..Stimulus::new(vec![port.beat_of(&[5]), port.beat_of(&[-6])], vec![port.beat_of(&[5]); 2])
//! };
//! let outcome = Builtin::new(|| Ok(Wire)).run(&dut, &stimulus)?;
//! assert_eq!(
//!     outcome.failures[0].describe(&|beat| format!("patch {beat}")),
//!     "beat 1 (patch 1), x: expected 0x0005 (5), got 0xfffa (-6), clock 5"
//! );
//! # Ok::<(), subdiv_rtl::Error>(())
//! ```

mod beat;
mod build_cache;
mod builtin;
mod compare;
mod core;
mod coverage;
mod dut;
mod external;
mod failure;
mod icarus;
pub mod loop_bench;
mod loop_traffic;
pub mod loop_trial;
mod outcome;
pub(crate) mod process;
mod settings;
mod stall;
pub mod strip_bench;
pub mod strip_lanes;
mod testbench;
pub(crate) mod tools;
mod vectors;
mod verdict;
mod verilator;
mod work;
mod workarounds;

pub(crate) use build_cache::{hash, user_cache};

pub use beat::{Beat, Lane, Port};
pub use builtin::{Builtin, Clocked, Handshake};
pub use core::{Model, device};
pub use coverage::{Coverage, CoveragePoint};
pub use dut::{Dut, Latency, Stimulus};
pub use external::{External, Tool};
pub use failure::{Failure, Number, Shift};
pub use outcome::Outcome;
pub use settings::Settings;
pub use stall::{PATTERN, Stall};
pub use testbench::{testbench, testbench_name};
pub use tools::{ToolStatus, Version, tools};
pub use vectors::{write_beats, write_stalls};

use crate::Result;

/// One way to run a core.
pub trait Simulator {
    /// As on the command line: `verilator`, `verilator-testbench`, `icarus`, `builtin`.
    fn name(&self) -> &'static str;

    /// The version that would run; [`crate::Kind::ToolMissing`] with the line that installs it.
    fn version(&self) -> Result<String>;

    /// Runs the core. A wrong core is an `Ok` with failures inside; `Err` means that there is no
    /// verdict: a tool is missing, failed, or was stopped because it took too long.
    fn run(&self, dut: &Dut, stimulus: &Stimulus) -> Result<Outcome>;
}
