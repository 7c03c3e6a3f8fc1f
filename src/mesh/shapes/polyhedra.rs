//! Solids with straight edges: the Platonic ones and bipyramids.

use super::Parts;
use crate::mesh::Mesh;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

fn polygons<const N: usize>(faces: &[[u32; N]]) -> Vec<Vec<u32>> {
    faces.iter().map(|face| face.to_vec()).collect()
}

pub(super) fn tetrahedron() -> Parts {
    let points = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]];
    let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    (points.map(|p| DVec3::from_array(p) * 0.75).to_vec(), polygons(&faces))
}

pub(super) fn octahedron() -> Parts {
    bipyramid(4)
}

/// The twelve points (0, ±1, ±g) and their rotations, g the golden section; scaled to fit.
pub(super) fn icosahedron() -> Parts {
    let short = 2.0 / (1.0 + 5f64.sqrt());
    let mut points = Vec::new();
    for (y, z) in [(short, 1.0), (-short, 1.0), (short, -1.0), (-short, -1.0)] {
        points.extend([dvec3(0.0, y, z), dvec3(z, 0.0, y), dvec3(y, z, 0.0)]);
    }
    // Neighbours are the pairs at the distance of an edge; a face is three mutual neighbours, turned outside.
    let near = |a: u32, b: u32| points[a as usize].distance(points[b as usize]) < 2.0 * short + 0.01;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|v| points[v as usize]);
                    faces.push(if p.dot(q.cross(r)) > 0.0 { vec![a, b, c] } else { vec![a, c, b] });
                }
            }
        }
    }
    (points, faces)
}

/// ```text
///    6 ─── 7
///   ╱│    ╱│
///  2 ─── 3 │       y
///  │ 4 ──│ 5       │ z (towards us)
///  │╱    │╱        │╱
///  0 ─── 1         └── x
/// ```
/// The box of Hall, chapter 5, in its numbering.
pub(super) fn cube_quads() -> Parts {
    let side = |bit: u32| if bit == 0 { -0.75 } else { 0.75 };
    let points = (0..8).map(|i: u32| dvec3(side(i & 1), side(i & 2), -side(i & 4))).collect();
    let faces = [[0, 1, 3, 2], [2, 3, 7, 6], [6, 7, 5, 4], [4, 5, 1, 0], [1, 5, 7, 3], [2, 6, 4, 0]];
    (points, polygons(&faces))
}

/// Each square cut from its first corner.
pub(super) fn cube() -> Parts {
    cut(cube_quads())
}

/// Every polygon as the fan of its first corner.
pub(super) fn cut((points, faces): Parts) -> Parts {
    let mesh = Mesh::new("", points, faces).triangulated();
    (mesh.positions, mesh.faces)
}

/// Two apexes of valence `sides` over and under a ring of valence 4.
pub(super) fn bipyramid(sides: u32) -> Parts {
    let mut points = vec![dvec3(0.0, 1.0, 0.0), dvec3(0.0, -1.0, 0.0)];
    let angle = |i: u32| f64::from(i) * TAU / f64::from(sides);
    points.extend((0..sides).map(|i| dvec3(angle(i).cos(), 0.0, -angle(i).sin())));
    let sides = (0..sides).map(|i| (2 + i, 2 + (i + 1) % sides));
    let faces = sides.flat_map(|(a, b)| [vec![0, a, b], vec![1, b, a]]).collect();
    (points, faces)
}
