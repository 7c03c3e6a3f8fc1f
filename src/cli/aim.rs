//! `--clock F --device NAME`: the form of a core is chosen for a clock on a device.

use super::generate;
use super::values::clock;
use crate::cores::{cc_strip, loop_fd};
use crate::error::{Error, Result};
use crate::fpga::Device;
use crate::fpga::pipelining::{CHUNKS, Goal, first_fast_enough};

/// What the core is pipelined for.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Target")]
pub struct Aim {
    /// Pipeline for this clock on the device, such as 300 or 300MHz: chunks of loop-fd, registers of cc-strip
    #[arg(long, value_name = "F", value_parser = clock, requires = "device")]
    pub clock: Option<f64>,

    /// The device: ecp5-25k, ecp5-85k, ice40-hx8k, ice40-up5k, gowin-gw2a18, gowin-gw5a25
    #[arg(long, value_name = "NAME", requires = "clock")]
    pub device: Option<String>,
}

// A core with what it is pipelined for. (A comment for the documentation would become the help.)
#[derive(Debug, Default, clap::Args)]
pub struct Aimed<C: clap::Args> {
    #[command(flatten)]
    pub core: C,

    #[command(flatten)]
    pub aim: Aim,
}

impl Aim {
    /// # Errors
    /// A device that there is none of.
    pub fn goal(&self) -> Result<Option<Goal>> {
        match (self.clock, &self.device) {
            (Some(mhz), Some(device)) => Ok(Some(Goal { device: Device::named(device)?, mhz })),
            _ => Ok(None),
        }
    }
}

/// The core with the widest chunks that reach the goal.
///
/// # Errors
/// A goal out of reach; chunks that were asked for by their size.
pub fn loop_fd(parameters: loop_fd::Parameters, goal: Goal) -> Result<loop_fd::Parameters> {
    if let Some(bits) = parameters.chunk {
        return Err(Error::usage(format!("chunks of {bits} bits and a clock to choose them for"))
            .help("leave out --chunk or --clock"));
    }
    let below = |chunk: &Option<u32>| chunk.is_none_or(|bits| bits < parameters.modulus());
    let with = |chunk| parameters.with_chunk(chunk);
    let describe = |chunk: Option<u32>| {
        chunk.map_or("the one without --chunk".into(), |bits| format!("that with --chunk {bits}"))
    };
    let chunks = CHUNKS.into_iter().filter(below);
    let (chunk, ..) = first_fast_enough(goal, chunks, |chunk| loop_fd::build(with(chunk)?), describe)?;
    with(chunk)
}

/// The core with registers behind its adders where the goal needs them.
///
/// # Errors
/// A goal out of reach.
pub fn cc_strip(core: &generate::CcStrip, goal: Goal) -> Result<cc_strip::Parameters> {
    let parameters = core.parameters()?;
    let with = |registered| cc_strip::Parameters { registered, ..parameters }.check();
    // Where registers were asked for, or no such core has them, there is no choice.
    let forms = [false, true].into_iter().filter(|&form| form || !parameters.registered);
    let forms: Vec<bool> = forms.filter(|&form| with(form).is_ok()).collect();
    let describe = |registered| format!("the one with{} --registered", if registered { "" } else { "out" });
    let (registered, ..) = first_fast_enough(goal, forms, |form| cc_strip::build(with(form)?), describe)?;
    with(registered)
}
