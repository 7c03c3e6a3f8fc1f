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
//!
//! Exact differences of order 2 are kept without their lowest bit, those of orders 3 and 4 without their lowest two,
//! which are always zero. In a reduced format each order has its own width and fraction; an add brings its addend to them first.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::{Parameters, RegisterForm, vertex, words};
use crate::cores::rounder::{self, Division, Rounder};
use crate::error::Result;
use crate::fixed::{Precision, Rounding};
use crate::hdl::{Builder, Expr, Module, Signal, Sum, Word};

/// (k, l) of the twelve differences that a start-up computes, in the order of the ports.
pub const DIFFERENCES: [(u32, u32); 12] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1), (0, 2), (1, 2), (0, 3), (1, 3)];

type Table = BTreeMap<(u32, u32), Signal>;

/// What a difference of order m gains: one of order m + 1, or twice that.
#[derive(Clone)]
pub(super) struct Higher {
    of: Signal,
    doubled: bool,
}

impl Higher {
    fn once(of: &Signal) -> Self {
        Higher { of: of.clone(), doubled: false }
    }

    pub(super) fn twice(of: &Signal) -> Self {
        Higher { of: of.clone(), doubled: true }
    }

    /// The addend of a difference of this order. In a reduced format it is read as a number, which a word of
    /// fewer integer bits than its own cannot tell apart from the difference of another patch.
    fn addend(&self, m: &Builder, parameters: Parameters, order: u32) -> Sum {
        let factor = if self.doubled { 2 } else { 1 };
        let Some(reduced) = parameters.precision.reduced() else {
            let zeros = words::low_zeros(order + 1) - words::low_zeros(order);
            let of = number(m, parameters, &self.of, order + 1);
            return (factor << zeros) * &of;
        };
        let word = self.of.word();
        let number = m.wrap(&self.of, Word { modular: false, ..word });
        let dropped = reduced.fractions.dropped(order as usize);
        if dropped == 0 {
            return factor * &number;
        }
        let (drop, fraction) = (dropped - u32::from(self.doubled), word.fraction - dropped as i32);
        let point = |signal: &Signal| m.rescale(signal, fraction);
        match reduced.rounding {
            // floor(x / 2^t + 1/2) is floor(x / 2^t) and the highest bit that is lost: a carry into the adder.
            Rounding::HalfUp if drop > 0 => {
                let carry = m.slice(&number, drop - 1, 1);
                &point(&m.round(&number, drop, Rounding::Floor)) + &point(&carry)
            }
            mode => Sum::from(&point(&m.round(&number, drop, mode))),
        }
    }
}

/// One coordinate: `n..` are taken at `capture` and wait; `load` moves them into the outer differences;
/// `strip` starts a strip and steps the outer differences; `step` goes one row up. `left` and `right` are
/// the rounded vertices of the row, `valid` and `pair` say which of them mean anything.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("difference_engine");
    let form = parameters.registers;
    m.purpose("Forward differences of one coordinate: a pair of vertices of a triangle strip per clock.");
    m.parameter("registers", form);
    match parameters.precision {
        Precision::Exact => m.parameter("modulus", format!("2^{}", parameters.modulus())),
        reduced => m.parameter("differences", reduced),
    }
    let [capture, load, strip, step] =
        ["capture", "load", "strip", "step"].map(|name| m.input(name, Word::bit()));
    let [valid, pair] = ["valid", "pair"].map(|name| m.input(name, Word::bit()));

    let mut waiting: Table = BTreeMap::new();
    for (k, l) in DIFFERENCES {
        let n = m.input(format!("n{k}{l}"), parameters.difference((k, l)));
        let register = m.register(format!("waiting_{k}{l}"), n.word());
        m.on(&capture, &register, &n);
        waiting.insert((k, l), register);
    }

    let outer = outer_differences(&m, parameters, &waiting, &load, &strip);
    let fourth = match outer.get(&(0, 4)) {
        Some(d04) => Higher { of: d04.clone(), doubled: parameters.precision != Precision::Exact },
        None => Higher::twice(&outer[&(1, 3)]),
    };
    let columns = Columns { m: &m, parameters, strip: &strip, step: &step };
    let last = [0, 1, 2, 3].map(|l| outer[&(0, l)].clone());
    let left = columns.column("left", last, 0, fourth.clone());
    let right = if form == RegisterForm::Relative19 {
        // r - l has the differences of the next column's polynomial less this one's: D10, D11, D12, D13.
        let gap = [0, 1, 2].map(|l| outer[&(1, l)].clone());
        let gap = columns.column("gap", gap, 1, Higher::once(&outer[&(1, 3)]));
        m.pipe("right", &left + Higher::once(&gap).addend(&m, parameters, 0))
    } else {
        let next = [0, 1, 2, 3].map(|l| {
            let gain = Higher::once(&outer[&(1, l)]).addend(&m, parameters, l);
            m.wire(format!("next_0{l}"), &outer[&(0, l)] + gain)
        });
        columns.column("right", next, 0, fourth)
    };

    let rounder = match parameters.precision {
        Precision::Exact => rounder::build(Rounder {
            modulus: parameters.modulus(),
            shift: parameters.shift(),
            result: parameters.output_range(),
            fraction: parameters.output_fraction,
            division: if parameters.chunk.is_some() { Division::Digits } else { Division::Reciprocal },
            halved: false,
        })?,
        Precision::Reduced(reduced) => vertex::build(parameters, reduced)?,
    };
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
    let mut start: BTreeMap<(u32, u32), Expr> = waiting.iter().map(|(&kl, n)| (kl, n.into())).collect();
    if matches!(parameters.registers, RegisterForm::Published23 | RegisterForm::WithoutZero22) {
        // In a reduced format their lowest bit, which is always zero, is left out.
        let twice = |kl: (u32, u32)| -> Expr {
            match parameters.precision {
                Precision::Exact => (2 * &number(m, parameters, &waiting[&kl], 4)).into(),
                Precision::Reduced(_) => (&waiting[&kl]).into(),
            }
        };
        start.insert((4, 0), twice((3, 1)));
        start.insert((0, 4), twice((1, 3)));
    }
    if parameters.registers == RegisterForm::Published23 {
        start.insert((2, 2), m.constant(0, parameters.difference((2, 2))).into());
    }
    let outer: Table = start
        .keys()
        .map(|&(k, l)| ((k, l), m.register(format!("d{k}{l}"), parameters.difference((k, l)))))
        .collect();
    for (&(k, l), register) in &outer {
        m.on(load, register, start[&(k, l)].clone());
        let higher = match outer.get(&(k + 1, l)) {
            Some(d40) if (k, l) == (3, 0) => {
                Some(Higher { of: d40.clone(), doubled: parameters.precision != Precision::Exact })
            }
            Some(higher) => Some(Higher::once(higher)),
            None if (k, l) == (3, 0) => Some(Higher::twice(&outer[&(3, 1)])),
            None => None, // constant along u
        };
        if let Some(higher) = higher {
            m.on(strip, register, register + higher.addend(m, parameters, k + l));
        }
    }
    outer
}

/// An exact difference of this order as what it stands for: where its word is narrower than the modulus, a number.
fn number(m: &Builder, parameters: Parameters, of: &Signal, order: u32) -> Signal {
    let narrow = of.width() + words::low_zeros(order) < parameters.modulus();
    if narrow { m.wrap(of, Word::signed(of.width())) } else { of.clone() }
}

/// Makes the running columns.
pub(super) struct Columns<'a> {
    pub(super) m: &'a Builder,
    pub(super) parameters: Parameters,
    pub(super) strip: &'a Signal,
    pub(super) step: &'a Signal,
}

impl Columns<'_> {
    /// One column of the scheme: on `strip` it starts, on `step` each difference gains the next higher one
    /// along v, the highest a constant. Returns the lowest, of order `lowest`: the samples.
    pub(super) fn column<const N: usize>(
        &self,
        name: &str,
        start: [Signal; N],
        lowest: u32,
        constant: Higher,
    ) -> Signal {
        let mut higher = constant;
        for (nth, initial) in start.into_iter().enumerate().rev() {
            let difference = self.m.register(format!("{name}_{nth}"), initial.word());
            self.m.on(self.strip, &difference, &initial);
            let addend = higher.addend(self.m, self.parameters, lowest + nth as u32);
            self.m.on(self.step, &difference, &difference + addend);
            higher = Higher::once(&difference);
        }
        higher.of
    }
}
