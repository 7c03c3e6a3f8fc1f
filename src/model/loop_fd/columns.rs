//! The fast way: forward differences in wrapping words, every column computed once.
//!
//! ```text
//!   outer registers N(k,l), at (i, 0)        column i starts from  N00 N01 N02 N03
//!     N00 N10 N20 N30                          l0 += l1   l1 += l2   l2 += l3   l3 += 2 N13
//!     N01 N11 N21 N31     step i -> i+1:     (old values on the right; N12, N13, N31 do not change)
//!     N02 N12             each gains the
//!     N03 N13             one to its right, N30 gains 2 N31
//! ```
//!
//! The engine is linear with integer coefficients: computed modulo 2^B, registers may overflow as they
//! please, and samples are exact because they fit in B = W + 4R + 4 bits. A column is differenced axis by axis
//! (five numbers, all in registers), then rounded in one sweep that the compiler puts into vectors.
//! Source: Bischoff, Kobbelt, Seidel 2000, section 3.3, without the three differences that are zero or twice
//! another (N22, N40, N04); start-up as in [`crate::surface::forward`].

use super::rounding::Rounding;
use crate::surface::word::Word;

/// Vertices that are differenced, then rounded, together.
const CHUNK: usize = 64;

/// The outer registers of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outer<W> {
    /// N00 N10 N20 N30
    pub row0: [W; 4],
    /// N01 N11 N21 N31
    pub row1: [W; 4],
    /// N02 N12
    pub row2: [W; 2],
    /// N03 N13
    pub row3: [W; 2],
}

impl<W: Word> Outer<W> {
    /// i -> i+1.
    #[inline(always)]
    fn step(&mut self) {
        for k in 0..3 {
            self.row0[k] = self.row0[k].plus(self.row0[k + 1]);
        }
        self.row0[3] = self.row0[3].plus(self.row1[3]).plus(self.row1[3]);
        for k in 0..3 {
            self.row1[k] = self.row1[k].plus(self.row1[k + 1]);
        }
        self.row2[0] = self.row2[0].plus(self.row2[1]);
        self.row3[0] = self.row3[0].plus(self.row3[1]);
    }
}

/// Walks over the columns of one patch after the other.
pub struct Columns<W, R> {
    rounding: R,
    axes: [Outer<W>; 3],
    /// N00 of the vertices at hand.
    samples: [[W; 3]; CHUNK],
}

impl<W: Word, R: Rounding<W>> Columns<W, R> {
    pub fn new(rounding: R) -> Self {
        Columns { rounding, axes: [Outer::default(); 3], samples: [[W::ZERO; 3]; CHUNK] }
    }

    /// Goes to column 0 of a patch.
    pub fn start(&mut self, level: u32, points: &[[W; 3]; 12]) {
        self.start_from([0, 1, 2].map(|x| differences(level, &points.map(|p| p[x]))));
    }

    /// Goes to column 0 of a patch with these differences.
    #[inline(always)]
    pub(super) fn start_from(&mut self, axes: [Outer<W>; 3]) {
        self.axes = axes;
        for axis in &mut self.axes {
            axis.row0[0] = axis.row0[0].plus(self.rounding.folded());
        }
    }

    /// Writes the column at hand, as many vertices as `column` has, and goes to the next one.
    #[inline]
    pub fn next(&mut self, column: &mut [[i64; 3]]) {
        let mut inner = self.axes.map(|axis| [axis.row0[0], axis.row1[0], axis.row2[0], axis.row3[0]]);
        for vertices in column.chunks_mut(CHUNK) {
            let samples = &mut self.samples[..vertices.len()];
            for x in 0..3 {
                let [mut l0, mut l1, mut l2, mut l3] = inner[x];
                let fourth = self.axes[x].row3[1].times(2);
                for sample in samples.iter_mut() {
                    sample[x] = l0;
                    (l0, l1, l2, l3) = (l0.plus(l1), l1.plus(l2), l2.plus(l3), l3.plus(fourth));
                }
                inner[x] = [l0, l1, l2, l3];
            }
            let rounding = self.rounding;
            for (y, &n00) in vertices.as_flattened_mut().iter_mut().zip(samples.as_flattened()) {
                *y = rounding.output(n00);
            }
        }
        self.axes.iter_mut().for_each(Outer::step);
    }

    /// Writes all (n+1)(n+2)/2 vertices of a patch, column after column.
    #[inline]
    pub fn patch(&mut self, level: u32, points: &[[W; 3]; 12], mut vertices: &mut [[i64; 3]]) {
        self.start(level, points);
        for length in (1..=(1usize << level) + 1).rev() {
            let (column, rest) = vertices.split_at_mut(length);
            self.next(column);
            vertices = rest;
        }
    }
}

/// Start-up, one axis: N00 N10 N20 N30 / N01 N11 N21 N31 / N02 N12 / N03 N13 at (0, 0), by shifts and adds.
#[inline(always)]
pub(super) fn differences<W: Word>(level: u32, p: &[W; 12]) -> Outer<W> {
    let second = |a: usize, b: usize, c: usize| p[a].plus(p[c]).minus(p[b].plus(p[b]));
    let (r_m, r_0, r_0p, r_1) = (second(0, 1, 2), second(3, 4, 5), second(4, 5, 6), second(7, 8, 9));
    let (s_m, s_0, s_0p, s_1) = (second(3, 7, 10), second(0, 4, 8), second(4, 8, 11), second(1, 5, 9));
    let c30 = r_m.plus(r_1).minus(r_0.plus(r_0));
    let c03 = s_m.plus(s_1).minus(s_0.plus(s_0));
    let (c21, c12) = (r_1.minus(r_0), s_1.minus(s_0));
    let g = r_0.plus(r_0p).minus(r_m).minus(r_1);
    let h = s_0.plus(s_0p).minus(s_m).minus(s_1);
    let (p10, p87, p53) = (p[1].minus(p[0]), p[8].minus(p[7]), p[5].minus(p[3]));
    let (p71, p80) = (p[7].minus(p[1]), p[8].minus(p[0]));
    let c11 = r_0.minus(p10).plus(p87);
    let c10 = p10.plus(p87).plus(p53.plus(p53));
    let c01 = p71.plus(p53).plus(p80.plus(p80));
    let c00 = p[0].plus(p[1]).plus(p[3]).plus(p[5]).plus(p[7]).plus(p[8]).plus(p[4].times(6));
    let [a, b, c, d] = [level, 2 * level, 3 * level, 4 * level];
    let at = |x: W, bits: u32| x.shifted_left(bits);
    let n10 =
        |c1: W, c2: W, c3: W, g: W| at(c1, c + 1).plus(at(c2.times(3), b + 1)).plus(at(c3, a + 1)).plus(g);
    let n20 = |c2: W, c3: W, g: W| at(c2, b).plus(at(c3, a)).times(12).plus(g.times(14));
    let n30 = |c3: W, g: W| at(c3, a).plus(g.times(3)).times(12);
    let n21 = |c21: W, g: W| at(c21, a).plus(g).times(12);
    let n11 = at(c11, b).plus(at(c21.plus(c12), a)).times(6).plus(g.plus(h).times(2));
    Outer {
        row0: [at(c00, d), n10(c10, r_0, c30, g), n20(r_0, c30, g), n30(c30, g)],
        row1: [n10(c01, s_0, c03, h), n11, n21(c21, g), g.times(12)],
        row2: [n20(s_0, c03, h), n21(c12, h)],
        row3: [n30(c03, h), h.times(12)],
    }
}
