//! Exact integer ranges: what a signal can be, and so how many bits it needs.
//!
//! ```
//! use subdiv_rtl::fixed::Range;
//! assert_eq!(Range::new(-4, 3).width(), 3);      // two's complement
//! assert_eq!(Range::new(0, 8).width(), 4);       // never negative: no sign bit
//! assert_eq!(Range::signed(8), Range::new(-128, 127));
//! assert_eq!((Range::new(-1, 2) * -3), Range::new(-6, 3));
//! ```

use std::fmt;
use std::ops::{Add, Mul, Neg};

/// The closed interval of integers `min ..= max`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Range {
    pub min: i128,
    pub max: i128,
}

impl Range {
    /// Wider words than this are refused. A range that leaves `i128` on the way there stays at its ends,
    /// and so is too wide, never wrong.
    pub const WIDEST: u32 = 120;

    pub fn new(min: i128, max: i128) -> Self {
        debug_assert!(min <= max, "an empty range: {min} .. {max}");
        Range { min, max }
    }

    /// Every two's-complement word of `width` bits.
    pub fn signed(width: u32) -> Self {
        Range::new(-(1 << (width - 1)), (1 << (width - 1)) - 1)
    }

    /// Every unsigned word of `width` bits.
    pub fn unsigned(width: u32) -> Self {
        Range::new(0, (1 << width) - 1)
    }

    pub fn point(value: i128) -> Self {
        Range::new(value, value)
    }

    /// A word needs a sign bit when it can be negative.
    pub fn is_signed(self) -> bool {
        self.min < 0
    }

    /// Bits of the narrowest word that holds the range; at least one.
    pub fn width(self) -> u32 {
        let magnitude = |x: i128| 128 - (if x < 0 { !x } else { x }).leading_zeros();
        let bits = magnitude(self.min).max(magnitude(self.max));
        (bits + u32::from(self.is_signed())).max(1)
    }

    pub fn contains(self, other: Range) -> bool {
        self.min <= other.min && other.max <= self.max
    }

    pub fn union(self, other: Range) -> Range {
        Range::new(self.min.min(other.min), self.max.max(other.max))
    }

    /// What both allow; the first range where they have nothing in common.
    pub fn intersect(self, other: Range) -> Range {
        let (min, max) = (self.min.max(other.min), self.max.min(other.max));
        if min <= max { Range { min, max } } else { self }
    }

    /// The range of `floor(x / 2^amount)`.
    pub fn shift_right(self, amount: u32) -> Range {
        Range::new(self.min >> amount, self.max >> amount)
    }

    /// The word that has the low bits of `value`: what a register of this range holds after being given it.
    pub fn wrap(self, value: i128) -> i128 {
        let spare = 128 - self.width();
        if self.is_signed() { value << spare >> spare } else { ((value as u128) << spare >> spare) as i128 }
    }
}

impl Add for Range {
    type Output = Range;
    fn add(self, other: Range) -> Range {
        Range::new(self.min.saturating_add(other.min), self.max.saturating_add(other.max))
    }
}

impl Neg for Range {
    type Output = Range;
    fn neg(self) -> Range {
        Range::new(self.max.saturating_neg(), self.min.saturating_neg())
    }
}

impl Mul<i128> for Range {
    type Output = Range;
    fn mul(self, factor: i128) -> Range {
        let (a, b) = (self.min.saturating_mul(factor), self.max.saturating_mul(factor));
        Range::new(a.min(b), a.max(b))
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}]", Bound(self.min), Bound(self.max))
    }
}

/// Bounds near a power of two read better as such: `2^59-1`.
struct Bound(i128);

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.unsigned_abs();
        let sign = if self.0 < 0 { "-" } else { "" };
        match magnitude {
            0..=4096 => write!(f, "{}", self.0),
            m if m.is_power_of_two() => write!(f, "{sign}2^{}", m.ilog2()),
            m if (m + 1).is_power_of_two() && self.0 > 0 => write!(f, "2^{}-1", (m + 1).ilog2()),
            _ => write!(f, "{}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn width_is_the_narrowest_word() {
        for (min, max, width) in [(0, 0, 1), (0, 1, 1), (-1, 0, 1), (-1, 1, 2), (-9, 7, 5), (5, 255, 8)] {
            assert_eq!(Range::new(min, max).width(), width, "{min}..{max}");
        }
    }

    #[test]
    fn wrapping_keeps_the_low_bits() {
        assert_eq!(Range::signed(4).wrap(9), -7);
        assert_eq!(Range::unsigned(4).wrap(-1), 15);
        assert_eq!(Range::signed(64).wrap(-5), -5);
    }
}
