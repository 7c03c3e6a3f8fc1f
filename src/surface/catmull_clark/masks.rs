//! The rules of Catmull and Clark as weights that sum to one, and their limit masks.
//!
//! ```text
//!   D1 ── A1 ── D0        d = valence, S = vertex, A_i = its edge neighbours, D_i = diagonals of its faces
//!   │     │     │
//!   A2 ── S ─── A0        F  = mean of the corners of a face
//!   │     │     │         E  = (F1 + F2 + A + B)/4                          A, B the ends of the edge
//!   D2 ── A3 ── D3        V' = (sum F + sum A)/d^2 + (d-2) S/d
//!                            = S + (6 sum A + sum D - 7d S)/(4 d^2)         for quadrilaterals
//!                         limit = S + (4 sum A + sum D - 5d S)/(d (d+5))
//!
//!   boundary:  edge (A + B)/2,  vertex (A + 6V + B)/8,  limit (A + 4V + B)/6
//! ```
//!
//! No rule divides by three: in Hall's thesis, section 6.4, the edge rule can be read as (F1 + F2 + M)/3
//! with the midpoint M, which is another surface; the thesis's own formulas for regular meshes agree with
//! the rule above. Sources: Catmull, Clark 1978; Hall, chapter 2 and equation (5.1).

use crate::surface::loop_masks::Mask;
use num_rational::Ratio;

/// The smallest and the largest valence of an interior vertex of a quad mesh.
pub const VALENCES: std::ops::RangeInclusive<usize> = 3..=16;

/// New vertex of an inner edge of a quad mesh: A, B, then the four other corners of its two faces.
pub const EDGE: Mask<6> = Mask { weights: [6, 6, 1, 1, 1, 1], denominator: 16 };
/// New vertex of a boundary edge: A, B.
pub const BOUNDARY_EDGE: Mask<2> = Mask { weights: [1, 1], denominator: 2 };
/// Old boundary vertex between its boundary neighbours: A, V, B.
pub const BOUNDARY_VERTEX: Mask<3> = Mask { weights: [1, 6, 1], denominator: 8 };
/// Limit position of a boundary vertex between its boundary neighbours: A, V, B.
pub const BOUNDARY_LIMIT: Mask<3> = Mask { weights: [1, 4, 1], denominator: 6 };

/// What becomes of a boundary vertex with a single face: a corner of the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Corners {
    /// Like every boundary vertex, (A + 6V + B)/8: the boundary is one smooth curve.
    #[default]
    Smooth,
    /// It stays where it is, V' = V.
    Sharp,
}

/// Weights of a vertex and its ring: the vertex, each edge neighbour, each diagonal; over `denominator`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingMask {
    pub valence: usize,
    pub vertex: i64,
    pub neighbour: i64,
    pub diagonal: i64,
    pub denominator: i64,
}

impl RingMask {
    /// The weight of the vertex, and those of one edge neighbour and one diagonal.
    pub fn rational(self) -> [Ratio<i64>; 3] {
        [self.vertex, self.neighbour, self.diagonal].map(|w| Ratio::new(w, self.denominator))
    }

    /// Sum of all weights; `denominator`, as the rules are affine.
    pub fn sum(self) -> i64 {
        self.vertex + self.valence as i64 * (self.neighbour + self.diagonal)
    }
}

/// V' of an interior vertex of a quad mesh.
pub fn vertex(valence: usize) -> RingMask {
    let d = valence as i64;
    RingMask { valence, vertex: 4 * d * d - 7 * d, neighbour: 6, diagonal: 1, denominator: 4 * d * d }
}

/// Limit position of an interior vertex of a quad mesh.
pub fn limit(valence: usize) -> RingMask {
    let d = valence as i64;
    RingMask { valence, vertex: d * d, neighbour: 4, diagonal: 1, denominator: d * (d + 5) }
}

/// Halstead, Kass, DeRose 1993, appendix A: A_d = 1 + C_1 + cos(pi/d) sqrt(2 (9 + C_1)), C_1 = cos(2 pi/d).
pub fn tangent_factor(valence: usize) -> f64 {
    let angle = std::f64::consts::TAU / valence as f64;
    1.0 + angle.cos() + (angle / 2.0).cos() * (2.0 * (9.0 + angle.cos())).sqrt()
}

/// The second largest eigenvalue of the subdivision of a ring: (4 + A_d)/16; 1/2 for valence 4.
pub fn subdominant(valence: usize) -> f64 {
    (4.0 + tangent_factor(valence)) / 16.0
}

/// Weights of the limit tangents: for i = 0..d of A_i and of D_i (between A_i and A_i+1), ccw.
///
/// `[t1, t2]`, up to a common factor; t1 x t2 points outwards.
///
/// ```text
///   t1 = sum A_d C_i A_i + (C_i + C_i+1) D_i       t2: the same with sines, S_i = sin(2 pi i/d)
/// ```
pub fn tangents(valence: usize) -> [Vec<[f64; 2]>; 2] {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / valence as f64;
    let factor = tangent_factor(valence);
    [f64::cos, f64::sin].map(|wave| {
        (0..valence).map(|i| [factor * wave(angle(i)), wave(angle(i)) + wave(angle(i + 1))]).collect()
    })
}

/// Contraction q_d of the ring radius max(|A_i - S|, |D_i - S|) by one step at an interior vertex.
///
/// The larger of the sums of absolute weights of A'_i - V' and of D'_i - V', the vertex taken as origin.
pub fn ring_contraction(valence: usize) -> f64 {
    let d = valence as f64;
    let (neighbour, diagonal) = (6.0 / (4.0 * d * d), 1.0 / (4.0 * d * d));
    let edge = (6.0 / 16.0 - neighbour).abs()
        + 2.0 * (1.0 / 16.0 - neighbour).abs()
        + (d - 3.0) * neighbour
        + 2.0 * (1.0 / 16.0 - diagonal).abs()
        + (d - 2.0) * diagonal;
    let face = 2.0 * (0.25 - neighbour).abs()
        + (d - 2.0) * neighbour
        + (0.25 - diagonal).abs()
        + (d - 1.0) * diagonal;
    edge.max(face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mask_is_affine() {
        for d in VALENCES {
            assert_eq!(vertex(d).sum(), vertex(d).denominator, "valence {d}");
            assert_eq!(limit(d).sum(), limit(d).denominator, "valence {d}");
        }
        assert_eq!(EDGE.weights.iter().sum::<i64>(), EDGE.denominator);
        assert_eq!(BOUNDARY_VERTEX.weights.iter().sum::<i64>(), BOUNDARY_VERTEX.denominator);
        assert_eq!(BOUNDARY_LIMIT.weights.iter().sum::<i64>(), BOUNDARY_LIMIT.denominator);
    }

    #[test]
    fn the_one_coefficient_form_is_the_rule_of_the_thesis() {
        // (5.1): (sum F + sum A)/d^2 + (d-2)/d S with F = (S + A_i + D_i + A_i+1)/4
        for d in 3..=16i64 {
            let per_face = Ratio::new(1, 4 * d * d);
            let mask = vertex(d as usize).rational();
            assert_eq!(mask[2], per_face);
            assert_eq!(mask[1], per_face * 2 + Ratio::new(1, d * d));
            assert_eq!(mask[0], per_face * d + Ratio::new(d - 2, d));
        }
    }

    #[test]
    fn valence_four_is_the_bicubic_spline() {
        let tensor = |a: [i64; 3], b: [i64; 3]| [a[1] * b[1], a[1] * b[0], a[0] * b[0]];
        let v = vertex(4);
        assert_eq!([v.vertex, v.neighbour, v.diagonal], tensor([1, 6, 1], [1, 6, 1]));
        let l = limit(4);
        assert_eq!([l.vertex, l.neighbour, l.diagonal], tensor([1, 4, 1], [1, 4, 1]));
    }

    /// One subdivision step of the ring of an interior vertex: S, then A_i, D_i in turn.
    fn step(ring: &[f64], d: usize) -> Vec<f64> {
        let (s, a, x) = (ring[0], |i: usize| ring[1 + 2 * (i % d)], |i: usize| ring[2 + 2 * (i % d)]);
        let sum = |f: &dyn Fn(usize) -> f64| (0..d).map(f).sum::<f64>();
        let mut next = vec![s + (6.0 * sum(&a) + sum(&x) - 7.0 * d as f64 * s) / (4 * d * d) as f64];
        for i in 0..d {
            next.push((6.0 * (s + a(i)) + a(i + 1) + a(i + d - 1) + x(i) + x(i + d - 1)) / 16.0);
            next.push((s + a(i) + a(i + 1) + x(i)) / 4.0);
        }
        next
    }

    #[test]
    fn limits_and_tangents_are_left_eigenvectors() {
        for d in VALENCES {
            let mut position = vec![limit(d).vertex as f64];
            (0..d).for_each(|_| position.extend([4.0, 1.0]));
            let [t1, t2] = tangents(d).map(|t| [vec![0.0], t.into_iter().flatten().collect()].concat());
            for (left, eigenvalue) in [(position, 1.0), (t1, subdominant(d)), (t2, subdominant(d))] {
                for unit in 0..=2 * d {
                    let mut ring = vec![0.0; 2 * d + 1];
                    ring[unit] = 1.0;
                    let value: f64 = step(&ring, d).iter().zip(&left).map(|(r, l)| r * l).sum();
                    assert!((value - eigenvalue * left[unit]).abs() < 1e-12, "valence {d}, entry {unit}");
                }
            }
        }
        assert!((tangent_factor(4) - 4.0).abs() < 1e-15 && (subdominant(4) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_ring_contracts_as_fast_as_claimed_and_no_faster() {
        let known = [
            (3, 0.611),
            (4, 0.781),
            (5, 0.840),
            (6, 0.861),
            (7, 0.867),
            (8, 0.867),
            (10, 0.860),
            (12, 0.851),
            (16, 0.834),
        ];
        for (d, q) in known {
            assert!((ring_contraction(d) - q).abs() < 6e-4, "q_{d} = {}", ring_contraction(d));
        }
        // the worst ring of radius 1 around 0, entry by entry
        for d in VALENCES {
            let mut response = vec![vec![0.0; 2 * d + 1]; 2 * d + 1];
            for unit in 1..=2 * d {
                let mut ring = vec![0.0; 2 * d + 1];
                ring[unit] = 1.0;
                let next = step(&ring, d);
                (1..=2 * d).for_each(|i| response[i][unit] = (next[i] - next[0]).abs());
            }
            let worst = response.iter().map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max);
            assert!((worst - ring_contraction(d)).abs() < 1e-12, "valence {d}");
        }
    }
}
