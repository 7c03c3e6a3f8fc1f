//! Design points of `loop-fd`: what they mean for the mesh, the reference and the core.
//!
//! ```text
//!   mesh, coordinates, level ─► Stage: control mesh, numbers of all vertices of all patches, true positions
//!   Stage, design ─► reference ─► every vertex of every patch ─► Tally
//!   design ─► Parameters ─► the core                    design, largest valence ─► bound
//! ```
//!
//! Around irregular vertices a mesh has patches of all levels. A regular mesh has those of one level only, and the core
//! of a reduced format is then narrower, so the core of a design depends on the mesh as well.

use super::meshes::Subject;
use super::point::{Design, Precision};
use super::tally::{Tally, Truth};
use crate::cores::loop_fd::Parameters;
use crate::error::{Error, Result};
use crate::fixed::{Format, Fractions, Precision as Numbers, Reduced, Rounding};
use crate::mesh;
use crate::model::loop_fd::{LoopFd, direct, reduced};
use crate::model::render::render;
use crate::surface::basis;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::error_bound::{Accuracy, error_bound_lsb};
use crate::surface::fine_grid::FineGrid;
use crate::surface::limit_oracle::{FRACTION, LimitOracle};
use crate::surface::packets;
use crate::surface::precision::total_lsb;
use crate::surface::precision::worst::{self, Side};
use crate::surface::table::Table;

/// What all points of one mesh, coordinate format and level share.
pub struct Stage {
    pub control: ControlMesh,
    level: u32,
    truth: Truth,
    /// The number of every vertex of every patch, in the order of the reference.
    vertices: Vec<u32>,
    /// The lowest level of a patch.
    lowest: u32,
}

/// The most vertices of all patches together: some 100 bytes each.
const MOST_VERTICES: usize = 1 << 25;

impl Stage {
    /// # Errors
    /// A mesh that the format does not hold or the scheme is not defined on; one that becomes too fine.
    pub fn new(subject: &Subject, coordinates: Format, level: u32) -> Result<Stage> {
        let quantised = mesh::quantise(&subject.mesh, coordinates)?;
        let control = ControlMesh::new(quantised.positions, subject.mesh.triangles()?)?;
        let oracle_vertices = FineGrid::new(&control, level)?.vertex_count();
        if control.triangles().len() * LoopFd::vertex_count(level) > MOST_VERTICES {
            return Err(Error::input(format!("level {level} makes {oracle_vertices} vertices of this mesh"))
                .at(subject.mesh.place())
                .help("explore at a lower level: the formats are judged by it just as well"));
        }
        let oracle = LimitOracle::new(&control, level)?;
        // The output has the fraction of the coordinates.
        let limits = (0..oracle_vertices).map(|v| oracle.limit12(v));
        let uncertainty = match control.largest_irregular_valence() {
            None => 0.0,
            Some(_) => f64::from(level + 1) * (-f64::from(FRACTION)).exp2(),
        };
        let truth = Truth::new(limits, 12 << FRACTION, uncertainty);
        let (vertices, lowest) = numbers(&control, level)?;
        Ok(Stage { control, level, truth, vertices, lowest })
    }

    pub fn uncertainty(&self) -> f64 {
        self.truth.uncertainty
    }

    /// Every vertex that the core puts out for this mesh.
    ///
    /// # Errors
    /// A design that the reference does not support.
    pub fn measure(&self, design: &Design) -> Result<Tally<'_>> {
        let mut tally = Tally::new(&self.truth);
        self.for_each_vertex(design, |vertex, position| tally.put(vertex, position))?;
        Ok(tally)
    }

    /// One position for each vertex of the fine mesh, in output units: where patches disagree, that of the last one.
    ///
    /// # Errors
    /// As [`Stage::measure`].
    pub fn positions(&self, design: &Design) -> Result<Vec<[i64; 3]>> {
        let mut positions = vec![[0; 3]; self.truth.vertices()];
        self.for_each_vertex(design, |vertex, position| positions[vertex] = position)?;
        Ok(positions)
    }

    fn for_each_vertex(&self, design: &Design, mut put: impl FnMut(usize, [i64; 3])) -> Result<()> {
        let core = reference(design)?;
        let mut rendered = vec![];
        render(&self.control, self.level, &core, &Table::new(design.table)?, &mut rendered)?;
        self.vertices.iter().zip(&rendered).for_each(|(&vertex, &position)| put(vertex as usize, position));
        Ok(())
    }

    /// The core of a design for this mesh.
    ///
    /// # Errors
    /// As [`parameters`].
    pub fn parameters(&self, design: &Design) -> Result<Parameters> {
        let parameters = parameters(design)?;
        match design.precision {
            Precision::Exact => Ok(parameters),
            _ => parameters.with_min_level(self.lowest),
        }
    }

    /// No vertex of this mesh is farther from the limit surface, in output units: what the hierarchy rounds around
    /// irregular vertices, and what the format rounds in the patches.
    ///
    /// # Errors
    /// As [`parameters`].
    pub fn bound(&self, design: &Design) -> Result<f64> {
        let exact = error_bound_lsb(&Accuracy {
            width: design.coordinates.width(),
            extra_fraction: 0,
            level: self.level,
            table_bits: design.table,
            largest_irregular_valence: self.control.largest_irregular_valence(),
        });
        Ok(match numbers_of(design)?.reduced() {
            None => exact,
            Some(reduced) => match (exact - 0.5, total_lsb(reduced, self.level, 0)) {
                (0.0, format) => format,
                // The sum of two numbers that are rounded up may still fall by its own last bit.
                (irregular, format) => (irregular + format).next_up(),
            },
        })
    }
}

/// The numbers of the vertices of all patches, column i = 0..n, in each j = 0..n-i, and the lowest level of a patch.
fn numbers(control: &ControlMesh, level: u32) -> Result<(Vec<u32>, u32)> {
    let grid = FineGrid::new(control, level)?;
    let (mut vertices, mut lowest) = (vec![], level);
    packets::patches(control, level, level, &Table::for_width(control.width())?, |patch| {
        lowest = lowest.min(patch.level);
        let n = patch.steps();
        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
            let [u, v] = patch.lattice(i, j);
            vertices.push(grid.vertex(patch.face as usize, u as usize, v as usize) as u32);
        }
    })?;
    Ok((vertices, lowest))
}

fn reference(design: &Design) -> Result<LoopFd> {
    LoopFd::new(design.coordinates.width(), 0, design.level)?.with_precision(numbers_of(design)?)
}

/// How a core of this design keeps its differences.
fn numbers_of(design: &Design) -> Result<Numbers> {
    let fractions = match design.precision {
        Precision::Exact => return Ok(Numbers::Exact),
        Precision::Uniform(bits) => Fractions::uniform(bits)?,
        Precision::Progressive(bits) => Fractions::new(bits)?,
        Precision::Guard(_) => {
            return Err(Error::usage("guard bits in Loop's scheme")
                .help("guard bits are for --scheme catmull-clark; use --fraction"));
        }
    };
    Ok(Numbers::Reduced(Reduced { rounding: design.rounding, ..Reduced::new(fractions) }))
}

/// The core of a design, for every mesh.
///
/// # Errors
/// A design that no core has.
pub fn parameters(design: &Design) -> Result<Parameters> {
    if design.precision == Precision::Exact && design.rounding != Rounding::HalfUp {
        return Err(Error::usage(format!("the exact format rounds {}", design.rounding))
            .help("it rounds once, half up: use --rounding half-up"));
    }
    Table::new(design.table)?;
    reference(design)?;
    Parameters::new(design.coordinates, design.coordinates.fraction, design.level, design.registers)?
        .with_precision(numbers_of(design)?)
}

/// The part of a design that [`worst`] depends on.
pub fn worst_name(design: &Design) -> String {
    format!("{} {} {} {}", design.coordinates, design.level, design.precision, design.rounding)
}

/// The largest error over control points that are made to be the worst, in output units; none where no such points
/// are found.
///
/// The exact format rounds once, so the worst is a tie: P0 = 6 alone puts the first corner at 6/12. Reduced formats
/// round the start-up, and [`worst`](crate::surface::precision::worst) pushes all of these roundings to one side.
///
/// # Errors
/// As [`parameters`].
pub fn worst(design: &Design) -> Result<Option<f64>> {
    let (core, width) = (reference(design)?, design.coordinates.width());
    let Some(reduced) = core.precision().reduced() else {
        let mut points = [[0i128; 3]; 12];
        points[0] = [6; 3];
        let found = direct::vertex(&core, design.level, &points, 0, 0);
        return Ok(Some((found[0] as f64 - 0.5).abs()));
    };
    let cases = [Side::Above, Side::Below].map(|side| worst::points(reduced, design.level, width, side));
    let errors = cases.iter().flatten().map(|case| corner_error(&core, design.level, &case.points));
    Ok(errors.reduce(f64::max))
}

/// |output - exact position| of p(n, 0), in output units.
fn corner_error(core: &LoopFd, level: u32, points: &[i64; 12]) -> f64 {
    let n = 1u32 << level;
    let wide = points.map(|p| [i128::from(p); 3]);
    let Some(mut columns) = reduced::columns(core) else { return 0.0 };
    columns.start(level, &wide);
    (0..n).for_each(|_| columns.next(&mut []));
    let mut last = [[0; 3]];
    columns.next(&mut last);
    let exact: i128 = basis::mask(level, n, 0).iter().zip(&wide).map(|(&w, p)| i128::from(w) * p[0]).sum();
    let unit = i128::from(basis::denominator(level));
    (i128::from(last[0][0]) * unit - exact).unsigned_abs() as f64 / unit as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cores::loop_fd::RegisterForm;
    use crate::explore::point::{Origin, Scheme};
    use crate::surface::assembly::Assembly;

    fn design(level: u32) -> Design {
        let coordinates = Format { integer: 2, fraction: 14 };
        Design {
            scheme: Scheme::Loop,
            coordinates,
            level,
            precision: Precision::Exact,
            table: Design::usual_table(Scheme::Loop, coordinates),
            rounding: Rounding::HalfUp,
            registers: RegisterForm::Minimal20,
        }
    }

    #[test]
    fn the_tally_says_what_the_oracle_and_the_assembly_say() {
        let subject = Subject::load(&Origin::Shape("blob".into()), false).unwrap();
        let design = design(3);
        let stage = Stage::new(&subject, design.coordinates, 3).unwrap();
        let tally = stage.measure(&design).unwrap();
        assert_eq!(tally.missing(), 0);

        // The slow way: patch by patch, each vertex by its own division.
        let core = reference(&design).unwrap();
        let mut assembly = Assembly::new(FineGrid::new(&stage.control, 3).unwrap());
        packets::patches(&stage.control, 3, 3, &Table::new(design.table).unwrap(), |patch| {
            let n = patch.steps() as u32;
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                let vertex = direct::vertex(&core, patch.level, &patch.points, i, j);
                assembly.put(patch, i as usize, j as usize, vertex);
            }
        })
        .unwrap();
        let oracle = LimitOracle::new(&stage.control, 3).unwrap();
        let expected = oracle.error(&assembly.positions().unwrap(), 0).unwrap();
        let errors = tally.errors();
        assert!((errors.max - expected.max).abs() < 1e-14, "{} {}", errors.max, expected.max);
        assert!((errors.rms - expected.rms).abs() < 1e-14);
        assert_eq!((tally.cracks().count, assembly.cracks()), (0, 0));
    }

    #[test]
    fn the_worst_case_of_the_exact_format_is_its_bound() {
        assert_eq!(worst(&design(4)).unwrap(), Some(0.5));
    }
}
