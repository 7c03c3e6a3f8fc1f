//! A sweep: every combination of what may vary, without those that no core has.
//!
//! ```text
//!   meshes x coordinates x levels x formats x tables x roundings x register forms
//!       └─► valid: Point       └─► invalid: counted, the first reason kept
//! ```

use std::collections::BTreeMap;

use super::meshes::Subject;
use super::point::{Design, Point, Precision, Scheme};
use super::ranges::Numbers;
use super::{cc_strip, loop_fd};
use crate::cores::loop_fd::RegisterForm;
use crate::error::{Error, Result};
use crate::fixed::{Format, Rounding};
use crate::mesh;

/// What may vary.
#[derive(Clone, Debug)]
pub struct Axes {
    /// Nothing: by the faces of each mesh.
    pub scheme: Option<Scheme>,
    pub levels: Numbers,
    /// Empty: for each mesh the widest fraction that fits in 24 bits.
    pub coordinates: Vec<Format>,
    pub precisions: Vec<Precision>,
    /// Nothing: what the coordinates need.
    pub tables: Option<Numbers>,
    pub roundings: Vec<Rounding>,
    pub registers: Vec<RegisterForm>,
}

/// The most points of one sweep.
const MOST_POINTS: usize = 1 << 20;

/// The points of a sweep, in their order.
#[derive(Debug)]
pub struct Sweep {
    pub points: Vec<Point>,
    /// Combinations that no core has.
    pub skipped: usize,
    /// Why the first of them was skipped.
    pub reason: Option<Error>,
}

impl Axes {
    /// # Errors
    /// A mesh that its scheme is not defined on; no valid point at all, with the first reason.
    pub fn sweep(&self, subjects: &[Subject]) -> Result<Sweep> {
        let mut sweep = Sweep { points: vec![], skipped: 0, reason: None };
        let mut known = BTreeMap::new();
        for subject in subjects {
            let scheme = self.scheme.unwrap_or_else(|| subject.scheme());
            subject.check(scheme)?;
            let coordinates = match self.coordinates.as_slice() {
                [] => vec![mesh::widest_format(&subject.mesh, 24)?],
                formats => formats.to_vec(),
            };
            for coordinates in coordinates {
                let fits = mesh::quantise(&subject.mesh, coordinates).map(drop);
                for design in self.designs(scheme, coordinates) {
                    if known.len() + sweep.skipped >= MOST_POINTS {
                        return Err(Error::usage(format!("more than {MOST_POINTS} combinations"))
                            .help("let fewer things vary at a time"));
                    }
                    let point = Point { design, mesh: subject.name.clone() };
                    match fits.clone().and_then(|()| check(&point.design)) {
                        Ok(()) => drop(known.insert(point.key(), point)),
                        Err(error) => {
                            sweep.skipped += 1;
                            sweep.reason.get_or_insert(error);
                        }
                    }
                }
            }
        }
        sweep.points = known.into_values().collect();
        sweep.points.sort_by_cached_key(Point::order);
        match (&sweep.points[..], sweep.reason.take()) {
            ([], Some(reason)) => Err(reason),
            ([], None) => Err(Error::usage("nothing to explore").help("give a mesh, or --shape NAME")),
            (_, reason) => Ok(Sweep { reason, ..sweep }),
        }
    }

    fn designs(&self, scheme: Scheme, coordinates: Format) -> Vec<Design> {
        let usual = Numbers::from(Design::usual_table(scheme, coordinates));
        let tables = self.tables.as_ref().unwrap_or(&usual);
        let mut designs = vec![];
        for (&level, &precision) in pairs(self.levels.values(), &self.precisions) {
            for (&table, &rounding) in pairs(tables.values(), &self.roundings) {
                for &registers in &self.registers {
                    designs.push(Design {
                        scheme,
                        coordinates,
                        level,
                        precision,
                        table,
                        rounding,
                        registers,
                    });
                }
            }
        }
        if scheme == Scheme::CatmullClark {
            // The register form says nothing here.
            designs.dedup_by_key(|design| design.to_string());
        }
        designs
    }
}

fn pairs<'a, A, B>(first: &'a [A], second: &'a [B]) -> impl Iterator<Item = (&'a A, &'a B)> {
    first.iter().flat_map(move |a| second.iter().map(move |b| (a, b)))
}

/// Refuses a design that no core has, whatever the mesh.
///
/// # Errors
/// The reason, with the option that mends it.
pub fn check(design: &Design) -> Result<()> {
    match design.scheme {
        Scheme::Loop => loop_fd::parameters(design).map(drop),
        Scheme::CatmullClark => cc_strip::check(design),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explore::point::Origin;

    fn axes() -> Axes {
        Axes {
            scheme: None,
            levels: "3..4".parse().unwrap(),
            coordinates: vec!["Q2.14".parse().unwrap(), "Q1.8".parse().unwrap()],
            precisions: vec![Precision::Exact, Precision::Guard(2)],
            tables: None,
            roundings: vec![Rounding::HalfUp],
            registers: vec![RegisterForm::Minimal20, RegisterForm::Relative19],
        }
    }

    fn shape(name: &str) -> Subject {
        Subject::load(&Origin::Shape(name.into()), false).unwrap()
    }

    #[test]
    fn invalid_combinations_are_counted_and_nothing_comes_twice() {
        // Loop: exact in two levels and two register forms; guard bits are none of Loop's. Q1.8 does not hold it.
        let mut large = shape("octahedron");
        large.mesh.positions.iter_mut().for_each(|p| *p *= 1.5);
        let sweep = axes().sweep(&[large.clone(), large]).unwrap();
        assert_eq!((sweep.points.len(), sweep.skipped), (4, 24));
        assert!(sweep.reason.is_some());
        // Strips: exact and guarded, and no register forms.
        let sweep = axes().sweep(&[shape("cube-quads")]).unwrap();
        assert_eq!(sweep.points.len(), 8);
    }

    #[test]
    fn a_sweep_without_a_valid_point_says_why() {
        let axes = Axes { precisions: vec![Precision::Guard(3)], ..axes() };
        assert!(axes.sweep(&[shape("octahedron")]).unwrap_err().what.contains("guard bits"));
        assert_eq!(axes.sweep(&[]).unwrap_err().exit_status(), 2);
    }
}
