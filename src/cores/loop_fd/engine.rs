//! The forward-difference engine of one coordinate: the outer differences walk from column to column, two
//! copies of their last column run along a strip.
//!
//! ```text
//! outer step  D00 += D10   D10 += D20   D20 += D30   D30 += 2 D31      (column i to column i + 1)
//!             D01 += D11   D11 += D21   D21 += D31
//!             D02 += D12   D03 += D13
//! inner step  l0 += l1     l1 += l2     l2 += l3     l3 += 2 D13       (row j to row j + 1; r likewise)
//! ```
//!
//! D22 = 0, D40 = 2 D31 and D04 = 2 D13 on every Loop patch, so of the 15 differences 12 need a register
//! (Bischoff, Kobbelt, Seidel count 23 registers with the two columns; 20 do, and 19 with r as l + m).

use std::collections::BTreeMap;
use std::rc::Rc;

use super::{Parameters, RegisterForm};
use crate::cores::rounder;
use crate::error::Result;
use crate::hdl::{Builder, Expr, Module, Signal, Word};

/// (k, l) of the twelve differences that a start-up computes, in the order of the ports.
pub const DIFFERENCES: [(u32, u32); 12] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1), (0, 2), (1, 2), (0, 3), (1, 3)];

type Table = BTreeMap<(u32, u32), Signal>;

/// One coordinate: `n..` are taken at `capture` and wait; `load` moves them into the outer differences;
/// `strip` starts a strip and steps the outer differences; `step` goes one row up. `left` and `right` are
/// the rounded vertices of the row, `valid` and `pair` say which of them mean anything.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("difference_engine");
    let (word, form) = (parameters.difference(), parameters.registers);
    m.purpose("Forward differences of one coordinate: a pair of vertices of a triangle strip per clock.");
    m.parameter("registers", form);
    m.parameter("modulus", format!("2^{}", parameters.modulus()));
    let [capture, load, strip, step] =
        ["capture", "load", "strip", "step"].map(|name| m.input(name, Word::bit()));
    let [valid, pair] = ["valid", "pair"].map(|name| m.input(name, Word::bit()));

    let mut waiting: Table = BTreeMap::new();
    for (k, l) in DIFFERENCES {
        let n = m.input(format!("n{k}{l}"), word);
        let register = m.register(format!("waiting_{k}{l}"), word);
        m.on(&capture, &register, &n);
        waiting.insert((k, l), register);
    }

    let outer = outer_differences(&m, parameters, &waiting, &load, &strip);
    let fourth: Expr = match outer.get(&(0, 4)) {
        Some(d04) => d04.into(),
        None => (2 * &outer[&(1, 3)]).into(),
    };
    let last = [0, 1, 2, 3].map(|l| outer[&(0, l)].clone());
    let left = column(&m, "left", &strip, &step, last, fourth.clone());
    let right = if form == RegisterForm::Relative19 {
        // r - l has the differences of the next column's polynomial less this one's: D10, D11, D12, D13.
        let gap = [0, 1, 2].map(|l| outer[&(1, l)].clone());
        let gap = column(&m, "gap", &strip, &step, gap, (&outer[&(1, 3)]).into());
        m.pipe("right", &left + &gap)
    } else {
        let next = [0, 1, 2, 3].map(|l| m.wire(format!("next_0{l}"), &outer[&(0, l)] + &outer[&(1, l)]));
        column(&m, "right", &strip, &step, next, fourth)
    };

    let rounder = rounder::build(
        parameters.modulus(),
        parameters.shift(),
        parameters.output_range(),
        parameters.output_fraction,
    )?;
    let both = m.wire("valid_pair", &valid & &pair);
    let round = |name: &str, numerator: &Signal, valid: &Signal| {
        m.instance(name, &rounder, &[("numerator", numerator), ("valid", valid)]).out("rounded")
    };
    let (left, right) = (round("round_left", &left, &valid), round("round_right", &right, &both));
    let last = left.time().max(right.time()).unwrap_or(0);
    m.output("left", m.at_time(&left, last));
    m.output("right", m.at_time(&right, last));
    m.finish()
}

/// The registers D(k,l); on `strip`, each gains the next higher one along u.
fn outer_differences(
    m: &Builder,
    parameters: Parameters,
    waiting: &Table,
    load: &Signal,
    strip: &Signal,
) -> Table {
    let word = parameters.difference();
    let mut start: BTreeMap<(u32, u32), Expr> = waiting.iter().map(|(&kl, n)| (kl, n.into())).collect();
    if matches!(parameters.registers, RegisterForm::Published23 | RegisterForm::WithoutZero22) {
        start.insert((4, 0), (2 * &waiting[&(3, 1)]).into());
        start.insert((0, 4), (2 * &waiting[&(1, 3)]).into());
    }
    if parameters.registers == RegisterForm::Published23 {
        start.insert((2, 2), m.constant(0, word).into());
    }
    let outer: Table = start.keys().map(|&(k, l)| ((k, l), m.register(format!("d{k}{l}"), word))).collect();
    for (&(k, l), register) in &outer {
        m.on(load, register, start[&(k, l)].clone());
        let higher: Option<Expr> = match outer.get(&(k + 1, l)) {
            Some(higher) => Some(higher.into()),
            None if (k, l) == (3, 0) => Some((2 * &outer[&(3, 1)]).into()),
            None => None, // constant along u
        };
        if let Some(higher) = higher {
            m.on(strip, register, register + crate::hdl::Sum::from(m.signal(higher)));
        }
    }
    outer
}

/// One column of the scheme: on `strip` it starts, on `step` each difference gains the next higher one
/// along v, the highest a constant. Returns the lowest: the samples.
fn column<const N: usize>(
    m: &Builder,
    name: &str,
    strip: &Signal,
    step: &Signal,
    start: [Signal; N],
    constant: Expr,
) -> Signal {
    let mut higher = constant;
    for (order, initial) in start.into_iter().enumerate().rev() {
        let difference = m.register(format!("{name}_{order}"), initial.word());
        m.on(strip, &difference, &initial);
        let sum = match higher {
            Expr::Signal(higher) => &difference + &higher,
            Expr::Sum(higher) => &difference + higher,
        };
        m.on(step, &difference, sum);
        higher = difference.into();
    }
    m.signal(higher)
}
