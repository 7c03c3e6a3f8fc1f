//! Strips sent call by call arrive as the same records; and what the records say about the mesh.

use crate::cc_meshes::{closed, lattice, open, ragged, shaken};
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::calls::{Call, StripBuilder, calls};
use subdiv_rtl::surface::catmull_clark::strips::records::{positioned, records};
use subdiv_rtl::surface::catmull_clark::strips::statistics::Statistics;
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

const BOUNDARIES: [Boundary; 3] = [Boundary::Ghosts, Boundary::Repeated, Boundary::Rim];

#[test]
fn calls_and_records_are_the_same() {
    let mut strips_seen = 0;
    for (name, mesh) in closed().iter().chain(&open()).chain(&ragged()) {
        for boundary in BOUNDARIES {
            let Ok(rings) = Rings::new(mesh, boundary) else { continue };
            let mut builder = StripBuilder::new();
            for strip in Method::ALL.iter().flat_map(|&method| cut(mesh, method)) {
                let sent = records(mesh, &rings, &strip);
                let mut arrived = Vec::new();
                for call in calls(&sent) {
                    arrived.extend(builder.call(call).unwrap());
                }
                assert_eq!(arrived, [sent], "{name} {boundary:?}");
                strips_seen += 1;
            }
        }
    }
    assert!(strips_seen > 1000, "{strips_seen}");
}

/// Every outside face over a strip edge is a face of the mesh or a ghost face: v_c, v_c+1, uR(c), uL(c+1).
#[test]
fn outside_faces_over_strip_edges_are_faces_of_the_mesh() {
    for (name, mesh) in &closed() {
        let rings = Rings::new(mesh, Boundary::Ghosts).unwrap();
        for strip in cut(mesh, Method::Natural) {
            let records = records(mesh, &rings, &strip);
            for pair in records.columns.windows(2) {
                for end in 0..2 {
                    let mut face = [
                        pair[0].vertices[end],
                        pair[1].vertices[end],
                        pair[0].outside[end].right,
                        pair[1].outside[end].left,
                    ];
                    face.sort_unstable();
                    let exists = mesh.quads().iter().any(|quad| {
                        let mut quad = *quad;
                        quad.sort_unstable();
                        quad == face
                    });
                    assert!(exists, "{name} {face:?}");
                }
            }
        }
    }
}

/// Four words a vertex on a torus (Hall, section 6.1): two of the strip and two outside of it in each column,
/// and three columns of each strip twice.
#[test]
fn a_regular_mesh_costs_four_words_a_vertex() {
    let mesh = shaken(lattice(40, 6, [true, true]), 10, 3);
    let rings = Rings::new(&mesh, Boundary::Ghosts).unwrap();
    let strips = cut(&mesh, Method::Natural);
    let statistics = Statistics::of(mesh.vertex_count(), &strips, &positioned(&mesh, &rings, &strips));
    assert_eq!((statistics.strips, statistics.closed, statistics.longest), (6, 6, 40));
    assert_eq!(statistics.words, 6 * 4 * 43);
    assert!((statistics.words_per_vertex() - 4.3).abs() < 1e-12);
    // the calls of a closed strip send each column once: exactly four
    let records = records(&mesh, &rings, &strips[0]);
    let words = calls(&records).iter().filter(|c| matches!(c, Call::Neighbour(_) | Call::Vertex(_))).count();
    assert_eq!(words, 4 * 40);
}
