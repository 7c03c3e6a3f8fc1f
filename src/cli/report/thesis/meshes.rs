//! What is sent for meshes, and what software keeps of them.

use serde::Serialize;

use crate::error::Result;
use crate::fixed::Format;
use crate::mesh::{self, shapes};
use crate::surface::catmull_clark::masks::Corners;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Boundary, Rings};
use crate::surface::catmull_clark::strips::records::records;
use crate::surface::catmull_clark::strips::statistics::Statistics;
use crate::surface::catmull_clark::strips::{Method, cut};
use crate::surface::catmull_clark::winged::{WingedMesh, face_based_pointers, winged_edge_pointers};

/// What a mesh costs. Every number is divided by its vertices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OnMesh {
    pub mesh: String,
    pub vertices: usize,
    pub strips: usize,
    pub mean_length: f64,
    pub words: f64,
    pub winged_edge_pointers: f64,
    pub face_based_pointers: f64,
    pub strip_pointers: f64,
    /// After three levels in software, which make the strips eight times as long.
    pub strip_pointers_refined: f64,
}

/// The built-in quad meshes, and at last a torus with long strips.
pub fn meshes() -> Result<Vec<OnMesh>> {
    let mut found = vec![];
    for shape in shapes().iter().filter(|shape| shape.name.ends_with("-quads")) {
        let mesh = mesh::quantise(&shape.mesh(), Format { integer: 2, fraction: 12 })?;
        let corners = |face: &Vec<u32>| <[u32; 4]>::try_from(face.as_slice()).ok();
        let quads: Vec<[u32; 4]> = mesh.faces.iter().filter_map(corners).collect();
        found.push(on_mesh(shape.name, &QuadMesh::new(mesh.positions, quads)?)?);
    }
    found.push(on_mesh(&format!("torus of {TORUS} x {TORUS} quads"), &torus(TORUS)?)?);
    Ok(found)
}

/// Quads around the torus either way.
const TORUS: u32 = 96;

fn torus(n: u32) -> Result<QuadMesh> {
    let vertex = |i: u32, j: u32| i % n * n + j % n;
    let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let quad = |(i, j)| [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
    // Only who is beside whom matters here.
    let positions = places.clone().map(|(i, j)| [i.into(), j.into(), 0]).collect();
    QuadMesh::new(positions, places.map(quad).collect())
}

fn on_mesh(name: &str, mesh: &QuadMesh) -> Result<OnMesh> {
    let rings = Rings::new(mesh, Boundary::Ghosts)?;
    let strips = cut(mesh, Method::Natural);
    let sent: Vec<_> = strips.iter().map(|strip| records(mesh, &rings, strip)).collect();
    let statistics = Statistics::of(mesh.vertex_count(), &strips, &sent);
    let winged = WingedMesh::new(mesh, &strips, Corners::Smooth);
    // Three levels of a large mesh are no longer small; there the strips are long as they are.
    let refined = if mesh.quads().len() > 1000 { 0 } else { 3 };
    let fine = (0..refined).fold(winged.clone(), |mesh, _| mesh.subdivided());
    let per_vertex = |count: usize| count as f64 / mesh.vertex_count() as f64;
    Ok(OnMesh {
        mesh: name.into(),
        vertices: mesh.vertex_count(),
        strips: statistics.strips,
        mean_length: statistics.mean_length(),
        words: statistics.words_per_vertex(),
        winged_edge_pointers: per_vertex(winged_edge_pointers(mesh.topology().edge_count() as usize)),
        face_based_pointers: per_vertex(face_based_pointers(4 * mesh.quads().len())),
        strip_pointers: per_vertex(winged.pointers()),
        strip_pointers_refined: fine.pointers() as f64 / fine.positions.len() as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_strips_of_a_regular_mesh_cost_four_words_and_four_pointers_a_vertex() {
        let mesh = on_mesh("torus", &torus(TORUS).unwrap()).unwrap();
        assert_eq!((mesh.strips, mesh.mean_length), (96, 96.0));
        // A closed strip sends its first column twice, and two guards of four words.
        assert_eq!(mesh.words, f64::from(4 * 97 + 8) / 96.0);
        assert_eq!((mesh.winged_edge_pointers, mesh.face_based_pointers), (16.0, 12.0));
        assert_eq!(mesh.strip_pointers, f64::from(4 * 96 + 4) / 96.0);
    }
}
