//! The exact packets of a mesh: what the forward-difference engine is fed with.
//!
//! ```text
//!   a sub-patch of level rho carries 4 (R - rho) extra fraction bits:
//!       |P| <= 2^(W-1) 16^(R-rho),  so every sample comes out over 12 16^R, whatever rho and r <= R
//! ```
//!
//! The hierarchy at resolution r delivers depth k = r - rho scaled by 16^k; the remaining 16^(R-r) is a
//! shift of the finished points. The surface points of a mesh therefore do not depend on R.

use crate::error::{Error, Result};
use crate::surface::control_mesh::ControlMesh;
use crate::surface::exact::Exact;
use crate::surface::hierarchy::{Counts, Patch, walk};
use crate::surface::table::Table;
use crate::surface::word::Word;

/// The highest level of any core: 2^10 steps along an edge.
pub const MAX_LEVEL: u32 = 10;

/// The widest coordinate of any core.
pub const MAX_WIDTH: u32 = 32;

/// Bits that hold every point, limit position and sample of a core exactly: W + 4R + 4.
pub fn word_bits(width: u32, max_level: u32) -> u32 {
    width + 4 * max_level + 4
}

/// Hands every packet of the mesh at resolution `level`, for a core of maximum level `max_level`, to `sink`,
/// in an order that depends on the mesh alone; nothing is stored.
///
/// # Errors
/// `level` above `max_level`, `max_level` above 10, coordinates of more than 32 bits.
pub fn patches(
    mesh: &ControlMesh,
    level: u32,
    max_level: u32,
    table: &Table,
    sink: impl FnMut(&Patch<[i128; 3]>),
) -> Result<Counts> {
    patches_of::<i128>(mesh, level, max_level, table, sink)
}

/// The same in words of the caller's choice: all points are exact if `word_bits` of the coordinates fits.
///
/// # Errors
/// As [`patches`], and a word that is too narrow.
pub fn patches_of<W: Word>(
    mesh: &ControlMesh,
    level: u32,
    max_level: u32,
    table: &Table,
    mut sink: impl FnMut(&Patch<[W; 3]>),
) -> Result<Counts> {
    if max_level > MAX_LEVEL || level > max_level {
        return Err(Error::usage(format!("level {level} on a core of maximum level {max_level}"))
            .help(format!("a core has a maximum level of 0 to {MAX_LEVEL} and renders up to that")));
    }
    let width = mesh.width();
    if width > MAX_WIDTH || word_bits(width, max_level) > W::BITS {
        return Err(Error::input(format!("coordinates of {width} bits do not fit"))
            .help(format!("use at most {MAX_WIDTH} bits, for example Q12.12")));
    }
    let shift = 4 * (max_level - level);
    let mut scaled = None;
    let point = |v: u32| mesh.positions()[v as usize].map(|x| W::narrow(x.into()));
    let counts = walk(&Exact::<W>::new(table), mesh, level, point, |patch| {
        if shift == 0 {
            return sink(patch);
        }
        let scaled: &mut Patch<_> = scaled.get_or_insert_with(|| patch.clone());
        scaled.clone_from(patch);
        scaled.points = patch.points.map(|p| p.map(|x| x.shifted_left(shift)));
        sink(scaled);
    });
    Ok(counts)
}
