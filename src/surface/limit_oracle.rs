//! The true limit position of every vertex of the fine mesh, by another route than the patches take:
//! the whole mesh is refined level by level, then every vertex is projected by its limit mask.
//!
//! ```text
//!   control mesh --refine--> level 1 --refine--> ... --refine--> level r --limit masks--> 12 * limit
//! ```
//!
//! Positions are integers over 2^90. Regular rules are exact there (level r <= 10 needs 4r <= 40 bits).
//! Irregular interior vertices use weights of 200 bits and round to 2^-90, as do the vertices near them:
//! after r levels a position is wrong by at most (r + 1) 2^-90 units.

use crate::error::{Error, Result};
use crate::surface::control_mesh::ControlMesh;
use crate::surface::fine_grid::FineGrid;
use crate::surface::packets::{MAX_LEVEL, MAX_WIDTH};
use crate::surface::refinement::{Point, Surroundings, refine};

/// Fraction bits of the oracle's positions. A 32-bit coordinate, these 90 and the largest sum (a ring of 32
/// neighbours, or 16 times a point) fit 128 bits.
pub const FRACTION: u32 = 90;

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

    /// How far these positions may be off, in input units; 0 where they are exact.
    pub fn uncertainty(&self) -> f64 {
        self.uncertainty
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
