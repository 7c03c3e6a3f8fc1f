//! A core on a real device: synthesis by Yosys, place and route by nextpnr, and what came of it in our names.
//!
//! ```text
//!   core ─► Verilog ─┐
//!            harness ┴► Yosys ─► netlist ─► tidied ─► nextpnr, once for each seed ─► clock, area, critical path
//!                                   └─► cells by unit   └─► on ECP5: placed ─► moved ─► routed
//! ```
//!
//! The tidied netlist of the core alone can also be simulated ([`GateLevel`]).
//!
//! **What is counted.** LUTs and flip-flops are those that nextpnr places, with the cells that it adds itself (carries
//! that enter and leave their chains), without those of the harness, which are counted from its own module. A cell of
//! carry is two LUTs. The units are counted in the tidied netlist by the names of the cells; a LUT between two units
//! belongs to the one whose net gave it its name.

mod block_outputs;
mod cache;
mod cell_models;
mod detailed_placement;
mod device;
pub mod estimate;
mod fan_out;
mod fold;
mod gate_level;
mod harness;
mod names;
mod netlist;
mod nets;
pub mod pipelining;
mod place;
mod ram_pins;
mod report;
mod resets;
mod run;
mod signs;
mod static_timing;
mod structural;
mod synthesis;
mod tidy;
mod timing;
mod tools;

use std::rc::Rc;

pub use device::{Area, DEVICES, Device, Family};
pub use gate_level::GateLevel;
pub use netlist::{Census, Netlist};
pub use report::{Clock, Estimated, Report, SeedClock, Throughput, Unit};
pub use run::{Progress, Stage};
pub use tidy::Tidied;
pub use timing::CriticalPath;
pub use tools::{Tools, find, status};

use crate::cosim::Settings;
use crate::error::Result;
use crate::hdl::{Module, verilog};
use crate::parallel;

/// A core and what it does in a clock.
#[derive(Clone, Debug)]
pub struct Subject {
    /// As on the command line: `loop-fd`.
    pub name: String,
    /// The command that generates it.
    pub command: String,
    pub module: Rc<Module>,
    pub throughput: Throughput,
}

/// How it is measured.
#[derive(Clone, Debug)]
pub struct Options {
    pub device: &'static Device,
    /// Seeds 1 to this one.
    pub seeds: u32,
    /// The clock that the tools are asked for, in MHz.
    pub target_mhz: f64,
    /// Keep and use what was made before.
    pub cached: bool,
    pub settings: Settings,
}

/// Synthesises, places and routes.
///
/// # Errors
/// `ToolMissing` with the line that mends it; `ToolFailed` with what the tool said last, as when the device is full.
pub fn measure(
    subject: &Subject,
    options: &Options,
    progress: &(dyn Fn(u32, Stage) + Sync),
) -> Result<Report> {
    let Options { device, settings, .. } = options;
    let tools = find(device, settings)?;
    let cache = cache::Cache::open(settings, options.cached);
    let mut sources = verilog::print(&subject.module, &subject.command)?;
    sources.push(harness::harness(&subject.module)?);
    let design = synthesis::Design { sources: &sources, top: harness::NAME, pads: true };
    let design = synthesis::synthesise(&design, device, &tools.yosys, settings, &cache, &|stage| {
        progress(0, stage);
    })?;
    let place = |seed: u32| {
        let run = place::Run { seed, target_mhz: options.target_mhz };
        let timing = place::place(&design, device, run, &tools.placer, settings, &cache, &|stage| {
            progress(seed, stage);
        });
        timing.map(|timing| (seed, timing))
    };
    // The tools themselves run on one thread.
    let seeds = options.seeds.max(1) as usize;
    let timings = parallel::map(parallel::available(), seeds, |index| place(index as u32 + 1));
    let timings = timings.into_iter().collect::<Result<_>>()?;
    Report::new(subject, options, &tools, &design, timings)
}
