//! Small quad meshes for the tests of strips: closed and open, all valences.

pub use crate::noise::Random;
use std::collections::{BTreeMap, BTreeSet};
use subdiv_rtl::fixed::Format;
use subdiv_rtl::mesh::{Mesh, quantise, shape, widest_format};
use subdiv_rtl::surface::catmull_clark::control::control;
use subdiv_rtl::surface::catmull_clark::masks::Corners;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;

/// The same quads with random positions of `width` bits.
pub fn shaken(quads: Vec<[u32; 4]>, width: u32, seed: u64) -> QuadMesh {
    let count = quads.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    let mut random = Random(seed);
    let positions = (0..count).map(|_| [0; 3].map(|_: i64| random.coordinate(width))).collect();
    QuadMesh::new(positions, quads).unwrap()
}

/// columns x rows cells, wrapped in neither, one or both directions.
pub fn lattice(columns: u32, rows: u32, wrap: [bool; 2]) -> Vec<[u32; 4]> {
    let [width, height] = [columns + u32::from(!wrap[0]), rows + u32::from(!wrap[1])];
    let at = |x: u32, y: u32| (y % height) * width + x % width;
    let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect()
}

/// Only the cells that `keep` says, with the vertices numbered anew.
pub fn pruned(quads: Vec<[u32; 4]>, keep: impl Fn(usize) -> bool) -> Vec<[u32; 4]> {
    let quads: Vec<[u32; 4]> = (0..quads.len()).filter(|&q| keep(q)).map(|q| quads[q]).collect();
    let used: BTreeSet<u32> = quads.iter().flatten().copied().collect();
    let number: BTreeMap<u32, u32> = used.into_iter().zip(0..).collect();
    quads.iter().map(|q| q.map(|v| number[&v])).collect()
}

/// n quads around a vertex; with `border`, a ring of 2n quads around them. n = 1 is a lone quad.
pub fn wheel(n: u32, border: bool) -> Vec<[u32; 4]> {
    let rim = |i: u32| 1 + i % (2 * n);
    let mut quads: Vec<[u32; 4]> = (0..n).map(|s| [0, rim(2 * s), rim(2 * s + 1), rim(2 * s + 2)]).collect();
    if border {
        let outer = |i: u32| 2 * n + rim(i);
        quads.extend((0..2 * n).map(|i| [rim(i), outer(i), outer(i + 1), rim(i + 1)]));
    }
    quads
}

/// n quads in a fan around a boundary vertex of n + 1 edges.
pub fn fan(n: u32) -> Vec<[u32; 4]> {
    (0..n).map(|s| [0, 1 + 2 * s, 2 + 2 * s, 3 + 2 * s]).collect()
}

/// Two wheels of n quads glued along their rims: two vertices of valence n; valence 3 or 4 between.
pub fn spindle(n: u32) -> Vec<[u32; 4]> {
    let rim = |i: u32| 2 + i % (2 * n);
    let upper = (0..n).map(|s| [0, rim(2 * s), rim(2 * s + 1), rim(2 * s + 2)]);
    let lower = (0..n).map(|s| [1, rim(2 * s + 3), rim(2 * s + 2), rim(2 * s + 1)]);
    upper.chain(lower).collect()
}

/// The surface of a set of unit cubes.
pub fn voxels(cubes: &[[i32; 3]]) -> Vec<[u32; 4]> {
    let full: BTreeSet<[i32; 3]> = cubes.iter().copied().collect();
    let mut numbers = BTreeMap::new();
    let mut quads = Vec::new();
    for cube in &full {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beside = *cube;
            beside[axis] += 2 * side - 1;
            if full.contains(&beside) {
                continue;
            }
            let (u, v) =
                if side == 1 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            quads.push([[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
                let mut corner = *cube;
                corner[axis] += side;
                corner[u] += a;
                corner[v] += b;
                let next = numbers.len() as u32;
                *numbers.entry(corner).or_insert(next)
            }));
        }
    }
    quads
}

/// Cubes of a drawing: rows from top to bottom, '#' is full.
pub fn flat(drawing: &[&str]) -> Vec<[i32; 3]> {
    let rows = drawing.iter().zip(0..);
    rows.flat_map(|(row, y)| row.bytes().zip(0..).filter(|(c, _)| *c == b'#').map(move |(_, x)| [x, -y, 0]))
        .collect()
}

/// The control mesh of a built-in shape at 13 bits and more.
pub fn of_shape(name: &str) -> QuadMesh {
    let mesh = shape(name).unwrap();
    let quantised = quantise(&mesh, Format::new(2, 12).unwrap()).unwrap();
    control(&mesh, &quantised, Corners::Sharp, 0).unwrap().mesh
}

/// The control mesh of a mesh from a file, at `width` bits.
pub fn of_mesh(mesh: &Mesh, width: u32) -> QuadMesh {
    let quantised = quantise(mesh, widest_format(mesh, width).unwrap()).unwrap();
    control(mesh, &quantised, Corners::Sharp, 0).unwrap().mesh
}

/// Closed meshes: every valence from 3 to 9 and more, neighbours of valence 3, genus 0 to 2.
pub fn closed() -> Vec<(&'static str, QuadMesh)> {
    let plus = [[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    let stairs: Vec<[i32; 3]> =
        (0..3).flat_map(|x| (0..=x).flat_map(move |y| (0..2).map(move |z| [x, y, z]))).collect();
    let quads = [
        ("cube", voxels(&[[0, 0, 0]])),
        ("bar", voxels(&flat(&["###"]))),
        ("L", voxels(&flat(&["#..", "#..", "###"]))),
        ("plus", voxels(&plus)),
        ("ring", voxels(&flat(&["###", "#.#", "###"]))),
        ("genus 2", voxels(&flat(&["#####", "#.#.#", "#####"]))),
        ("stairs", voxels(&stairs)),
        ("torus", lattice(5, 4, [true, true])),
        ("torus 3x3", lattice(3, 3, [true, true])),
        ("spindle 5", spindle(5)),
        ("spindle 12", spindle(12)),
        ("spindle 16", spindle(16)),
    ];
    let mut meshes: Vec<_> =
        quads.into_iter().zip(1..).map(|((n, q), seed)| (n, shaken(q, 14, seed))).collect();
    meshes.extend(
        ["double-torus-quads", "blob-quads", "blob", "icosahedron"].map(|name| (name, of_shape(name))),
    );
    meshes
}

/// Sheets whose boundary vertices have two or three edges: ghosts can complete them.
pub fn open() -> Vec<(&'static str, QuadMesh)> {
    let quads = [
        ("lone quad", lattice(1, 1, [false; 2])),
        ("two quads", lattice(2, 1, [false; 2])),
        ("row", lattice(5, 1, [false; 2])),
        ("band of one", lattice(5, 1, [true, false])),
        ("sheet", lattice(4, 3, [false; 2])),
        ("annulus", lattice(6, 2, [true, false])),
        ("wheel 3", wheel(3, false)),
        ("wheel 5", wheel(5, false)),
        ("bordered wheel 7", wheel(7, true)),
        ("bordered wheel 3", wheel(3, true)),
    ];
    let mut meshes: Vec<_> =
        quads.into_iter().zip(50..).map(|((n, q), seed)| (n, shaken(q, 14, seed))).collect();
    meshes.extend(["disc-quads", "square-quads"].map(|name| (name, of_shape(name))));
    meshes
}

/// Sheets with boundary vertices of every number of edges from two on.
pub fn ragged() -> Vec<(&'static str, QuadMesh)> {
    let cross = |q: usize| [1, 3, 4, 5, 7].contains(&q);
    let quads = [
        ("fan 2", fan(2)),
        ("fan 3", fan(3)),
        ("fan 4", fan(4)),
        ("fan 8", fan(8)),
        ("L sheet", pruned(lattice(4, 4, [false; 2]), |q| q % 4 < 2 || q / 4 < 2)),
        ("cross sheet", pruned(lattice(3, 3, [false; 2]), cross)),
        ("holes", pruned(lattice(7, 5, [false; 2]), |q| ![8, 10, 12, 24, 25].contains(&q))),
        ("torus with a hole", pruned(lattice(5, 5, [true; 2]), |q| ![6, 7, 11].contains(&q))),
        ("opened genus 2", pruned(voxels(&flat(&["#####", "#.#.#", "#####"])), |q| ![4, 30].contains(&q))),
    ];
    let mut meshes: Vec<_> =
        quads.into_iter().zip(90..).map(|((n, q), seed)| (n, shaken(q, 14, seed))).collect();
    meshes.push(("disc", of_shape("disc")));
    meshes
}
