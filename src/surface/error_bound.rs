//! The proven bound on the error of an output coordinate.
//!
//! ```text
//!   regular mesh:  1/2 unit of the last place (the final rounding is the only one)
//!   else:          1/2 + 2^f sum over k = 1..r of (rounding of V' at depth k + table error at depth k)
//!                      + 2^f (rounding of the limit + table error of the limit)
//!
//!   rounding of V' at depth k: 16^-k / 2          rounding of a limit: 1 / (24 * 16^r)
//!   table error:  n 2^-(b+1) D_k,  D_k = ring radius max |c_j - V| at depth k
//!                 D_0 < 2^W,  D_k+1 <= q_n D_k + (what the computed V' is off its rule)
//! ```
//!
//! All other rules are convex, so an error never grows on its way; it can only be added to. q_n, the
//! contraction of the ring, and with it every term grow with the valence n, so the largest interior valence
//! bounds the mesh. Without the roundings this is below K_n 2^-b D_0, K_n = (n/2) (1/(1-q_n) + 1); the
//! roundings of V' add at most (1/2)(1/16 + 1/256 + ...) = 1/30.

use crate::surface::loop_masks::ring_contraction;

/// What the bound depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Coordinate bits W.
    pub width: u32,
    /// Fraction bits f of the output beyond those of the input; may be negative.
    pub extra_fraction: i32,
    /// Resolution r of the fine mesh.
    pub level: u32,
    /// Fraction bits b of the weight table.
    pub table_bits: u32,
    /// Largest interior valence other than 6; none for a regular mesh.
    pub largest_irregular_valence: Option<usize>,
}

/// No output coordinate is farther from the limit surface than this, in units of the output's last place.
pub fn error_bound_lsb(accuracy: &Accuracy) -> f64 {
    let Some(n) = accuracy.largest_irregular_valence else { return 0.5 };
    let q = ring_contraction(n);
    let entry = n as f64 * (-f64::from(accuracy.table_bits) - 1.0).exp2();
    let mut radius = f64::from(accuracy.width).exp2();
    let mut error = 0.0;
    let mut unit = 1.0;
    for _ in 0..accuracy.level {
        unit /= 16.0;
        let step = unit / 2.0 + entry * radius;
        error += step;
        radius = q * radius + step;
    }
    error += unit / 24.0 + entry * radius;
    // The handful of f64 roundings above, each below 2^-52 of the whole, are covered by one part in 2^40.
    0.5 + error * f64::from(accuracy.extra_fraction).exp2() * (1.0 + (-40f64).exp2())
}

/// K_n: the table's part of the error of any surface point is at most K_n 2^-b D_0.
pub fn table_error_factor(n: usize) -> f64 {
    n as f64 / 2.0 * (1.0 / (1.0 - ring_contraction(n)) + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::table::MAX_VALENCE;

    #[test]
    fn factors_of_the_table_error() {
        let derived = [3.7, 5.2, 7.9, 11.0, 14.2, 17.6, 20.9, 24.4, 27.8, 31.3, 34.8, 38.3, 41.8, 45.4];
        for (n, expected) in (3..).zip(derived) {
            assert!((table_error_factor(n) - expected).abs() <= 0.051, "K_{n}");
        }
        assert!((table_error_factor(32) - 105.0).abs() < 0.5);
    }

    #[test]
    fn contraction_grows_with_the_valence_so_the_largest_bounds_the_mesh() {
        assert!((3..MAX_VALENCE).all(|n| ring_contraction(n) < ring_contraction(n + 1)));
        assert!(ring_contraction(MAX_VALENCE) < 1.0);
    }

    #[test]
    fn sixteen_more_table_bits_than_coordinate_bits_keep_every_mesh_within_a_sixteenth() {
        for width in 2..=32 {
            for level in 0..=10 {
                for n in (3..=MAX_VALENCE).filter(|&n| n != 6) {
                    let bound = error_bound_lsb(&Accuracy {
                        width,
                        extra_fraction: 0,
                        level,
                        table_bits: width + 16,
                        largest_irregular_valence: Some(n),
                    });
                    assert!(bound <= 0.5 + 1.0 / 16.0, "width {width}, level {level}, valence {n}: {bound}");
                }
            }
        }
    }

    #[test]
    fn a_coarse_table_dominates_as_its_series_says() {
        let accuracy = Accuracy {
            width: 30,
            extra_fraction: 0,
            level: 10,
            table_bits: 12,
            largest_irregular_valence: Some(9),
        };
        // (n/2) 2^-b D_0 (1 + q + ... + q^9, then q^10 at the limit), below K_n 2^-b D_0
        let q = ring_contraction(9);
        let factor = 4.5 * ((1.0 - q.powi(10)) / (1.0 - q) + q.powi(10));
        let ratio = error_bound_lsb(&accuracy) / (factor * 18f64.exp2());
        assert!((1.0..1.01).contains(&ratio) && factor < table_error_factor(9), "{ratio}");
    }

    #[test]
    fn a_regular_mesh_is_correctly_rounded() {
        let accuracy = Accuracy {
            width: 24,
            extra_fraction: 12,
            level: 6,
            table_bits: 40,
            largest_irregular_valence: None,
        };
        assert_eq!(error_bound_lsb(&accuracy), 0.5);
    }
}
