//! Control points whose start-up errors all push one vertex the same way.
//!
//! ```text
//!   the error of p(n, 0) in a uniform format, in units of 2^-F:
//!     e00 + n e10 + C(n,2) e20 + C(n,3) e30 + 2 C(n,4) e31,      e = rnd(N / M) - N / M,  M = 3 * 2^(4r+2-F)
//!
//!   N31 = 12 G                           so each e depends on a remainder modulo M of
//!   N30 = 12 a C30 + 36 G                a few integers: G first, which weighs most, then C30, C20;
//!   N20 = 12 b C20 + 12 a C30 + 14 G     a linear congruence gives the integer of each
//!   N10 = 2 c C10 + 6 b C20 + 2 a C30 + G           wanted remainder  (a, b, c = 2^r, 4^r, 8^r)
//! ```
//!
//! Random points never come near the bound, as their errors cancel. A beam of the best partial choices is
//! kept, and of the points that share G, C30 and C20 those are taken whose last rounding is the most
//! unlucky, too. The matrix is that of [`crate::surface::forward`].

use crate::error::{Error, Result};
use crate::fixed::{Reduced, Rounding};
use crate::surface::basis;
use crate::surface::control_mesh::ControlMesh;

/// Twelve control points, one axis, and what they do to p(n, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorstCase {
    /// P0..P11, numbered as in [`crate::surface::regular`].
    pub points: [i64; 12],
    /// Computed less exact D00 at (n, 0), over 2^F M.
    pub error: i128,
    /// M = 3 * 2^(4r + 2 - F).
    pub unit: i128,
}

impl WorstCase {
    /// The error before the final rounding, in units of the control coordinates.
    pub fn error_lsb(&self, fraction: u32) -> f64 {
        self.error as f64 / (self.unit as f64 * f64::from(fraction).exp2())
    }
}

/// The side to which a vertex is pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Above,
    Below,
}

/// Points of `width` bits that push p(n, 0) of a patch of this level as far to one side as their search finds;
/// nothing where no such points fit, or the format is as fine as exact numbers.
pub fn points(reduced: Reduced, level: u32, width: u32, side: Side) -> Option<WorstCase> {
    let fraction = reduced.fractions.of(4);
    let shift = (4 * level + 2).checked_sub(fraction).filter(|&s| s > 0 && level > 0)?;
    let [a, b] = [1i128 << level, 1 << (2 * level)];
    let n = a;
    let choose = |k: i128| (0..k).fold(1, |c, x| c * (n - x) / (x + 1));
    let search = Search { rounding: reduced.rounding, unit: 3 << shift, side, limit: 1 << (width - 3) };

    let start = Choice { numbers: [0; 3], score: 0 };
    let g = search.extend(&[start], 0, 2 * choose(4), |_| (12, 0));
    let c30 = search.extend(&g, 1, choose(3), |[g, ..]| (12 * a, 36 * g));
    let c20 = search.extend(&c30, 2, choose(2), |[g, c30, _]| (12 * b, 12 * a * c30 + 14 * g));
    c20.iter().find_map(|choice| search.unluckiest(choice.numbers, level, fraction, width))
}

/// A control mesh of 12 vertices and 13 triangles: the first one is the patch with these control points by
/// axis, the others are its surroundings.
///
/// # Errors
/// Coordinates that no control mesh has.
pub fn mesh(axes: [&[i64; 12]; 3]) -> Result<ControlMesh> {
    const PLACES: [[i32; 2]; 12] = [
        [0, -1],
        [1, -1],
        [2, -1],
        [-1, 0],
        [0, 0],
        [1, 0],
        [2, 0],
        [-1, 1],
        [0, 1],
        [1, 1],
        [-1, 2],
        [0, 2],
    ];
    let at = |u: i32, v: i32| PLACES.iter().position(|place| *place == [u, v]).map(|index| index as u32);
    let triangle = |corners: [[i32; 2]; 3]| -> Option<[u32; 3]> {
        let [a, b, c] = corners.map(|[u, v]| at(u, v));
        Some([a?, b?, c?])
    };
    let mut triangles: Vec<[u32; 3]> = (-1..=2)
        .flat_map(|v| (-1..=2).map(move |u| (u, v)))
        .flat_map(|(u, v)| [[[u, v], [u + 1, v], [u, v + 1]], [[u + 1, v], [u + 1, v + 1], [u, v + 1]]])
        .filter_map(triangle)
        .collect();
    let middle = triangles.iter().position(|t| *t == [4, 5, 8]);
    triangles.swap(0, middle.ok_or_else(|| Error::usage("the patch is not in its own mesh"))?);
    let positions = (0..12).map(|point| axes.map(|axis| axis[point])).collect();
    ControlMesh::new(positions, triangles)
}

/// G, C30, C20, as far as chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Choice {
    score: i128,
    numbers: [i128; 3],
}

struct Search {
    rounding: Rounding,
    /// M.
    unit: i128,
    side: Side,
    /// No number of a choice is larger.
    limit: i128,
}

/// Partial choices that are kept.
const BEAM: usize = 64;

impl Search {
    /// M (rnd(N/M) - N/M).
    fn error(&self, n: i128) -> i128 {
        let (below, rest) = (n.div_euclid(self.unit), n.rem_euclid(self.unit));
        let up = match self.rounding {
            Rounding::HalfUp | Rounding::Exact => 2 * rest >= self.unit,
            Rounding::HalfEven => 2 * rest > self.unit || (2 * rest == self.unit && below % 2 != 0),
            Rounding::Floor => false,
            Rounding::Truncate => n < 0 && rest != 0,
        };
        if up { self.unit - rest } else { -rest }
    }

    fn score(&self, n: i128) -> i128 {
        match self.side {
            Side::Above => self.error(n),
            Side::Below => -self.error(n),
        }
    }

    /// Chooses the number at `index`, whose N is `step * number + base`, in the ways that are best for the
    /// error of N, for each of the choices so far.
    fn extend(
        &self,
        choices: &[Choice],
        index: usize,
        weight: i128,
        numerator: impl Fn([i128; 3]) -> (i128, i128),
    ) -> Vec<Choice> {
        let mut extended = vec![];
        for choice in choices {
            let (step, base) = numerator(choice.numbers);
            // N runs through the remainders that are `base` modulo g, again and again after M / g numbers.
            let (g, inverse) = extended_gcd(step.rem_euclid(self.unit), self.unit);
            let period = self.unit / g;
            let first = base.rem_euclid(g);
            // Errors turn round at half a unit and at a whole one.
            let turns = [self.unit / 2, self.unit];
            let rests = turns.iter().flat_map(|turn| {
                let at = (turn - first).div_euclid(g);
                (at - 3..=at + 3).map(|t| (first + g * t).rem_euclid(self.unit))
            });
            for rest in rests {
                let number = ((rest - base).div_euclid(g) * inverse).rem_euclid(period);
                for times in -6..6 {
                    let number = number + times * period;
                    if number.abs() > self.limit {
                        continue;
                    }
                    let mut numbers = choice.numbers;
                    numbers[index] = number;
                    let score = choice.score + weight * self.score(step * number + base);
                    extended.push(Choice { score, numbers });
                }
            }
        }
        // The best first; of equal ones the smallest numbers.
        let size = |choice: &Choice| choice.numbers.iter().map(|x| x.abs()).max();
        let order = |a: &Choice, b: &Choice| b.score.cmp(&a.score).then(size(a).cmp(&size(b))).then(a.cmp(b));
        // Most are far from the best: these alone are sorted.
        if extended.len() > 8 * BEAM {
            extended.select_nth_unstable_by(8 * BEAM, order);
            extended.truncate(8 * BEAM);
        }
        extended.sort_by(order);
        extended.dedup();
        extended.truncate(BEAM);
        extended
    }

    /// Of the points with these G, C30 and C20 those whose vertex is worst after the final rounding.
    fn unluckiest(
        &self,
        [g, c30, c20]: [i128; 3],
        level: u32,
        fraction: u32,
        width: u32,
    ) -> Option<WorstCase> {
        let (least, most) = (-(1i128 << (width - 1)), (1i128 << (width - 1)) - 1);
        let sum = c30 + 2 * c20;
        let rm = sum.div_euclid(2);
        let (r1, r0_next) = (sum - rm, g - c20 + sum);
        let mut best: Option<(i128, WorstCase)> = None;
        for free in 0..12 * 12 {
            let (p5, p1) = (free % 12 - 6, free / 12 - 6);
            let points = [0, p1, rm + 2 * p1, c20 - p5, 0, p5, r0_next + 2 * p5, 0, 0, r1, 0, 0];
            if points.iter().any(|p| !(least..=most).contains(p)) {
                continue;
            }
            let error = self.total(&points, level);
            let exact: i128 =
                basis::mask(level, 1 << level, 0).iter().zip(&points).map(|(&m, p)| i128::from(m) * p).sum();
            // Computed D00 in units of 2^-F, and the rounded vertex, against the exact one over 12 * 16^r.
            let computed = (exact + error) / self.unit;
            let rounded =
                if fraction == 0 { computed } else { (computed + (1 << (fraction - 1))) >> fraction };
            let last = rounded * i128::from(basis::denominator(level)) - exact;
            let last = if self.side == Side::Above { last } else { -last };
            if best.as_ref().is_none_or(|(most, _)| last > *most) {
                let points = points.map(|p| p as i64);
                best = Some((last, WorstCase { points, error, unit: self.unit }));
            }
        }
        best.map(|(_, case)| case)
    }

    /// M times the error of p(n, 0) in units of 2^-F.
    fn total(&self, points: &[i128; 12], level: u32) -> i128 {
        use crate::surface::forward::row;
        let n = 1i128 << level;
        let choose = |k: i128| (0..k).fold(1, |c, x| c * (n - x) / (x + 1));
        let weights = [(0, 0, 1), (1, 0, n), (2, 0, choose(2)), (3, 0, choose(3)), (3, 1, 2 * choose(4))];
        weights
            .iter()
            .map(|&(k, l, weight)| {
                let numerator: i128 =
                    row(k, l, level).iter().zip(points).map(|(&w, p)| i128::from(w) * p).sum();
                weight * self.error(numerator)
            })
            .sum()
    }
}

/// gcd(a, m) and the inverse of a / gcd modulo m / gcd, for 0 <= a.
fn extended_gcd(a: i128, m: i128) -> (i128, i128) {
    let (mut r, mut s) = ((a, m), (1i128, 0i128));
    while r.1 != 0 {
        let q = r.0 / r.1;
        r = (r.1, r.0 - q * r.1);
        s = (s.1, s.0 - q * s.1);
    }
    (r.0, s.0.rem_euclid(m / r.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::precision::of_patch;

    #[test]
    fn the_inverse_inverts() {
        for (a, m) in [(12, 96), (7, 96), (36, 3 << 20), (0, 12), (1, 1)] {
            let (g, inverse) = extended_gcd(a, m);
            assert_eq!((a * inverse).rem_euclid(m), g % m, "{a} modulo {m}");
        }
    }

    #[test]
    fn the_found_error_is_near_the_bound() {
        for (level, fraction) in [(4, 13), (5, 17), (6, 21), (7, 25), (8, 29), (8, 20)] {
            let reduced = Reduced::new(crate::fixed::Fractions::uniform(fraction).unwrap());
            let bound = of_patch(reduced, level).largest().to_f64_up();
            let part = |side, sign: f64| {
                let case = points(reduced, level, 24, side).unwrap();
                sign * case.error_lsb(fraction) / bound
            };
            let above = part(Side::Above, 1.0);
            assert!((0.9..=1.0).contains(&above), "level {level}, F = {fraction}: {above}");
            // Half up: a tie goes the other way, so downwards the remainders may stop short.
            let below = part(Side::Below, -1.0);
            assert!((0.65..=1.0).contains(&below), "level {level}, F = {fraction}: {below}");
        }
    }

    #[test]
    fn the_mesh_has_the_patch_first() {
        let points = [7; 12];
        let control = mesh([&points; 3]).unwrap();
        assert_eq!((control.positions().len(), control.triangles().len()), (12, 13));
        assert_eq!(control.triangles()[0], [4, 5, 8]);
    }
}
