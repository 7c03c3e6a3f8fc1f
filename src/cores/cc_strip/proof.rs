//! The proof by linear forms that every level of a `cc-strip` computes its masks, for all inputs and for
//! every valence.
//!
//! Each level's column unit runs on a window of variables. What leaves must be the classical rules of
//! Catmull and Clark, written from the faces around a vertex and not from the separable sums of the core:
//!
//! ```text
//! F = mean of the face      E = (F1 + F2 + A + B) / 4      V = (sum F + sum A) / d^2 + (d - 2) S / d
//! ```
//!
//! For a valence whose kappa = 1 / (4 d^2) is no binary fraction, V is the rule with the table's constant.

use std::collections::BTreeMap;

use super::level::{self, column_names};
use super::outside::End;
use super::{Parameters, Precision};
use crate::cores::cc_strip::outside::kappa64;
use crate::error::{Error, Kind, Result};
use crate::fixed::Form;
use crate::hdl::linear::Value;
use crate::hdl::{Flat, LinearForms, Simulator};

/// Variables of the largest window: three columns of 65 rows and what lies outside.
const VARIABLES: usize = 256;

/// What was proved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Proof {
    pub levels: u32,
    /// Valences from 3 to this.
    pub max_valence: u32,
    /// Vertices whose form was compared with their rule.
    pub vertices: u64,
    /// Claims that were met and hold.
    pub claims: u64,
}

/// An integer combination of the window's variables.
type Mask = BTreeMap<usize, i128>;

fn plus(sum: &mut Mask, factor: i128, other: &Mask) {
    for (&variable, &weight) in other {
        *sum.entry(variable).or_insert(0) += factor * weight;
    }
}

fn total(parts: &[(i128, &Mask)]) -> Mask {
    let mut sum = Mask::new();
    parts.iter().for_each(|(factor, part)| plus(&mut sum, *factor, part));
    sum
}

/// Runs the proof; an error is a refutation.
pub fn prove(parameters: Parameters) -> Result<Proof> {
    let mut proof =
        Proof { levels: parameters.levels, max_valence: parameters.max_valence, ..Proof::default() };
    for level in 0..parameters.levels {
        for valence in 3..=parameters.max_valence {
            // Different valences at the two ends, so that they cannot be mixed up.
            let other = if valence == parameters.max_valence { 3 } else { valence + 1 };
            let (vertices, claims) = prove_level(parameters, level, [valence, other])?;
            proof.vertices += vertices;
            proof.claims += claims;
        }
    }
    Ok(proof)
}

/// The control vertices around the middle column as variables.
struct Window {
    rows: usize,
    columns: [Vec<Mask>; 3],
    ends: [Ring; 2],
}

/// What lies around an end vertex: neighbours and diagonals over the outside from left to right.
struct Ring {
    valence: u32,
    /// a_1 .. a_{d-3}
    neighbours: Vec<Mask>,
    /// x_1 .. x_{d-2}; the first and the last belong to the neighbouring columns.
    diagonals: Vec<Mask>,
}

impl Window {
    fn new(rows: usize, valences: [u32; 2]) -> Window {
        let mut next = 0;
        let mut variable = || {
            next += 1;
            Mask::from([(next - 1, 1)])
        };
        let columns = [0; 3].map(|_| (0..rows).map(|_| variable()).collect());
        let ends = valences.map(|valence| Ring {
            valence,
            neighbours: (0..valence - 3).map(|_| variable()).collect(),
            diagonals: (0..valence - 2).map(|_| variable()).collect(),
        });
        Window { rows, columns, ends }
    }

    /// The end vertex of column c (0, 1, 2), and the row next to it.
    fn end(&self, end: usize, column: usize) -> [&Mask; 2] {
        let rows = &self.columns[column];
        if end == 0 { [&rows[0], &rows[1]] } else { [&rows[self.rows - 1], &rows[self.rows - 2]] }
    }

    /// The edge neighbours of an end of the middle column, and the diagonals between them, all around:
    /// diagonal i lies between neighbours i and i + 1.
    fn around(&self, end: usize) -> (Vec<&Mask>, Vec<&Mask>) {
        let ring = &self.ends[end];
        let ([left, inner_left], [_, inner], [right, inner_right]) =
            (self.end(end, 0), self.end(end, 1), self.end(end, 2));
        let neighbours = std::iter::once(left).chain(&ring.neighbours).chain([right, inner]).collect();
        let diagonals = ring.diagonals.iter().chain([inner_right, inner_left]).collect();
        (neighbours, diagonals)
    }

    /// The value of an input port; nothing where the unit must not look.
    fn port(&self, column: usize, name: &str) -> Option<&Mask> {
        if let Some(row) = name.strip_prefix("row_") {
            return self.columns[column].get(row.parse::<usize>().ok()?);
        }
        let (end, place) = name.split_once('_')?;
        let end = usize::from(end == End::Bottom.name());
        let ring = &self.ends[end];
        let (first, last) = (ring.diagonals.first(), ring.diagonals.last());
        match (column, place) {
            (0, "right") => first,
            (2, "left") => last,
            // With valence 3 the face columns use the neighbouring columns' vertices.
            (1, "left") => ring.neighbours.first().or(Some(self.end(end, 2)[0])),
            (1, "right") => ring.neighbours.last().or(Some(self.end(end, 0)[0])),
            (1, _) => {
                let index: usize = place[2..].parse().ok()?;
                match place.starts_with('a') {
                    true => ring.neighbours.get(index - 1),
                    // x_{d-2} belongs to the next column.
                    false => ring.diagonals.get(index - 1).filter(|_| index + 2 < ring.valence as usize),
                }
            }
            _ => None,
        }
    }
}

/// Four times the point of a face.
fn face(corners: [&Mask; 4]) -> Mask {
    total(&corners.map(|c| (1, c)))
}

/// 64 times the point of the edge a-b between two faces, given as four times their points.
fn edge(a: &Mask, b: &Mask, faces: [&Mask; 2]) -> Mask {
    total(&[(4, faces[0]), (4, faces[1]), (16, a), (16, b)])
}

/// An expected vertex: its mask over 64 * 2^more.
struct Rule {
    mask: Mask,
    more: u32,
}

fn plain(mask: Mask) -> Rule {
    Rule { mask, more: 0 }
}

/// What must leave, by the name of the port; first the face column, then the vertex column.
fn rules(window: &Window, table_bits: u32) -> [BTreeMap<String, Rule>; 2] {
    let [p, c, n] = &window.columns;
    let (mut between, mut middle) = (BTreeMap::new(), BTreeMap::new());
    let inner = |a: &[Mask], b: &[Mask], k: usize| face([&a[k], &b[k], &a[k + 1], &b[k + 1]]);
    let last = window.rows - 1;
    let outer = |end: usize| {
        let ring = &window.ends[end];
        let (from, to) = (window.end(end, 1)[0], window.end(end, 2)[0]);
        let first = ring.neighbours.last().unwrap_or(window.end(end, 0)[0]);
        face([from, to, first, &ring.diagonals[ring.diagonals.len() - 1]])
    };
    for k in 0..window.rows {
        let above = if k == 0 { outer(0) } else { inner(c, n, k - 1) };
        let below = if k == last { outer(1) } else { inner(c, n, k) };
        between.insert(format!("row_{}", 2 * k), plain(edge(&c[k], &n[k], [&above, &below])));
        if k < last {
            between.insert(format!("row_{}", 2 * k + 1), plain(total(&[(16, &inner(c, n, k))])));
            let sides = [&inner(p, c, k), &inner(c, n, k)];
            middle.insert(format!("row_{}", 2 * k + 1), plain(edge(&c[k], &c[k + 1], sides)));
        }
        if k > 0 && k < last {
            let around = [&p[k], &c[k - 1], &n[k], &c[k + 1]];
            let corners = [&p[k - 1], &n[k - 1], &p[k + 1], &n[k + 1]];
            let mask = classical(&c[k], &around, &corners);
            middle.insert(format!("row_{}", 2 * k), plain(mask));
        }
    }
    for end in 0..2 {
        let name = |place: &str| format!("{}_{place}", End::BOTH[end].name());
        let (centre, ring) = (window.end(end, 1)[0], &window.ends[end]);
        let (neighbours, diagonals) = window.around(end);
        let point = plain(total(&[(16, &outer(end))]));
        for place in ["left", "right", "a_1"] {
            between.insert(name(place), Rule { mask: point.mask.clone(), more: 0 });
        }
        // Face i lies between neighbours i and i + 1.
        let count = neighbours.len();
        let faces: Vec<Mask> = (0..count)
            .map(|i| face([centre, neighbours[i], diagonals[i], neighbours[(i + 1) % count]]))
            .collect();
        let spoke =
            |i: usize| plain(edge(centre, neighbours[i], [&faces[(i + count - 1) % count], &faces[i]]));
        let outside = ring.valence as usize - 3;
        for i in 1..=outside {
            middle.insert(name(&format!("a_{i}")), spoke(i));
            if i >= 2 {
                middle.insert(name(&format!("x_{i}")), plain(total(&[(16, &faces[i - 1])])));
            }
        }
        // Left of it the face columns see a_1, right of it a_{d-3}; with valence 3 the edges across.
        middle.insert(name("left"), spoke(1));
        middle.insert(name("right"), spoke(outside));
        let row = if end == 0 { 0 } else { 2 * last };
        let mask = replacement(centre, &neighbours, &diagonals, table_bits);
        middle.insert(format!("row_{row}"), Rule { mask, more: table_bits });
    }
    [between, middle]
}

/// 4 d^2 times the vertex rule, from the faces; for d = 4 that is over 64.
fn classical(centre: &Mask, neighbours: &[&Mask], diagonals: &[&Mask]) -> Mask {
    let d = neighbours.len() as i128;
    let mut sum = total(&[(4 * d * (d - 2), centre)]);
    for neighbour in neighbours {
        // Each neighbour belongs to two faces, each face has the centre too.
        plus(&mut sum, 4 + 2, neighbour);
        plus(&mut sum, 1, centre);
    }
    diagonals.iter().for_each(|diagonal| plus(&mut sum, 1, diagonal));
    sum
}

/// The vertex rule over 64 * 2^bits with the table's constant: 64 2^bits S + kappa (classical - 4 d^2 S).
fn replacement(centre: &Mask, neighbours: &[&Mask], diagonals: &[&Mask], bits: u32) -> Mask {
    let d = neighbours.len() as i128;
    let rule = classical(centre, neighbours, diagonals);
    let kappa = kappa64(d as u32, bits);
    total(&[(kappa, &rule), ((64i128 << bits) - kappa * 4 * d * d, centre)])
}

/// One level with given valences at its ends; returns how many vertices and claims were checked.
fn prove_level(parameters: Parameters, level: u32, valences: [u32; 2]) -> Result<(u64, u64)> {
    let unit = level::build(parameters, level)?;
    let window = Window::new(parameters.rows(level), valences);
    let groups = vec![parameters.word(level).range];
    let mut simulator = Simulator::new(Flat::new(&unit)?, LinearForms::<VARIABLES>::new(groups));
    let input = |s: &Simulator<_>, name: &str| {
        s.flat.input(name).ok_or_else(|| Error::usage(format!("the unit has no input {name}")))
    };
    let set = |s: &mut Simulator<LinearForms<VARIABLES>>, name: &str, value| -> Result<()> {
        let id = input(s, name)?;
        s.set(id, value);
        Ok(())
    };
    for (end, valence) in End::BOTH.iter().zip(valences) {
        set(&mut simulator, &format!("{}_valence", end.name()), Value::Integer(valence.into()))?;
    }
    set(&mut simulator, "face", Value::Integer(0))?;
    set(&mut simulator, "arrive", Value::Integer(1))?;
    for column in 0..3 {
        for name in column_names(parameters, level) {
            let value = window.port(column, &name).map_or(Value::Unknown, |mask| Value::Form(form(mask)));
            set(&mut simulator, &name, value)?;
        }
        simulator.settle();
        simulator.edge(false)?;
    }
    set(&mut simulator, "arrive", Value::Integer(0))?;

    let [between, middle] = rules(&window, parameters.replacement_bits());
    let mut compared = 0;
    for (face, rules) in [(1, between), (0, middle)] {
        set(&mut simulator, "face", Value::Integer(face))?;
        simulator.settle();
        for (name, rule) in rules {
            let expected = rounded(parameters, level, &rule);
            let id = simulator.flat.output(&format!("out_{name}"));
            let found = id.map(|id| *simulator.get(id));
            if !matches!(found, Some(Value::Form(form)) if form.canonical() == expected) {
                let column = if face == 1 { "face column" } else { "vertex column" };
                let place = format!("level {level}, valences {valences:?}, {column}, {name}");
                return Err(
                    Error::new(Kind::Mismatch, "a vertex is another function of the window").at(place)
                );
            }
            compared += 1;
        }
    }
    match simulator.domain.failures.first() {
        Some(failure) => Err(Error { kind: Kind::Mismatch, ..failure.clone() }),
        None => Ok((compared, simulator.domain.proved.len() as u64)),
    }
}

fn form(mask: &Mask) -> Form<VARIABLES> {
    let mut form = Form::variable(0, 0);
    form.coefficients[0] = 0;
    mask.iter().for_each(|(&variable, &weight)| form.coefficients[variable] = weight as i64);
    form
}

/// The rule as the next level receives it: over the right power of two, half up.
fn rounded(parameters: Parameters, level: u32, rule: &Rule) -> Form<VARIABLES> {
    let drop = parameters.extra_fraction(level) + 6 - parameters.extra_fraction(level + 1) + rule.more;
    let unit = 1i128 << drop;
    // An end vertex has the fraction of the table on a face column, too, where nothing is below it.
    Form { constant: unit / 2, divisor: unit, ..form(&rule.mask) }.canonical()
}

/// Whether the intermediate columns of regular vertices lose nothing.
pub fn is_exact(parameters: Parameters) -> bool {
    parameters.precision == Precision::Exact
}
