//! A core described in [`hdl`](crate::hdl) as a device under test and as a built-in model.

use std::path::Path;
use std::rc::Rc;

use super::beat::{Beat, Port};
use super::builtin::{Clocked, Handshake};
use super::dut::{Dut, Latency};
use crate::error::{Error, Kind, Result};
use crate::hdl::vcd::Waveform;
use crate::hdl::{Direction, Flat, Integers, Module, NodeId, Simulator, verilog};

/// The device under test of a core whose streams follow the naming of AXI4-Stream.
pub fn device(core: &Rc<Module>, files: &[verilog::SourceFile], latency: Option<Latency>) -> Dut {
    Dut {
        top: core.name.clone(),
        files: files.iter().map(|f| (f.name.clone(), f.text.clone())).collect(),
        input: port(core, "s_axis", Direction::Input),
        output: port(core, "m_axis", Direction::Output),
        latency,
    }
}

/// The shape of one of the core's streams; its lanes are those of the `tdata` bus.
pub fn port(core: &Module, stream: &str, direction: Direction) -> Port {
    let width = |signal: &str| {
        let name = format!("{stream}_{signal}");
        let node = match direction {
            Direction::Input => core.input(&name).map(|i| core.inputs[i]),
            Direction::Output => core.output(&name).map(|i| core.outputs[i].node),
        };
        let bus = core.buses.iter().find(|b| b.name == name && b.direction == direction);
        bus.map_or(node.map_or(0, |id| core.node(id).word.width()), |bus| bus.width)
    };
    let data = format!("{stream}_tdata");
    let lanes = core.buses.iter().filter(|b| b.name == data).flat_map(|bus| {
        bus.lanes.iter().map(|lane| {
            let name = match direction {
                Direction::Input => core.node(core.inputs[lane.port]).name.clone().unwrap_or_default(),
                Direction::Output => core.outputs[lane.port].name.clone(),
            };
            // s_axis_tdata_left_x is the lane left.x.
            (name.trim_start_matches(&format!("{data}_")).replacen('_', ".", 1), lane.room)
        })
    });
    let port = Port::of_lanes(lanes).with_user(width("tuser"));
    let port = if width("tkeep") > 0 { port.with_keep() } else { port };
    if width("tlast") > 0 { port.with_last() } else { port }
}

/// The core in the built-in simulator.
pub struct Model {
    top: String,
    simulator: Simulator<Integers>,
    shapes: [Port; 2],
    input: StreamNodes,
    output: StreamNodes,
    /// Whether a beat stands at the input.
    offered: bool,
    /// Of the noise before reset.
    seed: u64,
    waveform: Option<(Waveform, u64)>,
    /// A waveform that could not be written is reported at the end, not in the middle of a run.
    failed: Option<std::io::Error>,
}

/// The nodes of a stream's signals.
struct StreamNodes {
    lanes: Vec<NodeId>,
    /// With the lowest of its bits.
    keep: Vec<(NodeId, u32)>,
    user: Option<NodeId>,
    last: Option<NodeId>,
    valid: NodeId,
    ready: NodeId,
}

impl Model {
    pub fn new(core: &Rc<Module>) -> Result<Model> {
        Model::from_flat(core, Flat::new(core)?)
    }

    /// A core in the built-in simulator from its flat form, which may have been changed since.
    pub fn from_flat(core: &Module, flat: Flat) -> Result<Model> {
        let find = |name: &str| flat.input(name).or_else(|| flat.output(name));
        let nodes = |stream: &str, port: &Port| -> Result<StreamNodes> {
            let missing = |name: &str| Error::usage(format!("{} has no port {name}", core.name));
            let signal = |name: &str| find(&format!("{stream}_{name}"));
            let lanes = port.lanes.iter().map(|lane| {
                let name = format!("tdata_{}", lane.name.replacen('.', "_", 1));
                signal(&name).ok_or_else(|| missing(&name))
            });
            Ok(StreamNodes {
                lanes: lanes.collect::<Result<_>>()?,
                keep: match core.buses.iter().find(|b| b.name == format!("{stream}_tkeep")) {
                    Some(bus) => bus
                        .lanes
                        .iter()
                        .map(|lane| (core.outputs[lane.port].name.clone(), lane.low))
                        .filter_map(|(name, low)| Some((find(&name)?, low)))
                        .collect(),
                    None => signal("tkeep").map(|node| (node, 0)).into_iter().collect(),
                },
                user: signal("tuser"),
                last: signal("tlast"),
                valid: signal("tvalid").ok_or_else(|| missing("tvalid"))?,
                ready: signal("tready").ok_or_else(|| missing("tready"))?,
            })
        };
        let shapes = [port(core, "s_axis", Direction::Input), port(core, "m_axis", Direction::Output)];
        let (input, output) = (nodes("s_axis", &shapes[0])?, nodes("m_axis", &shapes[1])?);
        let simulator = Simulator::new(flat, Integers);
        let (top, offered) = (core.name.clone(), false);
        Ok(Model { top, simulator, shapes, input, output, offered, seed: 1, waveform: None, failed: None })
    }

    /// Another noise in the registers before reset.
    pub fn with_seed(self, seed: u64) -> Model {
        Model { seed, ..self }
    }

    fn flag(&self, node: NodeId) -> bool {
        *self.simulator.get(node) != 0
    }

    fn offer(&mut self, beat: &Beat) {
        for (lane, &node) in self.input.lanes.iter().enumerate() {
            let word = self.simulator.flat.node(node).word;
            let number = self.shapes[0].number(beat, lane);
            self.simulator.set(node, word.range.wrap(number));
        }
        if let Some(user) = self.input.user {
            self.simulator.set(user, beat.user.into());
        }
        if let Some(last) = self.input.last {
            self.simulator.set(last, beat.last.into());
        }
    }

    /// While nothing is offered the payload is wrong on purpose: the last one with every bit inverted.
    fn withdraw(&mut self) {
        let payload = self.input.lanes.iter().copied().chain(self.input.user).chain(self.input.last);
        for node in payload.collect::<Vec<_>>() {
            let word = self.simulator.flat.node(node).word;
            self.simulator.set(node, word.range.wrap(!*self.simulator.get(node)));
        }
    }

    fn observe(&self) -> Beat {
        let value = |node: Option<NodeId>| node.map_or(0, |id| *self.simulator.get(id));
        let numbers: Vec<i128> = self.output.lanes.iter().map(|&id| *self.simulator.get(id)).collect();
        let mut beat = self.shapes[1].beat_of(&numbers);
        beat.keep.fill(0);
        for &(node, low) in &self.output.keep {
            let bits = *self.simulator.get(node) as u128;
            let (word, shift) = (low as usize / 64, low % 64);
            // A lane's bits lie in at most three words.
            let pieces = [
                bits << shift,
                bits.checked_shr(64 - shift).unwrap_or(0),
                bits.checked_shr(128 - shift).unwrap_or(0),
            ];
            for (index, piece) in pieces.into_iter().enumerate() {
                if let Some(word) = beat.keep.get_mut(word + index) {
                    *word |= piece as u64;
                }
            }
        }
        beat.user = value(self.output.user) as u64;
        beat.last = value(self.output.last) != 0;
        beat
    }
}

impl Clocked for Model {
    fn reset(&mut self) {
        self.simulator.scramble(self.seed);
        for node in [self.input.valid, self.output.ready] {
            self.simulator.set(node, 0);
        }
        self.simulator.settle();
        // On integers every control is an integer, so an edge cannot fail.
        let _ = self.simulator.edge(true);
    }

    fn clock(&mut self, input: Option<&Beat>, output_ready: bool) -> Handshake {
        self.simulator.set(self.input.valid, input.is_some().into());
        self.simulator.set(self.output.ready, output_ready.into());
        match input {
            Some(beat) => self.offer(beat),
            None if self.offered => self.withdraw(),
            None => {}
        }
        self.offered = input.is_some();
        self.simulator.settle();
        let output = self.flag(self.output.valid).then(|| self.observe());
        let handshake = Handshake { input_ready: self.flag(self.input.ready), output };
        if let Some((waveform, clock)) = &mut self.waveform {
            if let Err(error) = waveform.sample(*clock, &self.simulator) {
                self.failed.get_or_insert(error);
            }
            *clock += 1;
        }
        // As in `reset`.
        let _ = self.simulator.edge(false);
        handshake
    }

    fn trace(&mut self, vcd: Option<&Path>, clock: u64) -> Result<()> {
        let failed = |path: &Path, error: std::io::Error| {
            Error::new(Kind::ToolFailed, format!("cannot write the waveform: {error}")).at(path.display())
        };
        if let Some((waveform, _)) = self.waveform.take() {
            let written = waveform.finish();
            let failure = self.failed.take().or(written.err());
            if let Some(error) = failure {
                return Err(failed(Path::new("the waveform"), error));
            }
        }
        if let Some(path) = vcd {
            let waveform = Waveform::create(path, &self.simulator.flat, &self.top);
            self.waveform = Some((waveform.map_err(|e| failed(path, e))?, clock));
        }
        Ok(())
    }
}
