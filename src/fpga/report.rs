//! What a measurement found: clock, area, units, throughput.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::device::{Area, Device, Family};
use super::estimate::{Estimate, estimate};
use super::names::{TOP, unit};
use super::netlist::{Census, area, census, takes};
use super::synthesis::Synthesised;
use super::tidy::Tidied;
use super::timing::{CriticalPath, Timing, rounded};
use super::tools::Tools;
use super::{Options, Subject, harness};
use crate::error::Result;

/// A device is full when so much of its scarcest resource is used: beyond it routing suffers.
pub const FILLED: f64 = 0.9;

/// What a core puts out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// `triangles` or `vertices`.
    pub what: String,
    /// The most in a clock, while nothing stalls.
    pub per_clock: f64,
}

/// The clock that one seed reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedClock {
    pub seed: u32,
    pub mhz: f64,
    /// What the report of nextpnr says; less, where it counts the carries of an ECP5 wrongly.
    pub reported_mhz: f64,
    /// Why the clock is what nextpnr reports, where it should come from the delays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// The clocks of all seeds, in MHz.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    pub target: f64,
    pub min: f64,
    pub median: f64,
    pub seeds: Vec<SeedClock>,
}

/// An instance in the core, with all that is in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unit {
    pub name: String,
    pub area: Area,
    pub carry_cells: u64,
}

/// An estimate beside what was measured; errors are fractions of what was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimated {
    pub luts: u64,
    pub luts_error: f64,
    pub flip_flops: u64,
    pub flip_flops_error: f64,
    pub clock_mhz: f64,
    pub clock_error: f64,
}

impl Estimated {
    fn new(estimate: &Estimate, area: Area, mhz: f64) -> Estimated {
        let error = |made: f64, found: f64| match found > 0.0 {
            true => ((made / found - 1.0) * 1e3).round() / 1e3,
            false => 0.0,
        };
        let Estimate { luts, flip_flops, clock_mhz, .. } = *estimate;
        Estimated {
            luts,
            luts_error: error(luts as f64, area.luts as f64),
            flip_flops,
            flip_flops_error: error(flip_flops as f64, area.flip_flops as f64),
            clock_mhz,
            clock_error: error(clock_mhz, mhz),
        }
    }
}

/// Everything about one core on one device. It holds no time and nothing of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    pub core: String,
    pub command: String,
    pub device: String,
    pub part: String,
    pub yosys: String,
    pub nextpnr: String,
    pub clock: Clock,
    /// Placed, without the harness.
    pub area: Area,
    pub carry_cells: u64,
    /// What the core was expected to be; nothing for a family without calibration.
    pub estimate: Option<Estimated>,
    /// What the harness needs, and is not in the area.
    pub harness: Area,
    pub tidied: Tidied,
    /// As synthesised; the placer adds a few cells.
    pub units: Vec<Unit>,
    /// The unit `startup` left out of the area; nothing where there is none.
    pub area_without_startup: Option<Area>,
    /// Of the slowest seed.
    pub critical_path: CriticalPath,
    pub throughput: Throughput,
    /// In a second, at the median clock.
    pub per_second: f64,
    /// In a clock, for 1000 LUTs.
    pub per_clock_per_1000_luts: f64,
    /// The same, with the start-up left out.
    pub per_clock_per_1000_luts_without_startup: Option<f64>,
    /// Whole cores that the device holds, filled to [`FILLED`].
    pub cores_held: u64,
    /// The same, where one start-up serves all.
    pub engines_held: Option<u64>,
    /// Cells of the core by type, as synthesised.
    pub cells: BTreeMap<String, u64>,
}

impl Report {
    pub(super) fn new(
        subject: &Subject,
        options: &Options,
        tools: &Tools,
        design: &Synthesised,
        timings: Vec<(u32, Timing)>,
    ) -> Result<Report> {
        let Options { device, target_mhz, .. } = options;
        let family = device.family;
        let cells = design.netlist.cells(&subject.module.name);
        let core = census(cells.iter().map(|(_, kind)| *kind));
        let own = harness_area(family, &design.netlist.own_census(harness::NAME));
        let (synthesised, carry_cells) = area(family, &core);
        let slowest = timings.iter().min_by(|(_, a), (_, b)| a.clock_mhz.total_cmp(&b.clock_mhz));
        let slowest = slowest.map(|(_, timing)| timing.clone());
        // Nothing that is placed depends on the seed but where it lies.
        let used = timings.first().map(|(_, timing)| placed(family, &timing.used, synthesised.plus(own, 1)));
        let area = used.map_or(synthesised, |used| used.minus(own));
        let units = units(family, cells.iter().map(|(name, kind)| (name.as_str(), *kind)));
        let startup = units.iter().find(|unit| unit.name == "startup").map(|unit| unit.area);
        let rest = startup.map(|startup| area.minus(startup));
        let clock = clock(*target_mhz, &timings);
        let density =
            |area: Area| (subject.throughput.per_clock * 1e6 / area.luts.max(1) as f64).round() / 1e3;
        let estimate = estimate(&subject.module, device)?;
        Ok(Report {
            core: subject.name.clone(),
            command: subject.command.clone(),
            device: device.name.into(),
            part: device.part.into(),
            yosys: tools.yosys.short(),
            nextpnr: tools.placer.short(),
            area,
            carry_cells,
            estimate: estimate.map(|estimate| Estimated::new(&estimate, area, clock.median)),
            harness: own,
            tidied: design.tidied,
            area_without_startup: rest,
            critical_path: slowest.map(|timing| timing.critical_path).unwrap_or_default(),
            per_second: (subject.throughput.per_clock * clock.median * 1e6).round(),
            clock,
            per_clock_per_1000_luts: density(area),
            per_clock_per_1000_luts_without_startup: rest.map(density),
            throughput: subject.throughput.clone(),
            cores_held: device.count(area, FILLED),
            engines_held: startup.zip(rest).map(|(startup, rest)| engines(device, startup, rest)),
            units,
            cells: core,
        })
    }
}

/// Engines beside one start-up.
fn engines(device: &Device, startup: Area, rest: Area) -> u64 {
    let left = Device { holds: device.holds.minus(startup), ..*device };
    left.count(rest, FILLED)
}

fn clock(target: f64, timings: &[(u32, Timing)]) -> Clock {
    let seed = |(seed, timing): &(u32, Timing)| SeedClock {
        seed: *seed,
        mhz: timing.clock_mhz,
        reported_mhz: timing.reported_mhz,
        remark: timing.remark.clone(),
    };
    let seeds: Vec<SeedClock> = timings.iter().map(seed).collect();
    let mut sorted: Vec<f64> = seeds.iter().map(|seed| seed.mhz).collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let median = match sorted.len() {
        0 => 0.0,
        count if count % 2 == 1 => sorted[middle],
        _ => rounded((sorted[middle - 1] + sorted[middle]) / 2.0),
    };
    Clock { target, min: sorted.first().copied().unwrap_or(0.0), median, seeds }
}

/// Where a LUT and its register share a cell, a cell of the harness is a register; where a register is only reached
/// through a LUT, it has one.
fn harness_area(family: Family, census: &Census) -> Area {
    let (area, _) = area(family, census);
    match family {
        Family::Ice40 | Family::Gowin => Area { luts: area.flip_flops, ..area },
        Family::Ecp5 | Family::Nexus => area,
    }
}

/// What nextpnr placed; where it does not tell, what was synthesised.
fn placed(family: Family, used: &BTreeMap<String, u64>, synthesised: Area) -> Area {
    let of = |names: &[&str]| names.iter().filter_map(|name| used.get(*name)).sum::<u64>();
    let luts = match family {
        Family::Ecp5 => of(&["TRELLIS_COMB"]),
        Family::Ice40 => of(&["ICESTORM_LC"]),
        Family::Gowin => of(&["LUT4", "ALU"]) + 4 * of(&["RAM16SDP4"]),
        Family::Nexus => of(&["OXIDE_COMB"]),
    };
    Area { luts: if luts > 0 { luts } else { synthesised.luts }, ..synthesised }
}

/// Cells by unit, the largest first.
fn units<'a>(family: Family, cells: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Unit> {
    let mut found: BTreeMap<&str, (Area, u64)> = BTreeMap::new();
    for (name, kind) in cells {
        let (one, carry) = takes(family, kind);
        let (sum, carries) = found.entry(unit(name)).or_default();
        *sum = sum.plus(one, 1);
        *carries += carry;
    }
    let mut units: Vec<Unit> = found
        .into_iter()
        .map(|(name, (area, carry_cells))| Unit { name: name.into(), area, carry_cells })
        .collect();
    units.sort_by_key(|unit| (unit.name == TOP, std::cmp::Reverse(unit.area.luts + unit.area.flip_flops)));
    units
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_lies_in_the_middle() {
        let of = |clocks: &[f64]| {
            let path = CriticalPath::default();
            let timing = |&clock_mhz| {
                let (critical_path, used) = (path.clone(), BTreeMap::new());
                Timing { clock_mhz, reported_mhz: clock_mhz, remark: None, critical_path, used }
            };
            clock(400.0, &clocks.iter().map(timing).map(|timing| (1, timing)).collect::<Vec<_>>())
        };
        assert_eq!((of(&[310.0, 290.0, 300.0]).median, of(&[310.0, 290.0]).min), (300.0, 290.0));
        assert_eq!(of(&[310.0, 290.0]).median, 300.0);
        assert_eq!(of(&[]).median, 0.0);
    }

    #[test]
    fn units_are_told_apart_by_the_names_of_their_cells() {
        let cells = [
            ("startup.n00_TRELLIS_FF_Q", "TRELLIS_FF"),
            ("startup.n00_CCU2C_S0", "CCU2C"),
            ("waiting_TRELLIS_FF_Q", "TRELLIS_FF"),
            ("engine_x.left_LUT4_Z", "LUT4"),
        ];
        let units = units(Family::Ecp5, cells.into_iter());
        let names: Vec<_> = units.iter().map(|unit| (unit.name.as_str(), unit.area.luts)).collect();
        assert_eq!(names, [("startup", 2), ("engine_x", 1), (TOP, 0)]);
    }
}
