//! One mesh and level, many formats: the error and the cracks of each, fast.
//!
//! ```text
//!   prepared once    patches with their exact differences N      where each vertex truly lies, over 2^g
//!                    which vertices of which patches are the same point
//!   for each format  N --> rounded start-up --> columns --> |y 2^(g-f) - exact|,  largest and mean square
//!                                                       --> vertices at which patches disagree
//! ```
//!
//! All comparisons are of integers. What a core computes does not depend on its maximum level, so these are
//! the vertices of every core of the format. A prepared mesh is only read, so threads can share it.

use super::loop_fd::LoopFd;
use super::loop_fd::reduced::{Numerators, columns_of_any, numerators};
use crate::error::{Error, Result};
use crate::fixed::Precision;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::fine_grid::FineGrid;
use crate::surface::hierarchy::Counts;
use crate::surface::limit_oracle::{FRACTION, LimitOracle};
use crate::surface::packets::patches;
use crate::surface::table::Table;

/// A mesh at a level, ready to be evaluated in any format.
#[derive(Clone, Debug)]
pub struct Prepared {
    width: u32,
    level: u32,
    counts: Counts,
    patches: Vec<(u32, Numerators)>,
    /// Where each vertex of each patch truly lies, in the order of the packets, over 2^`fraction`.
    exact: Vec<[i64; 3]>,
    /// g.
    fraction: u32,
    /// How far `exact` may be off, in units of the control coordinates.
    uncertainty: f64,
    /// Vertices of patches, as places in `exact`, those that are one point side by side;
    /// `shared[starts[i] .. starts[i + 1]]` are one.
    shared: Vec<u32>,
    starts: Vec<u32>,
}

/// What a format does to a mesh, in units of the output's last place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Largest error of a coordinate against the exact limit surface, the final rounding included.
    pub max: f64,
    /// Root of the mean square over all coordinates of all patches.
    pub rms: f64,
    /// How far the exact positions themselves may be off.
    pub uncertainty: f64,
    /// Points that came out at more than one position.
    pub cracks: usize,
    /// Points that more than one patch delivers.
    pub shared_points: usize,
    /// How far apart the positions of a point lie at most, along an axis.
    pub largest_crack: i64,
}

impl Prepared {
    /// # Errors
    /// A level above 10, coordinates of more than 32 bits.
    pub fn new(mesh: &ControlMesh, level: u32, table: &Table) -> Result<Prepared> {
        let width = mesh.width().max(2);
        // Room for vertices 2^4 times outside of the range, which only a useless format makes.
        let fraction = i64::BITS - 6 - width;
        let oracle = LimitOracle::new(mesh, level)?;
        let grid = FineGrid::new(mesh, level)?;
        let unit = 12i128 << (FRACTION - fraction);
        let rounded = |limit: [i128; 3]| limit.map(|x| (2 * x + unit).div_euclid(2 * unit) as i64);
        let (mut prepared_patches, mut exact, mut places) = (vec![], vec![], vec![]);
        let counts = patches(mesh, level, level, table, |patch| {
            prepared_patches.push((patch.level, numerators(patch.level, &patch.points)));
            let n = patch.steps();
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                let [u, v] = patch.lattice(i, j);
                let vertex = grid.vertex(patch.face as usize, u as usize, v as usize);
                places.push((vertex as u32, exact.len() as u32));
                exact.push(rounded(oracle.limit12(vertex)));
            }
        })?;
        places.sort_unstable();
        let (mut shared, mut starts) = (vec![], vec![0]);
        for group in places.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            shared.extend(group.iter().map(|(_, place)| place));
            starts.push(shared.len() as u32);
        }
        let uncertainty = oracle.uncertainty() + (-f64::from(fraction) - 1.0).exp2();
        let patches = prepared_patches;
        Ok(Prepared { width, level, counts, patches, exact, fraction, uncertainty, shared, starts })
    }

    /// The bits of the widest coordinate.
    pub fn width(&self) -> u32 {
        self.width
    }

    pub fn level(&self) -> u32 {
        self.level
    }

    /// Patches and triangles.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Evaluates the mesh in a format, for outputs of `extra_fraction` more fraction bits than the input.
    /// `width` is that of the core's coordinates, which saturation goes by. `vertices` is overwritten: the
    /// vertices of all patches in the order of the packets.
    ///
    /// # Errors
    /// Numbers that no core has; coordinates that do not fit; outputs finer than the exact positions.
    pub fn measure(
        &self,
        width: u32,
        extra_fraction: i32,
        precision: Precision,
        vertices: &mut Vec<[i64; 3]>,
    ) -> Result<Measured> {
        if width < self.width || extra_fraction > self.fraction as i32 {
            return Err(Error::usage(format!(
                "{width} bits and {extra_fraction} extra fraction bits for coordinates of {} bits",
                self.width
            ))
            .help(format!("use at least {} bits, and at most {} extra ones", self.width, self.fraction)));
        }
        let core = LoopFd::new(width, extra_fraction, self.level)?.with_precision(precision)?;
        vertices.resize(self.exact.len(), [0; 3]);
        let mut columns = columns_of_any(&core);
        let mut rest = vertices.as_mut_slice();
        for (level, numerators) in &self.patches {
            columns.start_from(*level, numerators);
            for length in (1..=(1usize << level) + 1).rev() {
                let (column, after) = rest.split_at_mut(length);
                columns.next(column);
                rest = after;
            }
        }
        let (cracks, largest_crack) = self.cracks(vertices);
        let (max, rms) = self.error(extra_fraction, vertices);
        let uncertainty = self.uncertainty * f64::from(extra_fraction).exp2();
        let shared_points = self.starts.len() - 1;
        Ok(Measured { max, rms, uncertainty, cracks, shared_points, largest_crack })
    }

    /// Largest and root mean square distance to the exact positions, in units of the output.
    fn error(&self, extra_fraction: i32, vertices: &[[i64; 3]]) -> (f64, f64) {
        let shift = (self.fraction as i32 - extra_fraction) as u32;
        // 2^4 times the range and no more: what lies farther out counts as lying there.
        let most = i64::MAX >> 2 >> shift;
        let (mut largest, mut squares) = (0u64, 0.0);
        for (vertex, exact) in vertices.as_flattened().iter().zip(self.exact.as_flattened()) {
            let deviation = ((*vertex).clamp(-most, most) << shift) - exact;
            largest = largest.max(deviation.unsigned_abs());
            squares += (deviation as f64) * (deviation as f64);
        }
        let unit = f64::from(shift).exp2();
        let coordinates = (3 * vertices.len()).max(1) as f64;
        (largest as f64 / unit, (squares / coordinates).sqrt() / unit)
    }

    /// Points at which patches disagree, and by how much at most.
    fn cracks(&self, vertices: &[[i64; 3]]) -> (usize, i64) {
        let (mut cracks, mut largest) = (0, 0);
        for range in self.starts.windows(2) {
            let group = &self.shared[range[0] as usize..range[1] as usize];
            let first = vertices[group[0] as usize];
            let (mut least, mut most) = (first, first);
            for &place in &group[1..] {
                for ((least, most), x) in least.iter_mut().zip(&mut most).zip(vertices[place as usize]) {
                    (*least, *most) = ((*least).min(x), (*most).max(x));
                }
            }
            let gap = least.iter().zip(most).map(|(least, most)| most - least).max().unwrap_or(0);
            cracks += usize::from(gap > 0);
            largest = largest.max(gap);
        }
        (cracks, largest)
    }
}
