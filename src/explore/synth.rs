//! Real cell counts of a core, by Yosys for the ECP5.
//!
//! ```text
//!   Verilog ─► temporary folder ─► yosys: synth_ecp5, stat -json ─► LUT4, CCU2C, TRELLIS_FF, ...
//! ```
//!
//! Yosys knows no timing: the clock of a placed core needs nextpnr and is not measured here.

use std::collections::BTreeMap;
use std::process::Command;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{Error, Kind, Result};
use crate::hdl::verilog::SourceFile;

/// Cells after synthesis.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Synthesis {
    /// Four-input LUTs, those of carries (two a cell) and of distributed memory (four a cell) included.
    pub luts: u64,
    pub flip_flops: u64,
    /// All cells by their type.
    pub cells: BTreeMap<String, u64>,
}

/// Refuses to begin where Yosys is not there.
///
/// # Errors
/// `ToolMissing`, with the line that installs it.
pub fn check() -> Result<()> {
    match Command::new("yosys").arg("-V").output() {
        Ok(output) if output.status.success() => Ok(()),
        _ => Err(Error::new(Kind::ToolMissing, "yosys is not installed")
            .help("apt-get install yosys, or leave out --synth")),
    }
}

/// Synthesises one core.
///
/// # Errors
/// `ToolMissing`; `ToolFailed` with the last lines of what Yosys said.
pub fn yosys(top: &str, sources: &[SourceFile]) -> Result<Synthesis> {
    check()?;
    let failed = |what: String| Error::new(Kind::ToolFailed, what);
    let folder = tempfile::tempdir().map_err(|e| failed(format!("no temporary folder: {e}")))?;
    for source in sources {
        std::fs::write(folder.path().join(&source.name), &source.text)
            .map_err(|e| failed(format!("cannot write {}: {e}", source.name)))?;
    }
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    let script = format!(
        "read_verilog {}; synth_ecp5 -top {top}; tee -q -o cells.json stat -json -top {top}",
        names.join(" ")
    );
    let output = Command::new("yosys")
        .args(["-q", "-p", &script])
        .current_dir(folder.path())
        .output()
        .map_err(|e| failed(format!("yosys did not start: {e}")))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last: Vec<&str> = said.lines().rev().take(3).collect();
        return Err(failed(format!("yosys: {}", last.into_iter().rev().collect::<Vec<_>>().join("; "))));
    }
    let text = std::fs::read_to_string(folder.path().join("cells.json"))
        .map_err(|e| failed(format!("yosys left no cells.json: {e}")))?;
    counted(&text).ok_or_else(|| failed("cells.json has no counts of cells".into()))
}

/// Reads the report; Yosys writes a line or two before the object.
fn counted(text: &str) -> Option<Synthesis> {
    let report: Value = serde_json::from_str(&text[text.find('{')?..=text.rfind('}')?]).ok()?;
    let found = report["design"]["num_cells_by_type"].as_object()?;
    let cells: BTreeMap<String, u64> =
        found.iter().filter_map(|(name, count)| Some((name.clone(), count.as_u64()?))).collect();
    let of = |name: &str| cells.get(name).copied().unwrap_or(0);
    let luts = of("LUT4") + 2 * of("CCU2C") + 4 * of("TRELLIS_DPR16X4");
    Some(Synthesis { luts, flip_flops: of("TRELLIS_FF"), cells })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_is_found_behind_what_is_said_before_it() {
        let text = "\n{\n \"design\": { \"num_cells_by_type\": { \"LUT4\": 7, \"CCU2C\": 2, \"TRELLIS_FF\": 5 } }\n}\n";
        let found = counted(text).unwrap();
        assert_eq!((found.luts, found.flip_flops, found.cells.len()), (11, 5, 3));
        assert_eq!(counted("nothing"), None);
    }
}
