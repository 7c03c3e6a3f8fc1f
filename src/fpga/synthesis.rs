//! Synthesis: Verilog of the core and its harness to a netlist, by Yosys.
//!
//! The core is flattened into one module, which keeps its place in the harness, so that its cells are counted apart.

use super::cache::Cache;
use super::device::{Device, Family};
use super::netlist::Netlist;
use super::run::{Progress, Stage, run};
use super::tidy::{Tidied, tidy};
use super::tools::Tool;
use crate::cosim::{Settings, hash};
use crate::error::{Error, Kind, Result};
use crate::hdl::verilog::SourceFile;

/// What is to be synthesised.
#[derive(Clone, Copy, Debug)]
pub struct Design<'a> {
    pub sources: &'a [SourceFile],
    /// The module on top.
    pub top: &'a str,
    /// Whether its ports are pins, with the cells that some families have for them.
    pub pads: bool,
}

/// A netlist after all [`steps`], ready to be placed or simulated.
#[derive(Clone, Debug)]
pub struct Synthesised {
    pub netlist: Netlist,
    pub tidied: Tidied,
}

/// Synthesises; the same sources, device and version give the same netlist.
///
/// # Errors
/// `ToolFailed`, with the last lines of what Yosys said.
pub fn synthesise(
    Design { sources, top, pads }: &Design,
    device: &Device,
    yosys: &Tool,
    settings: &Settings,
    cache: &Cache,
    progress: Progress,
) -> Result<Synthesised> {
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    let family = device.family;
    let pads = match (*pads, family.pads()) {
        (true, command) if !command.is_empty() => format!("{command} {top}"),
        _ => String::new(),
    };
    let script = format!(
        "read_verilog {}; {}{}{} -top {top}{pads}; write_json netlist.json",
        names.join(" "),
        family.preparation(),
        device.synthesis(),
        family.without_pads()
    );
    let texts = sources.iter().map(|source| (source.name.as_str(), source.text.as_str()));
    let hash = hash([("yosys", yosys.version.as_str()), ("script", &script)].into_iter().chain(texts));
    let text = match cache.find("netlist", &hash) {
        Some(text) => text,
        None => {
            let folder = tempfile::tempdir()
                .map_err(|e| Error::new(Kind::ToolFailed, format!("no temporary folder: {e}")))?;
            for source in *sources {
                std::fs::write(folder.path().join(&source.name), &source.text).map_err(|e| {
                    Error::new(Kind::ToolFailed, format!("cannot write {}: {e}", source.name))
                })?;
            }
            let line = [yosys.program.as_str(), "-q", "-p", &script].map(String::from);
            run(&line, folder.path(), Stage::Synthesis, settings, progress)?;
            let text = std::fs::read(folder.path().join("netlist.json"))
                .map_err(|e| Error::new(Kind::ToolFailed, format!("Yosys left no netlist: {e}")))?;
            cache.keep("netlist", &hash, &text)?;
            text
        }
    };
    let mut netlist = Netlist::parse(&text)?;
    let tidied = steps(device.family, &mut netlist);
    Ok(Synthesised { netlist, tidied })
}

/// Everything between synthesis and placement.
pub fn steps(family: Family, netlist: &mut Netlist) -> Tidied {
    tidy(family, netlist)
}
