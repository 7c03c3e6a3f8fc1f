//! The fan unit: the end vertex of a column with everything around it, of any valence.
//!
//! ```text
//!            a_1   x_2   a_2            V' = S + kappa_d (6 sum A + sum D - 7 d S),  kappa_d = 1 / (4 d^2)
//!      uR(c-1)  \   |   /  uL(c+1)
//!              \ \  |  / /              A: left, right, inner, a_1 .. a_{d-3}
//!        left ───── S ───── right       D: the diagonals of the d faces around
//!                   │
//!          inner-l inner inner-r
//! ```
//!
//! The sum of the weights is exactly 1 whatever the table says, so a quantised table cannot shift the
//! model. Valence 4 needs no table: kappa is 1/64.

use super::Parameters;
use super::columns::{Column, Outside};
use crate::fixed::Range;
use crate::hdl::{Builder, Relation, Signal, Word};

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

    fn outside(self, column: &Column) -> &Outside {
        match self {
            End::Top => &column.top,
            End::Bottom => &column.bottom,
        }
    }

    /// The end vertex, and its neighbour within the column.
    fn rows(self, column: &Column) -> [&Signal; 2] {
        let rows = &column.rows;
        match self {
            End::Top => [&rows[0], &rows[1]],
            End::Bottom => [&rows[rows.len() - 1], &rows[rows.len() - 2]],
        }
    }
}

/// Three columns of the window.
pub struct Window<'a> {
    pub previous: &'a Column,
    pub column: &'a Column,
    pub next: &'a Column,
}

/// The end vertex of the new vertex column over 64 * 2^b, unrounded, and what lies outside of it over 64.
/// `valence` counts the edges of the end vertex.
pub fn replace_end(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    window: &Window,
    end: End,
    valence: &Signal,
) -> (Signal, Outside) {
    let name = |what: &str| format!("{}_{what}", end.name());
    let [left, inner_left] = end.rows(window.previous);
    let [centre, inner] = end.rows(window.column);
    let [right, inner_right] = end.rows(window.next);
    let outside = end.outside(window.column);
    let (before, after) = (&end.outside(window.previous).right, &end.outside(window.next).left);
    let spokes = parameters.outside_neighbours();

    // The ring over the outside: a_0 is left, a_{d-2} is right; x_i lies between a_{i-1} and a_i.
    let is_last = |i: usize| m.is(valence, i as i128 + 3);
    let mut sum = m.wire(
        name("spokes_0"),
        6 * left + 6 * right + 6 * inner + inner_left + inner_right + before - 21 * centre,
    );
    let mut neighbours = vec![];
    let mut diagonals = vec![];
    for i in 1..=spokes {
        let a = &outside.neighbours[i - 1];
        // The last face before the next column is the outside face of the strip.
        let ends_here = m.wire(name(&format!("ends_{i}")), is_last(i));
        let (next_a, next_x) = match (outside.neighbours.get(i), outside.diagonals.get(i - 1)) {
            (Some(a), Some(x)) => (m.select(&ends_here, right, a), m.select(&ends_here, after, x)),
            _ => (right.clone(), after.clone()),
        };
        let next_x = m.wire(name(&format!("x_{}", i + 1)), &next_x);
        let (last_a, last_x) = match i {
            1 => (left.clone(), before.clone()),
            _ => (outside.neighbours[i - 2].clone(), outside.diagonals[i - 2].clone()),
        };
        neighbours.push(m.wire(
            name(&format!("new_a_{i}")),
            4 * (6 * centre + 6 * a + &last_a + &last_x + &next_a + &next_x),
        ));
        if i >= 2 {
            // The face between a_{i-1} and a_i: its point is the new diagonal.
            diagonals.push(m.wire(name(&format!("new_x_{i}")), 16 * (centre + &last_a + &last_x + a)));
        }
        let present = m.compare(Relation::LessOrEqual, m.constant(i as i128 + 3, valence.word()), valence);
        let spoke = m.signal(6 * a + &next_x - 7 * centre);
        let zero = m.constant(0, Word { range: Range::point(0), ..spoke.word() });
        sum = m.wire(name(&format!("spokes_{i}")), &sum + &m.select(&present, &spoke, &zero));
    }

    let replaced = weighted(m, parameters, level, centre, &sum, valence, &name);
    let edge = |v: &Signal, w: &Signal, around: [&Signal; 4]| {
        let [a, b, c, d] = around;
        4 * (6 * v + 6 * w + a + b + c + d)
    };
    // With valence 3 there is no outside neighbour; the neighbouring columns use the edges to each other.
    let left_of_three = m.wire(name("edge_right"), edge(centre, right, [inner, inner_right, after, left]));
    let right_of_three = m.wire(name("edge_left"), edge(centre, left, [inner, inner_left, before, right]));
    let three = m.wire(name("is_three"), m.is(valence, 3));
    let mut last = neighbours[0].clone();
    for (i, a) in neighbours.iter().enumerate().skip(1) {
        let beyond = m.compare(Relation::LessOrEqual, m.constant(i as i128 + 4, valence.word()), valence);
        last = m.select(&beyond, a, &last);
    }
    let outside = Outside {
        left: m.wire(name("new_left"), m.select(&three, &left_of_three, &neighbours[0])),
        right: m.wire(name("new_right"), m.select(&three, &right_of_three, &last)),
        neighbours,
        diagonals,
    };
    (replaced, outside)
}

/// 64 S + 64 kappa_d * sum over 2^b, b the bits of the table; it is rounded once, with the column.
fn weighted(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    centre: &Signal,
    sum: &Signal,
    valence: &Signal,
    name: &dyn Fn(&str) -> String,
) -> Signal {
    let bits = parameters.replacement_bits();
    let entry = |d: u32| m.constant(kappa64(d, bits), Word::range(0, kappa64(3, bits)));
    let mut weight = entry(4);
    for d in (3..=parameters.max_valence).filter(|d| *d != 4) {
        weight = m.select(&m.is(valence, d.into()), entry(d), &weight);
    }
    let weight = m.wire(name("weight"), &weight);
    let product = m.wire(name("weighted"), m.product(sum, &weight));
    let point =
        m.rescale(&m.signal(&product + (centre << (6 + bits))), (centre.word().fraction + 6) + bits as i32);
    // A convex combination: it lies in the hull, whatever the interval of the product says.
    let hull = parameters.word(level).range * (64i128 << bits);
    m.claim(&name("replacement"), &point, Word { range: hull, ..point.word() }, None)
}

/// 64 / (4 d^2) over 2^`bits`, rounded half up; exactly 2^bits for d = 4.
pub fn kappa64(d: u32, bits: u32) -> i128 {
    let denominator = i128::from(d * d);
    ((16i128 << (bits + 1)) / denominator + 1) >> 1
}
