//! Host and core in one go: from the control mesh to the rounded positions of every patch.
//!
//! ```text
//!   control mesh --> surface::packets (exact integers) --> loop_fd::columns --> vertices, patch by patch:
//!                                                            (n+1)(n+2)/2, column i = 0..n, j = 0..n-i
//! ```
//!
//! 64-bit words serve wherever W + 4R + 4 bits fit in them; 128-bit words otherwise. Reduced formats have
//! columns of their own, [`reduced`].

use super::loop_fd::LoopFd;
use super::loop_fd::columns::Columns;
use super::loop_fd::reduced;
use super::loop_fd::rounding::{ByDivision, ByMultiplication, Rounding};
use crate::error::{Error, Result};
use crate::surface::control_mesh::ControlMesh;
use crate::surface::hierarchy::Counts;
use crate::surface::packets::{patches, patches_of};
use crate::surface::table::Table;
use crate::surface::word::Word;

/// Evaluates the whole mesh at resolution `level` and writes the vertices of all patches, in the order of
/// the packets, to `vertices`, whose old contents are overwritten (a buffer used again is not filled twice).
///
/// # Errors
/// Coordinates wider than the core's, a level above its maximum.
pub fn render(
    mesh: &ControlMesh,
    level: u32,
    core: &LoopFd,
    table: &Table,
    vertices: &mut Vec<[i64; 3]>,
) -> Result<Counts> {
    if mesh.width() > core.width() {
        return Err(Error::input(format!("coordinates of {} bits", mesh.width()))
            .help(format!("this core takes {} bits: use a smaller scale or a wider format", core.width())));
    }
    if let Some(mut columns) = reduced::columns(core) {
        vertices.clear();
        return patches(mesh, level, core.max_level(), table, |patch| {
            columns.start(patch.level, &patch.points);
            for length in (1..=(1usize << patch.level) + 1).rev() {
                let start = vertices.len();
                vertices.resize(start + length, [0; 3]);
                columns.next(&mut vertices[start..]);
            }
        });
    }
    if core.word_bits() > i64::BITS {
        return render_with::<i128, _>(mesh, level, core, table, ByDivision::new(core), vertices);
    }
    match ByMultiplication::new(core) {
        Some(rounding) => render_with::<i64, _>(mesh, level, core, table, rounding, vertices),
        None => render_with::<i64, _>(mesh, level, core, table, ByDivision::new(core), vertices),
    }
}

fn render_with<W: Word, R: Rounding<W>>(
    mesh: &ControlMesh,
    level: u32,
    core: &LoopFd,
    table: &Table,
    rounding: R,
    vertices: &mut Vec<[i64; 3]>,
) -> Result<Counts> {
    let (mut end, mut columns) = (0, Columns::new(rounding));
    let counts = patches_of::<W>(mesh, level, core.max_level(), table, |patch| {
        let start = end;
        end += LoopFd::vertex_count(patch.level);
        if end > vertices.len() {
            vertices.resize(end.max(2 * start), [0; 3]);
        }
        columns.patch(patch.level, &patch.points, &mut vertices[start..end]);
    })?;
    vertices.truncate(end);
    Ok(counts)
}
