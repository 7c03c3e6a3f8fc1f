//! The true refined position and the true limit position of every vertex of the fine mesh, by another route
//! than the strips take: the whole mesh is refined level by level, then projected by the limit masks.
//!
//! ```text
//!   control mesh --refine--> level 1 --refine--> ... --refine--> level L = refined --limit masks--> 36 * limit
//! ```
//!
//! Positions are integers over 2^80. Regular rules are exact there (level L <= 10 needs 6L <= 60 bits).
//! Other vertices divide by 4 d^2 and round to 2^-80, as do the vertices near them: all rules are convex, so
//! after L levels a position is wrong by at most (L + 1) 2^-80 units.

use crate::error::{Error, Result};
use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::masks::Corners;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::refinement::{Point, Surroundings, refine};
use crate::surface::limit_oracle::ErrorLsb;

/// Fraction bits of the oracle's positions. A 34-bit coordinate, these 80 and the largest sum (4 d^2 times a
/// point, d = 32) fit 127 bits.
pub const FRACTION: u32 = 80;

/// The highest level, the widest coordinate and the largest valence.
const MOST: (u32, u32, u32) = (10, 34, 32);

/// Which positions outputs are measured against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The vertices of the mesh refined L times: control points, as the thesis puts out.
    Refined,
    /// The points of the limit surface that they tend to.
    Limit,
}

/// Refined and limit positions of every vertex of the fine grid.
#[derive(Clone, Debug)]
pub struct QuadOracle {
    refined: Vec<Point>,
    limits36: Vec<Point>,
    uncertainty: f64,
}

impl QuadOracle {
    /// # Errors
    /// A level above 10, coordinates of more than 34 bits, a valence above 32.
    pub fn new(mesh: &QuadMesh, level: u32, corners: Corners) -> Result<Self> {
        let topology = mesh.topology();
        let valence = (0..topology.vertex_count()).map(|v| topology.valence(v)).max().unwrap_or(0);
        if level > MOST.0 || mesh.width() > MOST.1 || valence > MOST.2 {
            let what = format!("level {level}, coordinates of {} bits, valence {valence}", mesh.width());
            return Err(Error::usage(what).help(format!(
                "positions are known up to level {}, {} bits and valence {}",
                MOST.0, MOST.1, MOST.2
            )));
        }
        let scaled = |p: &[i64; 3]| p.map(|x| i128::from(x) << FRACTION);
        let mut refined: Vec<Point> = mesh.positions().iter().map(scaled).collect();
        let mut grid = QuadGrid::new(mesh, 0)?;
        for next in 1..=level {
            let fine = QuadGrid::new(mesh, next)?;
            refined = refine(&refined, &grid, &fine, corners);
            grid = fine;
        }
        let around = Surroundings::of(&refined, &grid, corners);
        let limits36 = (0..refined.len()).map(|v| around.limit36(&refined, v)).collect();
        let exact = mesh.largest_irregular_valence().is_none();
        let uncertainty = if exact { 0.0 } else { f64::from(level + 1) * (-f64::from(FRACTION)).exp2() };
        Ok(QuadOracle { refined, limits36, uncertainty })
    }

    /// The same positions in the order of another grid: that of a mesh whose quads are the first ones of this
    /// mesh, in the same order (a mesh without its surrounding rows of repeated vertices).
    pub fn restricted(&self, from: &QuadGrid, to: &QuadGrid) -> Self {
        let mut same = vec![0; to.vertex_count()];
        let n = to.steps();
        for quad in 0..to.mesh().quads().len() {
            for (u, v) in (0..=n).flat_map(|u| (0..=n).map(move |v| (u, v))) {
                same[to.vertex(quad, u, v)] = from.vertex(quad, u, v);
            }
        }
        let pick = |all: &[Point]| same.iter().map(|&v| all[v]).collect();
        QuadOracle {
            refined: pick(&self.refined),
            limits36: pick(&self.limits36),
            uncertainty: self.uncertainty,
        }
    }

    /// 2^[`FRACTION`] times the position of a vertex of the fine mesh.
    pub fn refined(&self, vertex: usize) -> [i128; 3] {
        self.refined[vertex]
    }

    /// 36 * 2^[`FRACTION`] times the limit position of a vertex.
    pub fn limit36(&self, vertex: usize) -> [i128; 3] {
        self.limits36[vertex]
    }

    /// A position in input units, rounded to `f64`.
    pub fn position(&self, vertex: usize, target: Target) -> [f64; 3] {
        let (positions, times) = self.positions(target);
        positions[vertex].map(|x| x as f64 / (times as f64 * f64::from(FRACTION).exp2()))
    }

    /// The scaled positions of a target and what they are multiplied by besides 2^FRACTION.
    fn positions(&self, target: Target) -> (&[Point], i128) {
        match target {
            Target::Refined => (&self.refined, 1),
            Target::Limit => (&self.limits36, 36),
        }
    }

    /// Error of one output vertex, in output units: the largest over its coordinates.
    pub fn vertex_error(&self, vertex: usize, output: [i64; 3], target: Target, extra_fraction: i32) -> f64 {
        let (positions, times) = self.positions(target);
        let unit = output_unit(times, extra_fraction);
        let deviations = (0..3).map(|x| deviation(output[x], positions[vertex][x], unit).unsigned_abs());
        deviations.max().unwrap_or(0) as f64 / unit as f64
    }

    /// Errors of all output vertices, one a vertex of the fine grid, in units of the output's last place.
    ///
    /// `extra_fraction`: fraction bits of the output less those of the input, -30..=42.
    ///
    /// # Errors
    /// Not as many outputs as vertices.
    pub fn error(&self, outputs: &[[i64; 3]], target: Target, extra_fraction: i32) -> Result<ErrorLsb> {
        let (positions, times) = self.positions(target);
        if outputs.len() != positions.len() {
            let counts = format!("{} output vertices for {}", outputs.len(), positions.len());
            return Err(Error::usage(counts).help("give one output for each vertex of the fine grid"));
        }
        let unit = output_unit(times, extra_fraction);
        let (mut most, mut squares) = (0, 0.0);
        for (output, position) in outputs.iter().zip(positions) {
            for (&y, &x) in output.iter().zip(position) {
                let deviation = deviation(y, x, unit).unsigned_abs();
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

/// One unit of the output, 2^-extra_fraction input units, in the scale of the positions.
fn output_unit(times: i128, extra_fraction: i32) -> i128 {
    times << (FRACTION as i32 - extra_fraction.clamp(-30, 42))
}

/// Output minus position in the scale of the positions. An output that lies wildly outside of every format
/// saturates, so that a fault shows as a huge error and not as a panic.
fn deviation(output: i64, position: i128, unit: i128) -> i128 {
    i128::from(output).saturating_mul(unit).saturating_sub(position).clamp(-i128::MAX / 2, i128::MAX / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(size: i64) -> QuadMesh {
        let side = |bit: i64| if bit == 0 { -size } else { size };
        let positions = (0..8).map(|i: i64| [side(i & 1), side(i & 2), -side(i & 4)]).collect();
        let quads = vec![[0, 1, 3, 2], [2, 3, 7, 6], [6, 7, 5, 4], [4, 5, 1, 0], [1, 5, 7, 3], [2, 6, 4, 0]];
        QuadMesh::new(positions, quads).unwrap()
    }

    #[test]
    fn the_corners_of_a_cube() {
        // refined once: A = 1/3 of the way, (9 S + 4 sum A + sum D)/24 at the limit: S = (1,1,1) -> 1/2
        let size = 36;
        for level in 0..=4 {
            let oracle = QuadOracle::new(&cube(size), level, Corners::Smooth).unwrap();
            let limit = oracle.position(7, Target::Limit);
            assert!(limit.iter().zip([18.0, 18.0, -18.0]).all(|(x, y)| (x - y).abs() < 1e-12), "{limit:?}");
        }
        // V' = S + (6 sum A + sum D - 21 S)/36; in each axis sum A = 1 and sum D = -1: S (1 - 16/36)
        let once = QuadOracle::new(&cube(size), 1, Corners::Smooth).unwrap();
        assert_eq!(once.position(7, Target::Refined), [20.0, 20.0, -20.0]);
    }

    fn square(height: i64) -> QuadMesh {
        QuadMesh::new(vec![[0, 0, 0], [48, 0, 0], [48, 48, height], [0, 48, 0]], vec![[0, 1, 2, 3]]).unwrap()
    }

    #[test]
    fn a_lone_square_has_a_spline_or_straight_lines_for_a_boundary() {
        let smooth = QuadOracle::new(&square(0), 1, Corners::Smooth).unwrap();
        assert_eq!(smooth.position(0, Target::Refined), [6.0, 6.0, 0.0]);
        assert_eq!(smooth.position(0, Target::Limit), [8.0, 8.0, 0.0]); // (A + 4V + B)/6 of the square
        let sharp = QuadOracle::new(&square(0), 3, Corners::Sharp).unwrap();
        let grid = QuadGrid::new(&square(0), 3).map(|g| g.vertex(0, 3, 0)).unwrap();
        assert_eq!(sharp.position(0, Target::Limit), [0.0; 3]);
        assert_eq!(sharp.position(grid, Target::Refined), [18.0, 0.0, 0.0]);
        // bilinear: the middle of a sharp square is the mean of its corners at every level
        let middle = QuadOracle::new(&square(16), 4, Corners::Sharp).unwrap();
        let mesh = square(16);
        let grid = QuadGrid::new(&mesh, 4).unwrap();
        assert_eq!(middle.position(grid.vertex(0, 8, 8), Target::Limit), [24.0, 24.0, 4.0]);
        assert_eq!(middle.position(grid.vertex(0, 12, 4), Target::Limit), [36.0, 12.0, 3.0]);
    }

    #[test]
    fn errors_are_measured_in_output_units() {
        let oracle = QuadOracle::new(&square(0), 0, Corners::Sharp).unwrap();
        let mut outputs = vec![[0, 0, 0], [96, 0, 0], [96, 96, 0], [0, 96, 1]];
        let error = oracle.error(&outputs, Target::Limit, 1).unwrap();
        assert_eq!((error.max, error.at_most_half), (1.0, false));
        assert!((error.rms - 12f64.sqrt().recip()).abs() < 1e-15);
        outputs[3] = [0, 96, 0];
        assert_eq!(oracle.error(&outputs, Target::Refined, 1).unwrap().max, 0.0);
        assert!(oracle.error(&outputs[1..], Target::Refined, 1).is_err());
    }
}
