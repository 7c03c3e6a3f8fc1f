//! One coordinate of the limit tangents at the end of a column, of any valence.
//!
//! ```text
//!            a_1   x_2   a_2          t1 = sum A_d C_i A_i + (C_i + C_i+1) D_i,   C_i = cos(2 pi i / d)
//!      x_1 ╲   │    │    │   ╱ x_d-2  t2 the same with sines;  A_0 the neighbour within the column, from there on
//!    a_0 ───── S ─────────── a_d-2    counterclockwise, D_i between A_i and A_i+1
//!      x_0     │         x_d-1
//!            inner                    A_d = 1 + C_1 + cos(pi / d) sqrt(2 (9 + C_1))
//! ```
//!
//! Around the axis through S and the inner neighbour cosines are even and sines odd, so that the vertices that
//! mirror each other are added or subtracted first and share a multiplier: a_j and a_{d-2-j}, x_j and x_{d-1-j}.
//!
//! Weights are integers over 2^16. Those of a valence are scaled so that the absolute values of either tangent add
//! up to 12 at most, as those of valence 4 do, (1 4 1) by (-1 0 1): these are exact. The weight of the inner
//! neighbour is what makes the sum zero, so the origin does not matter. A tangent is rounded half up to
//! the unit of the points. Source: Halstead, Kass, DeRose 1993, appendix A.

use std::f64::consts::TAU;

use super::fan::End;
use super::finish::{Parameters, stage};
use super::view::EndView;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Relation, Signal, Sum, Word};

/// Fraction bits of the weights.
pub const WEIGHT_BITS: u32 = 16;

/// Clocks from the points to the tangents and the registers that take them.
pub const LATENCY: u32 = 2;

/// The weights of one valence over 2^[`WEIGHT_BITS`]: of the pair a_j, a_{d-2-j} and of x_j, x_{d-1-j} in both tangents.
struct Weights {
    inner: i128,
    neighbours: Vec<[i128; 2]>,
    diagonals: Vec<[i128; 2]>,
}

impl Weights {
    fn of(d: u32) -> Weights {
        let angle = TAU / f64::from(d);
        let factor = 1.0 + angle.cos() + (angle / 2.0).cos() * (2.0 * (9.0 + angle.cos())).sqrt();
        let half = 2.0 * (angle / 2.0).cos();
        let at = |scale: f64, place: f64| [scale * (angle * place).cos(), scale * (angle * place).sin()];
        let neighbours: Vec<[f64; 2]> = (0..d).map(|i| at(factor, f64::from(i))).collect();
        // C_i + C_i+1 = 2 cos(pi / d) cos(2 pi (i + 1/2) / d)
        let diagonals: Vec<[f64; 2]> = (0..d).map(|i| at(half, f64::from(i) + 0.5)).collect();
        let length = |t: usize| neighbours.iter().chain(&diagonals).map(|w| w[t].abs()).sum::<f64>();
        // Rounding must not lengthen them beyond 12.
        let goal = if d == 4 { 12.0 } else { 12.0 - 1.0 / 256.0 };
        let scale = goal / length(0).max(length(1)) * f64::from(1 << WEIGHT_BITS);
        let rounded = |w: &[f64; 2]| w.map(|w| (w * scale).round() as i128);
        let neighbours: Vec<[i128; 2]> = neighbours.iter().map(rounded).collect();
        let diagonals: Vec<[i128; 2]> = diagonals.iter().map(rounded).collect();
        let others = neighbours[1..].iter().chain(&diagonals).map(|w| w[0]).sum::<i128>();
        // A_{j+1} is a_j; the diagonal D_j is x_j.
        Weights { inner: -others, neighbours: neighbours[1..].to_vec(), diagonals }
    }
}

/// Both tangents one clock later, t1 x t2 outwards.
pub fn tangents(m: &Builder, p: Parameters, end: End, view: &EndView, advance: &Signal) -> [Signal; 2] {
    let point = p.point().unwrap_or(p.word);
    let name = |what: &str| format!("{}_{what}", end.name());
    let valence = &view.valence;
    let weights: Vec<(u32, Weights)> = (3..=p.max_valence).map(|d| (d, Weights::of(d))).collect();
    // The entry of the valence, registered.
    let weight = |what: &str, of: &dyn Fn(u32, &Weights) -> i128| {
        let entries: Vec<i128> = weights.iter().map(|(d, weights)| of(*d, weights)).collect();
        let range = entries.iter().fold(Range::point(0), |range, &w| range.union(Range::point(w)));
        let entry = |w: i128| m.constant(w, range.into());
        let chosen =
            weights.iter().zip(&entries).skip(1).fold(m.signal(entry(entries[0])), |chosen, ((d, _), &w)| {
                m.select(&m.is(valence, (*d).into()), entry(w), &chosen)
            });
        stage(m, advance, name(&format!("weight_{what}")), &chosen)
    };
    let centre = stage(m, advance, name("inner_kept"), &view.inner[1]);
    let mut sums = [vec![(weight("inner", &|_, w| w.inner), centre)], vec![]];
    let mut add = |what: &str, pair: [Signal; 2], of: &dyn Fn(u32, &Weights) -> [i128; 2]| {
        let [left, right] = &pair;
        let (even, odd) = match end {
            End::Top => (left + right, right - left),
            End::Bottom => (left + right, left - right),
        };
        for (t, sum) in [even, odd].into_iter().enumerate() {
            // A vertex that is only ever the one in the middle has no sine.
            if weights.iter().all(|(d, weights)| of(*d, weights)[t] == 0) {
                continue;
            }
            let what = format!("{what}_{}", ["even", "odd"][t]);
            let sum = stage(m, advance, name(&what), &m.signal(sum));
            sums[t].push((weight(&what, &|d, w| of(d, w)[t]), sum));
        }
    };
    let mirrored = Mirrored { m, p, view };
    for j in 0..=(p.max_valence as usize - 2) / 2 {
        let there = move |d: u32| 2 * j + 2 <= d as usize;
        add(&format!("a_{j}"), mirrored.neighbours(j), &|d, w| {
            if there(d) { w.neighbours[j] } else { [0; 2] }
        });
    }
    for j in 0..=(p.max_valence as usize - 1) / 2 {
        let there = move |d: u32| 2 * j < d as usize;
        add(&format!("x_{j}"), mirrored.diagonals(j), &|d, w| if there(d) { w.diagonals[j] } else { [0; 2] });
    }
    // Half the sum of the weights' absolute values, times how far apart points can be.
    let s = point.range.max - point.range.min;
    let bound = (6 * s) << WEIGHT_BITS;
    [0, 1].map(|t| {
        let products: Vec<Signal> = sums[t].iter().map(|(weight, sum)| m.product(sum, weight)).collect();
        let sum = m.signal(Sum::weighted(products.iter().map(|product| (1, product))));
        let word = Word { range: Range::new(-bound, bound), ..sum.word() };
        let sum = m.claim(&name(&format!("tangent_{}", t + 1)), &sum, word, None);
        let over = m.rescale(&sum, point.fraction + WEIGHT_BITS as i32);
        m.round(&over, WEIGHT_BITS, Rounding::HalfUp)
    })
}

/// The vertices around an end in pairs; what the valence has not is zero, and so is the partner of the one in the middle.
struct Mirrored<'a> {
    m: &'a Builder,
    p: Parameters,
    view: &'a EndView,
}

impl Mirrored<'_> {
    fn zero(&self) -> Signal {
        let word = self.view.before.word();
        self.m.constant(0, Word { range: Range::point(0), ..word })
    }

    /// The signal where the valence is d at least.
    fn from(&self, d: usize, signal: &Signal) -> Signal {
        let valence = &self.view.valence;
        let least = self.m.constant(d as i128, valence.word());
        self.m.select(&self.m.compare(Relation::LessOrEqual, least, valence), signal, self.zero())
    }

    /// The partner that each valence from `first` on has.
    fn partner(&self, first: usize, of: impl Fn(usize) -> Signal) -> Signal {
        (first..=self.p.max_valence as usize).fold(self.zero(), |chosen, d| {
            self.m.select(&self.m.is(&self.view.valence, d as i128), of(d), &chosen)
        })
    }

    /// a_j and a_{d-2-j}.
    fn neighbours(&self, j: usize) -> [Signal; 2] {
        let [left, _, right] = &self.view.outer;
        let a = &self.view.neighbours;
        match j {
            0 => [left.clone(), right.clone()],
            _ => [self.from(2 * j + 2, &a[j - 1]), self.partner(2 * j + 3, |d| a[d - 3 - j].clone())],
        }
    }

    /// x_j and x_{d-1-j}.
    fn diagonals(&self, j: usize) -> [Signal; 2] {
        let [left, _, right] = &self.view.inner;
        let x = &self.view.diagonals;
        match j {
            0 => [left.clone(), right.clone()],
            1 => [self.view.before.clone(), self.from(4, &self.view.after)],
            _ => [self.from(2 * j + 1, &x[j - 2]), self.partner(2 * j + 2, |d| x[d - 3 - j].clone())],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_valence_four_are_the_bicubic_spline_and_all_are_bounded() {
        let four = Weights::of(4);
        let unit = 1 << WEIGHT_BITS;
        assert_eq!(four.inner, 4 * unit);
        assert_eq!(four.neighbours, [[0, 4 * unit], [-4 * unit, 0], [0, -4 * unit]]);
        assert_eq!(four.diagonals, [[unit, unit], [-unit, unit], [-unit, -unit], [unit, -unit]]);
        for d in 3..=16 {
            let weights = Weights::of(d);
            for t in 0..2 {
                let all = weights.neighbours.iter().chain(&weights.diagonals).map(|w| w[t]);
                let inner = if t == 0 { weights.inner } else { 0 };
                assert_eq!(all.clone().sum::<i128>() + inner, 0, "valence {d}");
                let length = all.map(i128::abs).sum::<i128>() + inner.abs();
                assert!(length <= 12 * unit, "valence {d}: {length}");
            }
        }
    }
}
