//! The harness around a core: few pins, no path from a pin to the core, nothing trimmed.
//!
//! ```text
//!   shift_in ─► chain of registers ─► inputs │ core │ outputs ─► registers ─► xor of 4 ─► registers ─► ... ─► data_out
//! ```
//!
//! It has no carry and shares no cell with the core, whose hierarchy is kept until it is placed; so what it
//! needs itself is counted from its own module and taken off.

use askama::Template;

use crate::error::{Error, Kind, Result};
use crate::hdl::Module;
use crate::hdl::ports::ports;
use crate::hdl::verilog::SourceFile;

/// The module of the harness.
pub const NAME: &str = "synth_harness";

#[derive(Template)]
#[template(path = "synth_harness.v")]
struct Text<'a> {
    name: &'a str,
    core: &'a str,
    inputs: u32,
    outputs: u32,
    connections: Vec<String>,
    stages: Vec<Stage>,
    lines: Vec<String>,
    last: String,
}

struct Stage {
    name: String,
    width: u32,
}

/// The harness of a core.
///
/// # Errors
/// A core without inputs or outputs, which nothing can be measured of.
pub fn harness(core: &Module) -> Result<SourceFile> {
    let (mut connections, mut inputs, mut outputs) = (vec![], 0, 0);
    for port in ports(core) {
        let name = &port.name;
        let (wire, count) = match (name.as_str(), port.direction) {
            ("aclk", _) => {
                connections.push(".aclk(clock)".into());
                continue;
            }
            ("aresetn", _) => {
                connections.push(".aresetn(reset_held)".into());
                continue;
            }
            (_, "input") => ("chain", &mut inputs),
            _ => ("outputs", &mut outputs),
        };
        connections.push(format!(".{name}({wire}[{}:{}])", *count + port.width - 1, *count));
        *count += port.width;
    }
    if inputs == 0 || outputs == 0 {
        return Err(Error::new(Kind::Usage, format!("{} has no inputs or no outputs", core.name))
            .help("only cores with ports can be placed"));
    }
    let mut stages = vec![Stage { name: "fold_0".into(), width: outputs }];
    let mut lines = vec!["fold_0 <= outputs;".to_string()];
    while let Some(Stage { name, width }) = stages.last().filter(|stage| stage.width > 1) {
        let next = Stage { name: format!("fold_{}", stages.len()), width: width.div_ceil(4) };
        for bit in 0..next.width {
            let highest = (4 * bit + 3).min(width - 1);
            lines.push(format!("{}[{bit}] <= ^{name}[{highest}:{}];", next.name, 4 * bit));
        }
        stages.push(next);
    }
    let last = stages.last().map(|stage| stage.name.clone()).unwrap_or_default();
    let page = Text { name: NAME, core: &core.name, inputs, outputs, connections, stages, lines, last };
    let text = page
        .render()
        .map_err(|e| Error::new(Kind::ToolFailed, format!("a template cannot be printed: {e}")))?;
    Ok(SourceFile { name: format!("{NAME}.v"), text: format!("{}\n", text.trim_end()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn every_bit_comes_from_a_register_and_ends_in_one() {
        let m = Builder::new("adder");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(7)));
        m.output("y", m.pipe("y", &a + &b));
        let text = harness(&m.finish().unwrap()).unwrap().text;
        for part in [
            "reg  [13:0] chain;",
            "between <= {chain[12:0], shift_in};",
            "chain <= between;",
            ".aclk(clock)",
            ".b(chain[13:7])",
            ".y(outputs[7:0])",
            "fold_0 <= outputs;",
            "fold_1[1] <= ^fold_0[7:4];",
            "fold_2[0] <= ^fold_1[1:0];",
            "assign data_out = fold_2;",
        ] {
            assert!(text.contains(part), "{part} is missing in\n{text}");
        }
    }
}
