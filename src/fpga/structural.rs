//! A netlist as Verilog again: its cells one by one, with the parameters and nets that Yosys gave them.
//!
//! ```text
//!   { "type": "LUT4", "parameters": { "INIT": "0110" }, "connections": { "A": [7], "Z": [9] } }
//!   LUT4 #(.INIT(4'b0110)) \engine_x.sum_LUT4_Z (.A(\engine_x.left [0]), .Z(\engine_x.sum [0]));
//! ```
//!
//! A net is called after the first of our names that it has, so that waveforms show them. The cells themselves are
//! those of [`super::cell_models`].

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use serde_json::{Map, Value};

use super::netlist::Netlist;
use crate::error::{Error, Kind, Result};

/// The modules of a netlist below one of them, as Verilog; and the types of the cells in them.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    pub text: String,
    pub types: BTreeSet<String>,
}

/// Prints a module and those below it.
///
/// # Errors
/// `ToolFailed` for a netlist with cells that synthesis has left without a place on the device.
pub fn print(netlist: &Netlist, top: &str) -> Result<Structure> {
    let mut structure = Structure::default();
    let mut open = vec![top.to_string()];
    let mut printed = BTreeSet::new();
    while let Some(name) = open.pop() {
        if !printed.insert(name.clone()) {
            continue;
        }
        for kind in Printer::new(netlist, &name)?.print(&mut structure.text)? {
            match inner(netlist, &kind) {
                true => open.push(kind),
                false => drop(structure.types.insert(kind)),
            }
        }
    }
    Ok(structure)
}

/// Whether a type is a module of the netlist, not a cell of the device.
fn inner(netlist: &Netlist, kind: &str) -> bool {
    netlist.0["modules"].get(kind).is_some_and(|module| module["attributes"]["blackbox"].is_null())
}

/// The entries of an object; none where there is none.
fn entries(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flatten()
}

fn bits(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

struct Printer<'a> {
    name: &'a str,
    module: &'a Value,
    /// The names of the nets by their number.
    nets: BTreeMap<u64, String>,
    /// Outputs that lead nowhere have nets of their own.
    unread: usize,
}

impl<'a> Printer<'a> {
    fn new(netlist: &'a Netlist, name: &'a str) -> Result<Printer<'a>> {
        let module = netlist.0["modules"].get(name);
        let module = module
            .ok_or_else(|| Error::new(Kind::ToolFailed, format!("the netlist has no module '{name}'")))?;
        Ok(Printer { name, module, nets: nets(module), unread: 0 })
    }

    /// The types of its cells.
    fn print(mut self, text: &mut String) -> Result<BTreeSet<String>> {
        let mut types = BTreeSet::new();
        let mut cells = String::new();
        for (name, cell) in entries(&self.module["cells"]) {
            let kind = cell["type"].as_str().unwrap_or_default();
            match kind {
                // A note of Yosys, not hardware.
                "$scopeinfo" => continue,
                _ if kind.starts_with('$') && !kind.starts_with("$paramod") => {
                    return Err(Error::new(
                        Kind::ToolFailed,
                        format!("{}: the cell '{name}' is left as {kind}", self.name),
                    ));
                }
                _ => self.cell(name, kind, cell, &mut cells),
            }
            types.insert(kind.to_string());
        }
        let ports: Vec<String> = entries(&self.module["ports"]).map(|(name, _)| escaped(name)).collect();
        line(text, format_args!("module {} ({});", escaped(self.name), ports.join(", ")));
        for (name, port) in entries(&self.module["ports"]) {
            let direction = port["direction"].as_str().unwrap_or("input");
            let highest = bits(&port["bits"]).len().saturating_sub(1);
            line(text, format_args!("  {direction} [{highest}:0] {};", escaped(name)));
        }
        for net in self.nets.values() {
            line(text, format_args!("  wire {net};"));
        }
        for number in 0..self.unread {
            line(text, format_args!("  wire unread_{number};"));
        }
        for (name, port) in entries(&self.module["ports"]) {
            for (index, bit) in bits(&port["bits"]).iter().enumerate() {
                let (port_bit, net) = (format!("{}[{index}]", escaped(name)), self.net(bit));
                match port["direction"] == "input" {
                    true => line(text, format_args!("  assign {net} = {port_bit};")),
                    false => line(text, format_args!("  assign {port_bit} = {net};")),
                }
            }
        }
        text.push_str(&cells);
        line(text, format_args!("endmodule\n"));
        Ok(types)
    }

    fn cell(&mut self, name: &str, kind: &str, cell: &Value, text: &mut String) {
        let parameters: Vec<String> = entries(&cell["parameters"])
            .map(|(name, value)| format!(".{}({})", escaped(name), parameter(value)))
            .collect();
        let mut ports = vec![];
        for (port, connected) in entries(&cell["connections"]) {
            let output = cell["port_directions"][port] == "output";
            let nets: Vec<String> = bits(connected)
                .iter()
                .rev()
                .map(|bit| match output && bit.is_string() {
                    true => {
                        self.unread += 1;
                        format!("unread_{}", self.unread - 1)
                    }
                    false => self.net(bit),
                })
                .collect();
            ports.push(format!(".{}({{{}}})", escaped(port), nets.join(", ")));
        }
        let parameters = match parameters.is_empty() {
            true => String::new(),
            false => format!(" #({})", parameters.join(", ")),
        };
        line(text, format_args!("  {}{parameters} {} ({});", escaped(kind), escaped(name), ports.join(", ")));
    }

    fn net(&self, bit: &Value) -> String {
        match bit {
            Value::String(constant) => format!("1'b{constant}"),
            number => number.as_u64().and_then(|bit| self.nets.get(&bit)).cloned().unwrap_or_default(),
        }
    }
}

/// A name for every bit that a port, a name or a cell has.
fn nets(module: &Value) -> BTreeMap<u64, String> {
    let mut named: BTreeMap<u64, String> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let empty = Map::new();
    let all = module["netnames"].as_object().unwrap_or(&empty);
    for (name, net) in all.iter().filter(|(_, net)| net["hide_name"] != 1) {
        for (index, bit) in bits(&net["bits"]).iter().enumerate() {
            let Some(bit) = bit.as_u64() else { continue };
            let text = escaped_always(&format!("{name}[{index}]"));
            if !named.contains_key(&bit) && taken.insert(text.clone()) {
                named.insert(bit, text);
            }
        }
    }
    let cells = entries(&module["cells"]).flat_map(|(_, cell)| entries(&cell["connections"]));
    let ports = entries(&module["ports"]).map(|(name, port)| (name, &port["bits"]));
    for (_, connected) in cells.chain(ports) {
        for bit in bits(connected).iter().filter_map(Value::as_u64) {
            named.entry(bit).or_insert_with(|| escaped_always(&format!("${bit}")));
        }
    }
    named
}

/// A name that Verilog takes as it is, or one with everything in it.
fn escaped(name: &str) -> String {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    match name.chars().all(word) && !name.starts_with(|c: char| c.is_ascii_digit()) {
        true => name.into(),
        false => escaped_always(name),
    }
}

/// The blank ends the name.
fn escaped_always(name: &str) -> String {
    format!("\\{name} ")
}

/// Yosys writes numbers as bits, and puts a blank behind a text that could be taken for them.
fn parameter(value: &Value) -> String {
    let digits = |text: &str| !text.is_empty() && text.chars().all(|c| "01xz".contains(c));
    match value {
        Value::String(text) if digits(text) => format!("{}'b{text}", text.len()),
        Value::String(text) if digits(text.trim_end()) => format!("\"{}\"", &text[..text.len() - 1]),
        Value::String(text) => format!("\"{text}\""),
        number => number.to_string(),
    }
}

/// Writing into a string does not fail.
fn line(text: &mut String, what: std::fmt::Arguments) {
    let _ = writeln!(text, "{what}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn netlist(kind: &str) -> Netlist {
        Netlist(json!({ "modules": {
            "top": {
                "ports": {
                    "a": { "direction": "input", "bits": [2, 3] },
                    "y": { "direction": "output", "bits": [4, "0"] },
                },
                "cells": { "unit.y_LUT4_Z": {
                    "type": kind,
                    "parameters": { "INIT": "0110", "CEMUX": "1 ", "MODE": "INV", "SIZE": 3 },
                    "port_directions": { "A": "input", "Z": "output", "COUT": "output" },
                    "connections": { "A": [3, 2, "1"], "Z": [4], "COUT": ["x"] },
                } },
                "netnames": {
                    "a": { "hide_name": 0, "bits": [2, 3] },
                    "$1": { "hide_name": 1, "bits": [4] },
                },
            },
            "LUT4": { "attributes": { "blackbox": "1" } },
        } }))
    }

    #[test]
    fn a_cell_keeps_its_name_its_parameters_and_its_nets() {
        let structure = print(&netlist("LUT4"), "top").unwrap();
        for part in [
            "module top (a, y);",
            "  input [1:0] a;",
            "  output [1:0] y;",
            "  wire \\a[0] ;",
            "  wire \\$4 ;",
            "  assign \\a[1]  = a[1];",
            "  assign y[0] = \\$4 ;",
            "  assign y[1] = 1'b0;",
            "LUT4 #(.INIT(4'b0110), .CEMUX(\"1\"), .MODE(\"INV\"), .SIZE(3)) \\unit.y_LUT4_Z ",
            "(.A({1'b1, \\a[0] , \\a[1] }), .Z({\\$4 }), .COUT({unread_0}));",
        ] {
            assert!(structure.text.contains(part), "{part} is missing in\n{}", structure.text);
        }
        assert_eq!(structure.types, BTreeSet::from(["LUT4".to_string()]));
    }

    #[test]
    fn what_has_no_place_on_the_device_is_refused() {
        assert!(print(&netlist("$add"), "top").unwrap_err().what.contains("left as $add"));
        assert!(print(&netlist("LUT4"), "other").unwrap_err().what.contains("no module 'other'"));
    }
}
