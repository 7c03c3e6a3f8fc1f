//! Boundaries, corners and creases by repeated vertices, as the thesis handles them.
//!
//! ```text
//!        P'── P'── P'      copies of the boundary row; the quads between them have no height
//!        │    │    │
//!   ──── P ── P ── P ──    old boundary        rows  the surface along the boundary
//!        │    │    │                            0    begins at 5/6 of the boundary row + 1/6 of the next
//!   ──── I ── I ── I ──                         1    begins at the boundary row's spline, (A + 4P + B)/6
//! ```
//!
//! The copies are quads like all others and are cut into strips with them ("the software can simply send extra
//! strips near the boundaries"); behind the last row the ghosts are copies again, see
//! [`Boundary::Repeated`]. A corner gets a copy on both sides and one between them, so with one row it stays
//! where it is. A crease is two boundaries in the same place: [`cut_along`] opens the mesh along edges, and with
//! one row both sides follow the same spline; where three or more cuts meet, a cusp.
//!
//! Source: Hall, section 4.3.
//!
//! [`Boundary::Repeated`]: crate::surface::catmull_clark::rings::Boundary::Repeated

use crate::error::{Error, Result};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use std::collections::BTreeSet;

/// The mesh with `rows` rows of repeated vertices around its boundary. The old vertices and quads come first.
///
/// # Errors
/// None on a mesh that is one; the new mesh is checked like any other.
pub fn repeated(mesh: &QuadMesh, rows: u32) -> Result<QuadMesh> {
    let mut mesh = mesh.clone();
    for _ in 0..rows {
        mesh = one_row(&mesh)?;
    }
    Ok(mesh)
}

fn one_row(mesh: &QuadMesh) -> Result<QuadMesh> {
    let topology = mesh.topology();
    let (mut positions, mut quads) = (mesh.positions().to_vec(), mesh.quads().to_vec());
    // Copies of each boundary vertex: beside the edge that leaves it along the boundary, and the one that arrives.
    let mut copies = vec![[0; 2]; mesh.vertex_count()];
    for v in (0..topology.vertex_count()).filter(|&v| topology.is_boundary(v)) {
        let first = positions.len() as u32;
        let corner = topology.valence(v) == 2;
        copies[v as usize] = if corner { [first, first + 1] } else { [first; 2] };
        for _ in 0..if corner { 3 } else { 1 } {
            positions.push(mesh.positions()[v as usize]);
        }
        if corner {
            quads.push([v, first + 1, first + 2, first]);
        }
    }
    for h in (0..topology.half_edge_count()).filter(|&h| topology.opposite(h).is_none()) {
        let (from, to) = (topology.origin(h), topology.destination(h));
        quads.push([to, from, copies[from as usize][0], copies[to as usize][1]]);
    }
    QuadMesh::new(positions, quads)
}

/// A mesh opened along edges.
#[derive(Clone, Debug)]
pub struct Opened {
    pub mesh: QuadMesh,
    /// The vertex of the old mesh that each vertex is a copy of; the first copies keep their numbers.
    pub copy_of: Vec<u32>,
}

/// Opens a mesh along edges, given by their vertices: a vertex gets one copy for each sector between cuts.
///
/// An edge opens if one of its vertices has another cut or lies on the boundary; the quads keep their numbers.
///
/// # Errors
/// Two vertices without an edge between them.
pub fn cut_along(mesh: &QuadMesh, edges: &[[u32; 2]]) -> Result<Opened> {
    let topology = mesh.topology();
    let mut cut = BTreeSet::new();
    for &[a, b] in edges {
        let edge = topology.edges().find(|e| e.vertices == [a, b] || e.vertices == [b, a]);
        let Some(edge) = edge else {
            return Err(Error::input(format!("there is no edge between vertices {a} and {b}"))
                .help("a crease runs along edges of the quad mesh"));
        };
        cut.insert(edge.id);
    }
    let mut opened = Opened { mesh: mesh.clone(), copy_of: (0..topology.vertex_count()).collect() };
    let (mut positions, mut quads) = (mesh.positions().to_vec(), mesh.quads().to_vec());
    for v in 0..topology.vertex_count() {
        let around: Vec<u32> = topology.half_edges_around(v).collect();
        let is_cut = |&h: &u32| cut.contains(&topology.edge_of(h));
        // The boundary begins the fan of a boundary vertex; else it begins at the first cut.
        let first = if topology.is_boundary(v) { Some(0) } else { around.iter().position(is_cut) };
        let Some(first) = first else { continue };
        let mut copy = v;
        for i in 0..around.len() {
            let h = around[(first + i) % around.len()];
            if i > 0 && is_cut(&h) {
                copy = positions.len() as u32;
                positions.push(mesh.positions()[v as usize]);
                opened.copy_of.push(v);
            }
            quads[h as usize / 4][h as usize % 4] = copy;
        }
    }
    opened.mesh = QuadMesh::new(positions, quads)?;
    Ok(opened)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// columns x rows cells of 6 x 6 units.
    fn sheet(columns: u32, rows: u32) -> QuadMesh {
        let at = |x: u32, y: u32| y * (columns + 1) + x;
        let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let quads = cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect();
        let points =
            (0..=rows).flat_map(|y| (0..=columns).map(move |x| [6 * i64::from(x), 6 * i64::from(y), 0]));
        QuadMesh::new(points.collect(), quads).unwrap()
    }

    #[test]
    fn a_row_of_copies_surrounds_the_boundary() {
        let mesh = repeated(&sheet(2, 1), 1).unwrap();
        // 2 x 1 cells become 4 x 3
        assert_eq!((mesh.quads().len(), mesh.vertex_count()), (12, 20));
        assert_eq!(mesh.quads()[..2], *sheet(2, 1).quads());
        let corners = (0..20).filter(|&v| mesh.topology().valence(v) == 2).count();
        assert_eq!((corners, mesh.topology().boundary_loops().len()), (4, 1));
        assert_eq!(mesh.largest_irregular_valence(), None);
    }

    #[test]
    fn a_cut_from_boundary_to_boundary_divides_the_sheet() {
        let opened = cut_along(&sheet(2, 2), &[[1, 4], [7, 4]]).unwrap();
        assert_eq!((opened.mesh.vertex_count(), opened.mesh.topology().component_count()), (12, 2));
        let mut copies = opened.copy_of[9..].to_vec();
        copies.sort_unstable();
        assert_eq!(copies, [1, 4, 7]);
    }

    #[test]
    fn a_cut_that_ends_inside_is_a_slit() {
        let opened = cut_along(&sheet(2, 2), &[[1, 4]]).unwrap();
        assert_eq!((opened.mesh.vertex_count(), opened.mesh.topology().component_count()), (10, 1));
        assert!(opened.mesh.topology().is_boundary(4));
        assert!(cut_along(&sheet(2, 2), &[[0, 4]]).is_err());
    }
}
