//! The slow and obvious way: every sample by itself, in wide integers.
//!
//! ```text
//!   N00 = sum of mask(i, j)[m] P_m           y = floor((2 N00 2^f + 12 * 16^R) / (2 * 12 * 16^R))
//! ```
//!
//! The masks are the box-spline basis itself. With |P| < 2^(W+1) 16^(R-level), masks that sum to
//! 12 * 16^level and f <= 4R + 1, everything stays below 2^121 for W <= 32 and R <= 10.

use super::{Beat, LoopFd};
use crate::surface::basis;

/// Sample p(i, j) of a patch, rounded; the meaning of `points` is that of [`LoopFd::beats`].
pub fn vertex(core: &LoopFd, level: u32, points: &[[i128; 3]; 12], i: u32, j: u32) -> [i64; 3] {
    let mask = basis::mask(level, i, j);
    [0, 1, 2].map(|axis| {
        let n00: i128 = points.iter().zip(mask).map(|(p, weight)| p[axis] * i128::from(weight)).sum();
        rounded(core, n00)
    })
}

/// floor(N00 2^f / (12 * 16^R) + 1/2), by one division.
pub fn rounded(core: &LoopFd, n00: i128) -> i64 {
    let f = core.extra_fraction();
    let numerator = n00 << f.max(0);
    let denominator = 12i128 << (4 * core.max_level() as i32 - f.min(0));
    (2 * numerator + denominator).div_euclid(2 * denominator) as i64
}

/// All beats of one patch.
pub fn beats(core: &LoopFd, level: u32, points: &[[i128; 3]; 12]) -> Vec<Beat> {
    let n = 1u32 << level;
    let mut beats = Vec::with_capacity(LoopFd::beat_count(level));
    for i in 0..n {
        for j in 0..=n - i {
            beats.push(Beat {
                left: vertex(core, level, points, i, j),
                right: (j < n - i).then(|| vertex(core, level, points, i + 1, j)),
                strip_end: j == n - i,
                patch_start: (i, j) == (0, 0),
                patch_end: (i, j) == (n - 1, 1),
            });
        }
    }
    beats
}
