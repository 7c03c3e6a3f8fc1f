//! Global subdivision of a whole quad mesh, for the oracle.
//!
//! ```text
//!   every quad (a, b, c, d), sum = a + b + c + d, gives
//!       face vertex = sum/4        edge (a, b) += sum + 4 (a + b) once        vertex a: faces += sum, ring += b
//!
//!   E = (F1 + F2 + A + B)/4        V' = (sum F + sum A)/d^2 + (d-2) S/d
//! ```
//!
//! No strips, no fans, no ghosts: sums are scattered from quads, and the rules are those of the paper (Hall,
//! equation (5.1)), so that nothing of the route that the strips take is used again. Points are integers with
//! [`FRACTION`] fraction bits.
//!
//! [`FRACTION`]: crate::surface::catmull_clark::oracle::FRACTION

use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::masks::Corners;

pub(super) type Point = [i128; 3];

/// x / n for an even n, rounded half up; exact where x is a multiple.
fn divided(x: i128, n: i128) -> i128 {
    (x + n / 2).div_euclid(n)
}

fn add(sum: &mut Point, p: &Point) {
    for (sum, x) in sum.iter_mut().zip(p) {
        *sum += x;
    }
}

/// What the quads of one level say about a vertex.
#[derive(Clone, Copy, Default)]
struct Around {
    /// Sum over its quads of all four corners.
    corners: Point,
    /// Sum of the edge neighbours of an interior vertex.
    ring: Point,
    /// Sum of the diagonals.
    diagonals: Point,
    /// Quads at the vertex; the valence of an interior one.
    quads: u8,
    /// Sum of the two boundary neighbours.
    rim: Point,
    boundary: bool,
}

/// The surroundings of every vertex of one level.
pub(super) struct Surroundings {
    around: Vec<Around>,
    corners: Corners,
}

impl Surroundings {
    pub(super) fn of(positions: &[Point], grid: &QuadGrid, corners: Corners) -> Self {
        let mut around = vec![Around::default(); positions.len()];
        for quad in grid.quads() {
            let mut sum = [0; 3];
            quad.iter().for_each(|&v| add(&mut sum, &positions[v as usize]));
            for i in 0..4 {
                let [next, diagonal] = [1, 2].map(|k| positions[quad[(i + k) % 4] as usize]);
                let vertex = &mut around[quad[i] as usize];
                add(&mut vertex.corners, &sum);
                add(&mut vertex.ring, &next);
                add(&mut vertex.diagonals, &diagonal);
                vertex.quads += 1;
            }
        }
        for_each_boundary_step(grid, |a, b| {
            for (a, b) in [(a, b), (b, a)] {
                add(&mut around[a].rim, &positions[b]);
                around[a].boundary = true;
            }
        });
        Surroundings { around, corners }
    }

    /// The vertex one level deeper.
    fn replaced(&self, positions: &[Point], v: usize) -> Point {
        let vertex = &self.around[v];
        let d = i128::from(vertex.quads);
        std::array::from_fn(|x| {
            let s = positions[v][x];
            match (vertex.boundary, d, self.corners) {
                (true, 1, Corners::Sharp) => s,
                (true, ..) => divided(6 * s + vertex.rim[x], 8),
                _ => divided(vertex.corners[x] + 4 * vertex.ring[x] + 4 * d * (d - 2) * s, 4 * d * d),
            }
        })
    }

    /// 36 times the limit position of the vertex.
    pub(super) fn limit36(&self, positions: &[Point], v: usize) -> Point {
        let vertex = &self.around[v];
        let d = i128::from(vertex.quads);
        std::array::from_fn(|x| {
            let s = positions[v][x];
            match (vertex.boundary, d, self.corners) {
                (true, 1, Corners::Sharp) => 36 * s,
                (true, ..) => 6 * (4 * s + vertex.rim[x]),
                _ => {
                    // S + (4 sum A + sum D - 5d S)/(d (d+5)); the quotient is formed first to stay in range
                    let spread = 4 * vertex.ring[x] + vertex.diagonals[x] - 5 * d * s;
                    36 * s + divided(36 * spread, d * (d + 5))
                }
            }
        })
    }
}

/// Calls `f` with both ends of every edge of the fine grid that lies on the boundary.
fn for_each_boundary_step(grid: &QuadGrid, mut f: impl FnMut(usize, usize)) {
    let n = grid.steps();
    let topology = grid.mesh().topology();
    for h in (0..topology.half_edge_count()).filter(|&h| topology.opposite(h).is_none()) {
        let at = |t: usize| {
            let [u, v] = grid.turned(h as usize % 4, t, 0);
            grid.vertex(h as usize / 4, u, v)
        };
        (0..n).for_each(|t| f(at(t), at(t + 1)));
    }
}

/// What the quads of one level say about the new vertex of an edge.
#[derive(Clone, Copy, Default)]
struct EdgeSums {
    ends: Point,
    corners: Point,
    quads: u8,
}

/// One global subdivision step.
pub(super) fn refine(
    positions: &[Point],
    coarse: &QuadGrid,
    fine: &QuadGrid,
    corners: Corners,
) -> Vec<Point> {
    let around = Surroundings::of(positions, coarse, corners);
    let mut refined = vec![[0; 3]; fine.vertex_count()];
    let mut edges = vec![EdgeSums::default(); fine.vertex_count()];
    let n = coarse.steps();
    for quad in 0..coarse.mesh().quads().len() {
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            let lattice = [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]];
            let ids = lattice.map(|[u, v]| coarse.vertex(quad, u, v));
            let mut sum = [0; 3];
            ids.iter().for_each(|&id| add(&mut sum, &positions[id]));
            refined[fine.vertex(quad, 2 * u + 1, 2 * v + 1)] = sum.map(|x| divided(x, 4));
            for side in 0..4 {
                let ([a, b], [c, d]) = (lattice[side], lattice[(side + 1) % 4]);
                let edge = &mut edges[fine.vertex(quad, a + c, b + d)];
                edge.ends = positions[ids[side]];
                add(&mut edge.ends, &positions[ids[(side + 1) % 4]]);
                add(&mut edge.corners, &sum);
                edge.quads += 1;
                refined[fine.vertex(quad, 2 * a, 2 * b)] = around.replaced(positions, ids[side]);
            }
        }
    }
    for (new, edge) in refined.iter_mut().zip(&edges) {
        match edge.quads {
            0 => {} // an old vertex or the middle of a quad
            1 => *new = edge.ends.map(|x| divided(x, 2)),
            _ => *new = std::array::from_fn(|x| divided(edge.corners[x] + 4 * edge.ends[x], 16)),
        }
    }
    refined
}
