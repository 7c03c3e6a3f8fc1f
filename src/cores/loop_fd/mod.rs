//! `loop-fd`: the forward-difference engine for Loop patches (Bischoff, Kobbelt, Seidel 2000, section 3
//! and appendix A.4), exact and complete: control points in, rounded vertices of triangle strips out.
//!
//! ```text
//!             ┌────────┐ 12 points, an ┌──────────┐ 12 differences ┌───────────┐ 2 numerators ┌──────────┐
//! s_axis ────►│ loader │──────────────►│ start-up │───────────────►│ engine  x │─────────────►│ rounders │──► FIFO ──► m_axis
//! 12 points   └────────┘ axis a clock  └──────────┘                │ engine  y │  a clock     └──────────┘
//! of a patch                                                       │ engine  z │
//!                                             strip control ──────►└───────────┘
//! ```
//!
//! **In**: packets of 12 beats, the control points in the order of section 3.2's lattice, row by row
//! (0,-1) (1,-1) (2,-1) | (-1,0) **(0,0)** **(1,0)** (2,0) | (-1,1) **(0,1)** (1,1) | (-1,2) (0,2); x, y
//! and z in lanes, `tuser` the level rho of the patch (2^rho steps along each edge), `tlast` on the
//! twelfth. A packet of another length, or of a level above the maximum R, is dropped whole. A control
//! point of a patch of level rho carries 4 (R - rho) fraction bits more than the coordinate format, so
//! all patches of a mesh, however deep, share the denominator 12 * 16^R.
//!
//! **Out**: for strip i the vertices p(i,j), p(i+1,j) for j = 0 .. 2^rho - i - 1, a pair a beat, then
//! p(i, 2^rho - i) alone (`tkeep` drops the right one) with `tlast`. `tuser` bit 0 marks the first beat of
//! a patch, bit 1 the last.
//!
//! **Lanes**, where [`Parameters::lanes`] asks for K of them: for every Kth strip i the vertices p(i,j) ... p(i+K,j) in a
//! beat, j = 0 .. 2^rho - i, as far as they exist (`tkeep`); `tlast` where j ends.
//!
//! **Columns**: both columns of a strip run, so that a vertex of an inner column is computed twice; or, where
//! [`Columns::Buffered`] asks for it, one runs and a memory keeps its vertices for the next strip. The beats are those of
//! one lane.
//!
//! **Numbers**: all differences are integers over the common denominator, kept modulo 2^B with
//! B = W + 4R + 4. The basis is non-negative with sum 1, so every vertex fits B bits, and a linear
//! recurrence modulo 2^B gives it exactly whatever the other registers do. The only rounding is the last.
//!
//! **Reduced numbers**, where [`Precision::Reduced`] asks for them: the start-up divides each difference by
//! 12 * 16^R and rounds it to the fraction bits of its order, at every level alike, so 12 numbers a patch are
//! divided and no vertex is. With progressive fractions an add rounds its addend. The registers are as wide
//! as [`words`] says. What comes out is within a proven bound of the surface; patches that share an edge may
//! differ there.

mod control;
mod engine;
mod lanes;
mod loader;
pub mod proof;
mod startup;
mod top;
mod vertex;
pub mod words;

use std::fmt;
use std::rc::Rc;
use std::str::FromStr;

use crate::cores::rounder;
use crate::error::{Error, Result};
use crate::fixed::{Format, Precision, Range, Rounding};
use crate::hdl::{Module, Word};

pub use engine::DIFFERENCES;
pub use lanes::{AHEAD, HOP, LATER};

/// How the differences are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RegisterForm {
    /// As published: all 15 differences and two columns of 4.
    Published23,
    /// Without the (2,2) difference, which is zero.
    WithoutZero22,
    /// Without the (4,0) and (0,4) differences, which are twice the (3,1) and (1,3) ones.
    Minimal20,
    /// The right column as its 3 differences from the left one.
    Relative19,
}

impl RegisterForm {
    pub const ALL: [RegisterForm; 4] = [
        RegisterForm::Published23,
        RegisterForm::WithoutZero22,
        RegisterForm::Minimal20,
        RegisterForm::Relative19,
    ];

    /// Registers per coordinate.
    pub fn count(self) -> u32 {
        match self {
            RegisterForm::Published23 => 23,
            RegisterForm::WithoutZero22 => 22,
            RegisterForm::Minimal20 => 20,
            RegisterForm::Relative19 => 19,
        }
    }

    pub fn from_count(count: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.count() == count)
    }
}

impl fmt::Display for RegisterForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.count())
    }
}

/// Where the two columns of a strip come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Columns {
    /// Both run: the vertices of an inner column are computed twice, or shared by lanes.
    #[default]
    Shared,
    /// One runs, and the one before it comes out of a memory: every vertex is computed once.
    Buffered,
}

impl Columns {
    pub const ALL: [Columns; 2] = [Columns::Shared, Columns::Buffered];
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Columns::Shared => "shared",
            Columns::Buffered => "buffered",
        })
    }
}

impl FromStr for Columns {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|columns| columns.to_string() == text).ok_or_else(|| {
            Error::usage(format!("no such form of columns: '{text}'")).help("choose shared or buffered")
        })
    }
}

/// What a `loop-fd` is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// The format of the control coordinates; W bits.
    pub coordinates: Format,
    /// Fraction bits of the output.
    pub output_fraction: u32,
    /// R: the highest level; every level from 0 on can be chosen for each patch.
    pub max_level: u32,
    /// The lowest level; patches below it are dropped. Reduced differences of fine levels are narrower.
    pub min_level: u32,
    pub registers: RegisterForm,
    pub precision: Precision,
    /// Bits of a chunk, where wide numbers are emitted in chunks with skewed carry.
    pub chunk: Option<u32>,
    /// Neighbouring strips that are computed at once, from columns that they share, and outer differences that are kept
    /// as digits where there are chunks; without, each strip has two columns of its own, and the outer differences step
    /// in a clock.
    pub lanes: Option<u32>,
    /// Where the columns of a strip come from; buffered, of one lane.
    pub columns: Columns,
}

impl Parameters {
    pub const HIGHEST_LEVEL: u32 = 10;
    pub const MOST_LANES: u32 = 32;

    /// A core of exact numbers, for all levels up to the highest.
    ///
    /// # Errors
    /// Numbers that no core has.
    pub fn new(
        coordinates: Format,
        output_fraction: u32,
        max_level: u32,
        registers: RegisterForm,
    ) -> Result<Self> {
        let precision = Precision::Exact;
        let parameters = Parameters {
            coordinates,
            output_fraction,
            max_level,
            min_level: 0,
            registers,
            precision,
            chunk: None,
            lanes: None,
            columns: Columns::Shared,
        };
        if max_level > Self::HIGHEST_LEVEL {
            return Err(Error::usage(format!("maximum level {max_level} is above {}", Self::HIGHEST_LEVEL))
                .help(format!("choose --max-level 0 to {}", Self::HIGHEST_LEVEL)));
        }
        let (most, f) = (coordinates.fraction + 4 * max_level + 1, i64::from(output_fraction));
        if output_fraction > most
            || i64::from(coordinates.integer) + f < 2
            || coordinates.integer + output_fraction > 56
        {
            let most = most.min(56 - coordinates.integer);
            return Err(Error::usage(format!(
                "{output_fraction} fraction bits of output with {coordinates} at maximum level {max_level}"
            ))
            .help(format!(
                "choose an output fraction of {} to {most} bits",
                2u32.saturating_sub(coordinates.integer)
            )));
        }
        Ok(parameters)
    }

    /// The same core with other numbers inside.
    ///
    /// # Errors
    /// Differences of order 0 with fewer fraction bits than the output; progressive fractions where the
    /// right column is kept as its distance from the left one, which would round it otherwise.
    pub fn with_precision(self, precision: Precision) -> Result<Self> {
        let Some(reduced) = precision.reduced() else { return Ok(Parameters { precision, ..self }) };
        let fractions = reduced.fractions;
        if self.coordinates.fraction + fractions.of(0) < self.output_fraction {
            return Err(Error::usage(format!(
                "{} fraction bits of the output, but differences of {} + {}",
                self.output_fraction,
                self.coordinates.fraction,
                fractions.of(0)
            ))
            .help("give the differences more fraction bits, or the output fewer"));
        }
        if self.registers == RegisterForm::Relative19 && !fractions.is_uniform() {
            return Err(Error::usage("progressive fractions with 19 registers")
                .help("use --registers 20: a column kept as a distance would be rounded otherwise"));
        }
        if reduced.rounding == Rounding::Exact {
            return Err(Error::usage("reduced numbers without rounding").help("choose a rounding mode"));
        }
        Ok(Parameters { precision, ..self })
    }

    /// The same core for levels from this one on.
    ///
    /// # Errors
    /// A level above the highest.
    pub fn with_min_level(self, min_level: u32) -> Result<Self> {
        if min_level > self.max_level {
            return Err(Error::usage(format!(
                "minimum level {min_level} above maximum level {}",
                self.max_level
            ))
            .help("lower --min-level or raise --max-level"));
        }
        Ok(Parameters { min_level, ..self })
    }

    /// The same core with its wide numbers in chunks of so many bits, or whole.
    ///
    /// # Errors
    /// Chunks of fewer than 4 bits.
    pub fn with_chunk(self, chunk: impl Into<Option<u32>>) -> Result<Self> {
        let chunk = chunk.into();
        if let Some(bits) = chunk.filter(|&bits| bits < 4) {
            return Err(Error::usage(format!("chunks of {bits} bits"))
                .help("choose 4 bits or more; with 14 to 16 the carry does not limit the clock of an ECP5"));
        }
        Ok(Parameters { chunk, ..self })
    }

    /// The same core with so many neighbouring strips at once.
    ///
    /// # Errors
    /// No lane, or too many; reduced numbers, and register forms of which lanes have none; several with buffered columns.
    pub fn with_lanes(self, lanes: impl Into<Option<u32>>) -> Result<Self> {
        let lanes = lanes.into();
        let Some(count) = lanes else { return Parameters { lanes, ..self }.with_columns(self.columns) };
        if !(1..=Self::MOST_LANES).contains(&count) {
            return Err(Error::usage(format!("{count} lanes"))
                .help(format!("choose 1 to {} lanes", Self::MOST_LANES)));
        }
        if self.precision != Precision::Exact {
            return Err(Error::usage("lanes of reduced numbers").help("leave out --lanes, or the fractions"));
        }
        if self.registers != RegisterForm::Minimal20 {
            return Err(Error::usage(format!("lanes with {} registers", self.registers))
                .help("use --registers 20: neighbouring lanes share their columns"));
        }
        Parameters { lanes, ..self }.with_columns(self.columns)
    }

    /// The same core with the columns of its strips from there. Buffered, it has one lane, said or not.
    ///
    /// # Errors
    /// Buffered columns of several lanes, of reduced numbers, or with a register form of which lanes have none.
    pub fn with_columns(self, columns: Columns) -> Result<Self> {
        if columns == Columns::Shared {
            return Ok(Parameters { columns, ..self });
        }
        if let Some(count) = self.lanes.filter(|&count| count != 1) {
            return Err(Error::usage(format!("buffered columns with {count} lanes")).help(
                "leave out --lanes, or --columns buffered: the buffer holds one column, which serves one strip",
            ));
        }
        if self.precision != Precision::Exact {
            return Err(Error::usage("buffered columns of reduced numbers")
                .help("leave out --columns buffered, or the fractions"));
        }
        if self.registers != RegisterForm::Minimal20 {
            return Err(Error::usage(format!("buffered columns with {} registers", self.registers))
                .help("use --registers 20: of its two columns, the buffer replaces one"));
        }
        Ok(Parameters { columns, lanes: Some(1), ..self })
    }

    /// Whether the column before the one that runs comes out of a memory.
    fn is_buffered(self) -> bool {
        self.columns == Columns::Buffered
    }

    /// Differences that a coordinate keeps: 12 that walk from column to column, and 4 of each column that runs.
    pub fn register_count(self) -> u32 {
        match (self.lanes, self.columns) {
            (None, _) => self.registers.count(),
            (Some(_), Columns::Buffered) => 16,
            (Some(lanes), Columns::Shared) => 12 + 4 * (lanes + 1),
        }
    }

    /// Bits of a digit of the outer differences of lanes, where they have several.
    fn digit(self) -> Option<u32> {
        self.chunk.filter(|&bits| bits < self.modulus())
    }

    /// Digits of a number: the clocks of a step of the outer differences of lanes.
    pub fn digits(self) -> u32 {
        self.digit().map_or(1, |bits| self.modulus().div_ceil(bits))
    }

    /// What the numerators of all vertices have in them where there are lanes.
    fn half(self) -> i128 {
        if self.lanes.is_some() { rounder::half(self.shift()) } else { 0 }
    }

    /// Whether the differences of a patch wait in registers of their own while another one runs. For one lane and patches
    /// of two thousand beats and more, the clocks in which the start-up works alone are fewer than 2 percent.
    fn differences_wait(self) -> bool {
        self.lanes != Some(1) || self.min_level < 6
    }

    /// Clocks from the decision on a beat to the beat.
    fn decided_before(self) -> u32 {
        if self.lanes == Some(1) { LATER } else { 0 }
    }

    /// Vertices in a beat.
    pub fn vertices(self) -> u32 {
        self.lanes.unwrap_or(1) + 1
    }

    /// Whether all patches are of one level.
    pub fn has_one_level(self) -> bool {
        self.min_level == self.max_level
    }

    /// B = W + 4R + 4: the width of every exact difference, and of a control point.
    pub fn modulus(self) -> u32 {
        self.coordinates.width() + 4 * self.max_level + 4
    }

    /// s: a vertex is its numerator over 3 * 2^s, in units of the output.
    pub fn shift(self) -> u32 {
        // 12 * 16^R = 3 * 2^(4R + 2); the output unit is 2^(f - F) of the coordinates'.
        4 * self.max_level + 2 + self.coordinates.fraction - self.output_fraction
    }

    /// F_0 - f: fraction bits that a vertex of reduced numbers loses at last.
    fn last_dropped(self, fraction: u32) -> u32 {
        self.coordinates.fraction + fraction - self.output_fraction
    }

    /// Every output coordinate, in units of the output. With fewer fraction bits than the control points
    /// have, the largest ones round up to 2^(integer - 1), one unit above what the format holds.
    pub fn output_range(self) -> Range {
        let format = Range::signed(self.coordinates.integer + self.output_fraction);
        if let Some(reduced) = self.precision.reduced() {
            if reduced.saturate {
                return format;
            }
            let vertex = words::vertex_range(self, reduced);
            let dropped = self.last_dropped(reduced.fractions.of(0));
            let half = (1i128 << dropped) >> 1;
            return (vertex + Range::point(half)).shift_right(dropped);
        }
        let up = i128::from(self.output_fraction < self.coordinates.fraction);
        Range::new(format.min, format.max + up)
    }

    /// Bits of an output coordinate.
    pub fn output_width(self) -> u32 {
        self.output_range().width()
    }

    /// Bits of one lane of the input stream: a control point in whole bytes.
    pub fn input_lane(self) -> u32 {
        self.point().width().next_multiple_of(8)
    }

    /// Bits of one lane of the output stream: the result in whole bytes.
    pub fn output_lane(self) -> u32 {
        self.output_width().next_multiple_of(8)
    }

    /// A control point. Ghosts beyond a boundary have two bits more than the others; limit positions, which come as
    /// patches of level 0, and reduced cores take all bits.
    fn point(self) -> Word {
        let bits = self.coordinates.width() + 4 * (self.max_level - self.min_level) + 2;
        let narrow = self.min_level > 0 && self.precision == Precision::Exact;
        Word::modular(if narrow { bits } else { self.modulus() })
    }

    /// The width of an exact difference in the start-up: that of a reduced core also needs those that are
    /// too large for the modulus, as long as a vertex depends on them.
    fn startup_modulus(self) -> u32 {
        self.modulus() + if self.precision.reduced().is_some() { 2 } else { 0 }
    }

    /// The difference D(k,l) in the engine.
    fn difference(self, (k, l): (u32, u32)) -> Word {
        match self.precision {
            Precision::Exact => Word::modular(words::exact_width(self, (k, l))),
            Precision::Reduced(reduced) => words::difference(self, reduced, (k, l)),
        }
    }

    /// The level of a patch, as the core carries it.
    fn level(self) -> Word {
        Word::range(0, self.max_level.into())
    }
}

pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Bits of `tuser` at the input: the level.
pub const LEVEL_BITS: u32 = 4;

/// The complete core.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    match parameters.lanes {
        Some(lanes) => lanes::build(parameters, lanes),
        None => top::build(parameters),
    }
}

/// Clocks from the points at the start-up's input to the differences at its output.
pub fn startup_depth(core: &Module) -> u32 {
    let startup = core.instances.iter().find(|i| i.name == "startup");
    startup.and_then(|i| Some(i.module.latency(i.module.outputs.first()?))).unwrap_or(0)
}
