//! Real figures of a core, on an ECP5-85F: clock and cells from nextpnr where it is found, else cells from Yosys.
//!
//! ```text
//!   Verilog ─► fpga: Yosys, nextpnr with one seed ─► LUTs, flip-flops, clock
//!       └────► without nextpnr: synth_ecp5, stat -json ─► LUT4, CCU2C, TRELLIS_FF, ... and no clock
//! ```

use std::collections::BTreeMap;
use std::process::Command;
use std::rc::Rc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::cosim::Settings;
use crate::error::{Error, Kind, Result};
use crate::fpga;
use crate::hdl::Module;
use crate::hdl::verilog::{self, SourceFile};

/// Where cores are placed.
const DEVICE: &str = "ecp5-85k";
/// The clock that nextpnr is asked for, in MHz.
const TARGET_MHZ: f64 = 400.0;

/// What the tools found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Synthesis {
    /// Four-input LUTs, those of carries (two a cell) and of distributed memory (four a cell) included.
    pub luts: u64,
    pub flip_flops: u64,
    /// All cells by their type.
    pub cells: BTreeMap<String, u64>,
    /// Of the placed and routed core; nothing where it was not placed, as in the records of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_mhz: Option<f64>,
    /// Where the clock was measured, or why it was not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub clock: String,
}

/// Refuses to begin where Yosys is not there.
///
/// # Errors
/// `ToolMissing`, with the line that installs it.
pub fn check() -> Result<()> {
    if placer().is_ok() {
        return Ok(());
    }
    match Command::new("yosys").arg("-V").output() {
        Ok(output) if output.status.success() => Ok(()),
        _ => Err(Error::new(Kind::ToolMissing, "yosys is not installed")
            .help("make fpga-tools, or apt-get install yosys, or leave out --synth")),
    }
}

fn placer() -> Result<fpga::Tools> {
    fpga::find(fpga::Device::named(DEVICE)?, &Settings::default())
}

/// Places one core where nextpnr is found, else counts its cells.
///
/// # Errors
/// `ToolMissing`; `ToolFailed` with what the tool said last.
pub fn measure(core: &Rc<Module>, command: &str) -> Result<Synthesis> {
    if let Err(missing) = placer() {
        let found = yosys(&core.name, &verilog::print(core, command)?)?;
        return Ok(Synthesis { clock: format!("not measured: {}", missing.what), ..found });
    }
    let throughput = fpga::Throughput { what: "vertices".into(), per_clock: 1.0 };
    let subject =
        fpga::Subject { name: core.name.clone(), command: command.into(), module: core.clone(), throughput };
    let options = fpga::Options {
        device: fpga::Device::named(DEVICE)?,
        seeds: 1,
        target_mhz: TARGET_MHZ,
        cached: true,
        settings: Settings { timeout: std::time::Duration::from_secs(7200), ..Settings::default() },
    };
    let report = fpga::measure(&subject, &options, &|_, _| ())?;
    Ok(Synthesis {
        luts: report.area.luts,
        flip_flops: report.area.flip_flops,
        cells: report.cells,
        clock_mhz: Some(report.clock.median),
        clock: format!("placed and routed on {DEVICE}, seed 1"),
    })
}

/// Counts the cells of one core.
fn yosys(top: &str, sources: &[SourceFile]) -> Result<Synthesis> {
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
    Some(Synthesis { luts, flip_flops: of("TRELLIS_FF"), cells, ..Synthesis::default() })
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
    #[test]
    fn records_of_older_versions_are_read() {
        let old: Synthesis =
            serde_json::from_str(r#"{"luts": 7, "flip_flops": 5, "cells": {"LUT4": 7}}"#).unwrap();
        assert_eq!((old.luts, old.clock_mhz, old.clock.as_str()), (7, None, ""));
    }
}
