//! Whether a mesh fits the block RAM of a device.
//!
//! ```text
//! blocks of a memory of d words of w bits = least of ceil(d / D) * ceil(w / W)
//! over the shapes D x W of a block: 16384 x 1, 8192 x 2, 4096 x 4, 2048 x 9, 1024 x 18, 512 x 36
//! ```

use super::boards::{Board, Device};
use crate::cores::board::Patches;
use crate::cores::loop_fd::Parameters;
use crate::error::{Error, Result};
use crate::fixed::Range;

/// Blocks of 16 or 18 kbit that the memories of a mesh take at most; small ones go into logic instead.
pub fn blocks(parameters: Parameters, patches: &Patches) -> u64 {
    let points = patches.points.len() as u64;
    let index = Range::new(0, points.max(2) as i128 - 1).width();
    let level = Range::new(0, parameters.max_level.into()).width();
    let count = patches.levels.len() as u64;
    3 * of_memory(points, parameters.modulus()) + of_memory(12 * count, index) + of_memory(count, level)
}

fn of_memory(depth: u64, width: u32) -> u64 {
    let shapes = [(16384, 1), (8192, 2), (4096, 4), (2048, 9), (1024, 18), (512, 36)];
    let count = |(deep, wide): (u64, u32)| depth.div_ceil(deep) * u64::from(width.div_ceil(wide));
    shapes.into_iter().map(count).min().unwrap_or(0)
}

/// # Errors
/// `Input`, with the figures, for a mesh that is too large.
pub fn check(board: &Board, device: &Device, parameters: Parameters, patches: &Patches) -> Result<u64> {
    let blocks = blocks(parameters, patches);
    if blocks <= device.blocks.into() {
        return Ok(blocks);
    }
    let (points, bits) = (patches.points.len(), 3 * parameters.modulus());
    let what = format!(
        "the mesh takes {blocks} block RAMs ({points} control points of {bits} bits, {} patches), but the {} of the {} has {}",
        patches.levels.len(),
        device.name,
        board.title,
        device.blocks
    );
    Err(Error::input(what)
        .help("choose a lower --level, fewer bits in --coordinates, a smaller mesh or a larger device"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_takes_the_best_shape() {
        assert_eq!(of_memory(512, 36), 1);
        assert_eq!(of_memory(513, 36), 2);
        assert_eq!(of_memory(1500, 8), 1);
        assert_eq!(of_memory(5000, 9), 3);
    }
}
