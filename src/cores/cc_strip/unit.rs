//! Unit vectors: a normal of any length becomes one of length 2^n.
//!
//! ```text
//!   clock 1   v = (x, y, z) 2^(m-e), rounded half up     m = n + 4; the leading bits of the longest component
//!   clock 2   squares
//!   clock 3   q = v . v;  u = q or 4q, in [1, 4) 2^2m
//!   clock 4   T_i and T_i - T_i+1 from the table          i = the k = ceil(n/2) bits behind the point of u
//!   clock 5   y = T_i - (T_i - T_i+1) g / 2^t             T_i = 2^p / sqrt(1 + i / 2^k), p = n + 5, t = n + 5 - k
//!   clock 6   v y
//!   clock 7   v y or 2 v y over 2^(m+p-n), rounded half up
//! ```
//!
//! e is the least integer with all components in [-2^e, 2^e), so the longest of v has a length of 2^(m-1) at least.
//!
//! **Error**: within 0.75 of the last place. The last rounding costs 0.5; the rounding of v at most
//! sqrt(3) 2^(n-m) = 0.109; the chord of the table lies above the curve by at most 3/32 2^-2k, which is 0.094; its
//! entries and the truncation of y cost 3 2^(n-p) = 0.094 downwards; the bits of u below g 0.016. Those of the table
//! have opposite signs. The zero vector stays zero.

use std::rc::Rc;

use super::finish::{AXES, stage};
use crate::error::Result;
use crate::fixed::Rounding;
use crate::hdl::{Bitwise, Builder, Module, Signal, Sum, Word};

/// Clocks from a normal to its unit vector.
pub const LATENCY: u32 = 7;

/// Inputs: `x`, `y`, `z` in `word`, and `advance`. Outputs: `unit_x`, `unit_y`, `unit_z`, registered, -2^n ..= 2^n in
/// n + 2 bits with n fraction bits.
pub fn build(word: Word, n: u32) -> Result<Rc<Module>> {
    let m = Builder::new("unit_vector");
    m.purpose(format!(
        "The unit vector over 2^{n} of a vector of any length, within 0.75 of the last place."
    ));
    m.parameter("fraction", n);
    let vector = AXES.map(|axis| m.input(axis, word));
    let advance = m.input("advance", Word::bit());
    let keep = |name: &str, value: &Signal| stage(&m, &advance, name, value);
    let (bits, precision) = (n + 4, n + 5);
    let index = n.div_ceil(2);
    let rest = precision - index;

    let v = normalised(&m, &vector, bits);
    let name = |what: &str, axis: usize| format!("{what}_{}", AXES[axis]);
    let v1 = [0, 1, 2].map(|axis| keep(&name("v", axis), &v[axis]));

    let squares = [0, 1, 2].map(|axis| keep(&name("square", axis), &m.product(&v1[axis], &v1[axis])));
    let mut v = v1;
    let pass = |v: &mut [Signal; 3], clock: u32| {
        *v = [0, 1, 2].map(|axis| keep(&format!("v_{}_{clock}", AXES[axis]), &v[axis]));
    };
    pass(&mut v, 2);
    let q = m.wire("q", Sum::weighted(squares.iter().map(|s| (1, s))));
    // A sum of squares, at most 3 4^m: it has no sign, whatever the interval of a product says.
    let q = keep("q_kept", &m.wrap(&q, Word::unsigned(2 * bits + 2)));
    pass(&mut v, 3);

    let short = m.wire("is_short", m.is(&m.slice(&q, 2 * bits, 2), 0));
    let longer = m.wrap(&q << 2, q.word());
    let u = m.wire("u", m.select(&short, &longer, &q));
    let (address, g) = (m.slice(&u, 2 * bits - index, index + 2), m.slice(&u, 2 * bits - index - rest, rest));
    let entries = entries(index, precision);
    let steps: Vec<i128> = entries.windows(2).map(|pair| pair[0] - pair[1]).collect();
    let most = |list: &[i128]| Word::range(0, list.iter().copied().max().unwrap_or(0));
    let depth = steps.len() as u32;
    let (root, step) = (most(&entries), most(&steps));
    // The step to the next entry stands above the entry: one word, one read.
    let words = entries.iter().zip(&steps).map(|(entry, step)| step << root.width() | entry).collect();
    let table = m.memory("reciprocal_root", depth, Word::unsigned(root.width() + step.width()), words);
    // The read is a register like the others: it waits for `advance`, and what belongs together stays so.
    let read = m.restart(&table.read("root_and_step", &address, Some(&advance)), 0);
    let entry = m.wrap(m.slice(&read, 0, root.width()), root);
    let step = m.wrap(m.slice(&read, root.width(), step.width()), step);
    let g = keep("g", &g);
    let short = keep("is_short_4", &short);
    pass(&mut v, 4);

    let fall = m.product(&step, &g);
    // Between two entries.
    let y = m.wrap(m.round((&entry << rest) - &fall, rest, Rounding::Floor), root);
    let y = keep("y", &y);
    let short = keep("is_short_5", &short);
    pass(&mut v, 5);

    let scaled = [0, 1, 2].map(|axis| keep(&name("scaled", axis), &m.product(&v[axis], &y)));
    let short = keep("is_short_6", &short);
    for (axis, scaled) in AXES.iter().zip(&scaled) {
        let long = m.select(&short, scaled << 1, scaled);
        let unit = m.round(&long, bits + precision - n, Rounding::HalfUp);
        // No component is longer than the vector, 2^n: the product's interval does not know.
        let unit = m.rescale(&m.wrap(&unit, Word::signed(n + 2)), n as i32);
        m.output(format!("unit_{axis}"), keep(&format!("unit_{axis}"), &unit));
    }
    m.finish()
}

/// The vector times a power of two with its leading bit in place, rounded half up to `bits` bits and a sign.
fn normalised(m: &Builder, vector: &[Signal; 3], bits: u32) -> [Signal; 3] {
    // One bit below the point tells -1, which a one's complement takes for nothing, from zero.
    let width = vector[0].width();
    let doubled = [0, 1, 2].map(|axis| {
        let wide = Word::signed(width + 1);
        m.rescale(&m.wrap(&vector[axis] << 1, wide), 0)
    });
    // What the three lengths have in bits: the components that are negative inverted.
    let lengths = doubled.each_ref().map(|component| {
        let (sign, bits) = (m.slice(component, width, 1), m.slice(component, 0, width));
        m.select(&sign, !&bits, &bits)
    });
    let mut length = m.wire("length", m.logic(Bitwise::Or, &[&lengths[0], &lengths[1], &lengths[2]]));
    let mut vector = doubled;
    for power in (0..width.next_power_of_two().ilog2()).rev() {
        let shift = 1 << power;
        if shift >= width {
            continue;
        }
        let empty = m.wire(format!("upper_{shift}_empty"), m.is(&m.slice(&length, width - shift, shift), 0));
        let moved = |signal: &Signal| m.signal(m.wrap(signal << shift, signal.word()));
        length = m.wire(format!("length_{shift}"), m.select(&empty, moved(&length), &length));
        vector = [0, 1, 2].map(|axis| {
            let name = format!("{}_{shift}", AXES[axis]);
            m.wire(name, m.select(&empty, moved(&vector[axis]), &vector[axis]))
        });
    }
    vector.map(|component| match width.checked_sub(bits) {
        Some(drop) => m.rescale(&m.round(&component, drop, Rounding::HalfUp), 0),
        None => m.signal(&component << (bits - width)),
    })
}

/// round(2^p / sqrt(i / 2^k)) for i = 0 ..= 4 2^k; below 2^k, where u never is, as at 2^k.
fn entries(k: u32, p: u32) -> Vec<i128> {
    let entry = |i: u128| ((1u128 << (2 * p + k + 2)) / i.max(1 << k)).isqrt().div_ceil(2) as i128;
    (0..=4u128 << k).map(entry).collect()
}
