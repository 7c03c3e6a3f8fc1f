//! Global names for the vertices of the fine mesh: every triangle of the control mesh carries a grid of
//! n = 2^r steps, and a grid point on a corner or an edge is the same vertex in all triangles around.
//!
//! ```text
//!        2            ids:  0 ..                      control vertices that are used, in order
//!        | \                then n - 1 an edge        from its lower to its higher vertex
//!      v |   \              then (n-1)(n-2)/2 a face  u = 1.., in each v = 1..
//!        0 --- 1
//!          u
//! ```

use crate::error::{Error, Result};
use crate::surface::control_mesh::ControlMesh;

/// Maps (face, u, v) to dense vertex ids at one level.
#[derive(Clone, Debug)]
pub struct FineGrid<'a> {
    mesh: &'a ControlMesh,
    level: u32,
    /// Dense number of each control vertex that a triangle uses.
    corner_id: Vec<u32>,
    corners: usize,
}

impl<'a> FineGrid<'a> {
    /// # Errors
    /// A fine mesh of more than 2^32 vertices.
    pub fn new(mesh: &'a ControlMesh, level: u32) -> Result<Self> {
        let mut corner_id = Vec::with_capacity(mesh.positions().len());
        let mut corners = 0;
        for v in 0..mesh.positions().len() as u32 {
            corner_id.push(corners);
            corners += u32::from(mesh.ring(v).valence() > 0);
        }
        let grid = FineGrid { mesh, level, corner_id, corners: corners as usize };
        if level >= 16 || grid.vertex_count() > u32::MAX as usize {
            return Err(Error::usage(format!("level {level} has too many vertices to number"))
                .help("render at a lower level"));
        }
        Ok(grid)
    }

    pub fn mesh(&self) -> &'a ControlMesh {
        self.mesh
    }

    pub fn level(&self) -> u32 {
        self.level
    }

    /// Steps along each edge, n = 2^level.
    pub fn steps(&self) -> usize {
        1 << self.level
    }

    fn inner_of_edge(&self) -> usize {
        self.steps() - 1
    }

    fn inner_of_face(&self) -> usize {
        let n = self.steps();
        (n - 1) * n.saturating_sub(2) / 2
    }

    /// Vertices of the mesh subdivided `level` times.
    pub fn vertex_count(&self) -> usize {
        self.corners
            + self.mesh.edges().len() * self.inner_of_edge()
            + self.mesh.triangles().len() * self.inner_of_face()
    }

    /// Triangles of the mesh subdivided `level` times.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles().len() << (2 * self.level)
    }

    /// The id of grid point (u, v), u + v <= n, of triangle `face`.
    pub fn vertex(&self, face: usize, u: usize, v: usize) -> usize {
        let n = self.steps();
        let w = n - u - v;
        let triangle = &self.mesh.triangles()[face];
        match (u == n, v == n, w == n) {
            (true, ..) => return self.corner_id[triangle[1] as usize] as usize,
            (_, true, _) => return self.corner_id[triangle[2] as usize] as usize,
            (.., true) => return self.corner_id[triangle[0] as usize] as usize,
            _ => {}
        }
        let along = |side: usize, t: usize| {
            let upwards = triangle[side] < triangle[(side + 1) % 3];
            let t = if upwards { t } else { n - t };
            self.corners + self.mesh.triangle_edges(face)[side] as usize * self.inner_of_edge() + t - 1
        };
        match (u, v, w) {
            (_, 0, _) => along(0, u),
            (.., 0) => along(1, v),
            (0, ..) => along(2, w),
            _ => {
                let columns_before = (u - 1) * (n - 2) - (u - 1) * u.saturating_sub(2) / 2;
                self.corners
                    + self.mesh.edges().len() * self.inner_of_edge()
                    + face * self.inner_of_face()
                    + columns_before
                    + (v - 1)
            }
        }
    }

    /// All triangles of the fine mesh, oriented as their roots: face by face, column by column.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let n = self.steps();
        let faces = 0..self.mesh.triangles().len();
        faces.flat_map(move |face| {
            let at = move |u, v| self.vertex(face, u, v) as u32;
            (0..n).flat_map(move |u| {
                (0..n - u).flat_map(move |v| {
                    let upright = [at(u, v), at(u + 1, v), at(u, v + 1)];
                    let turned = (u + v + 1 < n).then(|| [at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]);
                    std::iter::once(upright).chain(turned)
                })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn tetrahedron() -> ControlMesh {
        // vertex 2 is unused on purpose
        let faces = vec![[0, 1, 3], [0, 4, 1], [1, 4, 3], [3, 4, 0]];
        ControlMesh::new(vec![[0; 3]; 5], faces).unwrap()
    }

    #[test]
    fn ids_are_dense_and_triangles_close_the_surface() {
        let mesh = tetrahedron();
        for (level, vertices) in [(0, 4), (1, 10), (2, 34), (3, 130)] {
            let grid = FineGrid::new(&mesh, level).unwrap();
            assert_eq!(grid.vertex_count(), vertices);
            let triangles: Vec<_> = grid.triangles().collect();
            assert_eq!(triangles.len(), grid.triangle_count());
            let used: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
            assert!(used.iter().copied().eq(0..vertices as u32), "level {level}");
            // closed and oriented: each directed edge once, and its opposite too
            let directed: BTreeSet<_> =
                triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
            assert_eq!(directed.len(), 3 * triangles.len());
            assert!(directed.iter().all(|&(a, b)| directed.contains(&(b, a))));
        }
    }

    #[test]
    fn a_fine_mesh_that_cannot_be_numbered_is_refused() {
        assert!(FineGrid::new(&tetrahedron(), 16).is_err());
    }
}
