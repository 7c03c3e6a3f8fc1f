//! Design points of `cc-strip`: what they mean for the mesh, the reference and the core.
//!
//! ```text
//!   mesh, coordinates, level ─► Stage: quads, strips, numbers of all vertices of all columns, true positions
//!   Stage, design ─► reference ─► every column of every strip ─► Tally
//! ```
//!
//! Ghosts beyond a boundary may need more integer bits than the mesh, and the core has room for the largest
//! valence of the mesh, so the core of a design depends on the mesh as well.

use super::meshes::Subject;
use super::point::{Design, Precision};
use super::tally::{Tally, Truth};
use crate::cores::cc_strip::{self as core, Parameters};
use crate::cosim::strip_bench::reference_parameters;
use crate::error::{Error, Result};
use crate::fixed::{Format, Rounding};
use crate::mesh;
use crate::model::cc_strip::CcStrip;
use crate::surface::catmull_clark::control::control;
use crate::surface::catmull_clark::error_bound::{Accuracy, error_bound_lsb};
use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::numbers::MAX_LEVELS;
use crate::surface::catmull_clark::oracle::{FRACTION, QuadOracle};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Boundary, Rings};
use crate::surface::catmull_clark::strips::records::{StripRecords, positioned};
use crate::surface::catmull_clark::strips::{Method, cut};

/// What all points of one mesh, coordinate format and level share.
pub struct Stage {
    pub quads: QuadMesh,
    pub rings: Rings,
    /// The format of the core's input: that of the mesh, and integer bits for ghosts.
    coordinates: Format,
    level: u32,
    truth: Truth,
    strips: Vec<StripRecords<[i64; 3]>>,
    /// For each strip the numbers of the vertices, column after column from top to bottom.
    vertices: Vec<Vec<u32>>,
}

/// The most vertices of the fine mesh.
const MOST_VERTICES: usize = 1 << 25;

impl Stage {
    /// # Errors
    /// A mesh that the format does not hold or that cannot be cut into strips; one that becomes too fine.
    pub fn new(subject: &Subject, format: Format, level: u32) -> Result<Stage> {
        if !(1..=MAX_LEVELS).contains(&level) {
            return Err(Error::usage(format!("level {level} of a strip")).help("choose --level 1 to 7"));
        }
        let quantised = mesh::quantise(&subject.mesh, format)?;
        let boundary = Boundary::Ghosts;
        let quads = control(&subject.mesh, &quantised, boundary.corners(), 0)?.mesh;
        let rings = Rings::new(&quads, boundary)?;
        let more = rings.width().saturating_sub(format.width());
        let coordinates = Format { integer: format.integer + more, ..format };
        let grid = QuadGrid::new(&quads, level)?;
        if grid.vertex_count() > MOST_VERTICES {
            let what = format!("level {level} makes {} vertices of this mesh", grid.vertex_count());
            return Err(Error::input(what).at(subject.mesh.place()).help("explore at a lower level"));
        }
        let oracle = QuadOracle::new(&quads, level, boundary.corners())?;
        let uncertainty = match quads.largest_irregular_valence() {
            None => 0.0,
            Some(_) => f64::from(level + 1) * (-f64::from(FRACTION)).exp2(),
        };
        let refined = (0..grid.vertex_count()).map(|v| oracle.refined(v));
        let truth = Truth::new(refined, 1 << FRACTION, uncertainty);
        let cut = cut(&quads, Method::Natural);
        let strips = positioned(&quads, &rings, &cut);
        let rows = 1usize << level;
        let numbers = cut.iter().map(|strip| {
            let places =
                (0..=strip.len() << level).flat_map(|column| (0..=rows).map(move |row| (column, row)));
            places.map(|(column, row)| strip.fine_vertex(&grid, column, row) as u32).collect()
        });
        let vertices = numbers.collect();
        Ok(Stage { quads, rings, coordinates, level, truth, strips, vertices })
    }

    pub fn uncertainty(&self) -> f64 {
        self.truth.uncertainty
    }

    /// The core of a design for this mesh.
    ///
    /// # Errors
    /// A design that no core has.
    pub fn parameters(&self, design: &Design) -> Result<Parameters> {
        parameters(design, self.coordinates, self.rings.largest_valence().max(4) as u32)
    }

    /// Every vertex that the core puts out for this mesh.
    ///
    /// # Errors
    /// A design that the reference does not support.
    pub fn measure(&self, design: &Design) -> Result<Tally<'_>> {
        let reference = CcStrip::new(reference_parameters(self.parameters(design)?))?;
        let mut tally = Tally::new(&self.truth);
        let rows = (1usize << self.level) + 1;
        for (strip, numbers) in self.strips.iter().zip(&self.vertices) {
            reference.for_each_column(
                self.level,
                strip,
                |_, _, _| {},
                |column| {
                    let numbers = &numbers[column.index * rows..];
                    for (&vertex, &position) in numbers.iter().zip(&column.vertices) {
                        tally.put(vertex as usize, position);
                    }
                },
            )?;
        }
        Ok(tally)
    }

    /// No vertex of this mesh is farther from its refined position, in output units.
    ///
    /// # Errors
    /// As [`Stage::parameters`].
    pub fn bound(&self, design: &Design) -> Result<f64> {
        let reference = reference_parameters(self.parameters(design)?);
        Ok(error_bound_lsb(&Accuracy {
            width: self.coordinates.width(),
            extra_fraction: reference.extra_fraction,
            levels: self.level,
            numbers: reference.numbers,
            rounding: reference.rounding,
            table_bits: design.table,
            largest_irregular_valence: self.quads.largest_irregular_valence(),
            limit: false,
        }))
    }
}

fn parameters(design: &Design, coordinates: Format, max_valence: u32) -> Result<Parameters> {
    let refuse = |what: String, help: &str| Err(Error::usage(what).help(help));
    let precision = match design.precision {
        Precision::Exact => core::Precision::Exact,
        Precision::Guard(bits) => core::Precision::Guard(bits),
        Precision::Uniform(_) | Precision::Progressive(_) => {
            return refuse(
                format!("{} fraction bits in Catmull and Clark's scheme", design.precision),
                "use guard bits: --guard 0..6",
            );
        }
    };
    let parameters = Parameters {
        precision,
        rounding: design.rounding,
        table_bits: design.table,
        ..Parameters::exact(coordinates, design.level, max_valence)
    };
    let parameters = parameters.check()?;
    CcStrip::new(reference_parameters(parameters))?;
    Ok(parameters)
}

/// Refuses a design that no core has, whatever the mesh.
///
/// # Errors
/// The reason, with the option that mends it.
pub fn check(design: &Design) -> Result<()> {
    parameters(design, design.coordinates, 4).map(drop)
}

/// The largest error over control points that are made to be the worst, in output units.
///
/// The rings of a vertex that stays a vertex are 3 x 3 on every level. With the four neighbours at `e` and the
/// four diagonals at `f` from it, all of them equal, they stay so, and a level is three sums:
///
/// ```text
///   V' = (36 V + 24 E + 4 F)/64      E' = (6 V + 8 E + 2 F)/16      F' = (V + 2 E + F)/4
/// ```
///
/// All weights are positive, so the error is the largest where all roundings go the same way. The first levels
/// decide most, so the residues of small `e` and `f` are tried out, in a fixed order.
pub fn worst(design: &Design) -> Option<f64> {
    let Precision::Guard(guard) = design.precision else { return None };
    let most = (design.coordinates.max() / 2).min(255) as i128;
    let mut largest = 0.0f64;
    for e in -most..=most {
        // A low-discrepancy walk over the second distance instead of all of them.
        for step in 0..16i128 {
            let f = (e * 89 + step * 197).rem_euclid(2 * most + 1) - most;
            largest = largest.max(ring_error(design, guard, [0, e, f]));
        }
    }
    Some(largest)
}

/// |output - true position| of the vertex in the middle.
fn ring_error(design: &Design, guard: u32, [v, e, f]: [i128; 3]) -> f64 {
    let levels = design.level;
    let scale = |x: i128, bits: u32| x << bits;
    let mut exact = [v, e, f].map(|x| scale(x, 6 * levels));
    let mut kept = [v, e, f].map(|x| scale(x, guard));
    let rounded = |sum: i128, shift: u32, mode: Rounding| mode.apply(sum, shift).unwrap_or(sum >> shift);
    for _ in 0..levels {
        let sums = |[v, e, f]: [i128; 3]| [36 * v + 24 * e + 4 * f, 6 * v + 8 * e + 2 * f, v + 2 * e + f];
        let [a, b, c] = sums(kept);
        kept = [(a, 6), (b, 4), (c, 2)].map(|(sum, shift)| rounded(sum, shift, design.rounding));
        let [a, b, c] = sums(exact);
        // 6 bits a level hold every one of them.
        exact = [a >> 6, b >> 4, c >> 2];
    }
    let output = rounded(kept[0], guard, Rounding::HalfUp);
    let unit = (6.0 * f64::from(levels)).exp2();
    (scale(output, 6 * levels) - exact[0]).unsigned_abs() as f64 / unit
}
