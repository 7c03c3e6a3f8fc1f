//! `synth CORE --device NAME`: the core on a real device, with Yosys and nextpnr.
//!
//! ```text
//! options ─► core ─► fpga::measure ─► table, or one JSON object; with -o also synth.json and synth.md
//! FILE.toml ─► several of them ─► one row each, and compare.svg
//! ```

mod compare;
mod show;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{FromArgMatches, Subcommand};
use serde_json::json;

use super::output::{self, Format, FormatArg};
use super::progress::Progress;
use super::values::clock;
use super::{aim, generate};
use crate::cores;
use crate::cosim::{Settings, strip_bench::protocol};
use crate::error::{Error, Result};
use crate::files::write_whole;
use crate::fpga::estimate::Calibration;
use crate::fpga::pipelining::Goal;
use crate::fpga::{self, Device, Report, Stage, Subject, Throughput};
use crate::model::cc_strip_clocks::clocks_per_column;
use crate::package;

/// Synthesise, place and route a core on a device: clock, area, critical path
///
/// The core stands in a harness of registers, so that pins do not limit and nothing is trimmed; the harness is not
/// counted. Uses yosys and nextpnr where they are installed, else those that 'make fpga-tools' sets up.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, subcommand_negates_reqs = true, args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    core: Option<Core>,

    /// Several configurations side by side, from a file that has a [[configuration]] for each
    #[arg(long, value_name = "FILE.toml", required = true)]
    compare: Option<PathBuf>,

    /// Write synth.json, synth.md and synth.svg to this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    #[command(flatten)]
    work: Work,
}

#[derive(Debug, clap::Subcommand)]
enum Core {
    /// The forward-difference engine for regular patches of Loop surfaces
    #[command(mut_arg("output", says_folder), mut_arg("no_proof", hidden), mut_arg("proof", hidden))]
    #[command(mut_arg("force", hidden))]
    LoopFd(One<generate::LoopFd>),
    /// The sliding window for quad strips of Catmull-Clark surfaces
    #[command(mut_arg("output", says_folder), mut_arg("no_proof", hidden), mut_arg("force", hidden))]
    CcStrip(One<generate::CcStrip>),
}

// A core with the options that `generate` has for it. (A comment for the documentation would become the help.)
#[derive(Debug, clap::Args)]
struct One<C: clap::Args> {
    #[command(flatten)]
    core: C,

    #[command(flatten)]
    work: Work,
}

fn says_folder(argument: clap::Arg) -> clap::Arg {
    argument.help("Write synth.json and synth.md to this folder")
}

fn hidden(argument: clap::Arg) -> clap::Arg {
    argument.hide(true)
}

/// How it is measured.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Synthesis")]
struct Work {
    /// The device: ecp5-25k, ecp5-85k, ice40-hx8k, ice40-up5k, gowin-gw2a18, gowin-gw5a25, lifcl-40 [default: ecp5-85k]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,

    /// Place and route with the seeds 1 to N [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,

    /// The clock to aim for, such as 300 or 300MHz; a core without --chunk or --registered is pipelined for it [default:
    /// that of the options; the tools try for 400MHz]
    #[arg(long, value_name = "F", value_parser = clock)]
    clock: Option<f64>,

    /// Do everything anew, and keep nothing
    #[arg(long)]
    no_cache: bool,

    /// Stop a tool that runs longer
    #[arg(long, value_name = "SECONDS", default_value_t = 7200)]
    timeout: u64,

    #[command(flatten)]
    format: FormatArg,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl synth loop-fd --coordinates Q8.8 --max-level 3 --device ecp5-85k --seeds 5
  subdiv-rtl synth cc-strip --max-level 2 --device ecp5-25k -o report
  subdiv-rtl synth --compare cores.toml -o report

where cores.toml has the options of 'generate' by name:
  device = \"ecp5-85k\"
  seeds = 3

  [[configuration]]
  name = \"eight bits\"
  core = \"loop-fd\"
  coordinates = \"Q4.4\"
  max-level = 2

  [[configuration]]
  core = \"loop-fd\"
  coordinates = \"Q8.8\"
  max-level = 2";

impl Work {
    /// The clock that was asked for, on a device of which one can be estimated.
    fn goal(&self) -> Result<Option<Goal>> {
        let goal = |mhz, device: &'static Device| Goal { device, mhz };
        let device = Device::named(self.device.as_deref().unwrap_or("ecp5-85k"))?;
        let known = Calibration::built_in()?.constants(device.family).is_some();
        Ok(self.clock.filter(|_| known).map(|mhz| goal(mhz, device)))
    }

    fn options(&self) -> Result<fpga::Options> {
        let device = Device::named(self.device.as_deref().unwrap_or("ecp5-85k"))?;
        let timeout = Duration::from_secs(self.timeout);
        Ok(fpga::Options {
            device,
            seeds: self.seeds.unwrap_or(1),
            target_mhz: self.clock.unwrap_or(400.0),
            cached: !self.no_cache,
            settings: Settings { timeout, ..Settings::default() },
        })
    }
}

impl Core {
    fn work(&self) -> &Work {
        match self {
            Core::LoopFd(one) => &one.work,
            Core::CcStrip(one) => &one.work,
        }
    }

    fn folder(&self) -> Option<&Path> {
        match self {
            Core::LoopFd(one) => one.core.output.as_deref(),
            Core::CcStrip(one) => one.core.output.as_deref(),
        }
    }

    fn subject(&self) -> Result<Subject> {
        match self {
            Core::LoopFd(one) => {
                let parameters = one.core.settings()?.parameters()?;
                loop_fd(match one.work.goal()?.filter(|_| parameters.chunk.is_none()) {
                    Some(goal) => aim::loop_fd(parameters, goal)?,
                    None => parameters,
                })
            }
            Core::CcStrip(one) => {
                let parameters = one.core.parameters()?;
                cc_strip(match one.work.goal()?.filter(|_| !parameters.registered) {
                    Some(goal) => aim::cc_strip(&one.core, goal)?,
                    None => parameters,
                })
            }
        }
    }
}

/// The core of a command line, as behind `subdiv-rtl synth`: `loop-fd --max-level 2`.
///
/// # Errors
/// `Usage` for what is no such line, those of the core.
pub fn subject(line: &str) -> Result<Subject> {
    core(line.split_whitespace().map(String::from))?.subject()
}

/// Reads words as the command line does.
fn core(words: impl Iterator<Item = String>) -> Result<Core> {
    let line = ["synth".to_string()].into_iter().chain(words);
    let command = Core::augment_subcommands(clap::Command::new("synth").no_binary_name(false));
    let parsed = command.try_get_matches_from(line).and_then(|found| Core::from_arg_matches(&found));
    parsed.map_err(|error| {
        let said = error.to_string();
        Error::usage(said.lines().next().unwrap_or_default().trim_start_matches("error: "))
            .help("the keys are options of 'subdiv-rtl synth CORE'")
    })
}

/// Two triangles leave with every pair of vertices.
pub fn loop_fd(parameters: cores::loop_fd::Parameters) -> Result<Subject> {
    Ok(Subject {
        name: "loop-fd".into(),
        command: package::loop_fd::command(parameters),
        module: cores::loop_fd::build(parameters)?,
        throughput: Throughput {
            what: "triangles".into(),
            per_clock: f64::from(2 * parameters.lanes.unwrap_or(1)),
        },
    })
}

/// Of each column that comes in, 2^L columns of 2^L + 1 vertices leave; row by row, one vertex in a clock.
pub fn cc_strip(parameters: cores::cc_strip::Parameters) -> Result<Subject> {
    let module = cores::cc_strip::build(parameters)?;
    let clocks = clocks_per_column(protocol(&module, parameters)) as f64;
    let steps = f64::from(1u32 << parameters.levels);
    let columns = steps * (steps + 1.0) / clocks;
    let per_clock = if parameters.longitudinal.is_some() { columns.min(1.0) } else { columns };
    Ok(Subject {
        name: "cc-strip".into(),
        command: package::cc_strip::command(parameters),
        module,
        throughput: Throughput { what: "vertices".into(), per_clock },
    })
}

impl Args {
    pub fn format(&self) -> Format {
        self.core.as_ref().map_or(self.work.format.format, |core| core.work().format.format)
    }
}

/// Runs the subcommand.
///
/// # Errors
/// Those of the options and the core; `ToolMissing`, `ToolFailed`; a folder that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    match (&args.core, &args.compare) {
        (Some(core), _) => one(core),
        (None, Some(file)) => compare::run(file, &args.work, args.output.as_deref()),
        (None, None) => {
            Err(Error::usage("nothing to synthesise").help("name a core, or --compare FILE.toml"))
        }
    }
}

fn one(core: &Core) -> Result<()> {
    let options = core.work().options()?;
    let report = measured("", &core.subject()?, &options)?;
    let fields = json!(report);
    if let Some(folder) = core.folder() {
        write(folder, "synth.json", &output::object("synth", 1, &fields)?)?;
        write(folder, "synth.md", &show::markdown(&report))?;
    }
    match core.work().format.format {
        Format::Text => output::print(&show::text(&report)),
        Format::Json => output::print_object("synth", 1, &fields),
    }
}

/// Measures while the terminal shows how far it is.
fn measured(label: &str, subject: &Subject, options: &fpga::Options) -> Result<Report> {
    let shown = Progress::waiting(format!("{label}preparing"));
    fpga::measure(subject, options, &|seed, stage| {
        shown.say(match stage {
            Stage::Synthesis => format!("{label}synthesis"),
            Stage::Placement => format!("{label}placement, seed {seed} of {}", options.seeds),
            Stage::DetailedPlacement => format!("{label}moving cells, seed {seed} of {}", options.seeds),
            Stage::Routing => format!("{label}routing, seed {seed} of {}", options.seeds),
        });
    })
}

fn write(folder: &Path, name: &str, text: &str) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::input(format!("cannot make the folder: {e}")).at(folder.display()))?;
    write_whole(&folder.join(name), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_are_megahertz() {
        assert_eq!((clock("300").unwrap(), clock("312.5MHz").unwrap()), (300.0, 312.5));
        for text in ["", "fast", "0", "-3", "NaN"] {
            assert_eq!(clock(text).unwrap_err().exit_status(), 2, "{text}");
        }
    }

    #[test]
    fn throughput_is_that_of_the_core() {
        let format = crate::fixed::Format { integer: 4, fraction: 4 };
        let parameters = cores::cc_strip::Parameters::exact(format, 4, 4).check().unwrap();
        // Sixteen columns of seventeen vertices in sixteen clocks.
        assert_eq!(cc_strip(parameters).unwrap().throughput.per_clock, 17.0);
    }
}
