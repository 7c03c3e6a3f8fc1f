//! Formats with fewer bits than exact ones: rounded differences, added up.
//!
//! ```text
//!   start-up   D(k,l) = rnd(N(k,l) / (3 * 2^s)),  s = 4R + 2 - F_m,  m = k + l     in units of 2^-F_m
//!   an add     D of order m  +=  rnd(D of order m+1 / 2^t),  t = F_(m+1) - F_m     nothing to round if t = 0
//!   a vertex   y = floor(D00 / 2^(F_0 - f) + 1/2), put back into W + f bits if saturated
//! ```
//!
//! All patches share the denominator 12 * 16^R, so the start-up is the same at every level: N is exact, and
//! only its division by 12 * 16^R rounds. Differences that no vertex of a patch depends on (order 2 and up
//! at level 0, 3 and up at level 1) are left out: they can be larger than all others.
//! The adds are those of [`super::columns`], in its order.

use super::LoopFd;
use super::columns::{self as exact, Outer, differences};
use super::rounding::{ByDivision, ByMultiplication, Rounding as FinalRounding};
use crate::fixed::{Reduced, Rounding};
use crate::surface::word::Word;

/// N(k,l) of one patch, exact over 12 * 16^R, by axis and in the order
/// (0,0) (1,0) (2,0) (3,0) (0,1) (1,1) (2,1) (3,1) (0,2) (1,2) (0,3) (1,3).
pub type Numerators = [[i128; 12]; 3];

/// The exact start-up, which no format changes: sweeps keep it.
pub fn numerators(level: u32, points: &[[i128; 3]; 12]) -> Numerators {
    [0, 1, 2].map(|x| list(&differences(level, &points.map(|p| p[x]))))
}

/// Walks over the columns of one patch after the other.
pub trait Walk {
    /// Goes to column 0 of a patch with these control points.
    fn start(&mut self, level: u32, points: &[[i128; 3]; 12]) {
        self.start_from(level, &numerators(level, points));
    }

    /// Goes to column 0 of a patch with these differences.
    fn start_from(&mut self, level: u32, numerators: &Numerators);

    /// Writes the column at hand, as many vertices as `column` has, and goes to the next one.
    fn next(&mut self, column: &mut [[i64; 3]]);
}

/// The columns of a core with reduced numbers; nothing for an exact core.
pub fn columns(core: &LoopFd) -> Option<Box<dyn Walk>> {
    let reduced = core.precision().reduced()?;
    let fractions = reduced.fractions;
    // N of a live difference lies in W + 4R + 5 bits, a register in W + 2 + F; a few bits more for sums.
    let highest = core.word_bits().max(core.width() + fractions.of(4)) + 4;
    let narrow = highest < i64::BITS && fractions.of(4) <= 4 * core.max_level() + 1;
    Some(if narrow { by_mode::<i64>(core, reduced) } else { by_mode::<i128>(core, reduced) })
}

fn by_mode<W: Word>(core: &LoopFd, reduced: Reduced) -> Box<dyn Walk> {
    match reduced.rounding {
        _ if reduced.fractions.is_uniform() => Box::new(Columns::<W, Nothing>::new(core, reduced, Nothing)),
        Rounding::HalfUp | Rounding::Exact => Box::new(Columns::<W, HalfUp>::new(core, reduced, HalfUp)),
        Rounding::HalfEven => Box::new(Columns::<W, HalfEven>::new(core, reduced, HalfEven)),
        Rounding::Floor => Box::new(Columns::<W, Floor>::new(core, reduced, Floor)),
        Rounding::Truncate => Box::new(Columns::<W, Truncate>::new(core, reduced, Truncate)),
    }
}

/// How an addend loses bits; a type for each mode, so that a column is one plain loop.
trait Lose: Copy {
    fn lose<W: Word>(self, value: W, bits: u32) -> W;
}

/// There are no bits to lose.
#[derive(Clone, Copy)]
struct Nothing;
#[derive(Clone, Copy)]
struct HalfUp;
#[derive(Clone, Copy)]
struct HalfEven;
#[derive(Clone, Copy)]
struct Floor;
#[derive(Clone, Copy)]
struct Truncate;

impl Lose for Nothing {
    #[inline(always)]
    fn lose<W: Word>(self, value: W, _: u32) -> W {
        value
    }
}

impl Lose for HalfUp {
    #[inline(always)]
    fn lose<W: Word>(self, value: W, bits: u32) -> W {
        let half = W::narrow(1).shifted_left(bits).shifted_right(1);
        value.plus(half).shifted_right(bits)
    }
}

impl Lose for HalfEven {
    #[inline(always)]
    fn lose<W: Word>(self, value: W, bits: u32) -> W {
        if bits == 0 {
            return value;
        }
        let below_half = W::narrow(1).shifted_left(bits - 1).minus(W::narrow(1));
        value.plus(below_half).plus(odd(value.shifted_right(bits))).shifted_right(bits)
    }
}

impl Lose for Floor {
    #[inline(always)]
    fn lose<W: Word>(self, value: W, bits: u32) -> W {
        value.shifted_right(bits)
    }
}

impl Lose for Truncate {
    #[inline(always)]
    fn lose<W: Word>(self, value: W, bits: u32) -> W {
        // -1 or 0; a negative number is lifted by 2^bits - 1.
        let sign = value.shifted_right(W::BITS - 1);
        value.plus(sign.minus(sign.shifted_left(bits))).shifted_right(bits)
    }
}

/// The lowest bit.
#[inline(always)]
fn odd<W: Word>(value: W) -> W {
    value.minus(value.shifted_right(1).shifted_left(1))
}

struct Columns<W, L> {
    reduced: Reduced,
    lose: L,
    /// 4R + 2.
    exact_fraction: u32,
    /// F_0 - f.
    last: u32,
    /// The ends of the output format.
    ends: Option<[i64; 2]>,
    axes: [Outer<W>; 3],
}

impl<W: Word, L: Lose> Columns<W, L> {
    fn new(core: &LoopFd, reduced: Reduced, lose: L) -> Self {
        let top = 1i64 << (core.output_bits() - 1);
        Columns {
            reduced,
            lose,
            exact_fraction: 4 * core.max_level() + 2,
            last: (i64::from(reduced.fractions.of(0)) - i64::from(core.extra_fraction())) as u32,
            ends: reduced.saturate.then_some([-top, top - 1]),
            axes: [Outer::default(); 3],
        }
    }

    /// N / (12 * 16^R) * 2^F, rounded.
    fn rounded(&self, numerator: W, order: usize) -> W {
        // As many bits are appended as make the unit 3 * 2^s even.
        let fraction = self.reduced.fractions.of(order);
        let appended = (fraction + 1).saturating_sub(self.exact_fraction);
        let shift = self.exact_fraction + appended - fraction;
        let n = numerator.shifted_left(appended);
        let unit = W::narrow(3).shifted_left(shift);
        let half = unit.shifted_right(1);
        let floor = |n: W| n.shifted_right(shift).third();
        match self.reduced.rounding {
            Rounding::HalfUp | Rounding::Exact => floor(n.plus(half)),
            Rounding::HalfEven => {
                let up = floor(n.plus(half));
                let tie = n.plus(half) == up.times(3).shifted_left(shift);
                if tie { up.minus(odd(up)) } else { up }
            }
            Rounding::Floor => floor(n),
            Rounding::Truncate => {
                let lift = if n.wide() < 0 { unit.minus(W::narrow(1)) } else { W::ZERO };
                floor(n.plus(lift))
            }
        }
    }

    #[inline(always)]
    fn addend(&self, higher: W, order: usize) -> W {
        self.lose.lose(higher, self.reduced.fractions.dropped(order))
    }

    /// i -> i+1.
    fn step(&mut self) {
        let mut axes = self.axes;
        for axis in &mut axes {
            let old = *axis;
            for k in 0..3 {
                axis.row0[k] = old.row0[k].plus(self.addend(old.row0[k + 1], k));
                axis.row1[k] = old.row1[k].plus(self.addend(old.row1[k + 1], k + 1));
            }
            axis.row0[3] = old.row0[3].plus(self.addend(old.row1[3].times(2), 3));
            axis.row2[0] = old.row2[0].plus(self.addend(old.row2[1], 2));
            axis.row3[0] = old.row3[0].plus(self.addend(old.row3[1], 3));
        }
        self.axes = axes;
    }
}

impl<W: Word, L: Lose> Walk for Columns<W, L> {
    fn start_from(&mut self, level: u32, numerators: &Numerators) {
        let highest_live = [1, 2].get(level as usize).copied().unwrap_or(4);
        let mut axes = [Outer::default(); 3];
        for (axis, exact) in axes.iter_mut().zip(numerators) {
            let difference = |index: usize, order: usize| match order <= highest_live {
                true => self.rounded(W::narrow(exact[index]), order),
                false => W::ZERO,
            };
            const ORDERS: [usize; 12] = [0, 1, 2, 3, 1, 2, 3, 4, 2, 3, 3, 4];
            *axis = outer(&std::array::from_fn(|index| difference(index, ORDERS[index])));
        }
        self.axes = axes;
    }

    fn next(&mut self, column: &mut [[i64; 3]]) {
        let half = W::narrow(1).shifted_left(self.last).shifted_right(1);
        for (x, axis) in self.axes.iter().enumerate() {
            let [mut l0, mut l1, mut l2, mut l3] = [axis.row0[0], axis.row1[0], axis.row2[0], axis.row3[0]];
            let fourth = self.addend(axis.row3[1].times(2), 3);
            for vertex in column.iter_mut() {
                vertex[x] = l0.plus(half).shifted_right(self.last).wide() as i64;
                let [a0, a1, a2] = [self.addend(l1, 0), self.addend(l2, 1), self.addend(l3, 2)];
                (l0, l1, l2, l3) = (l0.plus(a0), l1.plus(a1), l2.plus(a2), l3.plus(fourth));
            }
        }
        if let Some([least, most]) = self.ends {
            column.as_flattened_mut().iter_mut().for_each(|y| *y = (*y).clamp(least, most));
        }
        self.step();
    }
}

/// The columns of any core.
pub fn columns_of_any(core: &LoopFd) -> Box<dyn Walk> {
    match (columns(core), ByMultiplication::new(core)) {
        (Some(columns), _) => columns,
        (None, Some(rounding)) => Box::new(ExactColumns(exact::Columns::<i64, _>::new(rounding))),
        (None, None) => Box::new(ExactColumns(exact::Columns::<i128, _>::new(ByDivision::new(core)))),
    }
}

struct ExactColumns<C>(C);

impl<W: Word, R: FinalRounding<W>> Walk for ExactColumns<exact::Columns<W, R>> {
    fn start_from(&mut self, _: u32, numerators: &Numerators) {
        self.0.start_from(numerators.map(|n| outer(&n.map(W::narrow))));
    }

    fn next(&mut self, column: &mut [[i64; 3]]) {
        self.0.next(column);
    }
}

fn outer<W: Word>(n: &[W; 12]) -> Outer<W> {
    let [a, b, c, d, e, f, g, h, i, j, k, l] = *n;
    Outer { row0: [a, b, c, d], row1: [e, f, g, h], row2: [i, j], row3: [k, l] }
}

fn list<W: Word>(outer: &Outer<W>) -> [W; 12] {
    let (a, b, c, d) = (outer.row0, outer.row1, outer.row2, outer.row3);
    [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], c[0], c[1], d[0], d[1]]
}
