//! One coordinate of the limit positions of a column.
//!
//! ```text
//!   limit = S + lambda_d (4 sum A + sum D - 5d S)                lambda_d = 1 / (d (d + 5)) over 2^b
//!
//!   inner rows    u_k = p_k + 4 c_k + n_k,   u_k-1 + 4 u_k + u_k+1 - 36 c_k,   lambda_4 = 1/36: no multiplier
//!   end rows      the sum around the end vertex as its valence says, times the table's entry
//! ```
//!
//! 2^b / 36 is 2^(b-2) / 9, in binary 000111 000111 ...: 7 (1 + 2^6 + 2^12 + ...), and what is left of the last
//! period. So the entry that a table of b bits has for valence 4 is a few shifts and adds, for every b.
//!
//! The sums are exact and rounded once. The weights sum to one whatever the table says, and none is
//! negative, so a limit lies in the hull of its ring.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::fan::End;
use super::finish::{Parameters, stage};
use super::view::EndView;
use super::view_ports::view;
use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Sum, Word};

/// Clocks from the view to the limit positions.
pub const LATENCY: u32 = 3;

/// Inputs: a view (see [`view`]) in the word of the finest level, and `advance`. Outputs: `limit_k` for each row,
/// registered, in the output word.
pub fn build(p: Parameters) -> Result<Rc<Module>> {
    let bits = p.limit.unwrap_or(0);
    let m = Builder::new("limit");
    m.purpose("One coordinate of the limit positions of a column of the finest level.");
    m.parameter("max_valence", p.max_valence);
    m.parameter("table_bits", bits);
    let view = view(&m, p, "", p.word);
    let advance = m.input("advance", Word::bit());
    let last = p.rows() - 1;

    let [previous, column, next] = &view.rows;
    let across: Vec<Signal> =
        (0..=last).map(|k| m.wire(format!("across_{k}"), &previous[k] + 4 * &column[k] + &next[k])).collect();
    let mut projected = vec![];
    for k in 1..last {
        let around = &across[k - 1] + 4 * &across[k] + Sum::from(&across[k + 1]);
        let spread = m.wire(format!("spread_{k}"), around - 36 * &column[k]);
        let spread = stage(&m, &advance, format!("spread_{k}_kept"), &spread);
        let centre = stage(&m, &advance, format!("centre_{k}_kept"), &column[k]);
        let share = m.wire(format!("share_{k}"), one_in_36(&m, &spread, bits));
        projected.push(point(&m, p, &advance, &format!("inner_{k}"), &centre, &share));
    }
    let ends = [0, 1].map(|end| {
        let name = End::BOTH[end].name();
        let (sum, weight) = around(&m, p, name, &view.ends[end]);
        let sum = stage(&m, &advance, format!("{name}_spread_kept"), &sum);
        let weight = stage(&m, &advance, format!("{name}_weight_kept"), &weight);
        let centre = stage(&m, &advance, format!("{name}_centre_kept"), &view.ends[end].outer[1]);
        let share = m.wire(format!("{name}_share"), m.product(&sum, &weight));
        point(&m, p, &advance, name, &centre, &share)
    });

    // Which row is the bottom one, beside the points that it chooses between.
    let bottoms: BTreeMap<usize, Signal> = p
        .bottoms()
        .map(|k| {
            let kept = stage(&m, &advance, format!("is_bottom_{k}_kept"), &view.is_bottom[k]);
            (k, stage(&m, &advance, format!("is_bottom_{k}_chosen"), &kept))
        })
        .collect();
    let drop = (p.word.fraction - p.output.fraction) as u32 + bits;
    for k in 0..=last {
        let chosen = match (k, bottoms.get(&k)) {
            (0, _) => ends[0].clone(),
            (k, _) if k == last => ends[1].clone(),
            (k, Some(is_bottom)) => m.select(is_bottom, &ends[1], &projected[k - 1]),
            (k, None) => projected[k - 1].clone(),
        };
        let rounded = m.round(&chosen, drop, p.rounding);
        let kept = stage(&m, &advance, format!("limit_{k}"), &m.wrap(&rounded, p.output));
        m.output(format!("limit_{k}"), &kept);
    }
    m.finish()
}

/// 2^b times the limit position, registered.
fn point(
    m: &Builder,
    p: Parameters,
    advance: &Signal,
    name: &str,
    centre: &Signal,
    share: &Signal,
) -> Signal {
    let bits = p.limit.unwrap_or(0);
    let sum = m.signal((centre << bits) + share);
    // A convex combination: it lies in the hull, whatever the interval of the product says.
    let hull = Word::from(p.word.range * (1i128 << bits)).fraction(p.word.fraction);
    let sum = m.claim(&format!("{name}_limit"), &sum, hull, None);
    let kept = stage(m, advance, format!("{name}_limit_kept"), &sum);
    m.rescale(&kept, p.word.fraction + bits as i32)
}

/// 4 sum A + sum D - 5d S around an end vertex, and lambda_d over 2^b.
fn around(m: &Builder, p: Parameters, name: &str, end: &EndView) -> (Signal, Signal) {
    let bits = p.limit.unwrap_or(0);
    let [left, centre, right] = &end.outer;
    let [inner_left, inner, inner_right] = &end.inner;
    let valence = &end.valence;
    // Of valence 3: the face over the outside lies between left and right.
    let three = 4 * left + 4 * right + 4 * inner + inner_left + inner_right + &end.before - 15 * centre;
    let mut sum = m.wire(format!("{name}_around_3"), three);
    for (i, a) in (1..).zip(&end.neighbours) {
        // One edge more, and the face behind it: the last one lies before the next column.
        let d = i as i128 + 3;
        let x = match end.diagonals.get(i - 1) {
            Some(x) => m.select(&m.is(valence, d), &end.after, x),
            None => end.after.clone(),
        };
        let spoke = m.signal(4 * a + &x - 5 * centre);
        let zero = m.constant(0, Word { range: crate::fixed::Range::point(0), ..spoke.word() });
        let present = m.compare(Relation::LessOrEqual, m.constant(d, valence.word()), valence);
        let spoke = m.wire(format!("{name}_spoke_{i}"), m.select(&present, &spoke, &zero));
        sum = m.wire(format!("{name}_around_{d}"), &sum + &spoke);
    }
    let entry = |d: u32| m.constant(lambda(d, bits), Word::range(0, lambda(3, bits)));
    let weight = (3..=p.max_valence)
        .filter(|d| *d != 4)
        .fold(m.signal(entry(4)), |weight, d| m.select(&m.is(valence, d.into()), entry(d), &weight));
    (sum, m.wire(format!("{name}_weight"), &weight))
}

/// 1 / (d (d + 5)) over 2^`bits`, rounded half up.
pub fn lambda(d: u32, bits: u32) -> i128 {
    let denominator = i128::from(d * (d + 5));
    ((1i128 << (bits + 1)) / denominator + 1) >> 1
}

/// What is left of 2^(b-2) / 9 when the whole periods of six bits are taken, rounded half up.
const REST: [i128; 6] = [0, 0, 0, 1, 2, 4];

/// x times the nearest integer to 2^b / 36.
fn one_in_36(m: &Builder, x: &Signal, bits: u32) -> Signal {
    let (periods, rest) = (bits.saturating_sub(2) / 6, bits.saturating_sub(2) % 6);
    let seven = m.signal(8 * x - x);
    let whole = repeated(m, &seven, periods, &mut BTreeMap::new());
    m.signal((&whole << rest) + REST[rest as usize] * x)
}

/// x * (1 + 2^6 + ... + 2^(6 (count - 1))): the sum of the largest power of two of periods, and of the rest.
fn repeated(m: &Builder, x: &Signal, count: u32, known: &mut BTreeMap<u32, Signal>) -> Signal {
    if count <= 1 {
        return x.clone();
    }
    if let Some(sum) = known.get(&count) {
        return sum.clone();
    }
    let low = count.next_power_of_two() / 2;
    let (half, rest) = (repeated(m, x, low, known), repeated(m, x, count - low, known));
    let sum = m.signal(&half + (&rest << (6 * low)));
    known.insert(count, sum.clone());
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Flat, Integers, Simulator};

    /// The shifts and adds are the table's entry for valence 4, for every table.
    #[test]
    fn periods_of_six_bits_are_a_thirty_sixth() {
        for bits in 8..=52 {
            let m = Builder::new("one_in_36");
            let x = m.input("x", Word::signed(12));
            m.output("y", one_in_36(&m, &x, bits));
            let mut simulator =
                Simulator::new(Flat::new(&m.finish().expect("a module")).expect("no loop"), Integers);
            let [x, y] =
                [simulator.flat.input("x"), simulator.flat.output("y")].map(|id| id.expect("a port"));
            for value in [1, -1, 2047, -2048] {
                simulator.set(x, value);
                simulator.settle();
                assert_eq!(*simulator.get(y), value * lambda(4, bits), "{bits} bits, {value}");
            }
            assert!((lambda(4, bits) * 36 - (1 << bits)).abs() <= 18, "{bits} bits");
        }
    }
}
