//! The proof by linear forms that the finishing stage computes its masks, for all inputs, every valence and every
//! level that it can be used at.
//!
//! The linear units run on a window of variables. What leaves must be, written from rings and tensor products and
//! not from the sums that the units share:
//!
//! ```text
//! limit      floor((2^b S + lambda_d (sum over faces (A_i + D_i + A_i+1) + 2 sum A - 5d S) + half) / 2^drop)
//! points     floor((S + half) / 2^drop)
//! vectors    the diagonals of each face;  t1, t2 of inner rows as tensor products, (-1 0 1) by (1 4 1), of ends with
//!            the weights of Halstead, Kass and DeRose for each entry of the ring
//! ```
//!
//! Products of vectors are not linear: tests compare them with the reference.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::fan::End;
use super::finish::{Kind, Parameters};
use super::view_ports::{self, names};
use super::{limit, tangents, vectors};
use crate::error::{Error, Kind as Failure, Result};
use crate::fixed::{Form, Range, Rounding};
use crate::hdl::linear::Value;
use crate::hdl::{Flat, LinearForms, Module, Simulator};

/// Variables of the largest window: three columns of 129 rows and two fans of valence 16.
const VARIABLES: usize = 448;

/// What was proved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Proof {
    /// Valences from 3 to this.
    pub max_valence: u32,
    /// Limit positions whose form was compared with their mask.
    pub limits: u64,
    /// Points of normals, and vectors between them.
    pub points: u64,
    pub vectors: u64,
    /// Claims that were met and hold.
    pub claims: u64,
}

/// An integer combination of the window's variables.
type Mask = BTreeMap<usize, i128>;

fn total<'a>(parts: impl IntoIterator<Item = (i128, &'a Mask)>) -> Mask {
    let mut sum = Mask::new();
    for (factor, part) in parts {
        for (&variable, &weight) in part {
            *sum.entry(variable).or_insert(0) += factor * weight;
        }
    }
    sum.retain(|_, weight| *weight != 0);
    sum
}

/// Runs the proof; an error is a refutation.
///
/// # Errors
/// What was found instead of a mask, or parameters that the stage refuses.
pub fn prove(p: Parameters) -> Result<Proof> {
    // A mode that is no floor of a sum is proved with the sums of half up, as the levels are.
    let rounding = if p.rounding == Rounding::Floor { Rounding::Floor } else { Rounding::HalfUp };
    let p = Parameters { rounding, ..p.check()? };
    let mut proof = Proof { max_valence: p.max_valence, ..Proof::default() };
    let limit = p.limit.map(|bits| Ok::<_, Error>((limit::build(p)?, bits))).transpose()?;
    let vectors = p.normals.map(|normals| Ok::<_, Error>((vectors::build(p)?, normals.kind))).transpose()?;
    for level in p.levels[0]..=p.levels[1] {
        for valence in 3..=p.max_valence {
            // Different valences at the two ends, so that they cannot be mixed up.
            let other = if valence == p.max_valence { 3 } else { valence + 1 };
            let window = Window::new(1 << level, [valence, other]);
            if let Some((unit, bits)) = &limit {
                let expected = window.limits(p, *bits);
                let (compared, claims) = window.compare(p, unit, p.word.range, limit::LATENCY, &expected)?;
                (proof.limits, proof.claims) = (proof.limits + compared, proof.claims + claims);
            }
            if let (Some((unit, kind)), Some(point)) = (&vectors, p.point()) {
                let (compared, claims) =
                    window.compare(p, unit, point.range, vectors::latency(p), &window.vectors(p, *kind))?;
                (proof.vectors, proof.claims) = (proof.vectors + compared, proof.claims + claims);
            }
        }
    }
    if let Some(point) = p.point() {
        let window = Window::new(p.rows() - 1, [p.max_valence; 2]);
        let unit = vectors::points(p)?;
        let drop = (p.word.fraction - point.fraction) as u32;
        let port = |name: &String| {
            Some((format!("point_{name}"), rounded(window.port(name)?, drop, Rounding::HalfUp)))
        };
        let names = names(p).into_iter().filter(|(name, _)| unit.input(name).is_some());
        let expected: Expected = names.filter_map(|(name, _)| port(&name)).collect();
        proof.points = window.compare(p, &unit, p.word.range, 0, &expected)?.0;
    }
    Ok(proof)
}

/// Outputs by name.
type Expected = BTreeMap<String, Form<VARIABLES>>;

fn form(mask: &Mask) -> Form<VARIABLES> {
    let mut form = Form::variable(0, 0);
    form.coefficients[0] = 0;
    mask.iter().for_each(|(&variable, &weight)| form.coefficients[variable] = weight as i64);
    form
}

/// The mask over 2^drop, rounded.
fn rounded(mask: &Mask, drop: u32, mode: Rounding) -> Form<VARIABLES> {
    let unit = 1i128 << drop;
    let half = if mode == Rounding::Floor { 0 } else { unit / 2 };
    Form { constant: half, divisor: unit, ..form(mask) }.canonical()
}

/// The vertices around the middle column as variables.
struct Window {
    /// The bottom row.
    last: usize,
    columns: [Vec<Mask>; 3],
    ends: [Ring; 2],
}

/// What lies around an end vertex, counterclockwise from its neighbour in the column: neighbours, and the diagonals
/// of the faces between each and the next.
struct Ring {
    neighbours: Vec<Mask>,
    diagonals: Vec<Mask>,
}

impl Window {
    fn new(last: usize, valences: [u32; 2]) -> Window {
        let mut next = 0;
        let mut variable = || {
            next += 1;
            Mask::from([(next - 1, 1)])
        };
        let columns = [0; 3].map(|_| (0..=last).map(|_| variable()).collect::<Vec<_>>());
        let ends = [0, 1].map(|end| {
            let (outer, inner) = if end == 0 { (0, 1) } else { (last, last - 1) };
            // With the strip below, counterclockwise is from the right neighbour to the left.
            let (first, second) = if end == 0 { (2, 0) } else { (0, 2) };
            let d = valences[end] as usize;
            let mut neighbours = vec![columns[1][inner].clone(), columns[first][outer].clone()];
            neighbours.extend((0..d - 3).map(|_| variable()));
            neighbours.push(columns[second][outer].clone());
            let mut diagonals = vec![columns[first][inner].clone()];
            diagonals.extend((0..d - 2).map(|_| variable()));
            diagonals.push(columns[second][inner].clone());
            Ring { neighbours, diagonals }
        });
        Window { last, columns, ends }
    }

    /// The value of an input port; nothing where the unit must not look.
    fn port(&self, name: &str) -> Option<&Mask> {
        if let Some(place) = name.strip_prefix("row_") {
            let (column, row) = place.split_once('_')?;
            return self.columns[column.parse::<usize>().ok()?].get(row.parse::<usize>().ok()?);
        }
        let (end, place) = name.split_once('_')?;
        let end = usize::from(end == End::Bottom.name());
        let ring = &self.ends[end];
        let d = ring.neighbours.len();
        let (outer, inner) = if end == 0 { (0, 1) } else { (self.last, self.last - 1) };
        // Place i of the outside, from the left to the right neighbour, as a place of the ring.
        let at = |i: usize, count: usize| if end == 0 { count - i } else { i };
        match place.rsplit_once('_').unwrap_or((place, "0")) {
            ("outer", column) => self.columns[column.parse::<usize>().ok()?].get(outer),
            ("inner", column) => self.columns[column.parse::<usize>().ok()?].get(inner),
            ("before", _) => ring.diagonals.get(at(1, d - 1)),
            ("after", _) => ring.diagonals.get(at(d - 2, d - 1)),
            ("a", i) => {
                let i = i.parse::<usize>().ok().filter(|i| i + 3 <= d)?;
                ring.neighbours.get(at(i + 1, d))
            }
            ("x", i) => {
                // x_{d-2} belongs to the next column.
                let i = i.parse::<usize>().ok().filter(|i| i + 2 < d)?;
                ring.diagonals.get(at(i, d - 1))
            }
            _ => None,
        }
    }

    /// The 3 x 3 vertices around an inner row, weighted by columns and by rows.
    fn tensor(&self, k: usize, columns: [i128; 3], rows: [i128; 3]) -> Mask {
        let pairs = (0..3).flat_map(|c| (0..3).map(move |r| (c, r)));
        total(pairs.map(|(c, r)| (columns[c] * rows[r], &self.columns[c][k + r - 1])))
    }

    fn end(&self, end: usize) -> &Mask {
        &self.columns[1][if end == 0 { 0 } else { self.last }]
    }

    fn limits(&self, p: Parameters, bits: u32) -> Expected {
        let drop = (p.word.fraction - p.output.fraction) as u32 + bits;
        let limit = |s: &Mask, spread: &Mask, denominator: i128| {
            let entry = (2 * (1i128 << bits) + denominator) / (2 * denominator);
            rounded(&total([(1i128 << bits, s), (entry, spread)]), drop, p.rounding)
        };
        let mut expected = Expected::new();
        for k in 1..self.last {
            let s = &self.columns[1][k];
            let spread = total([(1, &self.tensor(k, [1, 4, 1], [1, 4, 1])), (-36, s)]);
            expected.insert(format!("limit_{k}"), limit(s, &spread, 36));
        }
        for (end, row) in [(0, 0), (1, self.last)] {
            let (s, ring) = (self.end(end), &self.ends[end]);
            let d = ring.neighbours.len();
            let faces = (0..d).map(|i| {
                total([
                    (1, &ring.neighbours[i]),
                    (1, &ring.diagonals[i]),
                    (1, &ring.neighbours[(i + 1) % d]),
                    (2, &ring.neighbours[i]),
                    (-5, s),
                ])
            });
            let faces: Vec<Mask> = faces.collect();
            let spread = total(faces.iter().map(|face| (1, face)));
            expected.insert(format!("limit_{row}"), limit(s, &spread, (d * (d + 5)) as i128));
        }
        expected
    }

    /// The diagonals q2 - q0 and q3 - q1 of a face.
    fn diagonals(corners: [&Mask; 4]) -> [Mask; 2] {
        [0, 1].map(|i| total([(1, corners[i + 2]), (-1, corners[i])]))
    }

    fn vectors(&self, p: Parameters, kind: Kind) -> Expected {
        let mut pairs: Vec<(String, [Mask; 2])> = vec![];
        match kind {
            Kind::Faces => {
                for (side, [left, right]) in [("left", [0, 1]), ("right", [1, 2])] {
                    let [left, right] = [left, right].map(|c| &self.columns[c]);
                    let face = |k: usize| [&left[k], &left[k + 1], &right[k + 1], &right[k]];
                    let faces = (0..self.last).map(|k| (vectors::face(side, k), Self::diagonals(face(k))));
                    pairs.extend(faces);
                }
            }
            Kind::Limit => {
                let tangents =
                    |k| [([-1, 0, 1], [1, 4, 1]), ([1, 4, 1], [1, 0, -1])].map(|(c, r)| self.tensor(k, c, r));
                pairs.extend((1..self.last).map(|k| (vectors::row(k), tangents(k))));
            }
        }
        let mut expected = Expected::new();
        for (end, which) in End::BOTH.into_iter().enumerate() {
            if kind == Kind::Limit {
                for (name, tangent) in ["a", "b"].iter().zip(self.end_tangents(end)) {
                    let tangent = rounded(&tangent, tangents::WEIGHT_BITS, Rounding::HalfUp);
                    expected.insert(format!("{}_{name}", vectors::end(which)), tangent);
                }
                continue;
            }
            let (s, ring) = (self.end(end), &self.ends[end]);
            let d = ring.neighbours.len();
            for place in 1..=p.max_valence as usize - 2 {
                let name = vectors::fan(which, place as u32);
                if place + 2 > d {
                    // No face: its first vector is zero, whatever the second is.
                    pairs.push((name, [Mask::new(), Mask::new()]));
                    continue;
                }
                // The faces of the ring are counterclockwise, the places run from left to right.
                let face = if end == 0 { d - 1 - place } else { place };
                let corners =
                    [s, &ring.neighbours[face], &ring.diagonals[face], &ring.neighbours[(face + 1) % d]];
                pairs.push((name, Self::diagonals(corners)));
            }
        }
        for (name, [a, b]) in pairs {
            expected.insert(format!("{name}_a"), form(&a).canonical());
            if !a.is_empty() {
                expected.insert(format!("{name}_b"), form(&b).canonical());
            }
        }
        expected
    }

    /// The limit tangents of an end over 2^[`tangents::WEIGHT_BITS`], ring entry by ring entry.
    fn end_tangents(&self, end: usize) -> [Mask; 2] {
        let ring = &self.ends[end];
        let d = ring.neighbours.len();
        let turn = |i: usize| std::f64::consts::TAU * (i % d) as f64 / d as f64;
        let first = turn(1).cos();
        let factor = 1.0 + first + ((1.0 + first) * (9.0 + first)).sqrt();
        // An eigenvector's neighbour and diagonal weights: A_d C_i and C_i + C_i+1.
        let wave = |t: usize, i: usize| if t == 0 { turn(i).cos() } else { turn(i).sin() };
        let entries = |t: usize| (0..d).map(move |i| [factor * wave(t, i), wave(t, i) + wave(t, i + 1)]);
        let length = |t: usize| entries(t).flatten().map(f64::abs).sum::<f64>();
        let goal = if d == 4 { 12.0 } else { 12.0 - 1.0 / 256.0 };
        let scale = goal / length(0).max(length(1)) * f64::from(1u32 << tangents::WEIGHT_BITS);
        [0, 1].map(|t| {
            let rounded = |w: f64| (w * scale).round() as i128;
            let mask = total(entries(t).enumerate().flat_map(|(i, [a, x])| {
                [(rounded(a), &ring.neighbours[i]), (rounded(x), &ring.diagonals[i])]
            }));
            // The inner neighbour takes what the rounding leaves.
            let rest = mask.values().sum::<i128>();
            total([(1, &mask), (-rest, &ring.neighbours[0])])
        })
    }

    /// Runs the unit and compares; returns how many outputs and claims were checked.
    fn compare(
        &self,
        p: Parameters,
        unit: &Rc<Module>,
        variable: Range,
        clocks: u32,
        expected: &Expected,
    ) -> Result<(u64, u64)> {
        let mut simulator = Simulator::new(Flat::new(unit)?, LinearForms::<VARIABLES>::new(vec![variable]));
        let mut given: Vec<(String, Value<VARIABLES>)> = vec![("advance".into(), Value::Integer(1))];
        for (name, kind) in names(p) {
            let value = match kind {
                view_ports::Kind::Point => self.port(&name).map(|mask| Value::Form(form(mask))),
                view_ports::Kind::IsBottom => {
                    let bottom = name == format!("is_bottom_{}", self.last);
                    Some(Value::Integer(bottom.into()))
                }
                view_ports::Kind::Valence => {
                    let end = usize::from(name.starts_with(End::Bottom.name()));
                    Some(Value::Integer(self.ends[end].neighbours.len() as i128))
                }
            };
            given.extend(value.map(|value| (name, value)));
        }
        for (name, value) in given {
            if let Some(id) = simulator.flat.input(&name) {
                simulator.set(id, value);
            }
        }
        simulator.settle();
        for _ in 0..clocks {
            simulator.edge(false)?;
            simulator.settle();
        }
        for (name, expected) in expected {
            let found = simulator.flat.output(name).map(|id| *simulator.get(id));
            let same = match found {
                Some(Value::Form(form)) => form.canonical() == *expected,
                Some(Value::Integer(number)) => {
                    *expected == Form { constant: number, ..form(&Mask::new()) }.canonical()
                }
                _ => false,
            };
            if !same {
                let valences = self.ends.each_ref().map(|ring| ring.neighbours.len());
                let place = format!("{}, bottom row {}, valences {valences:?}, {name}", unit.name, self.last);
                let what = "a result is another function of the window";
                return Err(Error::new(Failure::Mismatch, what).at(place));
            }
        }
        match simulator.domain.failures.first() {
            Some(failure) => Err(Error { kind: Failure::Mismatch, ..failure.clone() }),
            None => Ok((expected.len() as u64, simulator.domain.proved.len() as u64)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::finish::Normals;
    use super::*;
    use crate::hdl::Word;

    #[test]
    fn every_valence_at_every_level_is_proved() {
        for (levels, max_valence, bits, kind, extra, rounding) in [
            ([2, 2], 4, 25, Kind::Limit, 12, Rounding::HalfUp),
            ([1, 3], 10, 37, Kind::Faces, 18, Rounding::Floor),
            ([1, 4], 7, 30, Kind::Limit, 6, Rounding::HalfEven),
            ([1, 1], 16, 52, Kind::Limit, 4, Rounding::HalfUp),
            ([7, 7], 16, 25, Kind::Limit, 4, Rounding::HalfUp),
        ] {
            let hull = Range::signed(12) * (1i128 << extra);
            let p = Parameters {
                word: Word::from(hull).fraction(8 + extra),
                output: Word::signed(12).fraction(8),
                rounding,
                levels,
                max_valence,
                limit: Some(bits),
                normals: Some(Normals { kind, point_fraction: 10, unit: None }),
            };
            let proof = prove(p).expect("the stage computes its masks");
            let rows: u64 = (levels[0]..=levels[1]).map(|level| 1 + (1 << level)).sum();
            assert_eq!(proof.limits, rows * u64::from(max_valence - 2), "{proof:?}");
            assert!(proof.claims >= proof.limits && proof.vectors > rows && proof.points > 9, "{proof:?}");
        }
    }
}
