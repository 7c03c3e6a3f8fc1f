//! The manifest: one JSON object for programs that use the core.

use std::collections::BTreeMap;
use std::rc::Rc;

use serde::Serialize;
use serde_json::Value;

use crate::fpga::estimate::Estimate;
use crate::hdl::ports::Port;
use crate::hdl::{Cell, Counts, Module};

/// `manifest.json`, in the order in which it is written.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// `subdiv-rtl/manifest/1`
    pub schema: &'static str,
    pub core: &'static str,
    pub top: String,
    pub generator: String,
    /// The command that writes exactly these files.
    pub command: String,
    pub parameters: Value,
    pub ports: Vec<Port>,
    /// How the streams are to be read, in words.
    pub streams: Value,
    /// In clocks.
    pub latency: Value,
    pub initiation_interval: Value,
    pub counts: Counts,
    /// On one device of every family that cores were measured on.
    pub estimates: Vec<Estimate>,
    pub proofs: Value,
    /// Every register of every module: its format, its range, and the source line that describes it.
    pub names: BTreeMap<String, BTreeMap<String, Name>>,
    /// BLAKE3 of each file.
    pub hashes: BTreeMap<String, String>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Name {
    pub format: String,
    pub source: String,
}

/// The registers of every module.
pub fn names(top: &Rc<Module>) -> BTreeMap<String, BTreeMap<String, Name>> {
    let mut modules = BTreeMap::new();
    for module in top.hierarchy() {
        let mut registers = BTreeMap::new();
        for node in &module.nodes {
            if let (Cell::Register { .. } | Cell::MemoryRead { .. }, Some(name)) = (&node.cell, &node.name) {
                let source = format!("{}:{}", node.place.file(), node.place.line());
                registers.insert(name.clone(), Name { format: node.word.to_string(), source });
            }
        }
        modules.insert(module.name.clone(), registers);
    }
    modules
}
