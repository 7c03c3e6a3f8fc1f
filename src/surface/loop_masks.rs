//! The rules of Loop subdivision as constants, in rationals and in `f64`.
//!
//! ```text
//!   edge            vertex (valence n)          boundary           limit (valence n)
//!      1              w     w                                         g     g
//!    /   \              \ /                  1 --- 6 --- 1              \ /
//!   3 --- 3  (/8)   w - 1-nw - w                 (/8)              g - 1-ng - g
//!    \   /              / \                  1 ---- 1 (/2)              / \
//!      1              w     w                                         g     g
//!
//!   w = alpha_n / n,  alpha_n = (40 - (3 + 2 cos(2 pi/n))^2) / 64
//!   g = gamma_n / n,  gamma_n = 8 alpha_n / (3 + 8 alpha_n)
//! ```
//!
//! Source: Bischoff, Kobbelt, Seidel 2000, Figures 2 and 8 (their alpha_N and gamma_N). Every boundary
//! vertex, whatever its valence, follows the boundary rules, so corners are smoothed.

use num_rational::Ratio;

/// Integer weights over one common denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask<const N: usize> {
    pub weights: [i64; N],
    pub denominator: i64,
}

impl<const N: usize> Mask<N> {
    pub fn rational(&self) -> [Ratio<i64>; N] {
        self.weights.map(|w| Ratio::new(w, self.denominator))
    }

    pub fn real(&self) -> [f64; N] {
        self.weights.map(|w| w as f64 / self.denominator as f64)
    }
}

/// New vertex of an interior edge (A, B) with opposite vertices C, D.
pub const EDGE: Mask<4> = Mask { weights: [3, 3, 1, 1], denominator: 8 };
/// New vertex of a boundary edge (A, B).
pub const BOUNDARY_EDGE: Mask<2> = Mask { weights: [1, 1], denominator: 2 };
/// Old interior vertex of valence 6: itself, then the ring.
pub const REGULAR_VERTEX: Mask<7> = Mask { weights: [10, 1, 1, 1, 1, 1, 1], denominator: 16 };
/// Old boundary vertex V between its boundary neighbours: A, V, B.
pub const BOUNDARY_VERTEX: Mask<3> = Mask { weights: [1, 6, 1], denominator: 8 };
/// Limit position of an interior vertex of valence 6: itself, then the ring.
pub const REGULAR_LIMIT: Mask<7> = Mask { weights: [6, 1, 1, 1, 1, 1, 1], denominator: 12 };
/// Limit position of a boundary vertex V between its boundary neighbours: A, V, B.
pub const BOUNDARY_LIMIT: Mask<3> = Mask { weights: [1, 4, 1], denominator: 6 };

/// Total ring weight of the vertex rule at interior valence `n`.
pub fn alpha(n: usize) -> f64 {
    let c = 3.0 + 2.0 * (std::f64::consts::TAU / n as f64).cos();
    (40.0 - c * c) / 64.0
}

/// Total ring weight of the limit rule at interior valence `n`.
pub fn gamma(n: usize) -> f64 {
    8.0 * alpha(n) / (3.0 + 8.0 * alpha(n))
}

/// Weight of each neighbour in the vertex rule V' = V + w (sum of the ring - n V).
pub fn vertex_weight(n: usize) -> f64 {
    alpha(n) / n as f64
}

/// Weight of each neighbour in the limit rule V + g (sum of the ring - n V).
pub fn limit_weight(n: usize) -> f64 {
    gamma(n) / n as f64
}

/// `alpha` where it is rational. cos(2 pi/n) is rational for n = 3, 4, 6 only (n >= 3); for other
/// valences up to 32 alpha is irrational too.
pub fn alpha_rational(n: usize) -> Option<Ratio<i64>> {
    let twice_cosine = match n {
        3 => -1,
        4 => 0,
        6 => 1,
        _ => return None,
    };
    let c: i64 = 3 + twice_cosine;
    Some(Ratio::new(40 - c * c, 64))
}

/// `gamma` where it is rational.
pub fn gamma_rational(n: usize) -> Option<Ratio<i64>> {
    alpha_rational(n).map(|alpha| alpha * 8 / (alpha * 8 + 3))
}

/// Contraction of the ring radius max |c_j - V| by one subdivision step at interior valence `n`:
/// q = |3/8 - w| + 2 |1/8 - w| + (n - 3) w, below 1 for every valence.
pub fn ring_contraction(n: usize) -> f64 {
    let w = vertex_weight(n);
    (0.375 - w).abs() + 2.0 * (0.125 - w).abs() + (n as f64 - 3.0) * w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rational_weights_are_the_published_ones() {
        let pairs = [(3, (9, 16), (3, 5)), (4, (31, 64), (31, 55)), (6, (3, 8), (1, 2))];
        for (n, a, g) in pairs {
            assert_eq!(alpha_rational(n), Some(Ratio::new(a.0, a.1)));
            assert_eq!(gamma_rational(n), Some(Ratio::new(g.0, g.1)));
            assert!((alpha(n) - a.0 as f64 / a.1 as f64).abs() < 1e-15);
        }
        assert_eq!(alpha_rational(5), None);
    }

    #[test]
    fn valence_six_gives_the_regular_masks() {
        let n = Ratio::from_integer(6);
        let [w, g] = [alpha_rational(6), gamma_rational(6)].map(|x| x.unwrap_or_default() / n);
        assert_eq!(REGULAR_VERTEX.rational()[1], w);
        assert_eq!(REGULAR_LIMIT.rational()[1], g);
    }

    #[test]
    fn every_mask_is_affine() {
        fn sum<const N: usize>(m: Mask<N>) -> bool {
            m.weights.iter().sum::<i64>() == m.denominator
        }
        assert!(sum(EDGE) && sum(BOUNDARY_EDGE) && sum(BOUNDARY_VERTEX) && sum(BOUNDARY_LIMIT));
        assert!(sum(REGULAR_VERTEX) && sum(REGULAR_LIMIT));
    }
}
