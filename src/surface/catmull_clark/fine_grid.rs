//! Global names for the vertices of the fine mesh: every quad of the control mesh carries a grid of n = 2^l
//! steps, and a grid point on a corner or an edge is the same vertex in all quads around.
//!
//! ```text
//!   3 ── ─ ── 2        ids:  0 ..                 control vertices, in order
//!   │         │              then n - 1 an edge   along its first half-edge
//!   v         │              then (n-1)^2 a quad  u = 1.., in each v = 1..
//!   0 ── u ── 1
//! ```

use crate::error::{Error, Result};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;

/// Maps (quad, u, v) to dense vertex ids at one level.
#[derive(Clone, Copy, Debug)]
pub struct QuadGrid<'a> {
    mesh: &'a QuadMesh,
    level: u32,
}

impl<'a> QuadGrid<'a> {
    /// # Errors
    /// A fine mesh of more than 2^32 vertices.
    pub fn new(mesh: &'a QuadMesh, level: u32) -> Result<Self> {
        let grid = QuadGrid { mesh, level };
        if level >= 16 || grid.vertex_count() > u32::MAX as usize {
            return Err(Error::usage(format!("level {level} has too many vertices to number"))
                .help("render at a lower level"));
        }
        Ok(grid)
    }

    pub fn mesh(&self) -> &'a QuadMesh {
        self.mesh
    }

    pub fn level(&self) -> u32 {
        self.level
    }

    /// Steps along each edge, n = 2^level.
    pub fn steps(&self) -> usize {
        1 << self.level
    }

    /// Vertices of the mesh subdivided `level` times.
    pub fn vertex_count(&self) -> usize {
        let inner = self.steps() - 1;
        let edges = self.mesh.topology().edge_count() as usize;
        self.mesh.vertex_count() + edges * inner + self.mesh.quads().len() * inner * inner
    }

    /// Quads of the mesh subdivided `level` times.
    pub fn quad_count(&self) -> usize {
        self.mesh.quads().len() << (2 * self.level)
    }

    /// The id of grid point (u, v), both in 0..=n, of a quad: u runs from corner 0 to 1, v from corner 0 to 3.
    pub fn vertex(&self, quad: usize, u: usize, v: usize) -> usize {
        let n = self.steps();
        let corner = |i: usize| self.mesh.quads()[quad][i] as usize;
        match (u, v) {
            (0, 0) => corner(0),
            (_, 0) if u == n => corner(1),
            (0, _) if v == n => corner(3),
            _ if u == n && v == n => corner(2),
            (_, 0) => self.on_side(quad, 0, u),
            (0, _) => self.on_side(quad, 3, n - v),
            _ if u == n => self.on_side(quad, 1, v),
            _ if v == n => self.on_side(quad, 2, n - u),
            _ => {
                let inner = n - 1;
                let edges = self.mesh.topology().edge_count() as usize;
                let before = self.mesh.vertex_count() + edges * inner + quad * inner * inner;
                before + (u - 1) * inner + (v - 1)
            }
        }
    }

    /// The point `t` steps along a side, 0 < t < n.
    fn on_side(&self, quad: usize, side: usize, t: usize) -> usize {
        let topology = self.mesh.topology();
        let half_edge = (4 * quad + side) as u32;
        let edge = topology.edge(topology.edge_of(half_edge));
        let t = if edge.half_edge == half_edge { t } else { self.steps() - t };
        self.mesh.vertex_count() + edge.id as usize * (self.steps() - 1) + t - 1
    }

    /// Grid coordinates (u, v) of a point seen from corner `corner`: `ahead` steps towards the next corner,
    /// `aside` towards the one before.
    pub fn turned(&self, corner: usize, ahead: usize, aside: usize) -> [usize; 2] {
        let n = self.steps();
        match corner {
            0 => [ahead, aside],
            1 => [n - aside, ahead],
            2 => [n - ahead, n - aside],
            _ => [aside, n - ahead],
        }
    }

    /// All quads of the fine mesh, oriented as their roots: quad by quad, column by column.
    pub fn quads(&self) -> impl Iterator<Item = [u32; 4]> + '_ {
        let n = self.steps();
        (0..self.mesh.quads().len()).flat_map(move |quad| {
            let at = move |u, v| self.vertex(quad, u, v) as u32;
            (0..n).flat_map(move |u| {
                (0..n).map(move |v| [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)])
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn cube() -> QuadMesh {
        let quads = vec![[0, 1, 3, 2], [2, 3, 7, 6], [6, 7, 5, 4], [4, 5, 1, 0], [1, 5, 7, 3], [2, 6, 4, 0]];
        QuadMesh::new(vec![[0; 3]; 8], quads).unwrap()
    }

    #[test]
    fn ids_are_dense_and_quads_close_the_surface() {
        let mesh = cube();
        for (level, vertices) in [(0, 8), (1, 26), (2, 98), (3, 386)] {
            let grid = QuadGrid::new(&mesh, level).unwrap();
            assert_eq!(grid.vertex_count(), vertices);
            let quads: Vec<_> = grid.quads().collect();
            assert_eq!(quads.len(), grid.quad_count());
            let used: BTreeSet<u32> = quads.iter().flatten().copied().collect();
            assert!(used.iter().copied().eq(0..vertices as u32), "level {level}");
            // closed and oriented: each directed edge once, and its opposite too
            let directed: BTreeSet<_> =
                quads.iter().flat_map(|&[a, b, c, d]| [(a, b), (b, c), (c, d), (d, a)]).collect();
            assert_eq!(directed.len(), 4 * quads.len());
            assert!(directed.iter().all(|&(a, b)| directed.contains(&(b, a))));
        }
    }

    #[test]
    fn a_turned_grid_starts_in_its_corner() {
        let mesh = cube();
        let grid = QuadGrid::new(&mesh, 2).unwrap();
        for corner in 0..4 {
            let at = |ahead, aside| {
                let [u, v] = grid.turned(corner, ahead, aside);
                grid.vertex(1, u, v) as u32
            };
            let quad = mesh.quads()[1];
            let expected = [0, 1, 2, 3].map(|i| quad[(corner + i) % 4]);
            assert_eq!([at(0, 0), at(4, 0), at(4, 4), at(0, 4)], expected);
        }
    }

    #[test]
    fn a_fine_mesh_that_cannot_be_numbered_is_refused() {
        assert!(QuadGrid::new(&cube(), 15).is_err());
    }
}
