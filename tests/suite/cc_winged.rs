//! The software algorithm of the thesis's chapter 3 on winged quadstrips.

use crate::cc_meshes::{closed, of_shape, open, ragged};
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::masks::Corners;
use subdiv_rtl::surface::catmull_clark::oracle::{QuadOracle, Target};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};
use subdiv_rtl::surface::catmull_clark::winged::{
    WingedMesh, face_based_pointers, winged_edge_pointers, winged_strip_pointers,
};

/// Strip s of M quads has become 2^L strips of 2^L M quads; row r of them is the r-th from the top.
#[test]
fn strips_become_long_ones_with_the_positions_of_the_subdivided_mesh() {
    for (name, mesh) in closed().iter().chain(&open()).chain(&ragged()) {
        for corners in [Corners::Smooth, Corners::Sharp] {
            let levels = 3;
            let strips = cut(mesh, Method::Natural);
            let mut winged = WingedMesh::new(mesh, &strips, corners);
            (0..levels).for_each(|_| winged = winged.subdivided());
            let grid = QuadGrid::new(mesh, levels).unwrap();
            let oracle = QuadOracle::new(mesh, levels, corners).unwrap();
            assert_eq!(winged.positions.len(), grid.vertex_count(), "{name}");
            assert_eq!(winged.strips.len(), strips.len() << levels);
            for (s, strip) in strips.iter().enumerate() {
                for row in 0..grid.steps() {
                    let fine = &winged.strips[(s << levels) + row];
                    assert_eq!(fine.columns.len(), (strip.len() << levels) + 1, "{name}");
                    for (column, vertices) in fine.columns.iter().enumerate() {
                        for (below, &v) in vertices.iter().enumerate() {
                            let vertex = strip.fine_vertex(&grid, column, row + below);
                            let expected = oracle.position(vertex, Target::Refined);
                            let off =
                                winged.positions[v as usize].iter().zip(expected).map(|(a, b)| (a - b).abs());
                            assert!(
                                off.fold(0.0, f64::max) < 1e-9,
                                "{name} strip {s} column {column} row {row}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn pointers_are_a_third_of_those_of_faces_and_a_quarter_of_those_of_edges() {
    let mesh = of_shape("torus-quads");
    let strips = cut(&mesh, Method::Natural);
    let mut winged = WingedMesh::new(&mesh, &strips, Corners::Smooth);
    assert_eq!(winged.pointers(), winged_strip_pointers(72, strips.len()));
    (0..3).for_each(|_| winged = winged.subdivided());
    // a torus of V vertices has V quads and 2V edges
    let v = winged.positions.len();
    assert_eq!((winged_edge_pointers(2 * v), face_based_pointers(4 * v)), (16 * v, 12 * v));
    let each = winged.pointers() as f64 / v as f64;
    assert!((4.0..4.05).contains(&each), "{each}");
}

#[test]
fn the_mean_length_doubles_with_every_level() {
    let mesh = of_shape("blob-quads");
    let strips = cut(&mesh, Method::Natural);
    let mut winged = WingedMesh::new(&mesh, &strips, Corners::Smooth);
    let mean =
        |w: &WingedMesh| w.strips.iter().map(|s| s.len()).sum::<usize>() as f64 / w.strips.len() as f64;
    let before = mean(&winged);
    (0..3).for_each(|_| winged = winged.subdivided());
    assert_eq!(mean(&winged), 8.0 * before);
}
