//! Small control meshes, and a sample-by-sample evaluation by masks, for the tests of `surface` and `model`.

pub use crate::noise::Random;
use std::collections::BTreeSet;
use subdiv_rtl::surface::assembly::Assembly;
use subdiv_rtl::surface::basis;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::fine_grid::FineGrid;
use subdiv_rtl::surface::hierarchy::Patch;
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::table::Table;

/// The same triangles with random positions of `width` bits.
pub fn shaken(triangles: Vec<[u32; 3]>, width: u32, seed: u64) -> ControlMesh {
    let count = triangles.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    let mut random = Random(seed);
    let positions = (0..count).map(|_| [0; 3].map(|_: i64| random.coordinate(width))).collect();
    ControlMesh::new(positions, triangles).unwrap()
}

pub fn tetrahedron() -> Vec<[u32; 3]> {
    vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
}

/// Two cones over a ring of n vertices: valences 4 (n times) and n (twice). n = 4 is the octahedron.
pub fn bipyramid(n: u32) -> Vec<[u32; 3]> {
    let upper = (0..n).map(|i| [i, (i + 1) % n, n]);
    let lower = (0..n).map(|i| [(i + 1) % n, i, n + 1]);
    upper.chain(lower).collect()
}

/// The triangular lattice wrapped in both directions: all valences 6.
pub fn torus(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    lattice(columns, rows, columns, rows)
}

/// The triangular lattice wrapped in one direction: a band with two boundaries.
pub fn band(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    lattice(columns, rows, columns, rows - 1)
}

/// A piece of the triangular lattice: boundary valences 2, 3 and 4.
pub fn sheet(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    lattice(columns, rows, columns - 1, rows - 1)
}

fn lattice(columns: u32, rows: u32, cells_across: u32, cells_up: u32) -> Vec<[u32; 3]> {
    let at = |x: u32, y: u32| (y % rows) * columns + x % columns;
    let cells = (0..cells_up).flat_map(|y| (0..cells_across).map(move |x| (x, y)));
    let pair =
        |(x, y)| [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]];
    cells.flat_map(pair).collect()
}

/// A wheel: one interior vertex of valence n, boundary valences 3.
pub fn wheel(n: u32) -> Vec<[u32; 3]> {
    (0..n).map(|i| [i, (i + 1) % n, n]).collect()
}

/// Puts a vertex of valence 3 into a triangle.
pub fn split(mut triangles: Vec<[u32; 3]>, face: usize) -> Vec<[u32; 3]> {
    let new = triangles.iter().flatten().max().map_or(0, |v| v + 1);
    let [a, b, c] = triangles[face];
    triangles[face] = [a, b, new];
    triangles.extend([[b, c, new], [c, a, new]]);
    triangles
}

/// A closed mesh of `vertices` vertices and genus 0 with random irregular valences 3 to 9.
pub fn random_closed(vertices: usize, seed: u64) -> Vec<[u32; 3]> {
    let mut random = Random(seed);
    let mut triangles = tetrahedron();
    while triangles.len() < 2 * vertices - 4 {
        let valence = valences(&triangles);
        let open: Vec<usize> =
            (0..triangles.len()).filter(|&f| triangles[f].iter().all(|&v| valence[v as usize] < 9)).collect();
        triangles = split(triangles, open[random.below(open.len())]);
        (0..6).for_each(|_| flip_random_edge(&mut triangles, &mut random));
    }
    triangles
}

fn valences(triangles: &[[u32; 3]]) -> Vec<usize> {
    let mut valence = vec![0; triangles.iter().flatten().max().map_or(0, |&v| v as usize + 1)];
    triangles.iter().flatten().for_each(|&v| valence[v as usize] += 1);
    valence
}

/// Replaces edge (a, b) of triangles (a, b, c), (b, a, d) by (c, d) where the mesh stays a mesh.
fn flip_random_edge(triangles: &mut [[u32; 3]], random: &mut Random) {
    let (f, side) = (random.below(triangles.len()), random.below(3));
    let [a, b, c] = [0, 1, 2].map(|x| triangles[f][(side + x) % 3]);
    let turned = |t: &[u32; 3]| (0..3).find(|&s| t[s] == b && t[(s + 1) % 3] == a);
    let Some((g, s)) = triangles.iter().enumerate().find_map(|(g, t)| turned(t).map(|s| (g, s))) else {
        return;
    };
    let d = triangles[g][(s + 2) % 3];
    let valence = valences(triangles);
    let edges: BTreeSet<_> =
        triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    let fits = valence[a as usize] > 3 && valence[b as usize] > 3;
    let fits = fits && valence[c as usize] < 9 && valence[d as usize] < 9 && !edges.contains(&(c, d));
    if fits && c != d {
        triangles[f] = [a, d, c];
        triangles[g] = [d, b, c];
    }
}

/// Every kind of mesh: closed and open, regular and not, valences 3 to 32.
pub fn zoo() -> Vec<(&'static str, Vec<[u32; 3]>)> {
    let mut two_apart = vec![[0, 1, 2], [3, 4, 5]];
    two_apart.extend(bipyramid(7).iter().map(|t| t.map(|v| v + 6)));
    vec![
        ("tetrahedron", tetrahedron()),
        ("octahedron", bipyramid(4)),
        ("bipyramid 9", bipyramid(9)),
        ("valences 3, 4, 31 and 32", split(bipyramid(31), 5)),
        ("torus", torus(5, 4)),
        ("band", band(5, 3)),
        ("band of one row", band(4, 2)),
        ("sheet", sheet(5, 4)),
        ("wheel 5", wheel(5)),
        ("wheel 6", wheel(6)),
        ("one triangle", vec![[0, 1, 2]]),
        ("two triangles", vec![[0, 1, 2], [0, 2, 3]]),
        ("three parts", two_apart),
        ("random 30", random_closed(30, 1)),
        ("random 67", random_closed(67, 2)),
    ]
}

/// Rounds N00 over 12 * 16^max_level to f more fraction bits: floor(N00 2^f / (12 16^R) + 1/2).
pub fn rounded(n00: i128, extra_fraction: i32, max_level: u32) -> i64 {
    // 2 N00 2^f + unit over 2 unit, all by 2^32 so that f may be negative
    let unit = 12i128 << (4 * max_level + 20);
    let numerator = n00 << (21 + extra_fraction);
    (numerator + unit).div_euclid(2 * unit) as i64
}

/// N00 of a sample, by its mask.
pub fn sample(patch: &Patch<[i128; 3]>, i: u32, j: u32) -> [i128; 3] {
    let mask = basis::mask(patch.level, i, j);
    [0, 1, 2].map(|x| patch.points.iter().zip(mask).map(|(p, w)| p[x] * i128::from(w)).sum())
}

/// Evaluates a mesh sample by sample.
pub fn assembled<'a>(
    mesh: &'a ControlMesh,
    level: u32,
    max_level: u32,
    table: &Table,
    extra_fraction: i32,
) -> Assembly<'a> {
    let mut assembly = Assembly::new(FineGrid::new(mesh, level).unwrap());
    patches(mesh, level, max_level, table, |patch| {
        let n = patch.steps() as u32;
        for i in 0..=n {
            for j in 0..=n - i {
                let position = sample(patch, i, j).map(|x| rounded(x, extra_fraction, max_level));
                assembly.put(patch, i as usize, j as usize, position);
            }
        }
    })
    .unwrap();
    assembly
}
