//! The report of nextpnr: clock, use of the device, critical path.
//!
//! ```text
//!   critical_paths[i].path   clk-to-q, routing, logic, routing, ..., setup      each with delay, net, cells
//!   fmax.CLOCK.achieved      in MHz
//!   utilization.CELL.used
//! ```
//!
//! Where a placement was read back, the clock and the path come from the [delays](super::static_timing) instead.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::names::{bit_of, ours};
use super::nets::names_at;
use super::static_timing::{Delays, Longest};
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
    /// What nextpnr's own report says: less, where it counts carries wrongly.
    pub reported_mhz: f64,
    /// Why the clock is that of the report, where it should come from the delays.
    pub remark: Option<String>,
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
        let clock_mhz = rounded(clock);
        Ok(Timing { clock_mhz, reported_mhz: clock_mhz, remark: None, critical_path: longest, used })
    }

    /// With the clock and the path as they are by the delays (SDF) of a placement of an ECP5 that was read back; the
    /// netlist is that placement. Where the delays as they stand do not give the clock of the report, another version of
    /// nextpnr counts in another way: the report stays as it is, with a remark.
    ///
    /// # Errors
    /// `ToolFailed` for what are no delays, or no netlist.
    pub fn with_delays(self, sdf: &str, netlist: &[u8]) -> Result<Timing> {
        let refused = |what: &str| Error::new(Kind::ToolFailed, format!("the delays of nextpnr {what}"));
        let mut delays = Delays::parse(sdf).ok_or_else(|| refused("cannot be read"))?;
        let clock = |longest: &Longest| rounded(1e6 / longest.picoseconds as f64);
        let nothing = || refused("have no path from register to register");
        let as_it_stands = clock(&delays.longest().ok_or_else(nothing)?);
        if (as_it_stands - self.reported_mhz).abs() > 0.02 {
            let reported = self.reported_mhz;
            let remark = format!(
                "the delays of nextpnr give {as_it_stands} MHz where it reports {reported} MHz; the report is taken, \
                 uncorrected"
            );
            return Ok(Timing { remark: Some(remark), ..self });
        }
        delays.count_upper_halves_as_packed();
        let longest = delays.longest().ok_or_else(nothing)?;
        let nets = names_at(netlist, &longest.outputs).map_err(|_| refused("are of another netlist"))?;
        let first = longest.outputs.first().map_or("", |(cell, _)| cell);
        let nanoseconds = |picoseconds: i64| rounded(picoseconds as f64 / 1e3);
        let critical_path = CriticalPath {
            from: begin(first, nets.first().map(String::as_str)),
            to: ours(&longest.end),
            logic_ns: nanoseconds(longest.logic),
            routing_ns: nanoseconds(longest.picoseconds - longest.logic),
            through: each_once(nets.iter().map(|net| ours(net))),
        };
        Ok(Timing { clock_mhz: clock(&longest), critical_path, ..self })
    }
}

/// What has a name of ours, each once.
fn each_once(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut once: Vec<String> = vec![];
    for name in names {
        if !name.is_empty() && !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

/// The register at the begin of a path. The first net is that of the register, with its bit; a cell's name has a number
/// that is none.
fn begin(cell: &str, first_net: Option<&str>) -> String {
    let from = ours(cell);
    match first_net.filter(|net| ours(net).split('[').next() == Some(&from)).and_then(bit_of) {
        Some(bit) => format!("{from}[{bit}]"),
        None => from,
    }
}

impl CriticalPath {
    pub fn delay(&self) -> f64 {
        self.logic_ns + self.routing_ns
    }
}

fn critical_path<'a>(path: &'a Value) -> CriticalPath {
    let steps: Vec<&'a Value> = path["path"].as_array().into_iter().flatten().collect();
    let delay = |routing: bool| {
        let own = steps.iter().filter(|step| (step["type"] == "routing") == routing);
        rounded(own.filter_map(|step| step["delay"].as_f64()).sum())
    };
    let nets = || steps.iter().filter_map(|step| step["net"].as_str());
    let cell = |step: Option<&&'a Value>, end: &str| -> &'a str {
        step.and_then(|step| step[end]["cell"].as_str()).unwrap_or_default()
    };
    CriticalPath {
        from: begin(cell(steps.first(), "from"), nets().next()),
        to: ours(cell(steps.last(), "to")),
        logic_ns: delay(false),
        routing_ns: delay(true),
        through: each_once(nets().map(ours)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::static_timing::tests::ADDER;
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

    /// What nextpnr reports of [`ADDER`], and its placement.
    fn of_the_adder(achieved: f64) -> Result<Timing> {
        let sum = |half: u32| format!("core.sum_CCU2C_S0$CCU2_COMB{half}");
        let netlist = serde_json::json!({ "modules": { "top": {
            "cells": {
                "core.a_TRELLIS_FF_Q": { "connections": { "Q": [2] } },
                sum(0): { "connections": { "A": [2], "FCI": [], "FCO": [3] } },
                sum(1): { "connections": { "FCI": [3], "FCO": [4] } },
                "core.more_CCU2C_S0$CCU2_COMB0": { "connections": { "FCI": [4], "F": [5] } },
                "b": { "connections": { "DI": [5] } },
            },
            "netnames": {
                "core.a[7]": { "bits": [2] }, "$abc$9$carry": { "bits": [3] },
                "core.sum_CCU2C_S0_1_COUT": { "bits": [4] }, "core.more[1]": { "bits": [5] },
            },
        } } });
        let report = format!(r#"{{ "fmax": {{ "clock": {{ "achieved": {achieved} }} }} }}"#);
        let report = Timing::parse(report.as_bytes())?;
        report.with_delays(ADDER, &serde_json::to_vec(&netlist).unwrap())
    }

    #[test]
    fn the_delays_give_a_higher_clock_than_the_report_and_the_path_in_our_names() {
        let timing = of_the_adder(1e6 / 1956.0).unwrap();
        assert_eq!((timing.reported_mhz, timing.clock_mhz, timing.remark), (511.25, 526.32, None));
        let path = timing.critical_path;
        assert_eq!((path.from.as_str(), path.to.as_str()), ("a[7]", "b"));
        assert_eq!((path.logic_ns, path.routing_ns), (1.08, 0.82));
        assert_eq!(path.through, ["a[7]", "sum", "more[1]"]);
    }

    #[test]
    fn where_the_delays_are_not_those_of_the_report_the_report_stays_and_says_so() {
        let timing = of_the_adder(500.0).unwrap();
        assert_eq!((timing.reported_mhz, timing.clock_mhz), (500.0, 500.0));
        let remark = timing.remark.unwrap();
        assert!(remark.contains("give 511.25 MHz") && remark.contains("reports 500 MHz"), "{remark}");
        let report = || Timing::parse(br#"{ "fmax": { "clock": { "achieved": 511.25 } } }"#).unwrap();
        for (sdf, netlist) in [("(IOPATH A", "{}"), ("", "{}"), (ADDER, "no")] {
            assert_eq!(report().with_delays(sdf, netlist.as_bytes()).unwrap_err().exit_status(), 5);
        }
    }

    #[test]
    fn a_report_without_a_clock_is_refused() {
        for text in [&b"{}"[..], b"no", br#"{"fmax": {}}"#] {
            assert_eq!(Timing::parse(text).unwrap_err().exit_status(), 5);
        }
    }
}
