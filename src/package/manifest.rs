//! The manifest: one JSON object for programs that use the core.

use std::collections::BTreeMap;
use std::rc::Rc;

use serde::Serialize;
use serde_json::Value;

use crate::fpga::estimate::Estimate;
use crate::hdl::{Cell, Counts, Direction, Module, Word};

/// `manifest.json`, in the order in which it is written.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// `subdiv-rtl/manifest/1`
    pub schema: &'static str,
    pub core: &'static str,
    pub top: String,
    pub generator: String,
    /// The command that writes exactly these files.
    pub command: String,
    pub parameters: Value,
    pub ports: Vec<Port>,
    /// How the streams are to be read, in words.
    pub streams: Value,
    /// In clocks.
    pub latency: Value,
    pub initiation_interval: Value,
    pub counts: Counts,
    /// On one device of every family that cores were measured on.
    pub estimates: Vec<Estimate>,
    pub proofs: Value,
    /// Every register of every module: its format, its range, and the source line that describes it.
    pub names: BTreeMap<String, BTreeMap<String, Name>>,
    /// BLAKE3 of each file.
    pub hashes: BTreeMap<String, String>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Port {
    pub name: String,
    pub direction: &'static str,
    pub width: u32,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lanes: Vec<Lane>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Lane {
    pub name: String,
    pub lowest_bit: u32,
    /// Bits that matter; up to the next lane an output is sign-extended and an input is ignored.
    pub width: u32,
    pub format: String,
}

#[derive(Clone, Debug, Serialize)]
pub struct Name {
    pub format: String,
    pub source: String,
}

/// The ports as the emitted Verilog has them.
pub fn ports(module: &Module) -> Vec<Port> {
    let mut ports: Vec<Port> = vec![];
    for (name, needed) in [("aclk", module.needs_clock()), ("aresetn", module.needs_reset())] {
        if needed {
            ports.push(Port { name: name.into(), direction: "input", width: 1, lanes: vec![] });
        }
    }
    let inputs = module
        .inputs
        .iter()
        .map(|&id| (module.node(id).name.clone().unwrap_or_default(), module.node(id).word));
    let outputs = module.outputs.iter().map(|o| (o.name.clone(), module.node(o.node).word));
    add(&mut ports, module, Direction::Input, inputs.collect());
    add(&mut ports, module, Direction::Output, outputs.collect());
    ports
}

fn add(ports: &mut Vec<Port>, module: &Module, direction: Direction, signals: Vec<(String, Word)>) {
    let text = if direction == Direction::Input { "input" } else { "output" };
    for (index, (name, word)) in signals.iter().enumerate() {
        let bus =
            module.buses.iter().find(|b| b.direction == direction && b.lanes.iter().any(|l| l.port == index));
        match bus {
            None => {
                ports.push(Port { name: name.clone(), direction: text, width: word.width(), lanes: vec![] })
            }
            Some(bus) if bus.lanes[0].port == index => {
                let lane = |l: &crate::hdl::Lane| Lane {
                    name: signals[l.port].0.trim_start_matches(&format!("{}_", bus.name)).to_string(),
                    lowest_bit: l.low,
                    width: signals[l.port].1.width(),
                    format: signals[l.port].1.to_string(),
                };
                let lanes = bus.lanes.iter().map(lane).collect();
                ports.push(Port { name: bus.name.clone(), direction: text, width: bus.width, lanes });
            }
            Some(_) => {}
        }
    }
}

/// The registers of every module.
pub fn names(top: &Rc<Module>) -> BTreeMap<String, BTreeMap<String, Name>> {
    let mut modules = BTreeMap::new();
    for module in top.hierarchy() {
        let mut registers = BTreeMap::new();
        for node in &module.nodes {
            if let (Cell::Register { .. } | Cell::MemoryRead { .. }, Some(name)) = (&node.cell, &node.name) {
                let source = format!("{}:{}", node.place.file(), node.place.line());
                registers.insert(name.clone(), Name { format: node.word.to_string(), source });
            }
        }
        modules.insert(module.name.clone(), registers);
    }
    modules
}
