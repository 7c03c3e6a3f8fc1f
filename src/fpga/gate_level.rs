//! A core as the netlist that is placed, to be simulated like the core itself.
//!
//! ```text
//!   core ─► Verilog ─► Yosys ─► netlist ─► the steps before placement ─► Verilog of cells ─┐
//!                                                     models of the cells, from Yosys ─────┴► simulator
//! ```
//!
//! The core is on top here, without the harness that `synth` puts around it; script and steps are the same.

use super::cache::Cache;
use super::device::{Device, Family};
use super::netlist::{Census, Netlist, census};
use super::synthesis::{self, Design};
use super::tidy::Tidied;
use super::tools::{self, Tool};
use super::{cell_models, structural};
use crate::cosim::Settings;
use crate::error::Result;
use crate::hdl::verilog::SourceFile;

/// A synthesised core.
#[derive(Clone, Debug)]
pub struct GateLevel {
    pub family: Family,
    /// After all steps before placement.
    pub netlist: Netlist,
    pub tidied: Tidied,
    top: String,
    yosys: Tool,
}

impl GateLevel {
    /// Synthesises the core of that name for the cells of a device.
    ///
    /// # Errors
    /// `ToolMissing` with the line that mends it; `ToolFailed` with what Yosys said last.
    pub fn of(top: &str, sources: &[SourceFile], device: &Device, settings: &Settings) -> Result<GateLevel> {
        let yosys = tools::find_yosys(device, settings)?;
        let cache = Cache::open(settings, true);
        let design = Design { sources, top, pads: false };
        let synthesised = synthesis::synthesise(&design, device, &yosys, settings, &cache, &|_| ())?;
        let (netlist, tidied) = (synthesised.netlist, synthesised.tidied);
        Ok(GateLevel { family: device.family, netlist, tidied, top: top.into(), yosys })
    }

    /// How many cells it has of each type.
    pub fn cells(&self) -> Census {
        census(self.netlist.cells(&self.top).iter().map(|(_, kind)| *kind))
    }

    /// What synthesised it, in one line.
    pub fn yosys(&self) -> String {
        self.yosys.short()
    }

    /// The netlist as Verilog, with the models of its cells.
    ///
    /// # Errors
    /// `ToolFailed` for a cell that Yosys has no model of.
    pub fn verilog(&self) -> Result<Vec<SourceFile>> {
        let structure = structural::print(&self.netlist, &self.top)?;
        let models = cell_models::models(self.family, &self.yosys, &structure.types)?;
        Ok(vec![
            SourceFile { name: "cells.v".into(), text: models },
            SourceFile { name: format!("{}_netlist.v", self.top), text: structure.text },
        ])
    }
}
