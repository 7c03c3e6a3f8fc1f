//! A control mesh of quadrilaterals over integer positions.
//!
//! ```text
//!   3 ───── 2     corners counterclockwise seen from outside; side i runs from corner i to corner i+1
//!   │   f   │     and is half-edge 4f + i of the topology
//!   0 ───── 1
//! ```

use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use glam::DVec3;

/// Quadrilaterals over integer control points, and who is next to whom.
#[derive(Clone, Debug)]
pub struct QuadMesh {
    positions: Vec<[i64; 3]>,
    quads: Vec<[u32; 4]>,
    topology: Topology,
}

impl QuadMesh {
    /// # Errors
    /// Whatever [`Topology::new`] refuses, and an interior vertex with two edges.
    pub fn new(positions: Vec<[i64; 3]>, quads: Vec<[u32; 4]>) -> Result<Self> {
        let points = positions.iter().map(|p| DVec3::from_array(p.map(|x| x as f64))).collect();
        let mesh = Mesh::new("quad mesh", points, quads.iter().map(|q| q.to_vec()).collect());
        Self::with_topology(positions, quads, Topology::new(&mesh)?)
    }

    /// The quads of a mesh at other positions; its messages name the vertices of its file.
    ///
    /// # Errors
    /// A face that is no quad, an interior vertex with two edges.
    pub(super) fn of_mesh(mesh: &Mesh, topology: Topology, positions: Vec<[i64; 3]>) -> Result<Self> {
        topology.check_valences(mesh, 3..=u32::MAX, 2..=u32::MAX)?;
        let quad = |(f, face): (usize, &Vec<u32>)| {
            face.as_slice().try_into().map_err(|_| {
                Error::input(format!("a face has {} corners, and only quads will do here", face.len()))
                    .at(mesh.face_place(f))
                    .help("subdivide the mesh once, all faces are quads after that")
            })
        };
        let quads = mesh.faces.iter().enumerate().map(quad).collect::<Result<_>>()?;
        Ok(QuadMesh { positions, quads, topology })
    }

    pub(super) fn with_topology(
        positions: Vec<[i64; 3]>,
        quads: Vec<[u32; 4]>,
        topology: Topology,
    ) -> Result<Self> {
        let mesh = QuadMesh { positions, quads, topology };
        let two = |&v: &u32| !mesh.topology.is_boundary(v) && mesh.topology.valence(v) < 3;
        match (0..mesh.topology.vertex_count()).find(two) {
            None => Ok(mesh),
            Some(v) => Err(Error::input(format!("interior vertex {v} has two edges only"))
                .help("join the two faces around it")),
        }
    }

    pub fn positions(&self) -> &[[i64; 3]] {
        &self.positions
    }

    pub fn quads(&self) -> &[[u32; 4]] {
        &self.quads
    }

    /// Half-edge 4f + i leaves corner i of quad f.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// The largest valence of an interior vertex other than 4, if there is one.
    pub fn largest_irregular_valence(&self) -> Option<usize> {
        let interior = (0..self.topology.vertex_count()).filter(|&v| !self.topology.is_boundary(v));
        interior.map(|v| self.topology.valence(v) as usize).filter(|&d| d != 4).max()
    }

    /// The bits that the coordinates need in two's complement; at least 2.
    pub fn width(&self) -> u32 {
        width(&self.positions)
    }
}

/// The bits that coordinates need in two's complement; at least 2.
pub fn width(positions: &[[i64; 3]]) -> u32 {
    let bits = |x: &i64| 65 - (x ^ (x >> 63)).leading_zeros();
    positions.iter().flatten().map(bits).max().unwrap_or(2).max(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_edges_are_numbered_by_quad_and_side() {
        let mesh = QuadMesh::new(vec![[0; 3]; 6], vec![[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap();
        let topology = mesh.topology();
        assert_eq!((topology.origin(5), topology.destination(5)), (2, 5));
        assert_eq!(topology.opposite(1), Some(7));
        assert_eq!(mesh.largest_irregular_valence(), None);
    }

    #[test]
    fn an_interior_vertex_of_two_quads_is_refused() {
        // two quads glued along two sides that meet in vertex 1, closed by a third around the rest
        let quads = vec![[0, 1, 2, 3], [2, 1, 0, 4], [0, 3, 2, 4]];
        let error = QuadMesh::new(vec![[0; 3]; 5], quads).unwrap_err();
        assert!(error.what.contains("two edges"), "{error}");
    }

    #[test]
    fn width_counts_the_sign() {
        let of = |x: i64| width(&[[0, x, 0]]);
        assert_eq!([0, 1, -2, 2, -8, 7, 8].map(of), [2, 2, 2, 3, 4, 4, 5]);
    }
}
