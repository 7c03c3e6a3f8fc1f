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
//! A chain without an unused half gets one, in a cell behind it in place of the one before it. A half that lets a
//! register's carry in needs no constant before it.
//!
//! Two registers with different enables do not fit behind one cell; where a chain ends so, its last bit moves into a
//! cell more.
//!
//! Besides, [choices](super::fold) go into the cells of the adders before them, for which [signs](super::signs) with two
//! readers are made twice; [registers](super::fan_out) with many readers are copied; [registers](super::block_outputs)
//! behind a block RAM go into it; an inverter in front of [resets](super::resets) goes into the registers, and so does a
//! gate with the reset; constants of [RAMs](super::ram_pins) need no wire. None of this changes a bit of what the circuit
//! computes; the netlist that is simulated is the one after this step.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::block_outputs::register_outputs;
use super::device::Family;
use super::fan_out::{copy_across, copy_registers};
use super::fold::{absorb_operands, fold_choices, seal_chains};
use super::netlist::Netlist;
use super::nets::{Nets, bit, net, open};
use super::ram_pins;
use super::resets::{direct_resets, invert_resets};
use super::signs::part_signs;

/// What was removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Tidied {
    /// Carries that nobody reads, disconnected.
    pub unread_carries: u64,
    /// Signs of sums that have a half of carry for each of two readers.
    pub parted_signs: u64,
    /// LUTs of choices that went into the adders before them.
    pub folded_choices: u64,
    /// LUTs of operands that went into the adders behind them.
    pub absorbed_operands: u64,
    /// Chains that begin with a carry out of a register, and ask for no constant any more.
    pub sealed_chains: u64,
    /// Chains whose constant carry-in is made in a half of their own.
    pub shifted_chains: u64,
    /// Carries that leave in a cell of their own, as their registers do not fit beside the others.
    pub parted_carries: u64,
    /// Registers that invert their reset themselves.
    pub inverted_resets: u64,
    /// Registers that are reset themselves, not by a gate before them.
    pub direct_resets: u64,
    /// Registers that went into the block RAMs before them.
    pub registered_outputs: u64,
    /// Constant pins of RAMs made of lookup tables that need no wire.
    pub raised_pins: u64,
    /// Copies of registers with many readers.
    pub copied_registers: u64,
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
        tidied.parted_signs += part_signs(module);
        tidied.folded_choices += fold_choices(module);
        tidied.absorbed_operands += absorb_operands(module);
        tidied.sealed_chains += seal_chains(module);
        tidied.shifted_chains += shift_chains(module);
        tidied.inverted_resets += invert_resets(module);
        tidied.direct_resets += direct_resets(module);
        tidied.registered_outputs += register_outputs(module);
        tidied.raised_pins += ram_pins::raise(module);
        tidied.copied_registers += copy_registers(module);
        tidied.parted_carries += part_carries(module);
    }
    tidied.copied_registers += copy_across(modules);
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

fn is_read(cell: &Value, port: &str, readers: &BTreeMap<u64, u64>) -> bool {
    bit(cell, port).and_then(Value::as_u64).is_some_and(|bit| readers.contains_key(&bit))
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

/// Moves chains that begin with a constant up by one half; where no half is free at the end, into a cell more, which the
/// constant would also take.
fn shift_chains(module: &mut Value) -> u64 {
    let readers = readers(module);
    let mut free = Nets::of(module).free();
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
        let last = chain[chain.len() - 1].clone();
        if bit(&cells[&last], "COUT").is_some_and(Value::is_u64) || !plain(cells, &chain) {
            continue;
        }
        if is_read(&cells[&last], "S1", &readers) {
            chain.push(lengthen(cells, &last, free));
            free += 1;
        }
        shift(cells, &chain, constant);
        shifted += 1;
    }
    shifted
}

/// A cell more behind the last one of a chain, both halves unused; returns its name.
fn lengthen(cells: &mut Map<String, Value>, last: &str, carry: u64) -> String {
    let mut more = cells[last].clone();
    cells[last]["connections"]["COUT"] = json!([carry]);
    more["connections"]["CIN"] = json!([carry]);
    for half in 0..2 {
        put(&mut more, half, unused());
    }
    let mut name = format!("{last}_more");
    while cells.contains_key(&name) {
        name.push('_');
    }
    cells.insert(name.clone(), more);
    name
}

/// Moves the last bit of a chain into a cell more where its register has not the enable and the reset of that beside it.
fn part_carries(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let control = |cell: &Value, port: &str| {
        let [(register, reads)] = nets.readers(net(cell, port)?) else { return None };
        let register = cells.get(register).filter(|cell| cell["type"] == "TRELLIS_FF" && reads == "DI")?;
        Some(["CE", "LSR"].map(|port| bit(register, port).cloned()))
    };
    let parts = |cell: &Value| match (control(cell, "S0"), control(cell, "S1")) {
        (Some(low), Some(high)) => low != high && !bit(cell, "COUT").is_some_and(Value::is_u64),
        _ => false,
    };
    let names: Vec<String> = cells
        .iter()
        .filter(|(_, cell)| is_carry(cell) && parts(cell))
        .map(|(name, _)| name.clone())
        .collect();
    for (free, name) in (nets.free()..).zip(&names) {
        let high = take(&cells[name], 1);
        let more = lengthen(cells, name, free);
        put(&mut cells[&more], 0, high);
        put(&mut cells[name], 1, Half { table: json!(format!("{:016b}", 0x8000)), ..unused() });
    }
    names.len() as u64
}

/// A half that makes nothing, and carries 0.
fn unused() -> Half {
    Half { inputs: [(); 4].map(|()| json!(["1"])), table: json!(format!("{:016b}", 0)), sum: open() }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(carry_in: Value, inputs: [u64; 2], sums: [u64; 2], carry_out: u64) -> Value {
        let mut cell = json!({
            "type": "CCU2C",
            "parameters": { "INIT0": "0110", "INIT1": "1001", "INJECT1_0": "NO", "INJECT1_1": "NO" },
            "port_directions": { "CIN": "input", "COUT": "output", "S0": "output", "S1": "output" },
            "connections": { "CIN": [carry_in], "COUT": [carry_out] },
        });
        for half in 0..2 {
            cell["connections"][format!("S{half}")] = json!([sums[half]]);
            for name in INPUTS {
                let value = if name == "A" { json!([inputs[half]]) } else { json!(["0"]) };
                cell["connections"][format!("{name}{half}")] = value;
                cell["port_directions"][format!("{name}{half}")] = json!("input");
            }
        }
        cell
    }

    /// A chain of two cells that reads bits 10 to 13 and makes 20 to 22, and 23 where it is wanted.
    fn chain(constant: &str, outputs: &[u64]) -> Netlist {
        Netlist(json!({ "modules": { "m": {
            "ports": { "y": { "direction": "output", "bits": outputs } },
            "cells": {
                "high": cell(json!(30), [12, 13], [22, 23], 31),
                "low": cell(json!(constant), [10, 11], [20, 21], 30),
            },
        } } }))
    }

    /// Whether the netlist puts out what it did before, for all numbers.
    fn sums(netlist: &Netlist, numbers: u64) -> BTreeMap<u64, bool> {
        let cells = &netlist.0["modules"]["m"]["cells"];
        let mut bits: BTreeMap<u64, bool> = (0..4).map(|i| (10 + i, numbers >> i & 1 == 1)).collect();
        for name in ["low", "high", "high_more"] {
            let cell = &cells[name];
            if cell.is_null() {
                continue;
            }
            let read = |bits: &BTreeMap<u64, bool>, port: String| match bit(cell, &port) {
                Some(Value::String(constant)) => constant == "1",
                Some(number) => number.as_u64().and_then(|bit| bits.get(&bit).copied()).unwrap_or(false),
                None => false,
            };
            let mut carry = read(&bits, "CIN".into());
            for half in 0..2 {
                let inputs = INPUTS.iter().enumerate();
                let index =
                    inputs.map(|(i, name)| usize::from(read(&bits, format!("{name}{half}"))) << i).sum();
                let table = cell["parameters"][format!("INIT{half}")].as_str().unwrap();
                let table = |index: usize| table.bytes().rev().nth(index) == Some(b'1');
                let (sum, generate) = (table(index), table(index & 3));
                if let Some(out) = bit(cell, &format!("S{half}")).and_then(Value::as_u64) {
                    bits.insert(out, sum ^ carry);
                }
                carry = if sum { carry } else { generate };
            }
            if let Some(out) = bit(cell, "COUT").and_then(Value::as_u64) {
                bits.insert(out, carry);
            }
        }
        bits.retain(|bit, _| (20..24).contains(bit));
        bits
    }

    #[test]
    fn an_unread_carry_is_disconnected_and_a_read_one_is_not() {
        let mut netlist = chain("x", &[20, 21, 22, 23]);
        assert_eq!(tidy(Family::Ecp5, &mut netlist), Tidied { unread_carries: 1, ..Tidied::default() });
        let cells = &netlist.0["modules"]["m"]["cells"];
        assert_eq!(
            (&cells["high"]["connections"]["COUT"], &cells["low"]["connections"]["COUT"]),
            (&open(), &json!([30]))
        );
        let mut netlist = chain("x", &[20, 21, 22, 23, 31]);
        assert_eq!(tidy(Family::Ecp5, &mut netlist), Tidied::default());
        let mut other = chain("0", &[20]);
        assert_eq!(tidy(Family::Ice40, &mut other), Tidied::default());
    }

    #[test]
    fn a_chain_with_an_unused_half_makes_its_constant_itself_and_computes_the_same() {
        for (constant, outputs) in [("0", 3), ("1", 3), ("0", 4), ("1", 4)] {
            let mut before = chain(constant, &[20, 21, 22, 23][..outputs]);
            if outputs == 3 {
                before.0["modules"]["m"]["cells"]["high"]["connections"]["S1"] = open();
            }
            let mut after = before.clone();
            assert_eq!(
                tidy(Family::Ecp5, &mut after),
                Tidied { unread_carries: 1, shifted_chains: 1, ..Tidied::default() }
            );
            let cells = after.0["modules"]["m"]["cells"].as_object().unwrap();
            assert_eq!(cells.len(), outputs - 1);
            assert_eq!(after.0["modules"]["m"]["cells"]["low"]["connections"]["CIN"], open());
            for numbers in 0..16 {
                assert_eq!(sums(&before, numbers), sums(&after, numbers), "{constant} {numbers:b}");
            }
            assert!((0..16).any(|numbers| sums(&before, numbers) != sums(&before, 0)));
        }
    }

    #[test]
    fn a_last_bit_with_an_enable_of_its_own_moves_into_a_cell_of_its_own() {
        let register = |input: u64, enable: u64| {
            json!({
                "type": "TRELLIS_FF",
                "port_directions": { "DI": "input", "CE": "input", "Q": "output" },
                "connections": { "DI": [input], "CE": [enable], "Q": [input + 100] },
            })
        };
        for (enable, parted) in [(40, 0), (41, 1)] {
            let mut before = chain("x", &[]);
            let cells = before.0["modules"]["m"]["cells"].as_object_mut().unwrap();
            // The lowest half carries its bit out, so that the last one has a carry to lose.
            cells["low"]["connections"]["C0"] = json!(["1"]);
            cells["low"]["parameters"]["INIT0"] = json!("0000000000000010");
            let bits = [(20, 40), (21, 40), (22, 40), (23, enable)];
            for (bit, enable) in bits {
                cells.insert(format!("r{bit}"), register(bit, enable));
            }
            let mut after = before.clone();
            assert_eq!(tidy(Family::Ecp5, &mut after).parted_carries, parted);
            for numbers in 0..16 {
                assert_eq!(sums(&before, numbers), sums(&after, numbers), "{numbers:b}");
            }
            let last = if parted == 1 { ("high_more", "S0") } else { ("high", "S1") };
            assert_eq!(after.0["modules"]["m"]["cells"][last.0]["connections"][last.1], json!([23]));
        }
    }

    #[test]
    fn a_carry_out_of_a_register_needs_no_constant_before_it() {
        for constant in ["0", "1"] {
            let mut before = chain(constant, &[21, 22, 23]);
            // 1 + bit 10 lets that bit in as the carry.
            let low = &mut before.0["modules"]["m"]["cells"]["low"];
            low["connections"]["S0"] = open();
            low["connections"]["B0"] = json!(["1"]);
            low["parameters"]["INIT0"] = json!("0000000000001001");
            let mut after = before.clone();
            let tidied = tidy(Family::Ecp5, &mut after);
            assert_eq!((tidied.sealed_chains, tidied.shifted_chains), (1, 0));
            assert_eq!(after.0["modules"]["m"]["cells"]["low"]["connections"]["CIN"], open());
            for numbers in 0..16 {
                assert_eq!(sums(&before, numbers), sums(&after, numbers), "{constant} {numbers:b}");
            }
            assert!((0..16).any(|numbers| sums(&before, numbers) != sums(&before, 0)));
        }
    }
}
