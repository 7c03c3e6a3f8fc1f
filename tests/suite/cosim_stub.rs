//! The stub core of the tests, its expected output, its twin in Rust, and the simulators to run it in.

use std::path::{Path, PathBuf};
use std::time::Duration;
use subdiv_rtl::Result;
use subdiv_rtl::cosim::{
    Beat, Builtin, Clocked, Dut, External, Handshake, Latency, Port, Settings, Simulator, Tool,
};

/// What is broken; the number travels in the `tuser` of the first input beat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    None,
    WrongBit,
    Drops,
    Repeats,
    Changes,
    Falls,
    LosesClocks,
    WrongLast,
    WrongUser,
    WrongKeep,
    Hangs,
    Extra,
    Late,
}

pub fn dut() -> Dut {
    let lanes = [("x", 24), ("y", 24), ("z", 24)];
    Dut {
        top: "add_one".into(),
        files: vec![("add_one.v".into(), include_str!("cosim_stub/add_one.v").into())],
        input: Port::of_lanes(lanes).with_user(4).with_last(),
        output: Port::of_lanes(lanes).with_keep().with_user(2).with_last(),
        latency: Some(Latency { beat: 0, clocks: 2 }),
    }
}

/// Packets of four beats; the last beat of each keeps only its first lane.
pub fn vectors(beats: usize, fault: Fault) -> (Vec<Beat>, Vec<Beat>) {
    let dut = dut();
    let (mut input, mut expected) = (Vec::new(), Vec::new());
    for at in 0..beats {
        let numbers = [at as i128, -7 * at as i128, 1000 + at as i128];
        let last = at % 4 == 3;
        let user = if at == 0 { fault as u64 } else { 0 };
        input.push(Beat { user, last, ..dut.input.beat_of(&numbers) });
        let user = u64::from(at % 4 == 0) | u64::from(last) << 1;
        let mut beat = Beat { user, last, ..dut.output.beat_of(&numbers.map(|n| n + 1)) };
        if last {
            // Not kept, so it must not matter that the core computes something here.
            beat = Beat { user, last, ..dut.output.beat_of(&[numbers[0] + 1]) };
            (1..3).for_each(|lane| dut.output.drop_lane(&mut beat, lane));
        }
        expected.push(beat);
    }
    (input, expected)
}

/// Where compiled simulators of the tests live from one run of the tests to the next.
pub fn settings() -> Settings {
    let cache = Some(Path::new(env!("CARGO_TARGET_TMPDIR")).join("simulators"));
    Settings { cache, timeout: Duration::from_secs(300), ..Settings::default() }
}

/// An external simulator, or `None` with a printed line if it is not installed.
pub fn external(tool: Tool, settings: Settings) -> Option<External> {
    let simulator = External::new(tool, settings);
    match simulator.version() {
        Ok(_) => Some(simulator),
        Err(error) => {
            println!("skipped {}: {}", simulator.name(), error.what);
            None
        }
    }
}

/// Every simulator that is installed; the built-in one comes first.
pub fn simulators() -> Vec<Box<dyn Simulator>> {
    let mut all: Vec<Box<dyn Simulator>> = vec![Box::new(Builtin::new(|| Ok(AddOne::default())))];
    for tool in [Tool::Verilator, Tool::VerilatorTestbench, Tool::Icarus] {
        all.extend(external(tool, settings()).map(|one| Box::new(one) as Box<dyn Simulator>));
    }
    all
}

/// One stage of the pipeline.
#[derive(Clone, Default)]
struct Stage {
    beat: Option<(Beat, bool)>,
    index: usize,
}

/// The twin of `add_one.v`, register for register.
#[derive(Default)]
pub struct AddOne {
    fault: usize,
    taken: usize,
    phase: u32,
    in_packet: bool,
    delayed: bool,
    waited: bool,
    repeated: bool,
    a: Stage,
    b: Stage,
    trace: Option<PathBuf>,
}

impl AddOne {
    fn is(&self, fault: Fault) -> bool {
        self.fault == fault as usize
    }

    fn output(&self) -> Option<Beat> {
        let (beat, first) = self.b.beat.as_ref()?;
        let (mut beat, index, port) = (beat.clone(), self.b.index, dut().output);
        beat.user =
            u64::from(*first && !(self.is(Fault::WrongUser) && index == 4)) | u64::from(beat.last) << 1;
        if beat.last && !self.is(Fault::WrongKeep) {
            (1..3).for_each(|lane| port.drop_lane(&mut beat, lane));
        }
        beat.last |= self.is(Fault::WrongLast) && index == 6;
        if self.is(Fault::WrongBit) && index == 5 {
            beat.data[0] ^= 1 << 33;
        }
        if self.is(Fault::Changes) && self.waited {
            beat.data[0] ^= 1 << 40;
        }
        (!(self.is(Fault::Falls) && self.waited)).then_some(beat)
    }
}

impl Clocked for AddOne {
    fn reset(&mut self) {
        *self = AddOne::default();
    }

    fn clock(&mut self, input: Option<&Beat>, output_ready: bool) -> Handshake {
        let output = self.output();
        let again = !self.repeated
            && ((self.is(Fault::Repeats) && self.b.index == 6)
                || (self.is(Fault::Extra) && self.b.index == 11));
        let transfer = output.is_some() && output_ready;
        let b_free = self.b.beat.is_none() || (transfer && !again);
        let full = self.a.beat.is_some();
        let a_go = b_free && !(self.is(Fault::Late) && full && !self.delayed);
        let refused =
            (self.is(Fault::LosesClocks) && self.phase == 5) || (self.is(Fault::Hangs) && self.taken == 7);
        let input_ready = (!full || a_go) && !refused;
        let accepted = input.filter(|_| input_ready);

        let drops = self.is(Fault::Drops) && self.taken == 5;
        if a_go {
            self.b = self.a.clone();
        } else if transfer && !again {
            self.b.beat = None;
        }
        if !full || a_go {
            let (input_port, output_port) = (dut().input, dut().output);
            let added = |beat: &Beat| {
                let numbers: Vec<_> = (0..3).map(|at| input_port.number(beat, at) + 1).collect();
                Beat { last: beat.last, ..output_port.beat_of(&numbers) }
            };
            let beat = accepted.filter(|_| !drops).map(|beat| (added(beat), !self.in_packet));
            self.a = Stage { beat, index: self.taken };
        }
        if let Some(beat) = accepted {
            if self.taken == 0 {
                self.fault = beat.user as usize;
            }
            self.taken = if self.taken == 255 { 254 } else { self.taken + 1 };
            self.in_packet = !beat.last;
        }
        self.phase = (self.phase + 1) % 8;
        self.waited = output.is_some() && !output_ready;
        self.repeated |= transfer && again;
        self.delayed |= full;
        Handshake { input_ready, output }
    }

    /// A stub's waveform: only the first clock of the window.
    fn trace(&mut self, vcd: Option<&Path>, clock: u64) -> Result<()> {
        if let Some(file) = vcd {
            std::fs::write(file, format!("#{clock}\n")).expect("the folder of the test is writable");
        }
        self.trace = vcd.map(Path::to_path_buf);
        Ok(())
    }
}
