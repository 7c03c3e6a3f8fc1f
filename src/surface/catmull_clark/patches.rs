//! The polynomial patches that the quads of a fine mesh belong to.
//!
//! ```text
//!   ┌───────┬───────┐     A quad whose corners are regular is one bicubic patch, of depth 0. Beside an irregular
//!   │   1   │   1   │     corner ● subdivision turns three quarters into patches, and leaves the fourth for the
//!   ├───┬───┼───────┤     next step: depth 1, depth 2, ...
//!   │ 2 │ 2 │       │
//!   ├─┬─┼───┤   1   │     Source: Stam, "Exact Evaluation of Catmull-Clark Subdivision Surfaces at Arbitrary
//!   ●─┴─┴───┴───────┘     Parameter Values", SIGGRAPH 1998.
//! ```
//!
//! On a boundary with reflected ghosts vertices of three edges, and corners of two, are regular.

use crate::surface::catmull_clark::fine_grid::QuadGrid;

/// A patch: after how many steps it is regular, and a number that tells patches apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Patch {
    pub depth: u32,
    pub number: u32,
}

/// One for each quad of [`QuadGrid::quads`]. What is irregular at the finest level still has the depth after it.
pub fn patches(grid: &QuadGrid) -> Vec<Patch> {
    let (mesh, n) = (grid.mesh(), grid.steps());
    let topology = mesh.topology();
    let regular = |vertex: u32| match (topology.is_boundary(vertex), topology.valence(vertex)) {
        (true, valence) => [2, 3].contains(&valence),
        (false, valence) => valence == 4,
    };
    let mut found = Vec::with_capacity(grid.quad_count());
    for (quad, corners) in (0..).zip(mesh.quads()) {
        let irregular = corners.map(|vertex| !regular(vertex));
        let cells = (0..n).flat_map(|u| (0..n).map(move |v| [u, v]));
        found.extend(cells.map(|cell| patch(quad, irregular, cell, n)));
    }
    found
}

/// The patch of the cell (u, v) of a quad that is divided into n by n.
fn patch(quad: u32, irregular: [bool; 4], [u, v]: [usize; 2], n: usize) -> Patch {
    // Twelve numbers a level are enough for three quarters at each of four corners.
    let numbered = |depth: u32, corner: usize, quarter: usize| Patch {
        depth,
        // Of more than ten million quads some would share a number, which no picture could show.
        number: quad.wrapping_mul(32 * 12).wrapping_add((depth * 4 + corner as u32) * 3 + quarter as u32),
    };
    let Some(first) = irregular.iter().position(|&i| i) else { return numbered(0, 0, quad as usize % 3) };
    let (right, upper) = (2 * u >= n, 2 * v >= n);
    let corner = [[0, 3], [1, 2]][usize::from(right)][usize::from(upper)];
    if !irregular[corner] {
        return numbered(1, corner, (corner + 3 - first) % 4);
    }
    // Steps from the corner, whose quarter this is.
    let from = |x: usize, far: bool| if far && n > 1 { n - 1 - x } else { x };
    let (a, b) = (from(u, right), from(v, upper));
    match usize::max(a, b).checked_ilog2() {
        None => numbered(n.ilog2() + 1, corner, 0),
        Some(log) => {
            let quarter = if b >> log == 0 { 0 } else { 1 + usize::from(a >> log == 0) };
            numbered(n.ilog2() - log, corner, quarter)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::catmull_clark::quad_mesh::QuadMesh;
    use std::collections::BTreeMap;

    fn depths(patches: &[Patch]) -> BTreeMap<u32, usize> {
        let mut counts = BTreeMap::new();
        patches.iter().for_each(|p| *counts.entry(p.depth).or_default() += 1);
        counts
    }

    #[test]
    fn a_cube_has_three_valence_three_layers_everywhere() {
        let quads = vec![[0, 1, 3, 2], [2, 3, 7, 6], [6, 7, 5, 4], [4, 5, 1, 0], [1, 5, 7, 3], [2, 6, 4, 0]];
        let mesh = QuadMesh::new(vec![[0; 3]; 8], quads).unwrap();
        let grid = QuadGrid::new(&mesh, 3).unwrap();
        let found = patches(&grid);
        assert_eq!(found.len(), grid.quad_count());
        // Each quarter of a quad is 4 by 4: three quarters of it at depth 2, then 3 cells, then the last one.
        assert_eq!(depths(&found), BTreeMap::from([(2, 24 * 12), (3, 24 * 3), (4, 24)]));
        let mut sizes: BTreeMap<Patch, usize> = BTreeMap::new();
        found.iter().for_each(|p| *sizes.entry(*p).or_default() += 1);
        assert!(sizes.iter().all(|(p, &size)| size == if p.depth == 2 { 4 } else { 1 }), "{sizes:?}");
    }

    #[test]
    fn the_quarters_beside_a_regular_corner_are_patches_at_once() {
        // One irregular corner of a quad of 4 by 4: its own quarter splits again, the others do not.
        let of = |corner: usize| {
            let irregular = std::array::from_fn(|i| i == corner);
            let cells = (0..16).map(|k| patch(5, irregular, [k / 4, k % 4], 4));
            cells.collect::<Vec<_>>()
        };
        for corner in 0..4 {
            assert_eq!(depths(&of(corner)), BTreeMap::from([(1, 12), (2, 3), (3, 1)]), "{corner}");
            let mut shades: Vec<u32> =
                of(corner).iter().filter(|p| p.depth == 1).map(|p| p.number % 3).collect();
            shades.sort_unstable();
            shades.dedup();
            assert_eq!(shades, [0, 1, 2]);
        }
    }

    #[test]
    fn a_regular_quad_is_one_patch_and_its_boundary_is_regular() {
        let mesh = QuadMesh::new(vec![[0; 3]; 6], vec![[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap();
        let found = patches(&QuadGrid::new(&mesh, 2).unwrap());
        assert_eq!(depths(&found), BTreeMap::from([(0, 32)]));
        assert_ne!(found[0], found[16]);
        assert_eq!(found[0], found[15]);
    }
}
