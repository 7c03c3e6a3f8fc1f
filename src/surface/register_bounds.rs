//! How wide each register of the engine must be so that it never overflows on a regular patch.
//!
//! ```text
//!   |N(k,l)_{i,j}| <= L1 * 2^(W-1),     L1 = sum of the absolute weights of the control points
//!   width = W + ceil(log2 L1), L1 maximised over all places (i, j) that the register visits
//! ```
//!
//! The bound is attained, up to one unit, by control points at the ends of their range. It holds for
//! regular patches of the control mesh itself (depth 0) and for no others: the points of a sub-patch carry
//! extra fraction bits, so an engine that serves every depth keeps the uniform W + 4R + 4 bits.

use crate::surface::forward::{ORDERS, Row, row};
use std::collections::BTreeMap;

/// Which places (i, j) count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// The samples of the patch: i + j <= n.
    Domain,
    /// Every value an engine computes, those one step outside at the end of a column included:
    /// i + j <= n + 1.
    Visited,
}

/// Bits above the coordinate width of every difference (k, l) at level `r`, zero rows left out.
pub fn bits_above_width(r: u32, places: Places) -> BTreeMap<(usize, usize), u32> {
    let largest = largest_l1(r, places);
    let entries = ORDERS.iter().zip(largest).filter(|(_, l1)| *l1 > 0);
    // ceil(log2 l1)
    entries.map(|(&order, l1)| (order, 64 - (l1 - 1).leading_zeros())).collect()
}

/// Low bits that are zero in every value of the difference (k, l): the power of two in all its weights.
pub fn always_zero_bits(r: u32) -> BTreeMap<(usize, usize), u32> {
    // A value at (i, j) is an integer combination of the differences of the same and higher order at (0, 0).
    let zeros = |&(k, l): &(usize, usize)| {
        let higher = ORDERS.iter().filter(|&&(x, y)| x >= k && y >= l);
        let weights = higher.flat_map(|&(x, y)| row(x, y, r)).fold(0, |bits, w| bits | w);
        ((k, l), weights.trailing_zeros())
    };
    ORDERS.iter().filter(|&&order| order != (2, 2)).map(zeros).collect()
}

/// The largest sum of absolute weights of each order, in the sequence of [`ORDERS`].
fn largest_l1(r: u32, places: Places) -> [u64; 15] {
    let last = (1usize << r) + usize::from(places == Places::Visited);
    let next_u = ORDERS.map(|(k, l)| index_of(k + 1, l));
    let next_v = ORDERS.map(|(k, l)| index_of(k, l + 1));
    let mut largest = [0; 15];
    let mut column = crate::surface::forward::matrix(r);
    for i in 0..=last {
        let mut at = column;
        for _ in 0..=last - i {
            for (most, weights) in largest.iter_mut().zip(&at) {
                *most = u64::max(*most, weights.iter().map(|w| w.unsigned_abs()).sum());
            }
            step(&mut at, &next_v);
        }
        step(&mut column, &next_u);
    }
    largest
}

fn index_of(k: usize, l: usize) -> Option<usize> {
    ORDERS.iter().position(|&order| order == (k, l))
}

/// One step of the grid: every difference gains the next higher one (old values on the right).
fn step(rows: &mut [Row; 15], next: &[Option<usize>; 15]) {
    let old = *rows;
    for (row, source) in rows.iter_mut().zip(next) {
        if let Some(source) = source {
            for (weight, gain) in row.iter_mut().zip(&old[*source]) {
                *weight += gain;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// N00; N10, N01; N20, N02; N11; N30, N03; N21, N12; N31, N13.
    const COLUMNS: [&[(usize, usize)]; 7] = [
        &[(0, 0)],
        &[(1, 0), (0, 1)],
        &[(2, 0), (0, 2)],
        &[(1, 1)],
        &[(3, 0), (0, 3)],
        &[(2, 1), (1, 2)],
        &[(3, 1), (1, 3)],
    ];

    fn assert_bits(r: u32, places: Places, expected: [u32; 7]) {
        let bits = bits_above_width(r, places);
        for (orders, expected) in COLUMNS.iter().zip(expected) {
            for order in *orders {
                assert_eq!(bits[order], expected, "r = {r}, N{}{}, {places:?}", order.0, order.1);
            }
        }
    }

    #[test]
    fn visited_places_give_the_derived_table() {
        let table = [
            [6, 9, 10, 9, 10, 9, 8],
            [8, 10, 11, 10, 10, 9, 8],
            [12, 11, 12, 11, 11, 10, 8],
            [16, 14, 13, 13, 12, 10, 8],
            [20, 17, 15, 14, 12, 11, 8],
            [24, 20, 16, 16, 13, 12, 8],
            [28, 23, 18, 18, 14, 13, 8],
            [32, 26, 20, 20, 15, 14, 8],
        ];
        for (r, expected) in table.into_iter().enumerate() {
            assert_bits(r as u32, Places::Visited, expected);
        }
    }

    #[test]
    fn the_domain_alone_needs_less_at_low_levels() {
        let table = [
            [4, 6, 9, 8, 10, 8, 8],
            [8, 8, 10, 9, 10, 9, 8],
            [12, 11, 11, 11, 11, 9, 8],
            [16, 14, 13, 12, 11, 10, 8],
            [20, 17, 14, 14, 12, 11, 8],
        ];
        for (r, expected) in table.into_iter().enumerate() {
            assert_bits(r as u32, Places::Domain, expected);
        }
    }

    #[test]
    fn low_zero_bits() {
        for r in 0..=10 {
            let zeros = always_zero_bits(r);
            for (orders, expected) in COLUMNS.iter().zip([0, 0, 1, 1, 2, 2, 2]) {
                for order in *orders {
                    assert_eq!(zeros[order], expected, "r = {r}, N{}{}", order.0, order.1);
                }
            }
        }
    }
}
