//! The report of nextpnr: clock, use of the device, critical path.
//!
//! ```text
//!   critical_paths[i].path   clk-to-q, routing, logic, routing, ..., setup      each with delay, net, cells
//!   fmax.CLOCK.achieved      in MHz
//!   utilization.CELL.used
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::names::{bit_of, ours};
use crate::error::{Error, Kind, Result};

/// The longest path from register to register.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CriticalPath {
    /// In our names, with the bit where there is one: `control.pairs_left[3]`.
    pub from: String,
    pub to: String,
    /// In nanoseconds.
    pub logic_ns: f64,
    pub routing_ns: f64,
    /// The nets on the way, in our names, each once.
    pub through: Vec<String>,
}

/// What one run found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    pub clock_mhz: f64,
    pub critical_path: CriticalPath,
    /// Cells used, by the name that nextpnr gives their kind.
    pub used: BTreeMap<String, u64>,
}

/// Hundredths are more than the tools know, and the same on every machine.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

impl Timing {
    /// Reads a report.
    ///
    /// # Errors
    /// `ToolFailed` for what is none, or has no clock.
    pub fn parse(text: &[u8]) -> Result<Timing> {
        let refused = |what: &str| Error::new(Kind::ToolFailed, format!("the report of nextpnr has {what}"));
        let report: Value = serde_json::from_slice(text).map_err(|_| refused("no JSON"))?;
        let clocks = report["fmax"].as_object().ok_or_else(|| refused("no clock"))?;
        let achieved = clocks.values().filter_map(|clock| clock["achieved"].as_f64());
        let clock = achieved.min_by(f64::total_cmp).ok_or_else(|| refused("no clock"))?;
        let used = report["utilization"].as_object().into_iter().flatten();
        let used = used.filter_map(|(name, found)| Some((name.clone(), found["used"].as_u64()?)));
        let used: BTreeMap<String, u64> = used.filter(|(_, count)| *count > 0).collect();
        let paths = report["critical_paths"].as_array().into_iter().flatten();
        let inner = |path: &&Value| {
            let clocked = |end: &str| path[end].as_str().is_some_and(|end| end.contains("edge"));
            clocked("from") && clocked("to")
        };
        let paths = paths.filter(inner).map(critical_path);
        let longest = paths.max_by(|a, b| a.delay().total_cmp(&b.delay())).unwrap_or_default();
        Ok(Timing { clock_mhz: rounded(clock), critical_path: longest, used })
    }
}

impl CriticalPath {
    pub fn delay(&self) -> f64 {
        self.logic_ns + self.routing_ns
    }
}

fn critical_path(path: &Value) -> CriticalPath {
    let steps: Vec<&Value> = path["path"].as_array().into_iter().flatten().collect();
    let delay = |routing: bool| {
        let own = steps.iter().filter(|step| (step["type"] == "routing") == routing);
        rounded(own.filter_map(|step| step["delay"].as_f64()).sum())
    };
    let nets = steps.iter().filter_map(|step| step["net"].as_str());
    let mut through: Vec<String> = vec![];
    for net in nets.map(ours) {
        if !through.contains(&net) {
            through.push(net);
        }
    }
    let end = |step: Option<&&Value>, end: &str| {
        step.and_then(|step| step[end]["cell"].as_str()).map(ours).unwrap_or_default()
    };
    // The first net is that of the register, with its bit; a cell's name has a number that is none.
    let first = steps.iter().find_map(|step| step["net"].as_str());
    let from = end(steps.first(), "from");
    let from = match first.filter(|net| ours(net).split('[').next() == Some(&from)).and_then(bit_of) {
        Some(bit) => format!("{from}[{bit}]"),
        None => from,
    };
    let to = end(steps.last(), "to");
    CriticalPath { from, to, logic_ns: delay(false), routing_ns: delay(true), through }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPORT: &[u8] = br#"{ "critical_paths": [
        { "from": "<async>", "to": "posedge $glbnet$clock", "path": [
            { "delay": 9.0, "type": "routing", "net": "x", "from": {"cell": "a"}, "to": {"cell": "b"} } ] },
        { "from": "posedge $glbnet$clock", "to": "posedge $glbnet$clock", "path": [
            { "delay": 0.4, "type": "clk-to-q", "from": {"cell": "core.control.pairs_left_TRELLIS_FF_Q_2"},
              "to": {"cell": "core.control.pairs_left_TRELLIS_FF_Q_2"} },
            { "delay": 2.5, "type": "routing", "net": "core.control.pairs_left[3]",
              "from": {"cell": "core.control.pairs_left_TRELLIS_FF_Q_2"}, "to": {"cell": "core.step_LUT4_Z"} },
            { "delay": 0.18, "type": "logic", "from": {"cell": "core.step_LUT4_Z"}, "to": {"cell": "core.step_LUT4_Z"} },
            { "delay": 1.5, "type": "routing", "net": "core.step",
              "from": {"cell": "core.step_LUT4_Z"}, "to": {"cell": "core.engine_x.left_0_TRELLIS_FF_Q_9"} },
            { "delay": 0, "type": "setup", "from": {"cell": "core.engine_x.left_0_TRELLIS_FF_Q_9"},
              "to": {"cell": "core.engine_x.left_0_TRELLIS_FF_Q_9"} } ] } ],
      "fmax": { "$glbnet$clock": { "achieved": 218.3406, "constraint": 400 } },
      "utilization": { "TRELLIS_COMB": { "available": 83640, "used": 1200 }, "DP16KD": { "available": 208, "used": 0 } } }"#;

    #[test]
    fn the_report_is_read_and_its_names_are_ours() {
        let timing = Timing::parse(REPORT).unwrap();
        assert_eq!((timing.clock_mhz, timing.used["TRELLIS_COMB"], timing.used.len()), (218.34, 1200, 1));
        let path = timing.critical_path;
        assert_eq!((path.from.as_str(), path.to.as_str()), ("control.pairs_left[3]", "engine_x.left_0"));
        assert_eq!((path.logic_ns, path.routing_ns), (0.58, 4.0));
        assert_eq!(path.through, ["control.pairs_left[3]", "step"]);
    }

    #[test]
    fn a_report_without_a_clock_is_refused() {
        for text in [&b"{}"[..], b"no", br#"{"fmax": {}}"#] {
            assert_eq!(Timing::parse(text).unwrap_err().exit_status(), 5);
        }
    }
}
