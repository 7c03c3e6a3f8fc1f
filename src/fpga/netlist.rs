//! The netlist between synthesis and placement: Yosys' JSON, read as far as cells and bits go.
//!
//! ```text
//!   modules ─► synth_harness ─► cells: chain_..., fold_..., core ─► the module of the core ─► cells: startup...., engine_x....
//! ```

use std::collections::BTreeMap;

use serde_json::Value;

use super::device::{Area, Family};
use crate::error::{Error, Kind, Result};

/// A netlist as Yosys wrote it; the order of modules and cells is kept.
#[derive(Clone, Debug)]
pub struct Netlist(pub Value);

/// Cells by type.
pub type Census = BTreeMap<String, u64>;

impl Netlist {
    /// # Errors
    /// `ToolFailed` for what is no netlist.
    pub fn parse(text: &[u8]) -> Result<Netlist> {
        let refused = |what: String| Error::new(Kind::ToolFailed, format!("Yosys left no netlist: {what}"));
        let value: Value = serde_json::from_slice(text).map_err(|error| refused(error.to_string()))?;
        match value["modules"].is_object() {
            true => Ok(Netlist(value)),
            false => Err(refused("there are no modules in it".into())),
        }
    }

    /// As the tools read it.
    ///
    /// # Errors
    /// None that a user can cause.
    pub fn text(&self) -> Result<String> {
        serde_json::to_string(&self.0)
            .map_err(|error| Error::new(Kind::ToolFailed, format!("the netlist cannot be written: {error}")))
    }

    /// The cells of a module and of all modules within: path and type, in order.
    pub fn cells<'a>(&'a self, module: &str) -> Vec<(String, &'a str)> {
        let mut found = vec![];
        self.gather(module, "", &mut found);
        found
    }

    fn gather<'a>(&'a self, module: &str, path: &str, found: &mut Vec<(String, &'a str)>) {
        for (name, kind) in self.own_cells(module) {
            match self.0["modules"].get(kind).filter(|inner| inner["attributes"]["blackbox"].is_null()) {
                Some(_) => self.gather(kind, &format!("{path}{name}."), found),
                None => found.push((format!("{path}{name}"), kind)),
            }
        }
    }

    /// The cells of a module, those within its instances left out. Scopes are notes of Yosys, not hardware.
    fn own_cells<'a>(&'a self, module: &str) -> impl Iterator<Item = (&'a str, &'a str)> {
        let cells = self.0["modules"][module]["cells"].as_object().into_iter().flatten();
        let cells = cells.filter_map(|(name, cell)| Some((name.as_str(), cell["type"].as_str()?)));
        cells.filter(|(_, kind)| !kind.starts_with('$'))
    }

    /// How many cells all modules have; an instance counts as one.
    pub fn size(&self) -> usize {
        let modules = self.0["modules"].as_object().into_iter().flatten();
        modules.map(|(name, _)| self.own_cells(name).count()).sum()
    }

    /// How many cells of each type a module has itself; an instance counts as one.
    pub fn own_census(&self, module: &str) -> Census {
        census(self.own_cells(module).map(|(_, kind)| kind))
    }
}

/// How many cells there are of each type.
pub fn census<'a>(kinds: impl Iterator<Item = &'a str>) -> Census {
    let mut census = Census::new();
    for kind in kinds {
        *census.entry(kind.into()).or_default() += 1;
    }
    census
}

/// What a cell takes: LUTs, flip-flops, and so on, and cells of carry.
pub fn takes(family: Family, kind: &str) -> (Area, u64) {
    let lut = |luts: u64| Area { luts, ..Area::default() };
    let register = Area { flip_flops: 1, ..Area::default() };
    let memory = Area { block_rams: 1, ..Area::default() };
    let multiplier = Area { dsps: 1, ..Area::default() };
    match (family, kind) {
        (Family::Ecp5 | Family::Nexus, "LUT4" | "INV") => (lut(1), 0),
        (Family::Ecp5, "CCU2C") | (Family::Nexus, "CCU2") => (lut(2), 1),
        (Family::Ecp5, "TRELLIS_DPR16X4") | (Family::Nexus, "DPR16X4") => (lut(4), 0),
        (Family::Ecp5, "TRELLIS_FF") => (register, 0),
        (Family::Ecp5, "DP16KD" | "PDPW16KD") => (memory, 0),
        (Family::Ecp5, "MULT18X18D") => (multiplier, 0),
        (Family::Nexus, kind) if kind.starts_with("FD1P3") => (register, 0),
        (Family::Nexus, kind) if kind.contains("16K") => (memory, 0),
        (Family::Nexus, kind) if kind.starts_with("MULT") => (multiplier, 0),
        (Family::Ice40, "SB_LUT4") => (lut(1), 0),
        (Family::Ice40, "SB_CARRY") => (Area::default(), 1),
        (Family::Ice40, kind) if kind.starts_with("SB_DFF") => (register, 0),
        (Family::Ice40, kind) if kind.starts_with("SB_RAM") => (memory, 0),
        (Family::Ice40, "SB_MAC16") => (multiplier, 0),
        (Family::Gowin, "LUT1" | "LUT2" | "LUT3" | "LUT4") => (lut(1), 0),
        (Family::Gowin, "ALU") => (lut(1), 1),
        (Family::Gowin, kind) if kind.starts_with("RAM16S") => (lut(4), 0),
        (Family::Gowin, kind) if kind.starts_with("DFF") => (register, 0),
        (Family::Gowin, "SP" | "DP" | "DPB" | "SDPB" | "pROM" | "SPX9" | "DPX9B" | "SDPX9B") => (memory, 0),
        (Family::Gowin, kind) if kind.starts_with("MULT") => (multiplier, 0),
        _ => (Area::default(), 0),
    }
}

/// What a module takes, and its cells of carry.
pub fn area(family: Family, census: &Census) -> (Area, u64) {
    census.iter().fold((Area::default(), 0), |(sum, carries), (kind, count)| {
        let (one, carry) = takes(family, kind);
        (sum.plus(one, *count), carries + carry * count)
    })
}

impl Area {
    /// With `count` more of `one`.
    pub fn plus(self, one: Area, count: u64) -> Area {
        Area {
            luts: self.luts + count * one.luts,
            flip_flops: self.flip_flops + count * one.flip_flops,
            block_rams: self.block_rams + count * one.block_rams,
            dsps: self.dsps + count * one.dsps,
        }
    }

    /// Without another one, at least nothing.
    pub fn minus(self, other: Area) -> Area {
        Area {
            luts: self.luts.saturating_sub(other.luts),
            flip_flops: self.flip_flops.saturating_sub(other.flip_flops),
            block_rams: self.block_rams.saturating_sub(other.block_rams),
            dsps: self.dsps.saturating_sub(other.dsps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_counted_by_what_they_take() {
        let text = br#"{ "modules": { "m": { "cells": {
            "a_LUT4_Z": { "type": "LUT4" }, "s_CCU2C_S0": { "type": "CCU2C" }, "r": { "type": "TRELLIS_FF" },
            "scope": { "type": "$scopeinfo" }, "w": { "type": "PFUMX" }, "q": { "type": "TRELLIS_FF" },
            "adder": { "type": "inner" }
        } }, "inner": { "cells": { "s": { "type": "TRELLIS_FF" } } } } }"#;
        let netlist = Netlist::parse(text).unwrap();
        let cells = netlist.cells("m");
        assert!(cells.contains(&("adder.s".into(), "TRELLIS_FF")));
        assert_eq!(netlist.own_census("m")["TRELLIS_FF"], 2);
        assert_eq!(netlist.size(), 7);
        let census = census(cells.iter().map(|(_, kind)| *kind));
        assert_eq!((census.len(), census["TRELLIS_FF"]), (4, 3));
        let (area, carries) = area(Family::Ecp5, &census);
        assert_eq!((area.luts, area.flip_flops, carries), (3, 3, 1));
        assert_eq!(area.minus(Area { luts: 5, ..Area::default() }).luts, 0);
    }

    #[test]
    fn what_is_no_netlist_is_refused() {
        for text in [&b"{}"[..], b"nothing"] {
            assert_eq!(Netlist::parse(text).unwrap_err().exit_status(), 5);
        }
    }
}
