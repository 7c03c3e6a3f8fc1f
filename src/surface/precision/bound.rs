//! How far a vertex of a reduced format can be from the exact one, before its final rounding.
//!
//! ```text
//!   A(i,j) = sum over orders m = 0..4 of  2^-F_m (s S_m(i,j)  +  a T_m(i,j))
//!
//!   S_m  how often the start-up errors of order m are in p(i,j):     S_0 = 1   S_1 = i + j
//!        S_2 = C(i,2) + ij + C(j,2)          S_3 = C(i,3) + C(i,2) j + i C(j,2) + C(j,3)
//!        S_4 = C(i,3) j + i C(j,3) + 2 C(i,4) + 2 C(j,4)             (D31, D13 twice in the fourth steps)
//!   T_m  how often the error of an add into order m is in p(i,j):    T_0 = S_1   T_1 = S_2   T_2 = S_3
//!        T_3 = C(i,3) j + i C(j,3), and C(i,4) + C(j,4) adds of a double
//!   s    error of a start-up rounding:  1/2, 1/2 to the nearest;  0, 1 by floor;  1, 1 by truncation
//!   a    error of an add that drops d bits, F_(m+1) - F_m, one less for a double:  0 for d = 0; else
//!        half up 1/2, 1/2 - 2^-d;  half even 1/2, 1/2;  floor 0, 1 - 2^-d;  truncation 1 - 2^-d both ways
//! ```
//!
//! (upwards, downwards). Every S and T grows with i and j, so the largest bound lies on i + j = n; on a
//! patch of a lower level it is smaller. Derived from the recurrences of Bischoff, Kobbelt, Seidel 2000,
//! section 3.3: an error of D(k,l) at (i', j') is in p(i,j) C(i-i', k) C(j-j', l) times.

use super::Dyadic;
use crate::fixed::precision::HIGHEST_ORDER;
use crate::fixed::{Fractions, Reduced, Rounding};

/// Bounds on computed less exact, in units of the control coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// How much too large a vertex can be.
    pub above: Dyadic,
    /// How much too small.
    pub below: Dyadic,
}

impl FormatError {
    pub fn largest(self) -> Dyadic {
        self.above.max(self.below)
    }
}

/// A(i, j).
pub fn at_vertex(reduced: Reduced, i: u64, j: u64) -> FormatError {
    Terms::of(i, j).bound(reduced)
}

/// The largest A on a patch of this level or a lower one.
pub fn of_patch(reduced: Reduced, level: u32) -> FormatError {
    let n = 1u64 << level;
    // The roles of i and j are symmetric.
    let bounds = (0..=n / 2).map(|j| at_vertex(reduced, n - j, j));
    bounds.fold(FormatError { above: Dyadic::default(), below: Dyadic::default() }, |most, bound| {
        FormatError { above: most.above.max(bound.above), below: most.below.max(bound.below) }
    })
}

/// No output coordinate of a patch of exact control points is farther from the limit surface than this, in
/// units of the output's last place: A and the final rounding, half up (there is none if F_0 = f).
pub fn total_lsb(reduced: Reduced, level: u32, extra_fraction: i32) -> f64 {
    let format = of_patch(reduced, level).largest().scaled(extra_fraction);
    let last = if i64::from(reduced.fractions.of(0)) == i64::from(extra_fraction) {
        Dyadic::default()
    } else {
        Dyadic::HALF
    };
    format.plus(last).to_f64_up()
}

/// S and T of one vertex.
pub(super) struct Terms {
    pub start: [u128; HIGHEST_ORDER + 1],
    pub adds: [u128; HIGHEST_ORDER],
    /// Adds of a double into order 3.
    pub doubles: u128,
}

impl Terms {
    pub fn of(i: u64, j: u64) -> Terms {
        let choose = |n: u64, k: u64| {
            let n = u128::from(n);
            (0..u128::from(k)).fold(1, |product, x| product * n.saturating_sub(x) / (x + 1))
        };
        let c = |a: u64, b: u64| choose(i, a) * choose(j, b);
        let second = c(2, 0) + c(1, 1) + c(0, 2);
        let third = c(3, 0) + c(2, 1) + c(1, 2) + c(0, 3);
        let (mixed, doubles) = (c(3, 1) + c(1, 3), c(4, 0) + c(0, 4));
        let first = u128::from(i) + u128::from(j);
        Terms {
            start: [1, first, second, third, mixed + 2 * doubles],
            adds: [first, second, third, mixed],
            doubles,
        }
    }

    pub fn bound(&self, reduced: Reduced) -> FormatError {
        let Reduced { fractions, rounding, .. } = reduced;
        let bits = fractions.of(HIGHEST_ORDER) + 1;
        let (mut above, mut below) = (0, 0);
        let mut add = |count: u128, [up, down]: [u128; 2]| {
            above += count * up;
            below += count * down;
        };
        for (order, &count) in self.start.iter().enumerate() {
            add(count, start_error(fractions, rounding, order));
        }
        for (order, &count) in self.adds.iter().enumerate() {
            add(count, add_error(fractions, rounding, order, fractions.dropped(order)));
        }
        let dropped = fractions.dropped(3).saturating_sub(1);
        add(self.doubles, add_error(fractions, rounding, 3, dropped));
        FormatError { above: Dyadic::new(above, bits), below: Dyadic::new(below, bits) }
    }
}

/// Half a unit of an order, over 2^(F_4 + 1).
fn half_unit(fractions: Fractions, order: usize) -> u128 {
    1 << (fractions.of(HIGHEST_ORDER) - fractions.of(order))
}

/// Upwards and downwards, over 2^(F_4 + 1).
pub(super) fn start_error(fractions: Fractions, rounding: Rounding, order: usize) -> [u128; 2] {
    let half = half_unit(fractions, order);
    match rounding {
        Rounding::HalfUp | Rounding::HalfEven | Rounding::Exact => [half, half],
        Rounding::Floor => [0, 2 * half],
        Rounding::Truncate => [2 * half, 2 * half],
    }
}

/// The same for an add that drops bits on its way into an order.
pub(super) fn add_error(fractions: Fractions, rounding: Rounding, order: usize, dropped: u32) -> [u128; 2] {
    if dropped == 0 {
        return [0, 0];
    }
    let half = half_unit(fractions, order);
    // 2^-dropped units; at least a unit of the highest order, which is 2 here.
    let last = 2 * half >> dropped;
    match rounding {
        Rounding::HalfUp | Rounding::Exact => [half, half - last],
        Rounding::HalfEven => [half, half],
        Rounding::Floor => [0, 2 * half - last],
        Rounding::Truncate => [2 * half - last, 2 * half - last],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format(fractions: &str, rounding: Rounding) -> Reduced {
        Reduced { rounding, ..Reduced::new(fractions.parse().unwrap()) }
    }

    #[test]
    fn the_uniform_bound_is_that_of_the_corner() {
        // B(n) = (1 + n + C(n,2) + C(n,3) + 2 C(n,4)) / 2
        let table = [1.0, 2.0, 8.5, 116.5, 2168.5, 38704.5, 657248.5];
        for (level, expected) in table.into_iter().enumerate() {
            let bound = of_patch(format("20", Rounding::HalfUp), level as u32);
            assert_eq!(bound.largest().scaled(20).to_f64_up(), expected, "level {level}");
            assert_eq!(bound, at_vertex(format("20", Rounding::HalfUp), 1 << level, 0));
        }
    }

    #[test]
    fn directed_roundings_double_the_terms_on_their_sides() {
        let nearest = of_patch(format("17", Rounding::HalfEven), 5).above;
        let floor = of_patch(format("17", Rounding::Floor), 5);
        assert_eq!((floor.above, floor.below), (Dyadic::default(), nearest.scaled(1)));
        let truncated = of_patch(format("17", Rounding::Truncate), 5);
        assert_eq!((truncated.above, truncated.below), (floor.below, floor.below));
    }

    #[test]
    fn progressive_bounds_by_hand() {
        // n = 2 at (2, 0): 1 + 2 start-ups and 2 adds of order 0, 2 + 1 of order 1 and 1 + 0 of order 2
        let bound = at_vertex(format("1,2,3,4,5", Rounding::HalfEven), 2, 0);
        let half = |count: f64, fraction: i32| count / 2.0 * (-f64::from(fraction)).exp2();
        let expected = half(1.0 + 2.0, 1) + half(2.0 + 1.0, 2) + half(1.0, 3);
        assert_eq!(bound.above.to_f64_up(), expected);
        // An add that drops one bit is never too small by half a unit: 1/2 - 2^-1 = 0.
        let up = at_vertex(format("1,2,3,4,5", Rounding::HalfUp), 2, 0);
        assert_eq!(up.above.to_f64_up(), expected);
        assert_eq!(up.below.to_f64_up(), half(1.0, 1) + half(2.0, 2) + half(1.0, 3));
        // The adds of a double of order 4 into order 3 are exact if one bit is dropped.
        let (one, two) = ("4,4,4,4,5", "4,4,4,4,6");
        let adds = |text: &str| {
            let with = at_vertex(format(text, Rounding::HalfEven), 8, 0).above.to_f64_up();
            with - half(1.0 + 8.0 + 28.0 + 56.0, 4) - half(140.0, if text == one { 5 } else { 6 })
        };
        assert_eq!((adds(one), adds(two)), (0.0, half(70.0, 4)));
    }

    #[test]
    fn the_hypotenuse_bounds_the_patch() {
        for fractions in ["9", "3,5,8,8,11", "5,6,6,9,10"] {
            for rounding in Rounding::TOTAL {
                let reduced = format(fractions, rounding);
                let most = of_patch(reduced, 4);
                for (i, j) in (0..=16).flat_map(|i| (0..=16 - i).map(move |j| (i, j))) {
                    let bound = at_vertex(reduced, i, j);
                    assert!(bound.above <= most.above && bound.below <= most.below, "{i}, {j}");
                }
            }
        }
    }

    #[test]
    fn the_total_has_the_final_rounding_where_there_is_one() {
        let reduced = format("17", Rounding::HalfUp);
        let a = 38704.5 / 131072.0;
        assert_eq!(total_lsb(reduced, 5, 0), 0.5 + a);
        assert_eq!(total_lsb(reduced, 5, 2), 0.5 + 4.0 * a);
        assert_eq!(total_lsb(reduced, 5, 17), a * 131072.0);
        assert_eq!(total_lsb(reduced, 5, -3), 0.5 + a / 8.0);
    }
}
