//! `doctor`: which external tools are here, and how to install those that are not.

use super::output::{self, Format, FormatArg};
use crate::cosim::{Settings, ToolStatus, tools};
use crate::error::Result;
use crate::fpga;
use crate::report::table::{Align, Cell, Table, Tone};
use serde_json::json;

/// Show which external tools are installed, and how to install the others
///
/// No tool is needed for the built-in simulator.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub format: FormatArg,
}

/// # Errors
/// Standard output that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let mut tools = tools(&Settings::default());
    tools.extend(fpga::status(&Settings::default()));
    match args.format.format {
        Format::Text => output::print(&text(&tools)),
        Format::Json => {
            let tools: Vec<_> = tools.iter().map(object).collect();
            output::print_object(
                "doctor",
                1,
                &json!({ "version": env!("CARGO_PKG_VERSION"), "tools": tools }),
            )
        }
    }
}

fn text(tools: &[ToolStatus]) -> String {
    let mut table = Table::new(&[
        ("tool", Align::Left),
        ("found", Align::Left),
        ("needed", Align::Left),
        ("what for", Align::Left),
        ("to install", Align::Left),
    ]);
    for tool in tools {
        let found = tool.found.as_ref().map_or("missing".into(), ToString::to_string);
        let tone = match (tool.usable(), tool.required) {
            (true, _) => Tone::Good,
            (false, true) => Tone::Bad,
            (false, false) => Tone::Faint,
        };
        let needed = tool.minimum.as_ref().map_or("any".into(), |v| format!("{v} or newer"));
        let install = match (tool.usable(), &tool.install) {
            (true, _) => String::new(),
            (false, Some(line)) => line.clone(),
            (false, None) => "with the package manager of this system".into(),
        };
        table.row([
            Cell::from(tool.name),
            Cell::new(found, tone),
            Cell::from(needed),
            Cell::from(tool.purpose),
            Cell::from(install),
        ]);
    }
    format!("{table}\nThe built-in simulator needs none of them.\n")
}

fn object(tool: &ToolStatus) -> serde_json::Value {
    json!({
        "name": tool.name,
        "purpose": tool.purpose,
        "found": tool.found.as_ref().map(ToString::to_string),
        "minimum": tool.minimum.as_ref().map(ToString::to_string),
        "usable": tool.usable(),
        "required": tool.required,
        "install": tool.install,
    })
}
