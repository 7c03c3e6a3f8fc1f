//! Prints a design as Verilog-2005, one module a file.
//!
//! Every operand is brought to the width of its operation explicitly, so no rule of Verilog about widths
//! or signs ever decides anything: what is printed is what the cells say.

mod nets;
mod sections;
mod text;

use std::rc::Rc;

use askama::Template;

use super::module::Module;
use super::names::Allocator;
use crate::error::{Error, Kind, Result};

/// One emitted file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    pub name: String,
    pub text: String,
}

/// A part of the module under a banner.
struct Section {
    banner: String,
    lines: Vec<String>,
}

#[derive(Template)]
#[template(path = "module.v")]
struct ModuleText<'a> {
    name: &'a str,
    purpose: &'a [String],
    version: &'a str,
    command: &'a str,
    parameters: &'a [(String, String)],
    separate: bool,
    ports: Vec<String>,
    sections: Vec<Section>,
}

/// The files of a design, the inner modules first. `command` is the command that generates them.
pub fn print(top: &Rc<Module>, command: &str) -> Result<Vec<SourceFile>> {
    let modules = top.hierarchy();
    let mut scope = Allocator::default();
    // The top keeps its name; inner modules that share one get numbers.
    let top_name = scope.allocate(&top.name);
    let names: Vec<String> = modules
        .iter()
        .map(|m| if Rc::ptr_eq(m, top) { top_name.clone() } else { scope.allocate(&m.name) })
        .collect();
    let name_of = |module: &Rc<Module>| -> String {
        // Every instance's module is in the hierarchy, so the position is always found.
        let index = modules.iter().position(|m| Rc::ptr_eq(m, module));
        index.map(|i| names[i].clone()).unwrap_or_else(|| module.name.clone())
    };
    modules.iter().zip(&names).map(|(module, name)| print_module(module, name, command, &name_of)).collect()
}

fn print_module(
    module: &Rc<Module>,
    name: &str,
    command: &str,
    name_of: &dyn Fn(&Rc<Module>) -> String,
) -> Result<SourceFile> {
    let nets = nets::Nets::new(module);
    let page = ModuleText {
        name,
        purpose: &module.purpose,
        version: env!("CARGO_PKG_VERSION"),
        command,
        parameters: &module.parameters,
        separate: module.separate,
        ports: sections::ports(module),
        sections: sections::sections(module, &nets, name_of),
    };
    // The last line ends, as every line of a text file does; templates drop that.
    let text = page
        .render()
        .map(|text| format!("{}\n", text.trim_end()))
        .map_err(|e| Error::new(Kind::ToolFailed, format!("the template module.v cannot be printed: {e}")))?;
    Ok(SourceFile { name: format!("{name}.v"), text })
}
