//! Which formats are worth a look for a target: the search that saves the sweep.
//!
//! ```text
//!   one number of bits    the bound falls with every bit: the fewest that meet the target, and one bit less
//!   the table             likewise, with the format beside it
//!   progressive           the cheapest of all, by the registers that count: those of the engine alone, or with
//!                         those that wait for the next patch
//! ```
//!
//! The search decides by the proven bound alone; what it finds is then evaluated like any other point.

use super::axes::{Axes, check};
use super::evaluate::Evaluator;
use super::meshes::Subject;
use super::point::{Design, Point, Precision, Scheme};
use crate::cores::loop_fd::RegisterForm;
use crate::error::Result;
use crate::fixed::{Format, Rounding};
use crate::mesh;
use crate::surface::precision::search::REGISTERS_20;
use crate::surface::precision::{Dyadic, cheapest_progressive};

/// The most fraction or guard bits that are tried.
const MOST_BITS: u32 = 48;

/// Registers of a coordinate by order: of the engine, and with the twelve that wait for the next patch.
const WEIGHTS: [[u32; 5]; 2] = [REGISTERS_20, [4, 6, 8, 10, 4]];

/// The fewest table bits that any core has.
const LEAST_TABLE: u32 = 8;

/// Points around the cheapest formats that meet the target, for every combination of the other axes. The exact format
/// is always among them, and for each kind of format the one with a bit less, to show what that loses.
///
/// # Errors
/// Those of [`Axes::sweep`].
pub fn points(
    evaluator: &Evaluator,
    axes: &Axes,
    subjects: &[Subject],
    target_lsb: f64,
) -> Result<Vec<Point>> {
    let mut found = vec![];
    for scheme in [Scheme::Loop, Scheme::CatmullClark] {
        let own = |subject: &&Subject| axes.scheme.unwrap_or_else(|| subject.scheme()) == scheme;
        let group: Vec<&Subject> = subjects.iter().filter(own).collect();
        if group.is_empty() {
            continue;
        }
        for coordinates in formats(axes, &group)? {
            for base in bases(axes, scheme, coordinates) {
                let search = Search { evaluator, group: &group, target_lsb };
                let designs = search.designs(base)?;
                let points = designs.iter().flat_map(|&design| {
                    group.iter().map(move |subject| Point { design, mesh: subject.name.clone() })
                });
                found.extend(points);
            }
        }
    }
    found.sort_by_cached_key(Point::order);
    found.dedup();
    Ok(found)
}

/// The formats that the sweep names, else the widest one that all meshes fit.
fn formats(axes: &Axes, group: &[&Subject]) -> Result<Vec<Format>> {
    if !axes.coordinates.is_empty() {
        return Ok(axes.coordinates.clone());
    }
    let widest = group.iter().map(|subject| mesh::widest_format(&subject.mesh, 24));
    let widest = widest.collect::<Result<Vec<Format>>>()?;
    Ok(widest.into_iter().max_by_key(|format| format.integer).into_iter().collect())
}

/// Every design but for its precision.
fn bases(axes: &Axes, scheme: Scheme, coordinates: Format) -> Vec<Design> {
    let usual = Design::usual_table(scheme, coordinates);
    let tables = axes.tables.as_ref().map_or(vec![usual], |tables| tables.values().to_vec());
    let mut designs = vec![];
    for &level in axes.levels.values() {
        for &table in &tables {
            for (&rounding, &registers) in
                axes.roundings.iter().flat_map(|r| axes.registers.iter().map(move |f| (r, f)))
            {
                let precision = Precision::Exact;
                designs.push(Design { scheme, coordinates, level, precision, table, rounding, registers });
            }
        }
    }
    if scheme == Scheme::CatmullClark {
        designs.dedup_by_key(|design| design.to_string());
    }
    designs
}

struct Search<'a> {
    evaluator: &'a Evaluator,
    group: &'a [&'a Subject],
    target_lsb: f64,
}

impl Search<'_> {
    /// The largest bound over the meshes; nothing for a design that no core has.
    fn bound(&self, design: Design) -> Result<Option<f64>> {
        if check(&design).is_err() {
            return Ok(None);
        }
        let mut largest = 0.0f64;
        for subject in self.group {
            let point = Point { design, mesh: subject.name.clone() };
            largest = largest.max(self.evaluator.bound(&point)?);
        }
        Ok(Some(largest))
    }

    fn meets(&self, design: Design) -> Result<bool> {
        Ok(self.bound(design)?.is_some_and(|bound| bound <= self.target_lsb))
    }

    /// The fewest bits with which a design meets the target.
    fn fewest(&self, from: u32, to: u32, with: impl Fn(u32) -> Design) -> Result<Option<u32>> {
        for bits in from..=to {
            if self.meets(with(bits))? {
                return Ok(Some(bits));
            }
        }
        Ok(None)
    }

    /// The cheapest progressive formats that leave room for what the mesh itself adds.
    fn progressive(&self, base: Design) -> Result<Vec<Design>> {
        let Some(exact) = self.bound(Design { rounding: Rounding::HalfUp, ..base })? else {
            return Ok(vec![]);
        };
        // 2^-40 units are finer than any format that matters. On a regular mesh the room is exact; else one unit less
        // makes up for the roundings of the sum.
        let irregular = f64::from(exact > 0.5);
        let room = ((self.target_lsb - exact) * 40f64.exp2()).floor() - irregular;
        if room < 1.0 {
            return Ok(vec![]);
        }
        let room = Dyadic::new(room as u128, 40);
        let formats = WEIGHTS
            .iter()
            .filter_map(|&weights| cheapest_progressive(base.level, room, base.rounding, weights));
        let designs = formats.map(|f| Design { precision: Precision::Progressive(f.all()), ..base });
        Ok(designs.filter(|design| design.registers != RegisterForm::Relative19).collect())
    }

    fn designs(&self, base: Design) -> Result<Vec<Design>> {
        let mut designs = vec![base];
        let kinds: &[fn(u32) -> Precision] = match base.scheme {
            Scheme::Loop => &[Precision::Uniform],
            Scheme::CatmullClark => &[Precision::Guard],
        };
        for kind in kinds {
            let with = |bits| Design { precision: kind(bits), ..base };
            let Some(fewest) = self.fewest(0, MOST_BITS, with)? else { continue };
            // One bit less, to show what it loses; two bits more, where a narrower table may pay for them.
            let around = fewest.saturating_sub(1)..=fewest + 2;
            designs.extend(around.clone().map(with));
            if base.scheme == Scheme::CatmullClark {
                for bits in around.filter(|&bits| bits >= fewest) {
                    let narrow = |table| Design { table, ..with(bits) };
                    let table = self.fewest(LEAST_TABLE, base.table, narrow)?;
                    designs.extend(table.map(narrow));
                }
            }
        }
        if base.scheme == Scheme::Loop {
            designs.extend(self.progressive(base)?);
        }
        designs.retain(|design| check(design).is_ok());
        Ok(designs)
    }
}
