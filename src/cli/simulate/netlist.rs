//! `simulate --netlist FAMILY`: in place of the Verilog its netlist, under the same vectors.

use serde_json::{Value, json};

use super::Settings;
use crate::cli::progress::Progress;
use crate::cosim::{self, Dut};
use crate::error::Result;
use crate::fpga::{Census, Device, GateLevel, Tidied};
use crate::hdl::verilog::SourceFile;
use crate::report::table::thousands;

/// What was simulated in place of the core.
pub struct Facts {
    family: String,
    yosys: String,
    cells: Census,
    tidied: Tidied,
}

/// The device with the netlist in place of its Verilog, where one is wanted.
///
/// # Errors
/// `ToolMissing` without Yosys; `ToolFailed` for what it cannot synthesise or has no models of.
pub fn of(settings: &Settings, dut: &Dut) -> Result<Option<(Dut, Facts)>> {
    let Some(family) = settings.netlist else { return Ok(None) };
    let device = Device::named(family.device())?;
    let _shown = Progress::waiting(format!("synthesising for {}", device.name));
    let tools = cosim::Settings { timeout: settings.timeout, ..cosim::Settings::default() };
    let sources: Vec<SourceFile> = dut
        .files
        .iter()
        .filter(|(name, _)| name.ends_with(".v"))
        .map(|(name, text)| SourceFile { name: name.clone(), text: text.clone() })
        .collect();
    let netlist = GateLevel::of(&dut.top, &sources, device, &tools)?;
    let facts = Facts {
        family: device.family.name().into(),
        yosys: netlist.yosys(),
        cells: netlist.cells(),
        tidied: netlist.tidied,
    };
    let files = netlist.verilog()?.into_iter().map(|file| (file.name, file.text)).collect();
    Ok(Some((Dut { files, ..dut.clone() }, facts)))
}

impl Facts {
    /// For people.
    pub fn text(&self) -> String {
        let mut kinds: Vec<(&String, &u64)> = self.cells.iter().collect();
        kinds.sort_by_key(|(name, count)| (std::cmp::Reverse(**count), name.as_str()));
        let kinds: Vec<String> =
            kinds.iter().map(|(name, count)| format!("{} {name}", thousands(**count))).collect();
        format!("{} for {}: {}", self.yosys, self.family, kinds.join(", "))
    }

    pub fn object(&self) -> Value {
        json!({
            "family": self.family,
            "yosys": self.yosys,
            "cells": self.cells,
            "tidied": self.tidied,
        })
    }
}
