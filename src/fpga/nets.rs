//! Who drives each bit of a module of the netlist, and who reads it.

use std::collections::{BTreeMap, HashMap};

use serde::Deserialize;
use serde_json::{Value, json};

/// A port of a cell, or of the module where the cell has no name; the name of the cell, then that of the port.
pub type Pin = (String, String);

/// Drivers and readers of every bit, in the order of the names of the cells.
#[derive(Clone, Debug, Default)]
pub struct Nets {
    pub drivers: BTreeMap<u64, Pin>,
    pub readers: BTreeMap<u64, Vec<Pin>>,
}

impl Nets {
    pub fn of(module: &Value) -> Nets {
        let mut nets = Nets::default();
        for (name, port) in module["ports"].as_object().into_iter().flatten() {
            nets.add("", name, &port["bits"], port["direction"] == "input");
        }
        for (name, cell) in module["cells"].as_object().into_iter().flatten() {
            for (port, bits) in cell["connections"].as_object().into_iter().flatten() {
                nets.add(name, port, bits, cell["port_directions"][port] == "output");
            }
        }
        nets.readers.values_mut().for_each(|readers| readers.sort());
        nets
    }

    fn add(&mut self, cell: &str, port: &str, bits: &Value, drives: bool) {
        for bit in bits.as_array().into_iter().flatten().filter_map(Value::as_u64) {
            let pin = (cell.to_string(), port.to_string());
            if drives {
                self.drivers.insert(bit, pin);
            } else {
                self.readers.entry(bit).or_default().push(pin);
            }
        }
    }

    pub fn readers(&self, bit: u64) -> &[Pin] {
        self.readers.get(&bit).map_or(&[], Vec::as_slice)
    }

    /// A number that no net has.
    pub fn free(&self) -> u64 {
        let highest = |bits: Option<u64>| bits.map_or(0, |bit| bit + 1);
        highest(self.drivers.keys().last().copied()).max(highest(self.readers.keys().last().copied()))
    }
}

/// The one bit at a port: a number, or a constant as text.
pub fn bit<'a>(cell: &'a Value, port: &str) -> Option<&'a Value> {
    cell["connections"][port].as_array()?.first()
}

/// The net at a port, where it is no constant.
pub fn net(cell: &Value, port: &str) -> Option<u64> {
    bit(cell, port)?.as_u64()
}

/// A port that is there and leads nowhere; the placer fails where the port itself is missing.
pub fn open() -> Value {
    json!(["x"])
}

/// A table of 16 bits, as Yosys writes it: the entry of all ones first.
pub fn table(cell: &Value, parameter: &str) -> Option<u16> {
    u16::from_str_radix(cell["parameters"][parameter].as_str()?, 2).ok()
}

/// The names of the nets at ports of cells, where a netlist has them; it is read as text, as it is large and only this is
/// asked of it.
///
/// # Errors
/// What is no netlist.
pub fn names_at(netlist: &[u8], pins: &[Pin]) -> serde_json::Result<Vec<String>> {
    #[derive(Deserialize)]
    struct Netlist {
        modules: BTreeMap<String, Module>,
    }
    #[derive(Deserialize)]
    struct Module {
        cells: HashMap<String, Cell>,
        netnames: HashMap<String, Net>,
    }
    #[derive(Deserialize)]
    struct Cell {
        connections: HashMap<String, Vec<Value>>,
    }
    #[derive(Deserialize)]
    struct Net {
        bits: Vec<Value>,
    }
    let netlist: Netlist = serde_json::from_slice(netlist)?;
    let mut found = vec![];
    for module in netlist.modules.values() {
        let bit = |cell: &str, port: &str| module.cells.get(cell)?.connections.get(port)?.first()?.as_u64();
        let bits: Vec<u64> = pins.iter().filter_map(|(cell, port)| bit(cell, port)).collect();
        let mut names = BTreeMap::new();
        for (name, net) in &module.netnames {
            if let Some(bit) = net.bits.first().and_then(Value::as_u64).filter(|bit| bits.contains(bit)) {
                names.insert(bit, name.to_string());
            }
        }
        found.extend(bits.iter().filter_map(|bit| names.get(bit).cloned()));
    }
    Ok(found)
}
