//! The outer differences of one coordinate: they walk from column to column and hand over the heads.
//!
//! ```text
//!   whole      D += D'                                            one clock a step
//!   digits     ┌► D[n-1] ─► ... ─► D[1] ─► D[0] ─┬► + ─┐          n clocks a step, the lowest digit first
//!              └─────────────────────────────────┴─────┘◄── D'[0]
//! ```

use std::collections::BTreeMap;
use std::rc::Rc;

use super::super::engine::DIFFERENCES;
use super::super::{Parameters, words};
use crate::error::Result;
use crate::hdl::serial::Digits;
use crate::hdl::skew::LEAD;
use crate::hdl::{Builder, Module, Signal, Word};

/// By (k, l).
type Table = BTreeMap<(u32, u32), Signal>;

/// D(k,l) gains this one along u, times 2^n.
fn higher((k, l): (u32, u32)) -> Option<((u32, u32), u32)> {
    // D40 = 2 D31; D22 = 0. Zeros at the low end are not kept.
    let (of, doubled) = if (k, l) == (3, 0) { ((3, 1), 1) } else { ((k + 1, l), 0) };
    let zeros = words::low_zeros(k + l + 1) - words::low_zeros(k + l);
    DIFFERENCES.contains(&of).then_some((of, zeros + doubled))
}

/// Inputs: `n..` are taken at `capture` and wait; `load` moves them into the outer differences; `advance` steps these
/// to the next column. Where they do not wait, `capture` loads. A clock later, `last_l` are the differences D0l of the
/// column before, `next_l` those of the
/// next one, which a buffered lane does without, and `fourth` is D13.
///
/// In digits, `turn` comes a clock ([`LEAD`]) before the first one of a load or an advance. As early, through all digits,
/// come `waiting_turns` (one is captured or loaded), `outer_turns` (one is loaded or advanced) and `loading` (which of the
/// two). Where differences do not wait, there are no `waiting_turns`.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("outer_differences");
    m.purpose("Outer differences of one coordinate: the heads of the columns, one after the other.");
    match parameters.digit() {
        None => whole(&m, parameters),
        Some(size) => in_digits(&m, parameters, size),
    }
    m.finish()
}

fn whole(m: &Builder, parameters: Parameters) {
    let [capture, advance] = ["capture", "advance"].map(|name| m.input(name, Word::bit()));
    let load = parameters.differences_wait().then(|| m.input("load", Word::bit()));
    let (mut waiting, mut outer) = (Table::new(), Table::new());
    for (k, l) in DIFFERENCES {
        let n = m.input(format!("n{k}{l}"), parameters.difference((k, l)));
        outer.insert((k, l), m.register(format!("d{k}{l}"), n.word()));
        let start = if load.is_some() {
            let register = m.register(format!("waiting_{k}{l}"), n.word());
            m.on(&capture, &register, &n);
            register
        } else {
            n
        };
        waiting.insert((k, l), start);
    }
    for (kl, d) in &outer {
        m.on(load.as_ref().unwrap_or(&capture), d, &waiting[kl]);
        if let Some((of, shift)) = higher(*kl) {
            let of = &outer[&of];
            let narrow = of.width() + words::low_zeros(kl.0 + kl.1 + 1) < parameters.modulus();
            let of = if narrow { m.wrap(of, Word::signed(of.width())) } else { of.clone() };
            m.on(&advance, d, d + (1 << shift) * &of);
        }
    }
    for l in 0..4 {
        let d = &outer[&(0, l)];
        let last = m.register(format!("last_{l}"), d.word());
        m.on(&advance, &last, d);
        m.output(format!("last_{l}"), &last);
        if !parameters.is_buffered() {
            m.output(format!("next_{l}"), d);
        }
    }
    m.output("fourth", &outer[&(1, 3)]);
}

fn in_digits(m: &Builder, parameters: Parameters, size: u32) {
    let count = parameters.digits();
    m.parameter("digit", size);
    // What says which digit it is belongs beside the digits of this coordinate.
    m.separate();
    let turn = m.input("turn", Word::bit());
    let digits = Digits::new(m, size, count, &turn);
    // In registers here, which synthesis may copy for all that they reach.
    let here = |name: &str| m.pipe(format!("{name}_here"), m.input(name, Word::bit()));
    let waiting_turns = parameters.differences_wait().then(|| here("waiting_turns"));
    let [outer_turns, loading] = ["outer_turns", "loading"].map(here);

    let word = Word::unsigned(size);
    let shifted = |name: &str, turns: &Signal| {
        let place = |place| m.register_at(format!("{name}_{place}"), word, None, LEAD);
        let places: Vec<Signal> = (0..count).map(place).collect();
        for pair in places.windows(2) {
            m.on(turns, &pair[0], &pair[1]);
        }
        (places[0].clone(), places[places.len() - 1].clone())
    };
    let (mut waiting, mut first, mut last) = (Table::new(), Table::new(), Table::new());
    for (k, l) in DIFFERENCES {
        let n = m.input_at(format!("n{k}{l}"), word, LEAD);
        let start = waiting_turns.as_ref().map(|turns| {
            let (lowest, highest) = shifted(&format!("waiting_{k}{l}"), turns);
            m.on(turns, &highest, &n);
            lowest
        });
        waiting.insert((k, l), start.unwrap_or(n));
        let (lowest, highest) = shifted(&format!("d{k}{l}"), &outer_turns);
        first.insert((k, l), lowest);
        last.insert((k, l), highest);
    }
    for (kl, lowest) in &first {
        // Chosen before the adder, where the choice takes no cell of its own: n + 0 or D + D'.
        let start = m.select(&loading, &waiting[kl], lowest);
        let next = match higher(*kl) {
            Some((of, shift)) => {
                let of = digits.shift_bits(&first[&of], shift);
                let of = m.select(&loading, m.constant(0, word), &of);
                digits.sum_when(&outer_turns, &start, &of)
            }
            None => start,
        };
        m.on(&outer_turns, &last[kl], &next);
    }
    for l in 0..4 {
        m.output(format!("last_{l}"), m.pipe(format!("last_{l}"), &first[&(0, l)]));
        if !parameters.is_buffered() {
            // The sum, a clock after its digits.
            m.output(format!("next_{l}"), m.restart(&last[&(0, l)], LEAD + 1));
        }
    }
    m.output("fourth", m.pipe("fourth", &first[&(1, 3)]));
}
