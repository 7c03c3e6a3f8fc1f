//! The designs that nothing beats: no other one of their group is both as accurate and cheaper.
//!
//! ```text
//!   error │ ×                     × dominated
//!         │   ●  ×                ● on the front: each step to the right buys accuracy
//!         │      ●   ×
//!         └────────●────── cost
//! ```
//!
//! A design that was measured on several meshes counts with its worst figures. Designs compete where they make the
//! same mesh: same scheme and level. Formats of different coordinates have different units, so errors are compared
//! as lengths.

use std::collections::BTreeMap;
use std::fmt;

use super::point::Scheme;
use super::record::Record;
use crate::error::{Error, Result};
use crate::fixed::Format;

/// What a design costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Price {
    /// Registers of the whole core.
    #[default]
    RegisterBits,
    /// Registers of the difference engines alone.
    EngineBits,
    Luts,
}

/// A design with its worst figures over all meshes.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The result of the mesh with the largest bound.
    pub record: Record,
    /// All in units of the output's last place, over all meshes.
    pub bound_lsb: f64,
    pub error_lsb: f64,
    pub worst_case_lsb: Option<f64>,
    pub cracks: u64,
    pub largest_crack: u64,
    /// The unit of the last place.
    pub unit: f64,
    pub register_bits: u64,
    pub engine_bits: u64,
    pub luts: u64,
    pub clock_mhz: f64,
    pub meshes: usize,
    /// No other candidate of its group is as accurate and cheaper.
    pub on_front: bool,
}

impl Candidate {
    pub fn price(&self, price: Price) -> u64 {
        match price {
            Price::RegisterBits => self.register_bits,
            Price::EngineBits => self.engine_bits,
            Price::Luts => self.luts,
        }
    }

    /// Designs of one group make the same mesh.
    pub fn group(&self) -> (Scheme, u32) {
        (self.record.point.scheme, self.record.point.level)
    }

    fn length(&self) -> f64 {
        self.bound_lsb * self.unit
    }

    fn add(&mut self, other: &Record) {
        self.meshes += 1;
        self.error_lsb = self.error_lsb.max(other.error_lsb.max);
        self.worst_case_lsb = match (self.worst_case_lsb, other.error_lsb.worst_case) {
            (Some(own), Some(other)) => Some(own.max(other)),
            (own, other) => own.or(other),
        };
        self.cracks = self.cracks.max(other.cracks.count);
        self.largest_crack = self.largest_crack.max(other.cracks.largest);
        self.register_bits = self.register_bits.max(other.cost.register_bits);
        self.engine_bits = self.engine_bits.max(other.cost.engine_bits);
        self.luts = self.luts.max(luts(other));
        self.clock_mhz = self.clock_mhz.min(clock(other));
        if other.bound_lsb > self.bound_lsb {
            self.bound_lsb = other.bound_lsb;
            self.record = other.clone();
        }
    }
}

/// LUTs: those of the synthesis where there was one.
fn luts(record: &Record) -> u64 {
    record.synthesis.as_ref().map_or(record.cost.luts, |found| found.luts)
}

/// The clock: that of the placed core where there is one.
fn clock(record: &Record) -> f64 {
    record.synthesis.as_ref().and_then(|found| found.clock_mhz).unwrap_or(record.cost.clock_mhz)
}

/// All designs of a list of results, in the order of the list, with the front of each group marked.
pub fn candidates(records: &[Record], price: Price) -> Vec<Candidate> {
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut all: Vec<Candidate> = vec![];
    for record in records {
        let name = format!("{} {}", record.point.scheme, record.label());
        if let Some(&place) = places.get(&name) {
            all[place].add(record);
            continue;
        }
        places.insert(name, all.len());
        all.push(Candidate {
            bound_lsb: record.bound_lsb,
            error_lsb: record.error_lsb.max,
            worst_case_lsb: record.error_lsb.worst_case,
            cracks: record.cracks.count,
            largest_crack: record.cracks.largest,
            unit: record.point.coordinates.parse::<Format>().map_or(1.0, Format::lsb),
            register_bits: record.cost.register_bits,
            engine_bits: record.cost.engine_bits,
            luts: luts(record),
            clock_mhz: clock(record),
            meshes: 1,
            on_front: false,
            record: record.clone(),
        });
    }
    mark_fronts(&mut all, price);
    all
}

/// From the cheapest on, a design is on the front when it is more accurate than all before it. Of equals the first
/// stays.
fn mark_fronts(all: &mut [Candidate], price: Price) {
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| {
        let (first, second) = (&all[a], &all[b]);
        let costs = first.price(price).cmp(&second.price(price));
        costs.then(first.length().total_cmp(&second.length())).then(a.cmp(&b))
    });
    let mut best: BTreeMap<(Scheme, u32), f64> = BTreeMap::new();
    for index in order {
        let length = all[index].length();
        let best = best.entry(all[index].group()).or_insert(f64::INFINITY);
        all[index].on_front = length < *best;
        *best = best.min(length);
    }
}

/// The cheapest design that is proved to meet a target, in units of the output's last place.
///
/// # Errors
/// No design does: says how near the best one comes.
pub fn recommend(all: &[Candidate], target_lsb: f64, price: Price) -> Result<&Candidate> {
    let meets = all.iter().filter(|candidate| candidate.bound_lsb <= target_lsb);
    let order = |a: &&Candidate, b: &&Candidate| {
        a.price(price).cmp(&b.price(price)).then(a.bound_lsb.total_cmp(&b.bound_lsb))
    };
    meets.min_by(order).ok_or_else(|| {
        let best = all.iter().map(|candidate| candidate.bound_lsb).fold(f64::INFINITY, f64::min);
        Error::usage(format!("no design of this sweep is proved to stay within {target_lsb} units"))
            .help(format!("the best one is proved for {best:.4}: widen the sweep, or raise --target-error"))
    })
}

impl fmt::Display for Price {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Price::RegisterBits => "register bits",
            Price::EngineBits => "register bits of the engines",
            Price::Luts => "LUTs",
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::explore::cost::Cost;
    use crate::explore::point::{MeshName, Origin};
    use crate::explore::record::{ErrorLsb, Planned};
    use crate::explore::tally::Cracks;

    pub fn record(mesh: &str, precision: &str, bound: f64, register_bits: u64) -> Record {
        let mesh = MeshName { name: mesh.into(), source: Origin::Shape(mesh.into()), hash: mesh.into() };
        let point = Planned {
            key: format!("{}{precision}", mesh.name),
            mesh,
            scheme: Scheme::Loop,
            coordinates: "Q2.10".into(),
            level: 3,
            precision: precision.into(),
            table: 20,
            rounding: "half-up".into(),
            registers: Some(20),
        };
        Record {
            point,
            bound_lsb: bound,
            error_lsb: ErrorLsb { max: bound / 2.0, rms: 0.1, worst_case: None, uncertainty: 0.0 },
            cracks: Cracks::default(),
            cost: Cost { register_bits, luts: 2000 - register_bits, ..Cost::default() },
            synthesis: None,
            command: String::new(),
        }
    }

    #[test]
    fn the_front_has_what_nothing_beats() {
        let records = [
            record("a", "uniform 4", 4.0, 100),
            record("a", "uniform 5", 2.0, 200),
            record("a", "uniform 6", 2.0, 300), // beaten by the one before
            record("a", "uniform 7", 1.0, 400),
            record("a", "uniform 8", 1.0, 400), // an equal one came first
        ];
        let front = |price| -> Vec<bool> { candidates(&records, price).iter().map(|c| c.on_front).collect() };
        assert_eq!(front(Price::RegisterBits), [true, true, false, true, false]);
        // By LUTs the last ones are the cheapest and the best.
        assert_eq!(front(Price::Luts), [false, false, false, true, false]);
    }

    #[test]
    fn a_design_counts_with_its_worst_mesh() {
        let records = [record("a", "uniform 4", 4.0, 100), record("b", "uniform 4", 5.0, 90)];
        let all = candidates(&records, Price::RegisterBits);
        assert_eq!(all.len(), 1);
        assert_eq!((all[0].bound_lsb, all[0].register_bits, all[0].meshes), (5.0, 100, 2));
    }

    #[test]
    fn the_cheapest_that_is_proved_is_recommended() {
        let records = [
            record("a", "uniform 4", 4.0, 100),
            record("a", "uniform 5", 2.0, 200),
            record("a", "uniform 6", 1.0, 300),
        ];
        let all = candidates(&records, Price::RegisterBits);
        let found = recommend(&all, 2.5, Price::RegisterBits).unwrap();
        assert_eq!(found.record.point.precision, "uniform 5");
        let error = recommend(&all, 0.5, Price::RegisterBits).unwrap_err();
        assert!(error.help.unwrap().contains("1.0000"));
    }
}
