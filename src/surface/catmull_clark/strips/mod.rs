//! Quadstrips: a quad mesh cut into rows of quads that follow each other across opposite edges.
//!
//! ```text
//!   t0 ── t1 ── t2 ── ... ── tM        column c = (t_c, b_c);   quad c = t_c, b_c, b_c+1, t_c+1 (ccw)
//!   │  0  │  1  │            │         half-edge c runs from t_c to b_c along quad c
//!   b0 ── b1 ── b2 ── ... ── bM        closed: column M is column 0
//! ```
//!
//! ```text
//!   quad mesh --[cut]--> strips --[records, with Rings]--> columns of vertices, fans and guards
//!                                                       --[calls]--> begin, neighbours, vertex, ..., end
//! ```
//!
//! Source: Hall, sections 3.5, 4.5 and 4.6.

pub mod calls;
pub mod cover;
pub mod records;
pub mod statistics;
pub mod walk;

use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;

/// A row of quads of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Strip {
    /// In each quad, the half-edge from the top to the bottom vertex of its first column.
    half_edges: Vec<u32>,
    /// The last quad is followed by the first.
    closed: bool,
}

/// How a mesh is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// From any quad in one direction until the boundary or a quad that is taken (the thesis's algorithm).
    Walk,
    /// From a quad with the fewest free neighbours towards that with the fewest (its improvement).
    FewestNeighbours,
    /// The longest free run first, then quads and strips turned across as long as strips get fewer.
    Natural,
}

impl Method {
    pub const ALL: [Method; 3] = [Method::Walk, Method::FewestNeighbours, Method::Natural];
}

/// Cuts a mesh into strips, every quad in exactly one; the same strips on every run.
pub fn cut(mesh: &QuadMesh, method: Method) -> Vec<Strip> {
    match method {
        Method::Walk => walk::walk(mesh),
        Method::FewestNeighbours => walk::fewest_neighbours(mesh),
        Method::Natural => cover::natural(mesh),
    }
}

/// The half-edge by which a strip that came in at `half_edge` leaves the quad, as seen from the next quad.
pub(super) fn across(mesh: &QuadMesh, half_edge: u32) -> Option<u32> {
    mesh.topology().opposite(half_edge ^ 2)
}

impl Strip {
    /// M, the number of quads.
    pub fn len(&self) -> usize {
        self.half_edges.len()
    }

    /// A strip has a quad at least.
    pub fn is_empty(&self) -> bool {
        self.half_edges.is_empty()
    }

    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// In each quad, the half-edge from the top to the bottom vertex of its first column.
    pub fn half_edges(&self) -> &[u32] {
        &self.half_edges
    }

    /// The quads from left to right.
    pub fn quads(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.half_edges.iter().map(|h| h / 4)
    }

    /// Top and bottom vertex of column c, 0..=M.
    pub fn column(&self, mesh: &QuadMesh, c: usize) -> [u32; 2] {
        let topology = mesh.topology();
        match self.half_edges.get(c) {
            Some(&h) => [topology.origin(h), topology.destination(h)],
            None => {
                let h = self.half_edges[self.len() - 1] ^ 2; // runs from the bottom to the top
                [topology.destination(h), topology.origin(h)]
            }
        }
    }

    /// The vertex of the fine grid at row 0..=2^L (top to bottom) of fine column 0..=2^L M.
    pub fn fine_vertex(&self, grid: &QuadGrid, column: usize, row: usize) -> usize {
        let c = (column >> grid.level()).min(self.len() - 1);
        let h = self.half_edges[c] as usize;
        let [u, v] = grid.turned(h % 4, row, column - (c << grid.level()));
        grid.vertex(h / 4, u, v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band of n quads that closes.
    pub(super) fn band(n: u32) -> QuadMesh {
        let quads = (0..n).map(|i| [i, (i + 1) % n, n + (i + 1) % n, n + i]).collect();
        QuadMesh::new(vec![[0; 3]; 2 * n as usize], quads).unwrap()
    }

    #[test]
    fn columns_and_fine_vertices_of_a_closed_strip() {
        let mesh = band(5);
        let strip = &cut(&mesh, Method::Natural)[0];
        assert!(strip.is_closed() && strip.len() == 5);
        assert_eq!(strip.column(&mesh, 5), strip.column(&mesh, 0));
        let grid = QuadGrid::new(&mesh, 2).unwrap();
        for c in 0..=5 {
            let fine = [0, 4].map(|row| strip.fine_vertex(&grid, 4 * c, row) as u32);
            assert_eq!(fine, strip.column(&mesh, c));
        }
        for row in 0..=4 {
            assert_eq!(strip.fine_vertex(&grid, 20, row), strip.fine_vertex(&grid, 0, row));
        }
    }

    #[test]
    fn the_quads_of_a_strip_are_counterclockwise() {
        let mesh = band(4);
        for strip in Method::ALL.iter().flat_map(|&method| cut(&mesh, method)) {
            for (c, quad) in strip.quads().enumerate() {
                let [[t, b], [u, d]] = [strip.column(&mesh, c), strip.column(&mesh, c + 1)];
                let corners = mesh.quads()[quad as usize];
                let first = corners.iter().position(|&v| v == t).unwrap();
                assert_eq!([0, 1, 2, 3].map(|i| corners[(first + i) % 4]), [t, b, d, u]);
            }
        }
    }
}
