//! The fan unit with a register behind every adder and every choice, and without a multiplier.
//!
//! ```text
//! A = left + right + inner + a_1 + ..       D = inner left + inner right + x_1 + ..        of what valence d has
//! spokes = 6 A + D - 7 d S                  V' = S + kappa_d spokes: a multiple for every valence, and a choice
//! edge to w between faces = 4 (6 (S + w) + the four vertices around)
//! ```
//!
//! Valence 3 has no outside neighbour: there the units of the edges to a_1 and a_2 make those to its neighbours in the
//! strip, which the columns beside it see. The ports are those of [`super::fan::build`].

use std::rc::Rc;

use super::fan::{kappa64, names};
use super::wait::Waits;
use super::{Parameters, VALENCE_BITS};
use crate::error::Result;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Module, Relation, Signal, Sum, Word};

/// The unit for columns of a level.
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

    let round = |name: &str, sum: &Signal, more: u32| {
        let fine = m.rescale(sum, word.fraction + 6 + more as i32);
        let drop = parameters.drop() + more;
        let rounded = m.round(&fine, drop, parameters.rounding);
        let free = drop == 0 || parameters.rounding == Rounding::Floor;
        if free { m.wire(name, &rounded) } else { m.pipe(name, &rounded) }
    };
    let is = |d: usize| m.is(&valence, d as i128);
    let at_least =
        |d: usize| m.compare(Relation::LessOrEqual, m.constant(d as i128, valence.word()), &valence);
    let choose = |name: String, condition: &Signal, yes: &Signal, no: &Signal| {
        let same = yes.is_same(no);
        m.pipe(name, &if same { yes.clone() } else { m.select(condition, yes, no) })
    };
    let zero = m.constant(0, Word { range: Range::point(0), ..word });
    let three = m.wire("is_three", is(3));

    // Behind a_i in the ring; behind the last one follows the right end.
    let next: Vec<[Signal; 2]> = (0..a.len())
        .map(|i| match (a.get(i + 1), x.get(i)) {
            (Some(a), Some(x)) => {
                let ends = is(i + 4);
                [m.select(&ends, right, *a), m.select(&ends, after, *x)]
            }
            _ => [right.clone(), after.clone()],
        })
        .collect();
    let ring = |i: usize| -> [&Signal; 5] {
        let [last_a, last_x] = if i == 0 { [left, before] } else { [a[i - 1], x[i - 1]] };
        [a[i], last_a, last_x, &next[i][0], &next[i][1]]
    };
    let edge = |name: &str, of_three: Option<[&Signal; 5]>, i: usize| {
        let pick = |at: usize, end: &Signal| {
            let of_three = of_three.map_or(end, |of_three| of_three[at]);
            choose(format!("{name}_takes_{at}"), &three, of_three, end)
        };
        let ring = ring(i);
        let [w, p, q, r, s] = [0, 1, 2, 3, 4].map(|at| pick(at, ring[at]));
        let edge = m.pipe(format!("{name}_ends"), centre + &w);
        let around = m.pipelined(&format!("{name}_around"), &p + &q + &r + &s);
        m.signal(4 * &m.pipelined(name, 6 * &edge + &around))
    };
    // In the order in which both have most in common.
    let right_of_three = [left, inner, inner_left, right, before];
    let right_of_one = [left, inner, before, right, inner_left];
    let left_edge = edge("spoke_1", Some([right, left, inner_right, inner, after]), 0);
    let mut spokes = vec![left_edge.clone()];
    for (i, &neighbour) in a.iter().enumerate().skip(1) {
        let spoke = edge(&format!("spoke_{}", i + 1), (i == 1).then_some(right_of_three), i);
        let [last_a, last_x] = [ring(i)[1], ring(i)[2]];
        let face = m.pipelined(&format!("face_{}", i + 1), centre + last_a + last_x + neighbour);
        m.output(format!("new_x_{}", i + 1), round(&format!("new_x_{}", i + 1), &m.signal(16 * &face), 0));
        m.output(format!("new_a_{}", i + 1), round(&format!("new_a_{}", i + 1), &spoke, 0));
        spokes.push(spoke);
    }
    let mut right_edge = match spokes.get(1) {
        Some(spoke) => choose("right_of_two".into(), &is(4), &spokes[0], spoke),
        None => edge("right_spoke", Some(right_of_one), 0),
    };
    for (i, spoke) in spokes.iter().enumerate().skip(2) {
        right_edge = choose(format!("right_of_{}", i + 1), &at_least(i + 4), spoke, &right_edge);
    }
    m.output("left", round("left", &left_edge, 0));
    m.output("right", round("right", &right_edge, 0));

    // What valence d has of the ring, and d times the centre by the digits of d.
    let there = |name: String, i: usize, of: &Signal| m.pipe(name, m.select(&at_least(i + 4), of, &zero));
    let mut neighbours = left + right + inner;
    let mut diagonals = inner_left + inner_right + before;
    for i in 0..a.len() {
        neighbours = neighbours + &there(format!("neighbour_{}", i + 1), i, a[i]);
        diagonals = diagonals + &there(format!("diagonal_{}", i + 1), i, &next[i][1]);
    }
    let digits = (0..=parameters.max_valence.ilog2())
        .map(|at| m.pipe(format!("centre_{at}"), m.select(&m.slice(&valence, at, 1), centre, &zero)));
    let digits: Vec<Signal> = digits.collect();
    let centres = Sum::weighted(digits.iter().enumerate().map(|(at, digit)| (1i128 << at, digit)));
    let (neighbours, diagonals) =
        (m.pipelined("neighbours", neighbours), m.pipelined("diagonals", diagonals));
    let centres = m.pipelined("centres", centres);
    let spokes = m.pipelined("spokes", 6 * &neighbours + &diagonals - 7 * &centres);

    let bits = parameters.replacement_bits();
    let others: Vec<(u32, Signal)> = (3..=parameters.max_valence)
        .filter(|d| *d != 4)
        .map(|d| (d, m.pipelined(&format!("weighted_{d}"), kappa64(d, bits) * &spokes)))
        .collect();
    let first = others.iter().filter_map(|(_, multiple)| multiple.time()).min().unwrap_or(0);
    // Of valence 4 kappa is a power of two.
    let mut weighted = m.signal(kappa64(4, bits) * &m.at_time(&spokes, first));
    for (d, multiple) in &others {
        weighted = choose(format!("weighted_to_{d}"), &is(*d as usize), multiple, &weighted);
    }
    let late = Waits::new(&m, parameters).until(
        "centre_slot",
        &[("centre".into(), centre.clone())],
        weighted.time().unwrap_or(0),
    );
    let vertex = m.pipe("replaced", &weighted + (&late[0] << (6 + bits)));
    // A convex combination: it lies in the hull, whatever the intervals say.
    let hull = word.range * (64i128 << bits);
    let vertex = m.claim("replacement", &vertex, Word { range: hull, ..vertex.word() }, None);
    m.output("vertex", round("vertex", &vertex, bits));
    m.finish()
}
