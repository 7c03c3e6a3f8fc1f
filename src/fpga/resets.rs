//! Resets belong at the registers: these can invert one themselves, and need no gate that makes their input 0.
//!
//! ```text
//!   before   aresetn ─► LUT (not) ─► LSR                d & aresetn ─► DI
//!   after    aresetn ─► LSR, inverted there             d ─► DI, aresetn ─► LSR, inverted there
//! ```
//!
//! Synthesis leaves the gate where a register is to be kept as it is.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::fold::Function;
use super::nets::{Nets, bit, net};

/// Registers behind an inverter of their reset take what stands before it; returns how many.
pub fn invert_resets(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let inverted = |cell: &Value| {
        let function = Function::of_lut(cells.get(&nets.drivers.get(&net(cell, "LSR")?)?.0)?)?;
        (function.nets.len() == 1 && function.table == 1).then(|| function.nets[0])
    };
    let registers: Vec<(String, u64)> = cells
        .iter()
        .filter(|(_, cell)| cell["type"] == "TRELLIS_FF" && cell["parameters"]["LSRMUX"] == "LSR")
        .filter_map(|(name, cell)| Some((name.clone(), inverted(cell)?)))
        .collect();
    for (name, reset) in &registers {
        set_reset(&mut cells[name], *reset);
    }
    drop_unread(module);
    registers.len() as u64
}

/// Registers whose input a gate makes 0 while the reset of most others is active take that reset; returns how many.
pub fn direct_resets(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let mut resets: BTreeMap<u64, u64> = BTreeMap::new();
    for (_, cell) in cells.iter().filter(|(_, cell)| cell["parameters"]["LSRMUX"] == "INV") {
        *resets.entry(net(cell, "LSR").unwrap_or_default()).or_default() += 1;
    }
    let Some((&reset, _)) = resets.iter().max_by_key(|(_, count)| **count) else { return 0 };
    let gates: Vec<String> = nets
        .readers(reset)
        .iter()
        .map(|(name, _)| name)
        .filter(|name| gates_reset(cells, &nets, name, reset))
        .cloned()
        .collect();
    let mut changed = 0;
    for gate in gates {
        let Some(out) = net(&cells[&gate], "Z") else { continue };
        let rest = Function::of_lut(&cells[&gate])
            .map(|function| function.fixed(|net| (net == reset).then_some(true)));
        // A gate of one other net passes it on.
        let passed = rest.filter(|rest| rest.nets.len() == 1 && rest.table == 0b10).map(|rest| rest.nets[0]);
        for (register, _) in nets.readers(out) {
            let cell = &mut cells[register];
            set_reset(cell, reset);
            cell["parameters"]["REGSET"] = json!("RESET");
            cell["parameters"]["SRMODE"] = json!("LSR_OVER_CE");
            if let Some(passed) = passed {
                cell["connections"]["DI"] = json!([passed]);
            }
            changed += 1;
        }
        for pin in ["A", "B", "C", "D"] {
            if net(&cells[&gate], pin) == Some(reset) {
                cells[&gate]["connections"][pin] = json!(["1"]);
            }
        }
    }
    drop_unread(module);
    changed
}

/// Whether a cell is a LUT that is 0 during the reset, and read by registers alone that have no reset and no enable.
fn gates_reset(cells: &Map<String, Value>, nets: &Nets, name: &str, reset: u64) -> bool {
    let Some(cell) = cells.get(name).filter(|cell| cell["type"] == "LUT4") else { return false };
    let Some(function) = Function::of_lut(cell) else { return false };
    let held = function.fixed(|net| (net == reset).then_some(false));
    let plain = |(register, port): &(String, String)| {
        let constant = |cell: &Value, port: &str, value: &str| bit(cell, port).is_none_or(|pin| pin == value);
        port == "DI"
            && cells.get(register).is_some_and(|cell| {
                cell["type"] == "TRELLIS_FF" && constant(cell, "CE", "1") && constant(cell, "LSR", "0")
            })
    };
    let readers = net(cell, "Z").map_or(&[][..], |out| nets.readers(out));
    held.table == 0 && !readers.is_empty() && readers.iter().all(plain)
}

fn set_reset(cell: &mut Value, reset: u64) {
    cell["connections"]["LSR"] = json!([reset]);
    cell["parameters"]["LSRMUX"] = json!("INV");
}

/// Removes LUTs that nothing reads.
fn drop_unread(module: &mut Value) {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return };
    let unread = |cell: &Value| net(cell, "Z").is_some_and(|out| nets.readers(out).is_empty());
    cells.retain(|_, cell| cell["type"] != "LUT4" || !unread(cell));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lut(table: u16, pins: [Value; 4], out: u64) -> Value {
        let [a, b, c, d] = pins;
        json!({
            "type": "LUT4",
            "parameters": { "INIT": format!("{table:016b}") },
            "port_directions": { "A": "input", "B": "input", "C": "input", "D": "input", "Z": "output" },
            "connections": { "A": [a], "B": [b], "C": [c], "D": [d], "Z": [out] },
        })
    }

    fn register(input: u64, reset: Value, out: u64) -> Value {
        json!({
            "type": "TRELLIS_FF",
            "parameters": { "LSRMUX": "LSR" },
            "port_directions": { "DI": "input", "LSR": "input", "Q": "output" },
            "connections": { "DI": [input], "LSR": [reset], "Q": [out] },
        })
    }

    fn module(cells: Value) -> Value {
        json!({ "cells": cells, "ports": { "y": { "direction": "output", "bits": [12, 15] } } })
    }

    #[test]
    fn an_inverter_before_a_reset_goes_into_the_register_and_another_function_does_not() {
        let inverter = |table| lut(table, [json!("1"), json!(10), json!("0"), json!("0")], 11);
        for (table, inverts) in [(0b0010, true), (0b1000, false), (0b1010, false)] {
            let mut module = module(json!({ "r": register(9, json!(11), 12), "inverter": inverter(table) }));
            assert_eq!(invert_resets(&mut module), u64::from(inverts));
            let cells = &module["cells"];
            assert_eq!(cells["r"]["connections"]["LSR"], json!([if inverts { 10 } else { 11 }]));
            assert_eq!(cells["r"]["parameters"]["LSRMUX"], if inverts { "INV" } else { "LSR" });
            assert_eq!(cells["inverter"].is_null(), inverts);
        }
    }

    #[test]
    fn a_gate_with_the_reset_goes_and_any_other_stays() {
        let inverter = lut(0b0010, [json!("1"), json!(10), json!("0"), json!("0")], 11);
        // Pins A and B; and, or, and of the inverted reset.
        for (table, direct) in [(0b1000u16, true), (0b1110, false), (0b0010, false)] {
            let gate = lut(table, [json!(13), json!(10), json!("0"), json!("0")], 14);
            let mut module = module(json!({
                "inverter": inverter,
                "r": register(9, json!(11), 12),
                "gate": gate,
                "kept": register(14, json!("0"), 15),
            }));
            assert_eq!(invert_resets(&mut module), 1);
            assert_eq!(direct_resets(&mut module), u64::from(direct));
            let kept = &module["cells"]["kept"];
            assert_eq!(kept["connections"]["DI"], json!([if direct { 13 } else { 14 }]));
            assert_eq!(kept["connections"]["LSR"], if direct { json!([10]) } else { json!(["0"]) });
            assert_eq!(module["cells"]["gate"].is_null(), direct);
        }
    }

    #[test]
    fn what_a_gate_of_more_nets_computes_stays_before_the_register() {
        let mut module = module(json!({
            "inverter": lut(0b0010, [json!("1"), json!(10), json!("0"), json!("0")], 11),
            "r": register(9, json!(11), 12),
            // (A | C) & B
            "gate": lut(0b1100_1000_1100_1000, [json!(13), json!(10), json!(16), json!("0")], 14),
            "kept": register(14, json!("0"), 15),
        }));
        invert_resets(&mut module);
        assert_eq!(direct_resets(&mut module), 1);
        let gate = Function::of_lut(&module["cells"]["gate"]).unwrap();
        assert_eq!(gate, Function { nets: vec![13, 16], table: 0b1110 });
    }
}
