//! Runs a core without any external tool: the same stalls and checks around a model in Rust.

use super::testbench::DRAIN_CLOCKS;
use super::{Beat, Dut, Failure, Outcome, PATTERN, Simulator, Stimulus, compare};
use crate::Result;
use std::path::Path;
use std::time::Instant;

/// A model that runs clock by clock.
pub trait Clocked {
    /// Back to the state after reset.
    fn reset(&mut self);

    /// One clock: given what stands at the inputs, says what stands at the outputs in the same clock
    /// (as settled just before the edge), then advances.
    ///
    /// `input` is the beat offered with `s_axis_tvalid`; `output_ready` is `m_axis_tready`.
    fn clock(&mut self, input: Option<&Beat>, output_ready: bool) -> Handshake;

    /// From the next clock on, whose number is given, write a waveform into the file; `None` ends it.
    fn trace(&mut self, vcd: Option<&Path>, clock: u64) -> Result<()>;
}

/// The outputs of a model in one clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Handshake {
    /// `s_axis_tready`.
    pub input_ready: bool,
    /// The beat that stands at the output, if `m_axis_tvalid`.
    pub output: Option<Beat>,
}

/// The built-in simulator; `make` builds the model of the core to be run.
pub struct Builtin<F> {
    make: F,
}

impl<F, C> Builtin<F>
where
    F: Fn() -> Result<C>,
    C: Clocked,
{
    pub fn new(make: F) -> Self {
        Builtin { make }
    }
}

impl<F, C> Simulator for Builtin<F>
where
    F: Fn() -> Result<C>,
    C: Clocked,
{
    fn name(&self) -> &'static str {
        "builtin"
    }

    fn version(&self) -> Result<String> {
        Ok(env!("CARGO_PKG_VERSION").into())
    }

    fn run(&self, dut: &Dut, stimulus: &Stimulus) -> Result<Outcome> {
        dut.check()?;
        stimulus.check(dut)?;
        let begun = Instant::now();
        let mut core = (self.make)()?;
        let build_seconds = begun.elapsed().as_secs_f64();

        let begun = Instant::now();
        let mut run = Run::new(dut, stimulus);
        core.reset();
        while run.running {
            run.clock(&mut core);
        }
        let mut outcome = run.conclude();
        outcome.run_seconds = begun.elapsed().as_secs_f64();
        outcome.name = self.name().into();
        outcome.version = self.version()?;
        outcome.build_seconds = build_seconds;

        if let (Some(failure), Some(vcd)) = (outcome.failures.first(), &stimulus.vcd) {
            let window = failure.window();
            let mut again = Run::new(dut, stimulus);
            core.reset();
            while again.running && again.now <= *window.end() {
                if again.now == *window.start() {
                    core.trace(Some(vcd), again.now)?;
                }
                again.clock(&mut core);
            }
            core.trace(None, again.now)?;
            outcome.vcd = Some(vcd.clone());
        }
        Ok(outcome)
    }
}

/// The testbench in Rust: what `testbenches/stream_testbench.v` does, step by step.
struct Run<'a> {
    dut: &'a Dut,
    stimulus: &'a Stimulus,
    offer: Vec<bool>,
    ready: Vec<bool>,
    running: bool,
    /// The number of this clock.
    now: u64,
    /// Clocks since the last transfer, and since everything is in and out.
    quiet: u64,
    drained: u64,
    accepted: usize,
    offering: bool,
    received: Vec<(u64, Beat)>,
    /// The beat that stood at the output in the clock before and was not taken.
    held: Option<Beat>,
    /// Whether any stall happened before the first output.
    stalled: bool,
    first: Option<u64>,
    start: Option<u64>,
    failures: Vec<Failure>,
    unstable: bool,
}

impl<'a> Run<'a> {
    fn new(dut: &'a Dut, stimulus: &'a Stimulus) -> Self {
        Run {
            dut,
            stimulus,
            offer: stimulus.offer_pattern(),
            ready: stimulus.ready_pattern(),
            running: true,
            now: 0,
            quiet: 0,
            drained: 0,
            accepted: 0,
            offering: false,
            received: Vec::with_capacity(stimulus.expected.len()),
            held: None,
            stalled: false,
            first: None,
            start: None,
            failures: Vec::new(),
            unstable: false,
        }
    }

    fn clock(&mut self, core: &mut impl Clocked) {
        let at = (self.now % PATTERN as u64) as usize;
        let ready = self.ready[at];
        let pending = self.stimulus.input.get(self.accepted);
        self.offering |= pending.is_some() && self.offer[at];
        let offered = pending.filter(|_| self.offering);

        let seen = core.clock(offered, ready);
        self.quiet += 1;
        self.check_stability(seen.output.as_ref());
        if self.first.is_none() {
            self.stalled |= !ready || (pending.is_some() && offered.is_none());
            self.first = seen.output.as_ref().map(|_| self.now);
        }
        self.output(seen.output, ready);
        if offered.is_some() && seen.input_ready {
            self.accept();
        }
        self.watch();
        self.now += 1;
    }

    /// What was held must still stand there.
    fn check_stability(&mut self, output: Option<&Beat>) {
        let Some(held) = self.held.take() else { return };
        let signal = match output {
            None => "tvalid",
            Some(now) if now.last != held.last => "tlast",
            Some(now) if now.user != held.user => "tuser",
            Some(now) if now.keep != held.keep => "tkeep",
            Some(now) if now.data != held.data => "tdata",
            Some(_) => return,
        };
        if !self.unstable {
            let (clock, beat) = (self.now, self.received.len() as u64);
            self.failures.push(Failure::Unstable { signal: format!("m_axis_{signal}"), clock, beat });
            self.unstable = true;
        }
    }

    fn output(&mut self, output: Option<Beat>, ready: bool) {
        let Some(beat) = output else { return };
        if self.received.len() == self.stimulus.expected.len() {
            let (clock, beat) = (self.now, self.received.len() as u64);
            self.failures.push(Failure::Extra { clock, beat });
            self.running = false;
        } else if ready {
            self.received.push((self.now, beat));
            self.quiet = 0;
        } else {
            self.held = Some(beat);
        }
    }

    fn accept(&mut self) {
        if self.accepted as u64 == self.dut.latency.map_or(0, |latency| latency.beat) {
            self.start = Some(self.now);
        }
        self.accepted += 1;
        self.offering = false;
        self.quiet = 0;
    }

    /// Ends the run when all is done, or when nothing happens any more.
    fn watch(&mut self) {
        let (inputs, outputs) = (self.stimulus.input.len(), self.stimulus.expected.len());
        if self.accepted == inputs && self.received.len() == outputs {
            self.drained += 1;
            self.running &= self.drained <= DRAIN_CLOCKS;
        } else if self.quiet >= self.stimulus.patience {
            self.failures.push(Failure::Hang {
                clock: self.now,
                quiet: self.quiet,
                accepted: self.accepted as u64,
                inputs: inputs as u64,
                received: self.received.len() as u64,
                outputs: outputs as u64,
            });
            self.running = false;
        }
    }

    fn conclude(mut self) -> Outcome {
        let (mismatches, wrong) = compare::compare(&self.dut.output, &self.stimulus.expected, &self.received);
        self.failures.extend(wrong);
        let clocks = self.received.last().map_or(0, |(clock, _)| clock + 1);
        let measured = self.first.zip(self.start);
        let latency = measured.map(|(first, start)| first as i64 - start as i64);
        if let (Some(expected), Some(measured), Some(clock), false) =
            (self.dut.latency, latency, self.first, self.stalled)
            && measured != expected.clocks as i64
        {
            self.failures.push(Failure::Latency { expected: expected.clocks, measured, clock });
        }
        if let Some(expected) = self.stimulus.expected_clocks
            && self.failures.is_empty()
            && clocks != expected
        {
            self.failures.push(Failure::Clocks { expected, measured: clocks });
        }
        let mut outcome = Outcome {
            beats: self.received.len() as u64,
            clocks,
            received: self.received,
            mismatches,
            latency,
            failures: self.failures,
            ..Outcome::default()
        };
        outcome.sort_failures();
        outcome
    }
}
