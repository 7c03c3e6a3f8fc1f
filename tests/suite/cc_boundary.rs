//! Boundaries: what ghosts can do and what they cannot, repeated vertices, creases.

use crate::cc_meshes::{lattice, open, ragged, voxels};
use num_rational::BigRational;
use num_traits::{One, Zero};
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters};
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::masks::Corners;
use subdiv_rtl::surface::catmull_clark::oracle::{QuadOracle, Target};
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::repeat::{cut_along, repeated};
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

type Q = BigRational;
type Matrix = Vec<Vec<Q>>;

fn q(numerator: i64, denominator: i64) -> Q {
    Q::new(numerator.into(), denominator.into())
}

/// The step of a ring as a matrix over S, A_0 .. A_{n-1}, D_0 .. (D_i between A_i and A_i+1): a closed ring, or
/// the half ring of a boundary vertex with its smooth rule.
fn step(edges: usize, closed: bool) -> Matrix {
    let faces = if closed { edges } else { edges - 1 };
    let (a, d) = (|i: usize| 1 + i % edges, |i: usize| 1 + edges + i % faces);
    let mut m = vec![vec![Q::zero(); 1 + edges + faces]; 1 + edges + faces];
    let mut add = |row: usize, column: usize, weight: Q| m[row][column] += weight;
    for i in 0..edges {
        let inner = closed || (i > 0 && i + 1 < edges);
        if inner {
            let before = (i + faces - 1) % faces;
            for (column, weight) in
                [(0, 6), (a(i), 6), (a(i + 1), 1), (a(i + edges - 1), 1), (d(i), 1), (d(before), 1)]
            {
                add(a(i), column, q(weight, 16));
            }
        } else {
            add(a(i), 0, q(1, 2));
            add(a(i), a(i), q(1, 2));
            add(0, a(i), q(1, 8));
        }
    }
    for i in 0..faces {
        for column in [0, a(i), a(i + 1), d(i)] {
            add(d(i), column, q(1, 4));
        }
    }
    let n = edges as i64;
    if closed {
        add(0, 0, Q::one() - q(7, 4 * n));
        (0..edges).for_each(|i| add(0, a(i), q(6, 4 * n * n)));
        (0..faces).for_each(|i| add(0, d(i), q(1, 4 * n * n)));
    } else {
        add(0, 0, q(3, 4));
    }
    m
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &Vec<Q>, j: usize| row.iter().zip(b).map(|(x, b)| x * &b[j]).sum();
    a.iter().map(|row| (0..b[0].len()).map(|j| entry(row, j)).collect()).collect()
}

fn rank(mut m: Matrix) -> usize {
    let mut rank = 0;
    for column in 0..m[0].len() {
        let Some(pivot) = (rank..m.len()).find(|&row| !m[row][column].is_zero()) else { continue };
        m.swap(rank, pivot);
        let pivot = m[rank].clone();
        for row in &mut m[rank + 1..] {
            let factor = &row[column] / &pivot[column];
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= &factor * p);
        }
        rank += 1;
    }
    rank
}

/// Whether the step has a Jordan block of an eigenvalue: M - eigenvalue loses rank when squared.
fn has_a_block(step: &Matrix, eigenvalue: Q) -> bool {
    let mut shifted = step.clone();
    (0..shifted.len()).for_each(|i| shifted[i][i] -= &eigenvalue);
    rank(product(&shifted, &shifted)) < rank(shifted)
}

/// A half ring that a closed ring could take in may have no block that closed rings do not have. Of the numbers
/// of boundary edges up to nine that leaves three, which has ghosts, and seven.
#[test]
fn most_numbers_of_boundary_edges_cannot_have_ghosts() {
    for edges in 2..=9 {
        let half = step(edges, false);
        let blocks = [has_a_block(&half, q(1, 4)), has_a_block(&half, q(1, 2))];
        assert_eq!(blocks, [edges % 2 == 0, edges % 4 == 1], "{edges} boundary edges");
    }
    for valence in 3..=16 {
        let ring = step(valence, true);
        assert!(!has_a_block(&ring, q(1, 4)) && !has_a_block(&ring, q(1, 2)), "valence {valence}");
    }
}

fn rendered(mesh: &QuadMesh, boundary: Boundary, levels: u32, limit: bool) -> Vec<[i64; 3]> {
    let rings = Rings::new(mesh, boundary).unwrap();
    let core = CcStrip::new(Parameters {
        rims: boundary == Boundary::Rim,
        extra_fraction: 4,
        limit,
        ..Parameters::exact(rings.width())
    })
    .unwrap();
    let assembly = core.render(mesh, &rings, &cut(mesh, Method::Natural), levels).unwrap();
    assert_eq!((assembly.cracks(), assembly.missing()), (0, 0));
    assembly.positions().unwrap()
}

/// Repeated vertices on any boundary: the strips are those of the mesh with the copies in it.
#[test]
fn repeated_vertices_are_the_surface_of_the_mesh_with_its_copies() {
    for (name, sheet) in open().iter().chain(&ragged()) {
        for rows in 0..=1 {
            let mesh = repeated(sheet, rows).unwrap();
            let wider = repeated(sheet, rows + 1).unwrap();
            let levels = 2;
            let [grid, wide] = [&mesh, &wider].map(|mesh| QuadGrid::new(mesh, levels).unwrap());
            let oracle = QuadOracle::new(&wider, levels, Corners::Smooth).unwrap().restricted(&wide, &grid);
            for (target, limit) in [(Target::Refined, false), (Target::Limit, true)] {
                let outputs = rendered(&mesh, Boundary::Repeated, levels, limit);
                let error = oracle.error(&outputs, target, 4).unwrap();
                assert!(error.max <= 0.5 + 1.0, "{name} {rows} {target:?} {error:?}");
            }
        }
    }
}

#[test]
fn where_a_repeated_boundary_begins() {
    // rows of vertices 6 units apart, straight along the boundary
    let quads = lattice(6, 3, [false; 2]);
    let positions = (0..4).flat_map(|y| (0..7).map(move |x| [6 * x, 6 * y, 0])).collect();
    let sheet = QuadMesh::new(positions, quads).unwrap();
    let limit = |rows: u32| {
        let mesh = repeated(&sheet, rows).unwrap();
        rendered(&mesh, Boundary::Repeated, 1, true)
    };
    // fine vertex 3 is control vertex 3, at (18, 0): 5/6 of the boundary and 1/6 of the next row, at height 6
    assert_eq!(limit(0)[3], [18 * 16, 16, 0]);
    // its copy in the first row lies on the boundary itself, and so does a corner
    let first_copy = |v: usize| 28 + v + if v > 0 { 2 } else { 0 };
    assert_eq!(limit(1)[first_copy(3)], [18 * 16, 0, 0]);
    let mesh = repeated(&sheet, 1).unwrap();
    let corner = (28..mesh.vertex_count()).find(|&v| mesh.topology().valence(v as u32) == 2).unwrap();
    assert_eq!(limit(1)[corner], mesh.positions()[corner].map(|x| x * 16));
}

/// A cube opened along all its edges stays a cube.
#[test]
fn creases_and_cusps() {
    let quads = voxels(&[[0, 0, 0]]);
    let positions: Vec<[i64; 3]> = (0..8)
        .map(|v| {
            let quad = quads.iter().position(|quad| quad.contains(&v)).unwrap();
            [i64::from(v) * 8, quad as i64 * 8, 8 * i64::from(v % 3)]
        })
        .collect();
    let cube = QuadMesh::new(positions.clone(), quads).unwrap();
    let edges: Vec<[u32; 2]> = cube.topology().edges().map(|e| e.vertices).collect();
    let opened = cut_along(&cube, &edges).unwrap();
    assert_eq!((opened.mesh.topology().component_count(), opened.mesh.vertex_count()), (6, 24));
    for (mesh, boundary) in
        [(opened.mesh.clone(), Boundary::Ghosts), (repeated(&opened.mesh, 1).unwrap(), Boundary::Repeated)]
    {
        let outputs = rendered(&mesh, boundary, 2, true);
        // the outermost vertices, one in each corner of each side, are the old corners
        let corners = (0..mesh.vertex_count()).filter(|&v| mesh.topology().valence(v as u32) == 2);
        let mut found = 0;
        for v in corners {
            let original = mesh.positions()[v];
            assert!(positions.contains(&original));
            assert_eq!(outputs[v], original.map(|x| 16 * x), "{boundary:?}");
            found += 1;
        }
        assert_eq!(found, 24);
    }
}
