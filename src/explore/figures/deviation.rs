//! Figure 17: what rounding does to a patch, by level and by kind of number.
//!
//! ```text
//!   at (1,0), (1/2,1/2) and (0,1) of every regular patch:   |computed - exact| / |exact|,   the largest
//!
//!   fixed    the reference of the core, its output included
//! ```
//!
//! The exact position is the mask of the box spline, in integers. Only the three columns that hold these points are
//! stepped down, so that even level 10 takes no time.

use super::counted::Vector;
use crate::error::Result;
use crate::model::loop_fd::LoopFd;
use crate::model::loop_fd::columns::Columns;
use crate::model::loop_fd::reduced;
use crate::model::loop_fd::rounding::ByDivision;
use crate::surface::basis;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::hierarchy::{Patch, PatchKind};
use crate::surface::packets::patches;
use crate::surface::table::Table;

/// The points that are looked at: (i, j) for n steps.
fn places(n: usize) -> [(usize, usize); 3] {
    [(0, n), (n / 2, n / 2), (n, 0)]
}

/// Calls `deviation` for each regular patch that has these points, and gives the largest result.
fn largest(
    control: &ControlMesh,
    level: u32,
    mut deviation: impl FnMut(&Patch<[i128; 3]>) -> f64,
) -> Result<f64> {
    let mut largest = 0.0f64;
    let table = Table::for_width(control.width())?;
    patches(control, level, level, &table, |patch| {
        if patch.kind == PatchKind::Regular && patch.level > 0 {
            largest = largest.max(deviation(patch));
        }
    })?;
    Ok(largest)
}

/// The exact position of a sample in units of the coordinates, as whole and rest: exact to 2^-53 of either.
fn exact(patch: &Patch<[i128; 3]>, level: u32, (i, j): (usize, usize)) -> [(f64, f64); 3] {
    let mask = basis::mask(patch.level, i as u32, j as u32);
    // Points carry 4 (level - patch.level) fraction bits, and the masks 12 * 16^patch.level.
    let unit = 12i128 << (4 * level);
    [0, 1, 2].map(|x| {
        let sum: i128 = patch.points.iter().zip(mask).map(|(p, weight)| p[x] * i128::from(weight)).sum();
        (sum.div_euclid(unit) as f64, sum.rem_euclid(unit) as f64 / unit as f64)
    })
}

fn relative(found: Vector<f64>, exact: [(f64, f64); 3]) -> f64 {
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let difference = square([0, 1, 2].map(|x| (found[x] - exact[x].0) - exact[x].1));
    let norm = square(exact.map(|(whole, rest)| whole + rest));
    // The origin has no relative error.
    if norm > 0.0 { (difference / norm).sqrt() } else { 0.0 }
}

/// The reference of a core, its last rounding included.
///
/// # Errors
/// Those of the packets.
pub fn fixed(control: &ControlMesh, level: u32, core: &LoopFd) -> Result<f64> {
    let mut column = vec![[0i64; 3]; (1 << level) + 1];
    let mut reduced = reduced::columns(core);
    let mut whole = Columns::<i128, _>::new(ByDivision::new(core));
    largest(control, level, |patch| {
        let n = 1usize << patch.level;
        match &mut reduced {
            Some(columns) => columns.start(patch.level, &patch.points),
            None => whole.start(patch.level, &patch.points),
        }
        let mut next = |length: usize| {
            match &mut reduced {
                Some(columns) => columns.next(&mut column[..length]),
                None => whole.next(&mut column[..length]),
            }
            column[length.saturating_sub(1)]
        };
        let mut most = 0.0f64;
        let mut i = 0;
        for (at, row) in places(n) {
            while i < at {
                next(0);
                i += 1;
            }
            let found = next(row + 1).map(|x| x as f64);
            i += 1;
            most = most.max(relative(found, exact(patch, level, (at, row))));
        }
        most
    })
}
