//! A register behind a block RAM goes into it: block RAMs of the ECP5 have registers at their outputs.
//!
//! ```text
//!   before   block RAM ─► register        a long way: the word comes late in the clock
//!   after    block RAM with its register  at the next edge, and early in it
//! ```
//!
//! Yosys, to 0.70 at least, makes no use of them (YosysHQ/yosys issue 5814: `memory_libmap` emits `REGMODE` NOREG always);
//! a RAM whose word goes to a plain register and nowhere else shows it. The register may have an enable, and the RAM one
//! of its own.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::nets::{Nets, bit, net};

/// What is to be done with a RAM.
struct Plan {
    ram: String,
    /// The ports of the RAM whose outputs are registered, by their letters.
    sides: Vec<char>,
    /// When the registers take their inputs: a net or 1.
    enable: Value,
    /// Outputs, each with its register and what that drives.
    outputs: Vec<(String, String, u64)>,
}

/// Registers go into the block RAMs before them; returns how many.
pub fn register_outputs(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object() else { return 0 };
    let rams = cells.iter().filter(|(_, cell)| cell["type"] == "DP16KD");
    let plans: Vec<Plan> =
        rams.filter_map(|(name, cell)| plan(name, cell, &nets, &|register| cells.get(register))).collect();
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let mut absorbed = BTreeSet::new();
    for Plan { ram, sides, enable, outputs } in plans {
        let cell = &mut cells[&ram];
        for side in sides {
            cell["parameters"][format!("REGMODE_{side}")] = json!("OUTREG");
            cell["connections"][format!("OCE{side}")] = json!([enable]);
        }
        for (output, register, driven) in outputs {
            cell["connections"][output] = json!([driven]);
            absorbed.insert(register);
        }
    }
    cells.retain(|name, _| !absorbed.contains(name));
    absorbed.len() as u64
}

fn plan<'a>(name: &str, ram: &Value, nets: &Nets, cell: &dyn Fn(&str) -> Option<&'a Value>) -> Option<Plan> {
    if ['A', 'B'].iter().any(|side| ram["parameters"][format!("REGMODE_{side}")] != "NOREG") {
        return None;
    }
    let mut outputs = vec![];
    let mut read = BTreeSet::new();
    for side in ['A', 'B'] {
        for port in (0..18).map(|place| format!("DO{side}{place}")) {
            let Some(out) = net(ram, &port) else { continue };
            match nets.readers(out) {
                [] => {}
                [(register, pin)] if pin == "DI" => {
                    read.insert(side);
                    outputs.push((port, register.clone(), net(cell(register)?, "Q")?));
                }
                _ => return None,
            }
        }
    }
    // Words of 36 bits leave at both ports, by the clock and enable of the second.
    let wide =
        ["DATA_WIDTH_A", "DATA_WIDTH_B"].iter().all(|width| number(&ram["parameters"][*width]) == Some(36));
    let (by, sides) = match read.iter().collect::<Vec<_>>()[..] {
        [_, _] | [_] if wide => ('B', vec!['A', 'B']),
        [&side] => (side, vec![side]),
        _ => return None,
    };
    let always = |port: &str, value: &str| bit(ram, &format!("{port}{by}")).is_some_and(|bit| bit == value);
    let clock = net(ram, &format!("CLK{by}"))?;
    let enabled = |(_, register, _): &(String, String, u64)| enable(cell(register)?, clock);
    let enable = enabled(outputs.first()?)?;
    let fits = always("RST", "0")
        && ram["parameters"][format!("CLK{by}MUX")] == format!("CLK{by}")
        && outputs.iter().all(|output| enabled(output).as_ref() == Some(&enable));
    fits.then(|| Plan { ram: name.into(), sides, enable, outputs })
}

/// The enable of a register that takes its input at rising edges of this clock, and is 0 at first.
fn enable(register: &Value, clock: u64) -> Option<Value> {
    let is = |port: &str, value: &str| bit(register, port).is_none_or(|bit| bit == value);
    let parameters = &register["parameters"];
    let fits = register["type"] == "TRELLIS_FF"
        && net(register, "CLK") == Some(clock)
        && parameters["CLKMUX"] == "CLK"
        && parameters["REGSET"] == "RESET"
        && parameters["LSRMUX"] == "LSR"
        && is("LSR", "0");
    let enable = match parameters["CEMUX"].as_str()?.trim() {
        "1" => json!("1"),
        "CE" => bit(register, "CE")?.clone(),
        _ => return None,
    };
    fits.then_some(enable)
}

/// A number as Yosys writes it, in binary.
fn number(parameter: &Value) -> Option<u64> {
    u64::from_str_radix(parameter.as_str()?, 2).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A RAM of which two bits are read, of this width, and a register behind each; with more put into the second register.
    fn ram(width: u64, changed: &dyn Fn(&mut Value)) -> Value {
        let register = |read: u64, driven: u64| {
            json!({
                "type": "TRELLIS_FF",
                "parameters": { "CEMUX": "1 ", "CLKMUX": "CLK", "LSRMUX": "LSR", "REGSET": "RESET" },
                "port_directions": { "CLK": "input", "DI": "input", "LSR": "input", "Q": "output" },
                "connections": { "CLK": [2], "DI": [read], "LSR": ["0"], "Q": [driven] },
            })
        };
        let width = format!("{width:032b}");
        let first = if width.ends_with("100100") { "DOA3" } else { "DOB3" };
        let mut module = json!({
            "ports": { "y": { "direction": "output", "bits": [20, 21] } },
            "cells": {
                "ram": {
                    "type": "DP16KD",
                    "parameters": {
                        "REGMODE_A": "NOREG", "REGMODE_B": "NOREG", "CLKBMUX": "CLKB",
                        "DATA_WIDTH_A": width, "DATA_WIDTH_B": width,
                    },
                    "port_directions": { "CLKB": "input", "DOA3": "output", "DOB3": "output", "DOB4": "output" },
                    "connections": { "CLKB": [2], "CEB": ["1"], "RSTB": ["0"], first: [10], "DOB4": [11], "OCEB": ["0"] },
                },
                "low": register(10, 20),
                "high": register(11, 21),
            },
        });
        changed(&mut module);
        module
    }

    #[test]
    fn plain_registers_go_into_the_ram_before_them() {
        for (width, first, other) in [(36, "DOA3", "OUTREG"), (18, "DOB3", "NOREG")] {
            let mut module = ram(width, &|_| {});
            assert_eq!(register_outputs(&mut module), 2);
            let cells = module["cells"].as_object().unwrap();
            assert_eq!(cells.len(), 1);
            let (ram, connections) = (&cells["ram"]["parameters"], &cells["ram"]["connections"]);
            assert_eq!((&ram["REGMODE_A"], &ram["REGMODE_B"]), (&json!(other), &json!("OUTREG")));
            assert_eq!((&connections[first], &connections["DOB4"]), (&json!([20]), &json!([21])));
            assert_eq!(connections["OCEB"], json!(["1"]));
            assert_eq!(register_outputs(&mut module), 0, "they are there already");
        }
    }

    #[test]
    fn the_enable_of_the_registers_goes_with_them_and_that_of_the_ram_stays() {
        let with = |low: u64, high: u64| {
            ram(18, &|module| {
                for (cell, net) in [("low", low), ("high", high)] {
                    module["cells"][cell]["parameters"]["CEMUX"] = json!("CE");
                    module["cells"][cell]["connections"]["CE"] = json!([net]);
                }
                module["cells"]["ram"]["connections"]["CEB"] = json!([6]);
            })
        };
        let mut module = with(5, 5);
        assert_eq!(register_outputs(&mut module), 2);
        let connections = &module["cells"]["ram"]["connections"];
        assert_eq!((&connections["CEB"], &connections["OCEB"]), (&json!([6]), &json!([5])));
        assert_eq!(register_outputs(&mut with(5, 7)), 0, "one enable for all");
    }

    #[test]
    fn whatever_a_register_of_the_ram_cannot_do_stays_outside() {
        let set = |cell: &'static str, kind: &'static str, name: &'static str, value: Value| {
            move |module: &mut Value| module["cells"][cell][kind][name] = value.clone()
        };
        let changes: [&dyn Fn(&mut Value); 7] = [
            &set("high", "connections", "CLK", json!([3])),
            &set("high", "connections", "LSR", json!([4])),
            &set("high", "parameters", "REGSET", json!("SET")),
            &set("high", "parameters", "CLKMUX", json!("INV")),
            &|module| {
                module["cells"]["high"]["parameters"]["CEMUX"] = json!("CE");
                module["cells"]["high"]["connections"]["CE"] = json!([5]);
            },
            &set("ram", "parameters", "CLKBMUX", json!("INV")),
            // Somebody else reads the word, too.
            &|module| module["ports"]["y"]["bits"] = json!([20, 21, 11]),
        ];
        for (nth, changed) in changes.into_iter().enumerate() {
            let mut module = ram(36, changed);
            let before = module.clone();
            assert_eq!(register_outputs(&mut module), 0, "change {nth}");
            assert_eq!(module, before);
        }
    }
}
