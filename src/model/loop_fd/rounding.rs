//! The final rounding, floor(N00 2^f / (12 * 16^R) + 1/2), as a shift and a division by 3.
//!
//! ```text
//!   s = 4R + 2 - f       M = (N00 + 3 * 2^(s-1)) >> s        y = floor(M / 3)
//!
//!   division by multiplication:  x = M + 3 * 2^(W-1+f) >= 0, of q = W + f + 2 bits
//!       y = (x m >> k) - 2^(W-1+f),   k = q if q is odd, else q + 1,   m = (2^k + 1) / 3
//!       exact for every x < 2^q because 3m - 2^k = 1 <= 2^(k-q)
//! ```
//!
//! Both constants before the shift are folded into one number, which a forward-difference column adds once
//! to its start instead of once a sample.

use super::LoopFd;
use crate::surface::word::Word;

/// Rounds samples held in words of type `W`.
pub trait Rounding<W: Word>: Copy {
    /// What is added to N00 once, at the start of a column.
    fn folded(&self) -> W;
    /// The output for N00 + `folded`.
    fn output(&self, n00: W) -> i64;
}

/// The general case: an arithmetic shift and a division.
#[derive(Clone, Copy, Debug)]
pub struct ByDivision {
    shift: u32,
}

impl ByDivision {
    pub fn new(core: &LoopFd) -> Self {
        ByDivision { shift: core.rounding_shift() }
    }
}

impl<W: Word> Rounding<W> for ByDivision {
    fn folded(&self) -> W {
        W::narrow(3 << (self.shift - 1))
    }

    fn output(&self, n00: W) -> i64 {
        (n00.wide() >> self.shift).div_euclid(3) as i64
    }
}

/// The fast case, q <= 32 bits: one 32 x 32 -> 64 bit multiplication.
#[derive(Clone, Copy, Debug)]
pub struct ByMultiplication {
    shift: u32,
    /// 2^(W-1+f), the bias of the output.
    bias: i64,
    m: u32,
    k: u32,
}

impl ByMultiplication {
    /// None if x has more than 32 bits or the sample more than 64.
    pub fn new(core: &LoopFd) -> Option<Self> {
        let q = core.output_bits() + 2;
        let k = q | 1;
        (q <= 32 && core.word_bits() <= i64::BITS).then(|| ByMultiplication {
            shift: core.rounding_shift(),
            bias: 1 << (core.output_bits() - 1),
            m: ((1u64 << k) / 3 + 1) as u32,
            k,
        })
    }
}

impl Rounding<i64> for ByMultiplication {
    fn folded(&self) -> i64 {
        // With the bias the sum is never negative, and below 2^B: |N00| <= 12 * 2^(W-1) 16^R = 3/8 * 2^B,
        // the bias is as much again, and the half unit is at most 3/32 of 2^B.
        (3i64 << (self.shift - 1)).wrapping_add((3 * self.bias) << self.shift)
    }

    #[inline(always)]
    fn output(&self, n00: i64) -> i64 {
        let x = (n00 as u64 >> self.shift) as u32;
        ((u64::from(x) * u64::from(self.m)) >> self.k) as i64 - self.bias
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::loop_fd::direct;

    /// All ways on one number.
    fn assert_agreement(core: &LoopFd, n00: i128) {
        let expected = direct::rounded(core, n00);
        let divide = ByDivision::new(core);
        let wide = Rounding::<i128>::output(&divide, n00 + Rounding::<i128>::folded(&divide));
        assert_eq!(wide, expected, "{core:?}, N00 = {n00}, division");
        if let Some(multiply) = ByMultiplication::new(core) {
            let output = multiply.output((n00 as i64).wrapping_add(multiply.folded()));
            assert_eq!(output, expected, "{core:?}, N00 = {n00}, multiplication");
        }
    }

    #[test]
    fn every_sample_of_small_cores() {
        for (width, max_level) in [(2, 0), (5, 0), (8, 0), (3, 1), (6, 1), (4, 2)] {
            for f in 2 - width as i32..=4 * max_level as i32 + 1 {
                let core = LoopFd::new(width, f, max_level).unwrap();
                let limit = 12i128 << (4 * max_level + width - 1);
                for n00 in -limit..=limit - (12 << (4 * max_level)) {
                    assert_agreement(&core, n00);
                }
            }
        }
    }

    #[test]
    fn ties_and_ends_of_large_cores() {
        for (width, max_level) in [(24, 6), (20, 10), (30, 7), (32, 10), (32, 6), (16, 10)] {
            for f in [2 - width as i32, -3, 0, 1, 5, 4 * max_level as i32 + 1] {
                let Ok(core) = LoopFd::new(width, f, max_level) else { continue };
                let unit = 12i128 << (4 * max_level);
                let (low, high) = (-unit << (width - 1), (unit << (width - 1)) - unit);
                let step = (high - low) / 997;
                for n00 in (0..997).map(|t| low + t * step).chain([high]) {
                    // to the next tie, and around it
                    let output = direct::rounded(&core, n00);
                    let tie = ((2 * i128::from(output) - 1) * unit) >> (f + 1).max(0);
                    for near in [n00, tie - 1, tie, tie + 1] {
                        assert_agreement(&core, near.clamp(low, high));
                    }
                }
            }
        }
    }
}
