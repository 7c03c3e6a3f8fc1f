//! Runs a core in an external simulator: compile (or find in the cache), simulate, read back, judge.
//!
//! ```text
//! Dut ──► Recipe ──► build cache ──► program ──► stdout ─────────► Verdict ─┐
//! Stimulus ──► input.hex, expected.hex, stalls.hex ──► received.hex ────────┴─► Outcome
//! ```

use super::build_cache::{BuildCache, hash};
use super::work::Work;
use super::workarounds::plus_argument;
use super::{Coverage, Dut, Failure, Outcome, Settings, Simulator, Stimulus};
use super::{compare, icarus, process, tools, vectors, verdict::Verdict, verilator};
use crate::{Error, Kind, Result};
use std::fs;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Instant;

/// Which external simulator, and with which bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Verilator with the C++ harness.
    Verilator,
    /// Verilator with the emitted testbench.
    VerilatorTestbench,
    /// Icarus with the emitted testbench.
    Icarus,
}

/// An external simulator.
#[derive(Clone, Debug)]
pub struct External {
    tool: Tool,
    settings: Settings,
}

/// How a core becomes a program.
pub(super) struct Recipe {
    /// Name and text of the testbench or harness.
    pub bench: (String, String),
    /// The command that compiles.
    pub compile: Vec<String>,
    /// The file that it makes.
    pub product: &'static str,
    /// The command that runs the product; empty when it runs by itself.
    pub run: &'static [&'static str],
}

/// A compiled simulator.
struct Program {
    line: Vec<String>,
    cached: bool,
}

impl External {
    pub fn new(tool: Tool, settings: Settings) -> Self {
        External { tool, settings }
    }

    fn recipe(&self, dut: &Dut, trace: bool) -> Result<Recipe> {
        match self.tool {
            Tool::Verilator => verilator::harness_recipe(dut, trace, &self.settings),
            Tool::VerilatorTestbench => verilator::testbench_recipe(dut, trace),
            Tool::Icarus => icarus::recipe(dut),
        }
    }

    /// The program from the cache, or a new one.
    fn program(&self, dut: &Dut, trace: bool, version: &str, work: &Work) -> Result<Program> {
        let recipe = self.recipe(dut, trace)?;
        let bench = [(recipe.bench.0.as_str(), recipe.bench.1.as_str())];
        let files = dut.files.iter().map(|(name, text)| (name.as_str(), text.as_str())).chain(bench);
        for (name, text) in files.clone() {
            work.write(name, text.as_bytes())?;
        }
        work.note(&recipe.compile)?;
        let made_by = [("version", version), (env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))];
        let flags = recipe.compile.iter().map(|flag| ("flag", flag.as_str()));
        let hash = hash(made_by.into_iter().chain(flags).chain(files));
        let cache = BuildCache::open(&self.settings)?;
        let found = cache.find(&hash);
        let cached = found.is_some();
        let program = match found {
            Some(program) => program,
            None => {
                self.require_compilers()?;
                let log = work.path().join("build.log");
                process::run(&recipe.compile, work.path(), &log, &self.settings)?;
                cache.keep(&hash, &work.path().join(recipe.product))?
            }
        };
        let mut line: Vec<String> = recipe.run.iter().map(|word| word.to_string()).collect();
        line.push(program.display().to_string());
        Ok(Program { line, cached })
    }

    fn require_compilers(&self) -> Result<()> {
        let compilers: &[&str] = if self.tool == Tool::Icarus { &[] } else { &["make", "g++"] };
        compilers.iter().try_for_each(|name| tools::require(name, &self.settings).map(drop))
    }

    /// Runs the program on the vectors in the folder; what it printed.
    fn simulate(&self, program: &Program, options: &[String], work: &Work) -> Result<String> {
        let line = [&program.line, options].concat();
        work.note(&line)?;
        let log = work.path().join("run.log");
        process::run(&line, work.path(), &log, &self.settings)?;
        Ok(String::from_utf8_lossy(&work.read("run.log")?).into_owned())
    }

    fn run_in(&self, work: &Work, dut: &Dut, stimulus: &Stimulus) -> Result<Outcome> {
        let version = self.version()?;
        let begun = Instant::now();
        let program = self.program(dut, false, &version, work)?;
        let build_seconds = begun.elapsed().as_secs_f64();

        let begun = Instant::now();
        write_vectors(work, dut, stimulus)?;
        let printed = self.simulate(&program, &options(stimulus), work)?;
        let Some(verdict) = Verdict::read(&printed, stimulus) else {
            return Err(self.no_verdict("ended without a verdict", work));
        };
        let received = vectors::read_received(&dut.output, &work.read("received.hex")?)?;
        let mut outcome = judge(verdict, dut, stimulus, received)
            .ok_or_else(|| self.no_verdict("judges otherwise than the comparison", work))?;
        outcome.run_seconds = begun.elapsed().as_secs_f64();

        if let (Some(failure), Some(vcd)) = (outcome.failures.first(), &stimulus.vcd) {
            self.trace(work, dut, stimulus, &version, failure.window(), vcd)?;
            outcome.vcd = Some(vcd.clone());
        }
        if self.settings.coverage && self.tool == Tool::Verilator {
            let data = work.read("coverage.dat")?;
            outcome.coverage = Some(Coverage::read(&String::from_utf8_lossy(&data))?);
        }
        outcome.name = self.name().into();
        outcome.version = version;
        outcome.folder = work.kept();
        outcome.build_seconds = build_seconds;
        outcome.cached = program.cached;
        Ok(outcome)
    }

    /// Runs again, up to the end of the window, and writes the waveform of the window.
    fn trace(
        &self,
        work: &Work,
        dut: &Dut,
        stimulus: &Stimulus,
        version: &str,
        window: RangeInclusive<u64>,
        vcd: &PathBuf,
    ) -> Result<()> {
        let program = self.program(dut, true, version, work)?;
        let bounds = [("vcd_from", *window.start()), ("vcd_to", *window.end())];
        let bounds = bounds.map(|(name, clock)| plus_argument(name, clock));
        self.simulate(&program, &[options(stimulus).as_slice(), &bounds].concat(), work)?;
        let wave = work.read("window.vcd")?;
        fs::write(vcd, wave).map_err(|error| {
            Error::new(Kind::Usage, format!("cannot write the waveform: {error}")).at(vcd.display())
        })
    }

    fn no_verdict(&self, what: &str, work: &Work) -> Error {
        let log = work.path().join("run.log");
        let what = format!("the simulation {what}:\n{}", process::tail(&log));
        Error::new(Kind::ToolFailed, format!("{}: {what}", self.name())).at(log.display())
    }
}

impl Simulator for External {
    fn name(&self) -> &'static str {
        match self.tool {
            Tool::Verilator => "verilator",
            Tool::VerilatorTestbench => "verilator-testbench",
            Tool::Icarus => "icarus",
        }
    }

    fn version(&self) -> Result<String> {
        match self.tool {
            Tool::Verilator | Tool::VerilatorTestbench => {
                tools::require("verilator", &self.settings).map(|version| version.to_string())
            }
            Tool::Icarus => {
                tools::require("vvp", &self.settings)?;
                tools::require("iverilog", &self.settings).map(|version| version.to_string())
            }
        }
    }

    fn run(&self, dut: &Dut, stimulus: &Stimulus) -> Result<Outcome> {
        dut.check()?;
        stimulus.check(dut)?;
        let work = Work::open(&self.settings, self.name())?;
        let result = self.run_in(&work, dut, stimulus);
        work.keep_on_failure(result)
    }
}

fn write_vectors(work: &Work, dut: &Dut, stimulus: &Stimulus) -> Result<()> {
    work.write("input.hex", &vectors::write_beats(&dut.input, &stimulus.input))?;
    work.write("expected.hex", &vectors::write_beats(&dut.output, &stimulus.expected))?;
    let stalls = vectors::write_stalls(&stimulus.offer_pattern(), &stimulus.ready_pattern());
    work.write("stalls.hex", &stalls)
}

fn options(stimulus: &Stimulus) -> Vec<String> {
    let clocks = stimulus.expected_clocks.map(|clocks| plus_argument("clocks", clocks));
    clocks.into_iter().chain([plus_argument("patience", stimulus.patience)]).collect()
}

/// Joins the testbench's judgement with the comparison of the beats; `None` when they contradict.
fn judge(
    verdict: Verdict,
    dut: &Dut,
    stimulus: &Stimulus,
    received: Vec<(u64, super::Beat)>,
) -> Option<Outcome> {
    let (mismatches, wrong) = compare::compare(&dut.output, &stimulus.expected, &received);
    let mut outcome = Outcome {
        beats: received.len() as u64,
        clocks: verdict.clocks,
        received,
        mismatches: mismatches.max(verdict.mismatches),
        latency: verdict.latency,
        failures: verdict.failures,
        ..Outcome::default()
    };
    outcome.failures.extend(wrong);
    outcome.sort_failures();
    let unknown = outcome.failures.iter().any(|failure| matches!(failure, Failure::Unknown { .. }));
    // Unknown bits read back as 0, so that only the testbench sees that they are wrong.
    let agrees = verdict.passed == outcome.failures.is_empty()
        && (unknown || (verdict.mismatches > 0) == outcome.value_differs());
    agrees.then_some(outcome)
}
