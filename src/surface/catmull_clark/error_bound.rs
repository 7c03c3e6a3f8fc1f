//! The proven bound on the error of an output coordinate of a strip.
//!
//! ```text
//!   error <= 1/2 + 2^f (sum over levels k = 1..L of r_k + tau_k  +  limit)     units of the output's last place
//!
//!   r_k    2^-(g+1) with g guard bits, twice that by floor or truncation; in the exact format 2^-(6k+1) where a valence is not 4, else 0
//!   tau_k  |kappa_d - table| |6 sum A + sum D - 7d S| <= 2^-(b+1) 7d D_k-1;  0 for d = 4, 8, 16
//!          D_k = ring radius max(|A_i - S|, |D_i - S|),  D_0 < 2^W,  D_k <= q_d D_k-1 + 2 r_k + tau_k
//!   limit  |lambda_d - table| |4 sum A + sum D - 5d S| <= 2^-(b+1) 5d D
//! ```
//!
//! All rules are convex, so an error never grows on its way; it can only be added to. Ghosts follow the same
//! rules from exact integers, so the bound holds for them too. Without the roundings the table's part is
//! below K_d 2^-b D_0 with K_d = (7d/2)/(1 - q_d), and below (5d/2) 2^-b D_0 more for a limit.

use crate::fixed::Rounding;
use crate::surface::catmull_clark::masks::{VALENCES, ring_contraction};
use crate::surface::catmull_clark::numbers::Numbers;
use crate::surface::catmull_clark::table::Table;

/// What the bound depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Coordinate bits W, ghosts included: no two input coordinates are farther apart than 2^W.
    pub width: u32,
    /// Fraction bits f of the output beyond those of the input; may be negative.
    pub extra_fraction: i32,
    /// L, how often a strip is subdivided.
    pub levels: u32,
    pub numbers: Numbers,
    /// How a new vertex is rounded to its level's numbers.
    pub rounding: Rounding,
    /// Fraction bits b of the table.
    pub table_bits: u32,
    /// Largest valence other than 4; none for a regular mesh.
    pub largest_irregular_valence: Option<usize>,
    /// The outputs are limit positions, not refined ones.
    pub limit: bool,
}

/// No output coordinate is farther from the true position than this, in units of the output's last place.
pub fn error_bound_lsb(accuracy: &Accuracy) -> f64 {
    let half_entry = (-f64::from(accuracy.table_bits) - 1.0).exp2();
    let spread = f64::from(accuracy.width).exp2();
    let irregular = accuracy.largest_irregular_valence;
    // (d, radius of the rings of valence d)
    let mut rings: Vec<(usize, f64)> =
        VALENCES.filter(|&d| irregular.is_some_and(|largest| d <= largest)).map(|d| (d, spread)).collect();
    // A direction costs up to a whole unit, the nearest number half of one.
    let directed = matches!(accuracy.rounding, Rounding::Floor | Rounding::Truncate);
    let units = if directed { 1.0 } else { 0.5 };
    let mut error = 0.0;
    for level in 1..=accuracy.levels {
        let rounding = match accuracy.numbers {
            Numbers::Exact if irregular.is_none() => 0.0,
            numbers => units * (-f64::from(numbers.fraction(level))).exp2(),
        };
        let mut most = 0.0;
        for (d, radius) in &mut rings {
            let shift = Table::kappa_shift(*d).is_some();
            let table = if shift { 0.0 } else { half_entry * 7.0 * *d as f64 * *radius };
            most = table.max(most);
            *radius = ring_contraction(*d) * *radius + 2.0 * rounding + table;
        }
        error += rounding + most;
    }
    if accuracy.limit {
        // The ring of a regular vertex may lie next to an irregular one, so q_4 does not bound it.
        let limits = rings.iter().map(|&(d, radius)| d as f64 * radius);
        error += half_entry * 5.0 * limits.fold(4.0 * spread, f64::max);
    }
    // The handful of f64 roundings above, each below 2^-52 of the whole, are covered by one part in 2^40.
    0.5 + error * f64::from(accuracy.extra_fraction).exp2() * (1.0 + (-40f64).exp2())
}

/// K_d: the table's part of the error of a refined position is at most K_d 2^-b D_0.
pub fn table_error_factor(valence: usize) -> f64 {
    3.5 * valence as f64 / (1.0 - ring_contraction(valence))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_the_table_error() {
        let derived = [
            (3, 27.0),
            (5, 109.0),
            (6, 151.0),
            (7, 185.0),
            (8, 211.0),
            (10, 250.0),
            (12, 281.0),
            (16, 337.0),
        ];
        for (d, expected) in derived {
            assert!((table_error_factor(d) - expected).abs() < 0.9, "K_{d} = {}", table_error_factor(d));
        }
        assert!((3..16).all(|d| table_error_factor(d) < table_error_factor(d + 1)));
    }

    fn accuracy(levels: u32, numbers: Numbers) -> Accuracy {
        let largest_irregular_valence = None;
        Accuracy {
            width: 12,
            extra_fraction: 0,
            levels,
            numbers,
            rounding: Rounding::HalfUp,
            table_bits: 25,
            largest_irregular_valence,
            limit: false,
        }
    }

    #[test]
    fn a_regular_mesh_pays_for_its_guard_bits_only() {
        assert_eq!(error_bound_lsb(&accuracy(7, Numbers::Exact)), 0.5);
        let bound = error_bound_lsb(&accuracy(5, Numbers::Guard(6)));
        assert!((bound - (0.5 + 5.0 / 128.0)).abs() < 1e-9, "{bound}");
        let floor = Accuracy { rounding: Rounding::Floor, ..accuracy(5, Numbers::Guard(6)) };
        assert!((error_bound_lsb(&floor) - (0.5 + 5.0 / 64.0)).abs() < 1e-9);
    }

    #[test]
    fn thirteen_more_table_bits_than_coordinate_bits_keep_every_mesh_within_a_sixteenth() {
        for width in 2..=32 {
            for (levels, d) in (1..=7).flat_map(|levels| VALENCES.map(move |d| (levels, d))) {
                for limit in [false, true] {
                    let bound = error_bound_lsb(&Accuracy {
                        width,
                        extra_fraction: 0,
                        levels,
                        numbers: Numbers::Exact,
                        rounding: Rounding::HalfUp,
                        table_bits: width + 13,
                        largest_irregular_valence: Some(d),
                        limit,
                    });
                    assert!(bound <= 0.5 + 1.0 / 16.0, "width {width}, level {levels}, valence {d}: {bound}");
                }
            }
        }
    }

    #[test]
    fn a_coarse_table_dominates_as_its_series_says() {
        let coarse =
            Accuracy { table_bits: 10, largest_irregular_valence: Some(9), ..accuracy(7, Numbers::Exact) };
        let q = ring_contraction(9);
        let series = 31.5 * (1.0 - q.powi(7)) / (1.0 - q) * 4.0;
        // the table's own error widens the ring it is applied to a little
        let ratio = (error_bound_lsb(&coarse) - 0.5) / series;
        assert!((1.0..1.15).contains(&ratio), "{ratio}");
        assert!(series < table_error_factor(9) * 4.0);
    }
}
