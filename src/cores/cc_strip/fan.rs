//! The fan unit: the end vertex of a column with everything around it, of any valence.
//!
//! ```text
//!            a_1   x_2   a_2            V' = S + kappa_d (6 sum A + sum D - 7 d S),  kappa_d = 1 / (4 d^2)
//!      before   \   |   /   after
//!              \ \  |  / /              A: outer 0 and 2, inner 1, a_1 .. a_{d-3}
//!    outer 0 ── outer 1 ── outer 2      D: the diagonals of the d faces around
//!        │          │          │
//!    inner 0 ── inner 1 ── inner 2      S is outer 1
//! ```
//!
//! The sum of the weights is exactly 1 whatever the table says, so a quantised table cannot shift the
//! model. Valence 4 needs no table: kappa is 1/64. Source: Hall, equation (5.1) and section 4.4.

use std::rc::Rc;

use super::view::EndView;
use super::wait::Waits;
use super::{Parameters, VALENCE_BITS};
use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Sum, Word};

/// Which end of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Top,
    Bottom,
}

impl End {
    pub const BOTH: [End; 2] = [End::Top, End::Bottom];

    pub fn name(self) -> &'static str {
        match self {
            End::Top => "top",
            End::Bottom => "bottom",
        }
    }
}

/// x_2, a_2, x_3, a_3, ...: the fan behind a_1 up to the largest valence, in the order of the stream.
pub fn fan_names(parameters: Parameters) -> Vec<String> {
    (2..=parameters.outside_neighbours()).flat_map(|i| [format!("x_{i}"), format!("a_{i}")]).collect()
}

/// Names of what a fan unit sees, in the order of [`signals`].
pub(super) fn names(parameters: Parameters) -> Vec<String> {
    let columns = ["outer", "inner"].iter().flat_map(|row| (0..3).map(move |c| format!("{row}_{c}")));
    let ring = ["corner_left", "corner_right", "a_1"].map(String::from);
    columns.chain(ring).chain(fan_names(parameters)).collect()
}

/// The signals of an end in the order of [`names`].
pub(super) fn signals(end: &EndView) -> Vec<Signal> {
    let mut signals: Vec<Signal> = end.outer.iter().chain(&end.inner).cloned().collect();
    signals.extend([end.before.clone(), end.after.clone()]);
    for (i, a) in end.neighbours.iter().enumerate() {
        signals.extend(i.checked_sub(1).map(|x| end.diagonals[x].clone()));
        signals.push(a.clone());
    }
    signals
}

/// What a fan unit makes: the vertex that replaces the end, and what lies outside of it.
pub struct Replaced {
    pub vertex: Signal,
    pub left: Signal,
    pub right: Signal,
    /// As [`fan_names`].
    pub fan: Vec<Signal>,
}

impl Replaced {
    /// The clock of the last of them.
    pub fn time(&self) -> Option<u32> {
        [&self.vertex, &self.left, &self.right].into_iter().chain(&self.fan).filter_map(Signal::time).max()
    }

    /// All of the clock of the last.
    pub fn together(self, waits: &Waits) -> Replaced {
        let until = self.time().unwrap_or(0);
        let beside = [("left".to_string(), self.left), ("right".to_string(), self.right)];
        let beside = waits.until("beside_slot", &beside, until);
        let fan: Vec<(String, Signal)> =
            self.fan.into_iter().enumerate().map(|(i, signal)| (format!("fan_{i}"), signal)).collect();
        Replaced {
            vertex: waits.m.at_time(&self.vertex, until),
            left: beside[0].clone(),
            right: beside[1].clone(),
            fan: waits.until("fan_slot", &fan, until),
        }
    }

    pub fn each(&self, of: impl Fn(&Signal) -> Signal) -> Replaced {
        Replaced {
            vertex: of(&self.vertex),
            left: of(&self.left),
            right: of(&self.right),
            fan: self.fan.iter().map(of).collect(),
        }
    }
}

/// A fan unit on an end.
pub fn place(m: &Builder, parameters: Parameters, unit: &Rc<Module>, name: &str, end: &EndView) -> Replaced {
    let (names, signals) = (names(parameters), signals(end));
    let mut inputs: Vec<(&str, &Signal)> = names.iter().map(String::as_str).zip(&signals).collect();
    inputs.push(("valence", &end.valence));
    let placed = m.instance(name, unit, &inputs);
    Replaced {
        vertex: placed.out("vertex"),
        left: placed.out("left"),
        right: placed.out("right"),
        fan: fan_names(parameters).iter().map(|place| placed.out(&format!("new_{place}"))).collect(),
    }
}

/// The unit for columns of a level. Inputs: see [`names`], and `valence`. Outputs: `vertex`, `left`, `right` and
/// `new_..`, vertices of the next level.
pub fn build(parameters: Parameters, level: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("fan_unit_{level}"));
    m.purpose(format!("Replaces an end vertex of a column of level {level} and what lies outside of it."));
    m.parameter("max_valence", parameters.max_valence);
    let word = parameters.word(level);
    let inputs: Vec<Signal> = names(parameters).iter().map(|name| m.input(name.clone(), word)).collect();
    let valence = m.input("valence", Word::unsigned(VALENCE_BITS));
    let [left, centre, right, inner_left, inner, inner_right, before, after] = &inputs[..8] else {
        return m.finish();
    };
    let a: Vec<&Signal> = inputs[8..].iter().step_by(2).collect();
    let x: Vec<&Signal> = inputs[9..].iter().step_by(2).collect();

    let round = |sum: &Signal, more: u32| {
        let fine = m.rescale(sum, word.fraction + 6 + more as i32);
        m.round(&fine, parameters.drop() + more, parameters.rounding)
    };
    let put = |name: String, sum: &Signal| m.output(name.clone(), m.wire(name, round(sum, 0)));

    // The ring over the outside: a_0 is left, a_{d-2} is right; x_i lies between a_{i-1} and a_i.
    let mut spokes = m
        .wire("spokes_0", 6 * left + 6 * right + 6 * inner + inner_left + inner_right + before - 21 * centre);
    let mut neighbours = vec![];
    for i in 1..=a.len() {
        // The last face before the next column is the outside face of the strip.
        let ends_here = m.wire(format!("ends_{i}"), m.is(&valence, i as i128 + 3));
        let (next_a, next_x) = match (a.get(i), x.get(i - 1)) {
            (Some(a), Some(x)) => (m.select(&ends_here, right, *a), m.select(&ends_here, after, *x)),
            _ => (right.clone(), after.clone()),
        };
        let next_x = m.wire(format!("x_after_{i}"), &next_x);
        let (last_a, last_x) = if i == 1 { (left, before) } else { (a[i - 2], x[i - 2]) };
        let spoke = 4 * (6 * centre + 6 * a[i - 1] + last_a + last_x + &next_a + &next_x);
        neighbours.push(m.wire(format!("spoke_{i}"), spoke));
        if i >= 2 {
            // The face between a_{i-1} and a_i: its point is the new diagonal.
            let face = m.wire(format!("face_{i}"), 16 * (centre + last_a + last_x + a[i - 1]));
            put(format!("new_x_{i}"), &face);
            put(format!("new_a_{i}"), &neighbours[i - 1]);
        }
        let present = m.compare(Relation::LessOrEqual, m.constant(i as i128 + 3, valence.word()), &valence);
        let more = m.signal(6 * a[i - 1] + &next_x - 7 * centre);
        let none = m.constant(0, Word { range: crate::fixed::Range::point(0), ..more.word() });
        spokes = m.wire(format!("spokes_{i}"), &spokes + &m.select(&present, &more, &none));
    }
    let replaced = replacement(&m, parameters, level, centre, &spokes, &valence);
    m.output("vertex", m.wire("vertex", round(&replaced, parameters.replacement_bits())));

    // With valence 3 there is no outside neighbour; the neighbouring columns use the edges to each other.
    let edge = |w: &Signal, around: [&Signal; 4]| -> Sum {
        let [a, b, c, d] = around;
        4 * (6 * centre + 6 * w + a + b + c + d)
    };
    let left_of_three = m.wire("edge_right", edge(right, [inner, inner_right, after, left]));
    let right_of_three = m.wire("edge_left", edge(left, [inner, inner_left, before, right]));
    let three = m.wire("is_three", m.is(&valence, 3));
    let mut last = neighbours[0].clone();
    for (i, spoke) in neighbours.iter().enumerate().skip(1) {
        let beyond = m.compare(Relation::LessOrEqual, m.constant(i as i128 + 4, valence.word()), &valence);
        last = m.select(&beyond, spoke, &last);
    }
    put("left".into(), &m.wire("left_sum", m.select(&three, &left_of_three, &neighbours[0])));
    put("right".into(), &m.wire("right_sum", m.select(&three, &right_of_three, &last)));
    m.finish()
}

/// The replacement vertex: 64 S + 64 kappa_d * spokes over 2^b, b the bits of the table.
fn replacement(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    centre: &Signal,
    spokes: &Signal,
    valence: &Signal,
) -> Signal {
    let bits = parameters.replacement_bits();
    let entry = |d: u32| m.constant(kappa64(d, bits), Word::range(0, kappa64(3, bits)));
    let mut weight = entry(4);
    for d in (3..=parameters.max_valence).filter(|d| *d != 4) {
        weight = m.select(&m.is(valence, d.into()), entry(d), &weight);
    }
    let weight = m.wire("kappa", &weight);
    let product = m.wire("weighted", m.product(spokes, &weight));
    let point = m.signal(&product + (centre << (6 + bits)));
    // A convex combination: it lies in the hull, whatever the interval of the product says.
    let hull = parameters.word(level).range * (64i128 << bits);
    m.claim("replacement", &point, Word { range: hull, ..point.word() }, None)
}

/// 64 / (4 d^2) over 2^`bits`, rounded half up; exactly 2^bits for d = 4.
pub fn kappa64(d: u32, bits: u32) -> i128 {
    let denominator = i128::from(d * d);
    ((16i128 << (bits + 1)) / denominator + 1) >> 1
}
