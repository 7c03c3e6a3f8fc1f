//! The fast way: forward differences in wrapping words, every column computed once, two at a time.
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
//! please, and samples are exact because they fit in B = W + 4R + 4 bits. Two columns and three axes make
//! six independent lanes, which the compiler puts into vectors.
//! Source: Bischoff, Kobbelt, Seidel 2000, section 3.3, without the three differences that are zero or twice
//! another (N22, N40, N04); start-up as in [`crate::surface::forward`].

use super::rounding::Rounding;
use crate::surface::word::Word;

/// One number per axis.
type Triple<W> = [W; 3];

/// Two columns side by side: x, y, z of the left one, x, y, z of the right one.
const LANES: usize = 6;

/// Walks over the columns of one patch.
pub struct Columns<'a, W, R> {
    rounding: &'a R,
    /// N00 N10 N20 N30; N01 N11 N21 N31; N02 N12; N03 N13.
    row0: [Triple<W>; 4],
    row1: [Triple<W>; 4],
    row2: [Triple<W>; 2],
    row3: [Triple<W>; 2],
}

impl<'a, W: Word, R: Rounding<W>> Columns<'a, W, R> {
    /// Starts before column 0 of a patch of level `level`.
    pub fn new(level: u32, points: &[Triple<W>; 12], rounding: &'a R) -> Self {
        let mut columns = Columns {
            rounding,
            row0: [[W::ZERO; 3]; 4],
            row1: [[W::ZERO; 3]; 4],
            row2: [[W::ZERO; 3]; 2],
            row3: [[W::ZERO; 3]; 2],
        };
        for axis in 0..3 {
            let n = differences(level, &points.map(|p| p[axis]));
            (0..4).for_each(|k| columns.row0[k][axis] = n[0][k]);
            (0..4).for_each(|k| columns.row1[k][axis] = n[1][k]);
            (0..2).for_each(|k| columns.row2[k][axis] = n[2][k]);
            (0..2).for_each(|k| columns.row3[k][axis] = n[3][k]);
            columns.row0[0][axis] = n[0][0].plus(rounding.folded());
        }
        columns
    }

    /// l0..l3 of the column at hand.
    #[inline(always)]
    fn column(&self) -> [Triple<W>; 4] {
        [self.row0[0], self.row1[0], self.row2[0], self.row3[0]]
    }

    /// Goes on to the next column.
    #[inline(always)]
    fn step(&mut self) {
        for x in 0..3 {
            let twice_n31 = self.row1[3][x].plus(self.row1[3][x]);
            for k in 0..3 {
                self.row0[k][x] = self.row0[k][x].plus(self.row0[k + 1][x]);
                self.row1[k][x] = self.row1[k][x].plus(self.row1[k + 1][x]);
            }
            self.row0[3][x] = self.row0[3][x].plus(twice_n31);
            self.row2[0][x] = self.row2[0][x].plus(self.row2[1][x]);
            self.row3[0][x] = self.row3[0][x].plus(self.row3[1][x]);
        }
    }

    /// Writes the next two columns, of n-i+1 and n-i vertices (the second is empty after the last column).
    #[inline(always)]
    pub fn next_pair(&mut self, left: &mut [[i64; 3]], right: &mut [[i64; 3]]) {
        let first = self.column();
        self.step();
        let second = self.column();
        self.step();
        let mut l: [[W; LANES]; 4] = std::array::from_fn(|m| {
            std::array::from_fn(|lane| if lane < 3 { first[m][lane] } else { second[m][lane - 3] })
        });
        let fourth: [W; LANES] =
            std::array::from_fn(|lane| self.row3[1][lane % 3].plus(self.row3[1][lane % 3]));
        let (last, body) = match left.split_last_mut() {
            Some(split) => split,
            None => return,
        };
        for (left, right) in body.iter_mut().zip(right) {
            let y: [i64; LANES] = std::array::from_fn(|lane| self.rounding.output(l[0][lane]));
            [*left, *right] = [[y[0], y[1], y[2]], [y[3], y[4], y[5]]];
            for lane in 0..LANES {
                l[0][lane] = l[0][lane].plus(l[1][lane]);
                l[1][lane] = l[1][lane].plus(l[2][lane]);
                l[2][lane] = l[2][lane].plus(l[3][lane]);
                l[3][lane] = l[3][lane].plus(fourth[lane]);
            }
        }
        *last = std::array::from_fn(|x| self.rounding.output(l[0][x]));
    }

    /// Writes all (n+1)(n+2)/2 vertices of the patch, column after column.
    #[inline(always)]
    pub fn all(&mut self, level: u32, mut vertices: &mut [[i64; 3]]) {
        let n = 1usize << level;
        for i in (0..=n).step_by(2) {
            let (left, rest) = vertices.split_at_mut(n - i + 1);
            let (right, rest) = rest.split_at_mut(n - i);
            self.next_pair(left, right);
            vertices = rest;
        }
    }
}

/// Start-up, one axis: N00 N10 N20 N30 / N01 N11 N21 N31 / N02 N12 / N03 N13 at (0, 0), by shifts and adds.
#[inline(always)]
fn differences<W: Word>(level: u32, p: &[W; 12]) -> [[W; 4]; 4] {
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
    [
        [at(c00, d), n10(c10, r_0, c30, g), n20(r_0, c30, g), n30(c30, g)],
        [n10(c01, s_0, c03, h), n11, n21(c21, g), g.times(12)],
        [n20(s_0, c03, h), n21(c12, h), W::ZERO, W::ZERO],
        [n30(c03, h), h.times(12), W::ZERO, W::ZERO],
    ]
}
