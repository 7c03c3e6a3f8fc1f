//! One coordinate of the vectors whose cross products are the normals: diagonals of faces, limit tangents.
//!
//! ```text
//!   p_k ───── c_k ───── n_k       face:      a = q2 - q0, b = q3 - q1 of the corners q counterclockwise
//!    │  left   │  right  │
//!   p_k+1 ── c_k+1 ── n_k+1       tangents:  a along the rows  (n - p)_k-1 + 4 (n - p)_k + (n - p)_k+1
//!                                            b upwards         s_k-1 - s_k+1,  s = p + 4 c + n
//!
//!   outside of the top:  a = x_i - S, b = a_i-1 - a_i      of the bottom:  b = a_i - a_i-1
//! ```
//!
//! The vectors of a face that the valence has not are zero. The tangents of the ends are those of their valences
//! (see [`tangents`]).

use std::rc::Rc;

use super::fan::End;
use super::finish::{Kind, Parameters, stage};
use super::tangents;
use super::view::{EndView, View};
use super::view_ports::{self, names as ports};
use crate::error::Result;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// The vectors of a face of the strip, on the left or the right of the column, below row k.
pub fn face(side: &str, k: usize) -> String {
    format!("{side}_{k}")
}

/// The vectors in place i of the fan around an end: 1 .. d-2 are the faces outside, from left to right.
pub fn fan(end: End, i: u32) -> String {
    format!("{}_fan_{i}", end.name())
}

/// The limit tangents of an end.
pub fn end(end: End) -> String {
    format!("{}_tangents", end.name())
}

/// Clocks from the points to the vectors.
pub fn latency(p: Parameters) -> u32 {
    if is_limit(p) { tangents::LATENCY } else { 1 }
}

/// The limit tangents of an inner row.
pub fn row(k: usize) -> String {
    format!("row_{k}")
}

/// The name of each pair of vectors, what sort of vectors they are, and the word of their coordinates.
pub fn names(p: Parameters) -> Vec<(String, &'static str, Word)> {
    let point = p.point().unwrap_or(p.word);
    let s = point.range.max - point.range.min;
    let within = |bound: i128| Word::range(-bound, bound).fraction(point.fraction);
    let (diagonals, tangents) = (("diagonals", within(s)), ("tangents", within(6 * s)));
    let last = p.rows() - 1;
    let mut names = vec![];
    let mut add = |name: String, (sort, word): (&'static str, Word)| names.push((name, sort, word));
    if is_limit(p) {
        (1..last).for_each(|k| add(row(k), tangents));
        End::BOTH.into_iter().for_each(|which| add(end(which), tangents));
        return names;
    }
    for side in ["left", "right"] {
        (0..last).for_each(|k| add(face(side, k), diagonals));
    }
    for which in End::BOTH {
        (1..=p.max_valence - 2).for_each(|i| add(fan(which, i), diagonals));
    }
    names
}

fn is_limit(p: Parameters) -> bool {
    p.normals.is_some_and(|normals| normals.kind == Kind::Limit)
}

/// Whether vectors are made from the port: the faces take the inner rows from the columns.
fn is_used(p: Parameters, name: &str) -> bool {
    is_limit(p) || !name.contains("_inner_")
}

/// The points that the vectors are made from. Inputs: the coordinates of a view, outputs `point_..`: the same
/// rounded half up to the fraction of the points.
pub fn points(p: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("points");
    m.purpose("One coordinate of a window, rounded half up to the fraction of the points of normals.");
    let point = p.point().unwrap_or(p.word);
    let drop = (p.word.fraction - point.fraction) as u32;
    for (name, kind) in ports(p) {
        if kind == view_ports::Kind::Point && is_used(p, &name) {
            let vertex = m.input(name.clone(), p.word);
            let rounded = m.round(&vertex, drop, Rounding::HalfUp);
            let name = format!("point_{name}");
            m.output(name.clone(), m.wire(name, &rounded));
        }
    }
    m.finish()
}

/// Inputs: the points, the valences of the ends, `advance`. Outputs: `.._a` and `.._b` of [`names`], registered.
pub fn build(p: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("vectors");
    m.purpose("One coordinate of the diagonals and tangents whose cross products are the normals.");
    m.parameter("max_valence", p.max_valence);
    let point = p.point().unwrap_or(p.word);
    let signals: Vec<Signal> = ports(p)
        .into_iter()
        .map(|(name, kind)| match kind {
            view_ports::Kind::Point if is_used(p, &name) => m.input(name, point),
            view_ports::Kind::Valence => m.input(name, Word::unsigned(super::VALENCE_BITS)),
            // Never looked at.
            _ => m.bit(false),
        })
        .collect();
    let view = view_ports::of_signals(&m, p, &signals);
    let advance = m.input("advance", Word::bit());

    let mut pairs = vec![];
    if is_limit(p) {
        for (name, vectors) in inner_tangents(&m, &view) {
            // As late as those of the ends.
            let kept = ["a", "b"].iter().zip(&vectors);
            let kept: Vec<Signal> =
                kept.map(|(v, vector)| stage(&m, &advance, format!("{name}_{v}_kept"), vector)).collect();
            pairs.push((name, [kept[0].clone(), kept[1].clone()]));
        }
    } else {
        pairs.extend(strip_faces(&m, &view));
    }
    for (which, view) in End::BOTH.into_iter().zip(&view.ends) {
        match is_limit(p) {
            true => pairs.push((end(which), tangents::tangents(&m, p, which, view, &advance))),
            false => pairs.extend(fan_of(&m, p, which, view)),
        }
    }
    for (name, _, word) in names(p) {
        let Some((_, vectors)) = pairs.iter().find(|(found, _)| *found == name) else { continue };
        for (vector, value) in ["a", "b"].iter().zip(vectors) {
            let name = format!("{name}_{vector}");
            let register = m.register(name.clone(), word);
            m.on(&advance, &register, value);
            m.output(name, &register);
        }
    }
    m.finish()
}

type Pair = (String, [Signal; 2]);

fn nothing(m: &Builder, vector: &Signal) -> Signal {
    m.constant(0, Word { range: Range::point(0), ..vector.word() })
}

/// The diagonals of the faces between the columns.
fn strip_faces(m: &Builder, view: &View) -> Vec<Pair> {
    let [previous, column, next] = &view.rows;
    let sides = [("left", previous, column), ("right", column, next)];
    let below = |(side, left, right): (&str, &Vec<Signal>, &Vec<Signal>)| -> Vec<Pair> {
        let faces = left.windows(2).zip(right.windows(2)).enumerate();
        let diagonals = |l: &[Signal], r: &[Signal]| [&r[1] - &l[0], &r[0] - &l[1]];
        faces.map(|(k, (l, r))| (face(side, k), diagonals(l, r).map(|sum| m.signal(sum)))).collect()
    };
    sides.into_iter().flat_map(below).collect()
}

/// The tangents of the rows between the ends.
fn inner_tangents(m: &Builder, view: &View) -> Vec<Pair> {
    let [previous, column, next] = &view.rows;
    let across: Vec<Signal> =
        (0..column.len()).map(|k| m.wire(format!("across_{k}"), &next[k] - &previous[k])).collect();
    let along: Vec<Signal> = (0..column.len())
        .map(|k| m.wire(format!("along_{k}"), &previous[k] + 4 * &column[k] + &next[k]))
        .collect();
    let tangents =
        |k: usize| [&across[k - 1] + 4 * &across[k] + &across[k + 1], &along[k - 1] - &along[k + 1]];
    (1..column.len() - 1).map(|k| (row(k), tangents(k).map(|sum| m.signal(sum)))).collect()
}

/// The vectors around an end.
fn fan_of(m: &Builder, p: Parameters, end: End, view: &EndView) -> Vec<Pair> {
    let [left, centre, right] = &view.outer;
    let valence = &view.valence;
    let constant = |value: u32| m.constant(value.into(), valence.word());
    // The faces outside, from left to right: face i lies between a_i-1 and a_i.
    let mut pairs = vec![];
    for i in 1..=p.max_valence - 2 {
        let index = i as usize;
        let ends_here = m.is(valence, i128::from(i) + 2);
        let a = match view.neighbours.get(index - 1) {
            Some(a) => m.select(&ends_here, right, a),
            None => right.clone(),
        };
        let x = match (i, view.diagonals.get(index.wrapping_sub(2))) {
            (1, _) => view.before.clone(),
            (_, Some(x)) => m.select(&ends_here, &view.after, x),
            (_, None) => view.after.clone(),
        };
        let before = if i == 1 { left } else { &view.neighbours[index - 2] };
        let spoke = m.signal(&x - centre);
        let present = m.compare(Relation::LessOrEqual, constant(i + 2), valence);
        let around = match end {
            End::Top => m.signal(before - &a),
            End::Bottom => m.signal(&a - before),
        };
        pairs.push((fan(end, i), [m.select(&present, &spoke, nothing(m, &spoke)), around]));
    }
    pairs
}
