//! Between synthesis and placement: what the netlist asks for and nobody needs.
//!
//! The placer of the ECP5 gives a cell of its own, two LUTs, to every carry that leaves its chain and to every
//! constant that enters one.
//!
//! ```text
//!   before   0 ─►[a0|a1]─►[a2| 0]─► carry that nobody reads         4 cells: in, two of the adder, out
//!   unread       the carry is not connected                         3 cells
//!   shifted      [0 |a0]─►[a1|a2]                                   2 cells: the unused half makes the constant
//! ```
//!
//! Neither changes a bit of what the circuit computes; the netlist that is simulated is the one after this step.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::device::Family;
use super::netlist::Netlist;

/// What was removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Tidied {
    /// Carries that nobody reads, disconnected.
    pub unread_carries: u64,
    /// Chains whose constant carry-in is made in a half that was unused.
    pub shifted_chains: u64,
}

/// Tidies every module for the tools of the family.
pub fn tidy(family: Family, netlist: &mut Netlist) -> Tidied {
    let mut tidied = Tidied::default();
    if family != Family::Ecp5 {
        return tidied;
    }
    let Some(modules) = netlist.0["modules"].as_object_mut() else { return tidied };
    for (_, module) in modules.iter_mut() {
        tidied.unread_carries += drop_unread_carries(module);
        tidied.shifted_chains += shift_chains(module);
    }
    tidied
}

/// Readers of every bit: inputs of cells, and ports of the module.
fn readers(module: &Value) -> BTreeMap<u64, u64> {
    let mut readers = BTreeMap::new();
    let mut read = |bits: &Value| {
        for bit in bits.as_array().into_iter().flatten().filter_map(Value::as_u64) {
            *readers.entry(bit).or_default() += 1;
        }
    };
    for (_, port) in module["ports"].as_object().into_iter().flatten() {
        read(&port["bits"]);
    }
    for (_, cell) in module["cells"].as_object().into_iter().flatten() {
        for (port, bits) in cell["connections"].as_object().into_iter().flatten() {
            if cell["port_directions"][port] != "output" {
                read(bits);
            }
        }
    }
    readers
}

/// The one bit at a port: a number, or a constant as text.
fn bit<'a>(cell: &'a Value, port: &str) -> Option<&'a Value> {
    cell["connections"][port].as_array()?.first()
}

fn is_read(cell: &Value, port: &str, readers: &BTreeMap<u64, u64>) -> bool {
    bit(cell, port).and_then(Value::as_u64).is_some_and(|bit| readers.contains_key(&bit))
}

/// A port that is there and leads nowhere; the placer fails where the port itself is missing.
fn open() -> Value {
    json!(["x"])
}

fn is_carry(cell: &Value) -> bool {
    cell["type"] == "CCU2C"
}

fn drop_unread_carries(module: &mut Value) -> u64 {
    let readers = readers(module);
    let mut dropped = 0;
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    for (_, cell) in cells.iter_mut().filter(|(_, cell)| is_carry(cell)) {
        if bit(cell, "COUT").is_some_and(Value::is_u64) && !is_read(cell, "COUT", &readers) {
            cell["connections"]["COUT"] = open();
            dropped += 1;
        }
    }
    dropped
}

/// Moves chains that begin with a constant and end in an unused half up by one half.
fn shift_chains(module: &mut Value) -> u64 {
    let readers = readers(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let mut after: BTreeMap<u64, String> = BTreeMap::new();
    let mut heads = vec![];
    for (name, cell) in cells.iter().filter(|(_, cell)| is_carry(cell)) {
        match bit(cell, "CIN") {
            Some(Value::String(constant)) if constant == "0" || constant == "1" => {
                heads.push((name.clone(), constant == "1"));
            }
            Some(carry) => {
                // A carry with several readers belongs to no plain chain.
                let several = |bit: &u64| readers.get(bit) == Some(&1);
                carry.as_u64().filter(several).map(|carry| after.insert(carry, name.clone()));
            }
            None => {}
        }
    }
    let mut shifted = 0;
    for (head, constant) in heads {
        let mut chain = vec![head];
        while let Some(next) = chain
            .last()
            .and_then(|name| bit(&cells[name], "COUT")?.as_u64())
            .and_then(|carry| after.get(&carry))
        {
            chain.push(next.clone());
        }
        let last = &cells[&chain[chain.len() - 1]];
        if !bit(last, "COUT").is_some_and(Value::is_u64)
            && !is_read(last, "S1", &readers)
            && plain(cells, &chain)
        {
            shift(cells, &chain, constant);
            shifted += 1;
        }
    }
    shifted
}

/// Whether every half of the chain passes the carry on as adders do.
fn plain(cells: &Map<String, Value>, chain: &[String]) -> bool {
    let passes = |cell: &Value, half| cell["parameters"][format!("INJECT1_{half}")] == "NO";
    chain.iter().all(|name| passes(&cells[name], 0) && passes(&cells[name], 1))
}

/// One half of a cell: its four inputs, its table, its sum.
struct Half {
    inputs: [Value; 4],
    table: Value,
    sum: Value,
}

const INPUTS: [&str; 4] = ["A", "B", "C", "D"];

fn take(cell: &Value, half: usize) -> Half {
    let connections = &cell["connections"];
    let inputs = INPUTS.map(|name| connections[format!("{name}{half}")].clone());
    let sum = connections[format!("S{half}")].clone();
    Half { inputs, table: cell["parameters"][format!("INIT{half}")].clone(), sum }
}

fn put(cell: &mut Value, half: usize, content: Half) {
    for (name, input) in INPUTS.iter().zip(content.inputs) {
        cell["connections"][format!("{name}{half}")] = input;
    }
    cell["connections"][format!("S{half}")] = content.sum;
    cell["parameters"][format!("INIT{half}")] = content.table;
}

/// The first half makes the constant: with all inputs 1 its sum is 0, so that its carry is bit 3 of its table.
fn shift(cells: &mut Map<String, Value>, chain: &[String], constant: bool) {
    let table = format!("{:016b}", if constant { 0b1000 } else { 0 });
    let mut carried = Half { inputs: [(); 4].map(|()| json!(["1"])), table: json!(table), sum: open() };
    for (index, name) in chain.iter().enumerate() {
        let cell = &mut cells[name];
        let (low, high) = (take(cell, 0), take(cell, 1));
        put(cell, 0, carried);
        put(cell, 1, low);
        carried = high;
        if index == 0 {
            cell["connections"]["CIN"] = open();
        }
    }
}
