//! Pins of RAMs made of lookup tables that always read the same.
//!
//! A zero on such a pin is a wire from a LUT that makes the zero, all over the device; a one costs nothing, as a pin
//! that is not connected reads one.
//!
//! ```text
//!   words 0, 1, 2 of 16    address 0 0 a1 a0  ─►  words 12, 13, 14    address 1 1 a1 a0
//!   written in every clock                        told so by a setting
//! ```

use serde_json::{Value, json};

use super::netlist::Netlist;

/// The RAM, its addresses, and its enable.
const RAM: &str = "TRELLIS_DPR16X4";
const ADDRESSES: [&str; 2] = ["RAD", "WAD"];
const ENABLE: &str = "WRE";

/// Moves what a RAM holds from its lowest words to its highest ones where only a part is used, and tells a RAM that is
/// written in every clock so by its setting; returns how many pins need no wire any more.
pub fn raise(module: &mut Value) -> u64 {
    let mut raised = 0;
    let cells = module["cells"].as_object_mut().into_iter().flatten();
    for (_, ram) in cells.filter(|(_, cell)| cell["type"] == RAM) {
        if is_blank(&ram["parameters"]["INITVAL"]) {
            for bit in 0..4 {
                if ADDRESSES.iter().all(|port| ram["connections"][port][bit] == "0") {
                    ADDRESSES.iter().for_each(|port| ram["connections"][port][bit] = json!("1"));
                    raised += 2;
                }
            }
        }
        if ram["connections"][ENABLE][0] == "1" && ram["parameters"]["WREMUX"] == "WRE" {
            ram["parameters"]["WREMUX"] = json!("1 ");
            raised += 1;
        }
    }
    raised
}

/// Whether all words hold the same at first.
fn is_blank(contents: &Value) -> bool {
    let bits = contents.as_str().unwrap_or("0").as_bytes();
    bits.iter().all(|bit| bit == &bits[0])
}

/// The netlist for the placer, with nothing on the pins that read one.
pub fn open_high(netlist: &Netlist) -> Netlist {
    let mut netlist = netlist.clone();
    let modules = netlist.0["modules"].as_object_mut().into_iter().flatten();
    for (_, module) in modules {
        for (_, ram) in module["cells"].as_object_mut().into_iter().flatten() {
            if ram["type"] != RAM {
                continue;
            }
            for port in ADDRESSES.iter().chain([&ENABLE]) {
                let pins = ram["connections"][*port].as_array_mut().into_iter().flatten();
                pins.filter(|pin| **pin == "1").for_each(|pin| *pin = json!("x"));
            }
        }
    }
    netlist
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(contents: &str) -> Value {
        json!({ "cells": { "ram": {
            "type": RAM,
            "parameters": { "INITVAL": contents, "WREMUX": "WRE" },
            "connections": {
                "RAD": [5, "0", 6, "0"], "WAD": [7, "0", 8, 9], "WRE": ["1"], "DI": ["1", 2, 3, 4],
            },
        } } })
    }

    #[test]
    fn what_both_addresses_never_read_is_raised() {
        let mut here = module("xxxx");
        assert_eq!(raise(&mut here), 3);
        let ram = &here["cells"]["ram"];
        assert_eq!(ram["connections"]["RAD"], json!([5, "1", 6, "0"]));
        assert_eq!(ram["connections"]["WAD"], json!([7, "1", 8, 9]));
        assert_eq!(ram["parameters"]["WREMUX"], "1 ");
        assert_eq!(raise(&mut here), 0);
        let open = open_high(&Netlist(json!({ "modules": { "m": here } })));
        let pins = &open.0["modules"]["m"]["cells"]["ram"]["connections"];
        assert_eq!(pins["RAD"], json!([5, "x", 6, "0"]));
        assert_eq!((&pins["WRE"], &pins["DI"][0]), (&json!(["x"]), &json!("1")));
    }

    #[test]
    fn contents_stay_where_they_are_read() {
        let mut here = module("0110");
        assert_eq!(raise(&mut here), 1);
        assert_eq!(here["cells"]["ram"]["connections"]["RAD"][1], "0");
    }
}
