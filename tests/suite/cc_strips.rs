//! Cutting a mesh into strips and rendering all of them gives exactly the subdivided mesh.

use crate::cc_meshes::{closed, open, ragged};
use std::collections::{BTreeMap, BTreeSet};
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::strips::{Method, Strip, cut};

fn all() -> Vec<(&'static str, QuadMesh)> {
    closed().into_iter().chain(open()).chain(ragged()).collect()
}

#[test]
fn the_zoo_has_what_it_promises() {
    let (mut interior, mut boundary, mut neighbours_of_three) = (BTreeSet::new(), BTreeSet::new(), 0);
    for (_, mesh) in all() {
        let topology = mesh.topology();
        for v in 0..topology.vertex_count() {
            let set = if topology.is_boundary(v) { &mut boundary } else { &mut interior };
            set.insert(topology.valence(v));
        }
        let three = |v: u32| !topology.is_boundary(v) && topology.valence(v) == 3;
        neighbours_of_three += topology.edges().filter(|e| e.vertices.iter().all(|&v| three(v))).count();
    }
    assert!((3..=9).all(|d| interior.contains(&d)) && interior.contains(&16), "{interior:?}");
    assert!((2..=9).all(|d| boundary.contains(&d) || [6, 7, 8].contains(&d)), "{boundary:?}");
    assert!(neighbours_of_three > 12);
}

#[test]
fn every_quad_is_in_exactly_one_strip() {
    for (name, mesh) in all() {
        for method in Method::ALL {
            let strips = cut(&mesh, method);
            let mut quads: Vec<u32> = strips.iter().flat_map(|s| s.quads().collect::<Vec<_>>()).collect();
            quads.sort_unstable();
            assert!(quads.iter().copied().eq(0..mesh.quads().len() as u32), "{name} {method:?}");
            assert_eq!(strips, cut(&mesh, method), "{name} {method:?}");
        }
    }
}

#[test]
fn consecutive_quads_share_a_column_and_closed_strips_close() {
    let mut closed_strips = 0;
    for (name, mesh) in all() {
        for strip in Method::ALL.iter().flat_map(|&method| cut(&mesh, method)) {
            for (c, quad) in strip.quads().enumerate() {
                let corners = mesh.quads()[quad as usize];
                for column in [strip.column(&mesh, c), strip.column(&mesh, c + 1)] {
                    assert!(column.iter().all(|v| corners.contains(v)), "{name}");
                }
            }
            let ends = [0, strip.len()].map(|c| strip.column(&mesh, c));
            assert_eq!(strip.is_closed(), ends[0] == ends[1], "{name}");
            closed_strips += usize::from(strip.is_closed());
        }
    }
    assert!(closed_strips > 50, "{closed_strips}");
}

/// Quads between consecutive fine columns, turned so that the lowest vertex comes first.
fn fine_quads(strip: &Strip, grid: &QuadGrid) -> Vec<[u32; 4]> {
    let n = grid.steps();
    let at = |column: usize, row: usize| strip.fine_vertex(grid, column, row) as u32;
    let quad = |column: usize, row: usize| {
        [at(column, row), at(column, row + 1), at(column + 1, row + 1), at(column + 1, row)]
    };
    (0..n * strip.len()).flat_map(|column| (0..n).map(move |row| turned(quad(column, row)))).collect()
}

fn turned(mut quad: [u32; 4]) -> [u32; 4] {
    let lowest = (0..4).min_by_key(|&i| quad[i]).unwrap_or(0);
    quad.rotate_left(lowest);
    quad
}

#[test]
fn the_columns_of_all_strips_make_up_the_subdivided_mesh_with_its_orientation() {
    for (name, mesh) in all() {
        for level in 0..=3 {
            let grid = QuadGrid::new(&mesh, level).unwrap();
            let mut expected: Vec<[u32; 4]> = grid.quads().map(turned).collect();
            expected.sort_unstable();
            for method in Method::ALL {
                let mut quads: Vec<_> =
                    cut(&mesh, method).iter().flat_map(|s| fine_quads(s, &grid)).collect();
                quads.sort_unstable();
                assert_eq!(quads, expected, "{name} {method:?} level {level}");
            }
        }
    }
}

#[test]
fn natural_strips_are_never_more_than_those_of_the_thesis() {
    let mut totals = BTreeMap::new();
    for (name, mesh) in all() {
        let counts = Method::ALL.map(|method| cut(&mesh, method).len());
        assert!(counts[2] <= counts[0] && counts[2] <= counts[1], "{name}: {counts:?}");
        println!("{name}: {} quads, strips {counts:?}", mesh.quads().len());
        for (method, count) in Method::ALL.into_iter().zip(counts) {
            *totals.entry(method).or_insert(0) += count;
        }
    }
    println!("{totals:?}");
    assert!(totals[&Method::Natural] * 10 < totals[&Method::Walk] * 9, "{totals:?}");
    assert!(totals[&Method::Natural] * 10 < totals[&Method::FewestNeighbours] * 9, "{totals:?}");
}
