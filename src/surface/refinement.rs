//! Global Loop subdivision of a whole mesh, for the limit oracle.
//!
//! ```text
//!   every triangle (a, b, c) gives:   ring sum of a += b, of b += c, of c += a: each neighbour once
//!                                     opposite of edge (a, b) += c, of (b, c) += a, of (c, a) += b
//! ```
//!
//! No rings, no control meshes of patches, no differences: sums are scattered from triangles, so that nothing
//! of the route that the patches take is used again. Points are integers with [`FRACTION`] fraction bits.
//!
//! [`FRACTION`]: crate::surface::limit_oracle::FRACTION

use crate::surface::fine_grid::FineGrid;
use crate::surface::table::{WEIGHT_BITS, weights};
use num_bigint::BigInt;
use num_traits::ToPrimitive;

pub(crate) type Point = [i128; 3];

/// x / 2^bits, rounded half up; exact where x is a multiple.
fn halved(x: i128, bits: u32) -> i128 {
    (x + (1 << (bits - 1))) >> bits
}

/// What the triangles of one level say about its vertices.
pub(crate) struct Surroundings {
    ring_sum: Vec<Point>,
    /// Triangles at each vertex; the valence of an interior vertex.
    triangles: Vec<u8>,
    /// Sum of the two boundary neighbours; used where `boundary` holds.
    boundary_sum: Vec<Point>,
    boundary: Vec<bool>,
}

fn add(sum: &mut Point, p: &Point) {
    for (sum, x) in sum.iter_mut().zip(p) {
        *sum += x;
    }
}

impl Surroundings {
    pub(crate) fn of(positions: &[Point], grid: &FineGrid) -> Self {
        let count = positions.len();
        let mut around = Surroundings {
            ring_sum: vec![[0; 3]; count],
            triangles: vec![0; count],
            boundary_sum: vec![[0; 3]; count],
            boundary: vec![false; count],
        };
        for triangle in grid.triangles() {
            for side in 0..3 {
                let [a, b] = [triangle[side] as usize, triangle[(side + 1) % 3] as usize];
                add(&mut around.ring_sum[a], &positions[b]);
                around.triangles[a] += 1;
            }
        }
        for_each_boundary_step(grid, |a, b| {
            for (a, b) in [(a, b), (b, a)] {
                add(&mut around.boundary_sum[a], &positions[b]);
                around.boundary[a] = true;
            }
        });
        around
    }

    /// V' = V + w_n (S - nV), or (A + 6V + B)/8 on the boundary.
    fn replaced(&self, positions: &[Point], v: usize) -> Point {
        std::array::from_fn(|x| {
            let (at, ring) = (positions[v][x], self.ring_sum[v][x]);
            match (self.boundary[v], self.triangles[v]) {
                (true, _) => halved(6 * at + self.boundary_sum[v][x], 3),
                (_, 6) => halved(10 * at + ring, 4),
                (_, n) => at + weighted_spread(&weights()[n as usize].w, at, ring, n, 1),
            }
        })
    }

    /// Twelve times V + g_n (S - nV), or twice A + 4V + B on the boundary.
    pub(crate) fn limit12(&self, positions: &[Point], v: usize) -> Point {
        std::array::from_fn(|x| {
            let (at, ring) = (positions[v][x], self.ring_sum[v][x]);
            match (self.boundary[v], self.triangles[v]) {
                (true, _) => 2 * (4 * at + self.boundary_sum[v][x]),
                (_, 6) => 6 * at + ring,
                (_, n) => 12 * at + weighted_spread(&weights()[n as usize].g, at, ring, n, 12),
            }
        })
    }
}

/// factor * weight * (ring - n v), half up; the weight is over 2^[`WEIGHT_BITS`].
fn weighted_spread(weight: &BigInt, v: i128, ring: i128, n: u8, factor: i64) -> i128 {
    let spread = BigInt::from(ring) - BigInt::from(v) * n;
    let product: BigInt = (spread * weight * factor + (BigInt::from(1) << (WEIGHT_BITS - 1))) >> WEIGHT_BITS;
    product.to_i128().expect("|12 g_n (S - nV)| < 15 |V|, and 16 |V| fits")
}

/// Calls `f` with every edge of the fine grid that lies on the boundary.
fn for_each_boundary_step(grid: &FineGrid, mut f: impl FnMut(usize, usize)) {
    let (mesh, n) = (grid.mesh(), grid.steps());
    let mut uses = vec![0u8; mesh.edges().len()];
    for face in 0..mesh.triangles().len() {
        mesh.triangle_edges(face).iter().for_each(|&e| uses[e as usize] += 1);
    }
    for face in 0..mesh.triangles().len() {
        for (side, edge) in mesh.triangle_edges(face).into_iter().enumerate() {
            if uses[edge as usize] == 1 {
                let at = |t: usize| {
                    let [u, v] = [[t, 0], [n - t, t], [0, n - t]][side];
                    grid.vertex(face, u, v)
                };
                (0..n).for_each(|t| f(at(t), at(t + 1)));
            }
        }
    }
}

/// The sums that belong to one new edge vertex.
#[derive(Clone, Copy, Default)]
struct EdgeSums {
    ends: Point,
    opposite: Point,
    triangles: u8,
}

/// One global subdivision step.
pub(crate) fn refine(positions: &[Point], coarse: &FineGrid, fine: &FineGrid) -> Vec<Point> {
    let around = Surroundings::of(positions, coarse);
    let replaced: Vec<Point> = (0..positions.len()).map(|v| around.replaced(positions, v)).collect();
    let mut edges = vec![EdgeSums::default(); fine.vertex_count()];
    let mut refined = vec![[0; 3]; fine.vertex_count()];
    let n = coarse.steps();
    for face in 0..coarse.mesh().triangles().len() {
        for u in 0..=n {
            for v in 0..=n - u {
                refined[fine.vertex(face, 2 * u, 2 * v)] = replaced[coarse.vertex(face, u, v)];
                let upright = [[u, v], [u + 1, v], [u, v + 1]];
                let turned = [[u + 1, v], [u + 1, v + 1], [u, v + 1]];
                let triangles = [(upright, u + v < n), (turned, u + v + 1 < n)];
                for (triangle, _) in triangles.iter().filter(|t| t.1) {
                    scatter_edges(triangle, positions, face, coarse, fine, &mut edges);
                }
            }
        }
    }
    for (new, edge) in refined.iter_mut().zip(&edges) {
        match edge.triangles {
            0 => {} // an old vertex, already replaced
            1 => *new = edge.ends.map(|x| halved(x, 1)),
            _ => *new = std::array::from_fn(|x| halved(3 * edge.ends[x] + edge.opposite[x], 3)),
        }
    }
    refined
}

fn scatter_edges(
    triangle: &[[usize; 2]; 3],
    positions: &[Point],
    face: usize,
    coarse: &FineGrid,
    fine: &FineGrid,
    edges: &mut [EdgeSums],
) {
    let points = triangle.map(|[u, v]| positions[coarse.vertex(face, u, v)]);
    for side in 0..3 {
        let (a, b, c) = (side, (side + 1) % 3, (side + 2) % 3);
        let middle = fine.vertex(face, triangle[a][0] + triangle[b][0], triangle[a][1] + triangle[b][1]);
        let edge = &mut edges[middle];
        edge.ends = points[a];
        add(&mut edge.ends, &points[b]);
        add(&mut edge.opposite, &points[c]);
        edge.triangles += 1;
    }
}
