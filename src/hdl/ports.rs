//! The ports of a module as the emitted Verilog has them, for whoever connects them or lists them.

use serde::Serialize;

use super::{Direction, Module, Word};

/// A port, or a bus of several.
#[derive(Clone, Debug, Serialize)]
pub struct Port {
    pub name: String,
    pub direction: &'static str,
    pub width: u32,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lanes: Vec<PortLane>,
}

/// One of the numbers side by side in a bus.
#[derive(Clone, Debug, Serialize)]
pub struct PortLane {
    pub name: String,
    pub lowest_bit: u32,
    /// Bits that matter; up to the next lane an output is sign-extended and an input is ignored.
    pub width: u32,
    pub format: String,
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
                let lane = |l: &super::Lane| PortLane {
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
