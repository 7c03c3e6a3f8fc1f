//! The true limit position of every vertex of the fine mesh, by another route than the patches take:
//! the whole mesh is refined level by level, then every vertex is projected by its limit mask.
//!
//! ```text
//!   control mesh --refine--> level 1 --refine--> ... --refine--> level r --limit masks--> 12 * limit
//!
//!   every triangle (a, b, c) gives:   ring sum of a += b (and b += c, c += a): each neighbour once
//!                                     opposite of edge (a, b) += c
//! ```
//!
//! No rings, no control meshes of patches, no differences: sums are scattered from triangles, and an edge
//! with one triangle is a boundary edge. Positions are integers over 2^90. Regular rules are exact there
//! (level r <= 10 needs 4r <= 40 bits). Irregular interior vertices use weights of 200 bits and round to
//! 2^-90, as do the vertices near them: after r levels a position is wrong by at most (r + 1) 2^-90 units.

use crate::error::{Error, Result};
use crate::surface::control_mesh::ControlMesh;
use crate::surface::fine_grid::FineGrid;
use crate::surface::packets::{MAX_LEVEL, MAX_WIDTH};
use crate::surface::table::{WEIGHT_BITS, weights};
use num_bigint::BigInt;
use num_traits::ToPrimitive;

/// Fraction bits of the oracle's positions. A 32-bit coordinate, these 90 and the largest sum (a ring of 32
/// neighbours, or 16 times a point) fit 128 bits.
pub const FRACTION: u32 = 90;

type Point = [i128; 3];

/// Twelve times the limit position of every vertex of the fine mesh, over 2^[`FRACTION`] input units.
#[derive(Clone, Debug)]
pub struct LimitOracle {
    limits12: Vec<Point>,
    uncertainty: f64,
}

/// How far output vertices lie from the limit surface, in units of the output's last place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorLsb {
    /// Largest error of any coordinate.
    pub max: f64,
    /// Root of the mean square over all coordinates.
    pub rms: f64,
    /// No coordinate is off by more than half a unit; decided in integers.
    pub at_most_half: bool,
    /// How far the oracle itself may be off, in the same units; 0 where it is exact.
    pub uncertainty: f64,
}

impl LimitOracle {
    /// # Errors
    /// A level above 10, coordinates of more than 32 bits.
    pub fn new(mesh: &ControlMesh, level: u32) -> Result<Self> {
        if level > MAX_LEVEL || mesh.width() > MAX_WIDTH {
            return Err(Error::usage(format!("level {level}, coordinates of {} bits", mesh.width()))
                .help(format!("the limit is known up to level {MAX_LEVEL} and {MAX_WIDTH} bits")));
        }
        let mut grid = FineGrid::new(mesh, 0)?;
        let mut positions = vec![[0; 3]; grid.vertex_count()];
        for (face, triangle) in mesh.triangles().iter().enumerate() {
            for (corner, (u, v)) in [(0, 0), (1, 0), (0, 1)].into_iter().enumerate() {
                let position = mesh.positions()[triangle[corner] as usize];
                positions[grid.vertex(face, u, v)] = position.map(|x| i128::from(x) << FRACTION);
            }
        }
        for next in 1..=level {
            let fine = FineGrid::new(mesh, next)?;
            positions = refine(&positions, &grid, &fine);
            grid = fine;
        }
        let around = Surroundings::of(&positions, &grid);
        let limits12 = (0..positions.len()).map(|v| around.limit12(&positions, v)).collect();
        let exact = mesh.largest_irregular_valence().is_none();
        let uncertainty = if exact { 0.0 } else { f64::from(level + 1) * (-f64::from(FRACTION)).exp2() };
        Ok(LimitOracle { limits12, uncertainty })
    }

    /// Limit position of a vertex of the fine grid, in input units, rounded to `f64`.
    pub fn position(&self, vertex: usize) -> [f64; 3] {
        self.limits12[vertex].map(|x| x as f64 / (12.0 * f64::from(FRACTION).exp2()))
    }

    /// 12 * 2^[`FRACTION`] times the limit position of a vertex.
    pub fn limit12(&self, vertex: usize) -> [i128; 3] {
        self.limits12[vertex]
    }

    /// Error of output vertex `vertex` with `extra_fraction` more fraction bits than the input, in output
    /// units: the largest over its coordinates.
    pub fn vertex_error(&self, vertex: usize, output: [i64; 3], extra_fraction: i32) -> f64 {
        let unit = output_unit(extra_fraction);
        let limit = self.limits12[vertex];
        (0..3).map(|x| deviation(output[x], limit[x], unit).unsigned_abs()).max().unwrap_or(0) as f64
            / unit as f64
    }

    /// Errors of all output vertices, one a vertex of the fine grid.
    ///
    /// `extra_fraction`: fraction bits of the output less those of the input, -30..=41.
    ///
    /// # Errors
    /// Not as many outputs as vertices.
    pub fn error(&self, outputs: &[[i64; 3]], extra_fraction: i32) -> Result<ErrorLsb> {
        if outputs.len() != self.limits12.len() {
            let counts = format!("{} output vertices for {}", outputs.len(), self.limits12.len());
            return Err(Error::usage(counts).help("give one output for each vertex of the fine grid"));
        }
        let unit = output_unit(extra_fraction);
        let (mut most, mut squares) = (0, 0.0);
        for (output, limit) in outputs.iter().zip(&self.limits12) {
            for (&y, &limit) in output.iter().zip(limit) {
                let deviation = deviation(y, limit, unit).unsigned_abs();
                most = deviation.max(most);
                squares += (deviation as f64 / unit as f64).powi(2);
            }
        }
        let coordinates = (3 * outputs.len()).max(1) as f64;
        Ok(ErrorLsb {
            max: most as f64 / unit as f64,
            rms: (squares / coordinates).sqrt(),
            at_most_half: 2 * most <= unit as u128,
            uncertainty: self.uncertainty * f64::from(extra_fraction).exp2(),
        })
    }
}

/// One unit of the output, 2^-extra_fraction input units, in the scale of the limits.
fn output_unit(extra_fraction: i32) -> i128 {
    12 << (FRACTION as i32 - extra_fraction.clamp(-30, 41))
}

/// Output minus limit in the scale of the limits. An output that lies wildly outside of every format
/// saturates, so that a fault shows as a huge error and not as a panic.
fn deviation(output: i64, limit: i128, unit: i128) -> i128 {
    i128::from(output).saturating_mul(unit).saturating_sub(limit).clamp(-i128::MAX / 2, i128::MAX / 2)
}

/// x / 2^bits, rounded half up; exact where x is a multiple.
fn halved(x: i128, bits: u32) -> i128 {
    (x + (1 << (bits - 1))) >> bits
}

/// What the triangles of one level say about its vertices.
struct Surroundings {
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
    fn of(positions: &[Point], grid: &FineGrid) -> Self {
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
    fn limit12(&self, positions: &[Point], v: usize) -> Point {
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
fn refine(positions: &[Point], coarse: &FineGrid, fine: &FineGrid) -> Vec<Point> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron(size: i64) -> ControlMesh {
        let positions =
            vec![[size, 0, 0], [0, size, 0], [-size, 0, 0], [0, -size, 0], [0, 0, size], [0, 0, -size]];
        let upper = (0..4).map(|i| [i, (i + 1) % 4, 4]);
        let lower = (0..4).map(|i| [(i + 1) % 4, i, 5]);
        ControlMesh::new(positions, upper.chain(lower).collect()).unwrap()
    }

    #[test]
    fn the_top_of_an_octahedron() {
        // g_4 = 31/220: limit = V (1 - 4 g) = V 24/55, at every level the same
        let size = 55;
        for level in 0..=4 {
            let oracle = LimitOracle::new(&octahedron(size), level).unwrap();
            let position = oracle.position(4);
            assert!((position[2] - 24.0).abs() < 1e-14 && position[0] == 0.0, "{position:?}");
        }
    }

    #[test]
    fn the_middle_of_a_lone_edge_is_a_cubic_spline() {
        // one triangle: its boundary is the uniform cubic B-spline of its corners;
        // the middle of edge 0-1 is (C + 23 A + 23 B + C)/48
        let mesh = ControlMesh::new(vec![[0; 3], [48, 0, 0], [0, 48, 0]], vec![[0, 1, 2]]).unwrap();
        let oracle = LimitOracle::new(&mesh, 1).unwrap();
        let id = FineGrid::new(&mesh, 1).unwrap().vertex(0, 1, 0);
        assert_eq!(oracle.position(id), [23.0, 2.0, 0.0]);
        assert_eq!(oracle.uncertainty, 0.0);
    }

    #[test]
    fn errors_are_measured_in_output_units() {
        let mesh = ControlMesh::new(vec![[6, 0, 0], [0; 3], [0; 3]], vec![[0, 1, 2]]).unwrap();
        let oracle = LimitOracle::new(&mesh, 0).unwrap(); // limits 4, 1, 1
        let exact = [[4, 0, 0], [1, 0, 0], [1, 0, 0]];
        assert_eq!(oracle.error(&exact, 0).unwrap().max, 0.0);
        let halves = exact.map(|p| p.map(|x| 2 * x)).map(|[x, y, z]| [x, y + 1, z]);
        let error = oracle.error(&halves, 1).unwrap();
        assert_eq!((error.max, error.at_most_half), (1.0, false));
        assert!((error.rms - (3.0f64 / 9.0).sqrt()).abs() < 1e-15);
        assert!(oracle.vertex_error(1, [i64::MAX, 0, 0], 0) > 1e9);
        assert!(oracle.error(&exact[..2], 0).is_err());
    }
}
