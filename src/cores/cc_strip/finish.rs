//! The finishing stage: what leaves the finest level. Positions, refined or projected to the limit surface, and
//! normals of the faces around each vertex or of the limit surface.
//!
//! ```text
//!            ┌─► limit (one an axis) ──────────────────────────────────────► delay ─► positions
//!   view x 3 ┤
//!            └─► points ─► vectors (one each an axis) ─► cross products ─► sums ─► unit ─► normals
//! ```
//!
//! Every register moves where `advance` is 1, so the stage stalls as one piece. It looks at the row where the
//! strip ends at the level in use; rows below that hold nothing.

use super::view::View;
use super::view_ports::{connected, names};
use super::{limit, normals};
use crate::error::{Error, Result};
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Signal, Word};

/// The axes in the order of the views.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Which normals leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The sum of the cross products of the diagonals of the faces around the vertex (Hall, section 4.4).
    Faces,
    /// The cross product of the tangents of the limit surface.
    Limit,
}

/// The normals that leave: integer vectors in units of 2^-2f, f the fraction of the points; in full, or as unit
/// vectors.
///
/// A point is off by half a unit 2^-f at most in each coordinate, and so the diagonal of a face by one and a tangent,
/// whose length is some twelve edges, by six and a half. A normal's angle is off by about the sum of both vectors'
/// errors over their lengths: the shorter the edges, the more fraction bits it takes. Face normals have
/// the error of the faces besides, which four times as many faces make a quarter; at an irregular vertex it
/// goes down more slowly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Normals {
    pub kind: Kind,
    /// f: fraction bits of the points that normals are computed from. Vertices are rounded to it, half up;
    /// all that follows is exact.
    pub point_fraction: u32,
    /// n: unit vectors over 2^n leave instead, within 0.75 of their last place (see [`unit`](super::unit)).
    pub unit: Option<u32>,
}

/// What a finishing stage is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// A vertex of the finest level.
    pub word: Word,
    /// A position that leaves, and how it loses the bits that the output has not.
    pub output: Word,
    pub rounding: Rounding,
    /// The levels that can be chosen at run time, the last the finest; equal for a core of one level.
    pub levels: [u32; 2],
    pub max_valence: u32,
    /// b: fraction bits of the table lambda_d = 1 / (d (d + 5)) of limit positions; none for refined ones.
    pub limit: Option<u32>,
    pub normals: Option<Normals>,
}

impl Parameters {
    /// # Errors
    /// Numbers that no stage has; the message names what mends it.
    pub fn check(self) -> Result<Self> {
        let refuse = |what: String, help: &str| Err(Error::usage(what).help(help));
        let rounded = self.rounded(self.output.fraction);
        if self.rounding == Rounding::Exact {
            return refuse("positions that lose nothing".into(), "choose half-up, half-even or floor");
        }
        if self.output.fraction > self.word.fraction {
            let what = format!("positions {} from vertices {}", self.output, self.word);
            return refuse(what, "choose an output fraction that the finest level has, --guard is one way");
        }
        if !self.output.range.contains(rounded) {
            let what = format!("positions {} of vertices within {rounded}", self.output);
            return refuse(what, "a fraction that is rounded away can carry into one integer bit more");
        }
        let Some(Normals { kind, point_fraction, unit }) = self.normals else { return Ok(self) };
        if point_fraction as i32 > self.word.fraction {
            let what = format!("normals from {point_fraction} fraction bits of vertices {}", self.word);
            return refuse(what, "choose no more than the finest level has");
        }
        if self.normal_word().is_none_or(|word| word.width() > 63) {
            let what = format!("{kind:?} normals from points of {point_fraction} fraction bits");
            return refuse(what, "choose fewer fraction bits for them: normals of up to 63 bits leave");
        }
        if let Some(n) = unit.filter(|n| !(8..=16).contains(n)) {
            return refuse(format!("unit normals over 2^{n}"), "choose 8 to 16 fraction bits");
        }
        Ok(self)
    }

    /// Strip vertices of a column of the finest level.
    pub fn rows(self) -> usize {
        1 + (1 << self.levels[1])
    }

    /// Rows other than the last that can be the bottom of the strip.
    pub fn bottoms(self) -> impl Iterator<Item = usize> {
        (self.levels[0]..self.levels[1]).map(|level| 1 << level)
    }

    /// The range of a vertex that is rounded half up to a fraction.
    fn rounded(self, fraction: i32) -> Range {
        let drop = (self.word.fraction - fraction).clamp(0, 120) as u32;
        let half = 1i128 << drop >> 1;
        (self.word.range + Range::point(half)).shift_right(drop)
    }

    /// A vertex as normals see it.
    pub fn point(self) -> Option<Word> {
        let fraction = self.normals?.point_fraction as i32;
        Some(Word::from(self.rounded(fraction)).fraction(fraction))
    }

    /// A component of a normal that is not normalised: at most 2d s^2 for d faces with points s apart, and 72 s^2 for
    /// limit tangents, whose positive weights add up to 6.
    pub fn normal_word(self) -> Option<Word> {
        let point = self.point()?;
        let s = point.range.max.checked_sub(point.range.min)?;
        let most = match self.normals?.kind {
            Kind::Faces => 2 * i128::from(self.max_valence),
            Kind::Limit => 72,
        };
        let bound = s.checked_mul(s)?.checked_mul(most)?;
        Some(Word::range(-bound, bound).fraction(2 * point.fraction))
    }
}

/// The results for the middle column of a view.
pub struct Finished {
    /// Per row, in the output word.
    pub positions: Vec<[Signal; 3]>,
    /// Per row: in [`Parameters::normal_word`], or unit vectors in n + 2 bits. Empty without.
    pub normals: Vec<[Signal; 3]>,
    /// Clocks with `advance` from a view to its results; the last stage is registered.
    pub latency: u32,
}

/// Registers of a stage: all of them move where `advance` is 1.
pub(super) fn stage(m: &Builder, advance: &Signal, name: impl Into<String>, value: &Signal) -> Signal {
    let register = m.register(name, value.word());
    m.on(advance, &register, value);
    register
}

/// A value that waits for slower ones.
fn waiting(m: &Builder, advance: &Signal, name: &str, value: &Signal, clocks: u32) -> Signal {
    (1..=clocks).fold(value.clone(), |value, clock| stage(m, advance, format!("{name}_wait_{clock}"), &value))
}

/// Positions and normals of the middle column of three. All registers move where `advance` is 1.
///
/// # Errors
/// Parameters that [`Parameters::check`] refuses, a mistake in the units.
pub fn finish(m: &Builder, p: &Parameters, views: [&View; 3], advance: &Signal) -> Result<Finished> {
    let p = p.check()?;
    let (columns, early) = match p.limit {
        Some(_) => limits(m, p, views, advance)?,
        None => refined(m, p, views, advance),
    };
    let (normals, late) = match p.normals {
        Some(_) => normals::normals(m, p, views, advance)?,
        None => (vec![], early),
    };
    let latency = early.max(late);
    let positions = (0..p.rows()).map(|row| {
        [0, 1, 2].map(|axis| {
            let name = format!("position_{row}_{}", AXES[axis]);
            waiting(m, advance, &name, &columns[axis][row], latency - early)
        })
    });
    let normals = normals.iter().enumerate().map(|(row, normal)| {
        [0, 1, 2].map(|axis| {
            let name = format!("normal_{row}_{}", AXES[axis]);
            waiting(m, advance, &name, &normal[axis], latency - late)
        })
    });
    Ok(Finished { positions: positions.collect(), normals: normals.collect(), latency })
}

/// The refined positions, rounded.
fn refined(m: &Builder, p: Parameters, views: [&View; 3], advance: &Signal) -> (Vec<Vec<Signal>>, u32) {
    let column = |(view, axis): (&&View, &str)| {
        let rounded = |(row, vertex): (usize, &Signal)| {
            let drop = (p.word.fraction - p.output.fraction) as u32;
            let rounded = m.round(vertex, drop, p.rounding);
            stage(m, advance, format!("refined_{row}_{axis}"), &m.wrap(&rounded, p.output))
        };
        view.rows[1].iter().enumerate().map(rounded).collect()
    };
    (views.iter().zip(AXES).map(column).collect(), 1)
}

fn limits(
    m: &Builder,
    p: Parameters,
    views: [&View; 3],
    advance: &Signal,
) -> Result<(Vec<Vec<Signal>>, u32)> {
    let unit = limit::build(p)?;
    let ports = names(p);
    let column = |(view, axis): (&&View, &str)| -> Vec<Signal> {
        let mut inputs = connected(m, p, &ports, view, p.word);
        inputs.push(("advance".into(), advance.clone()));
        let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
        let placed = m.instance(&format!("limit_{axis}"), &unit, &inputs);
        (0..p.rows()).map(|row| placed.out(&format!("limit_{row}"))).collect()
    };
    Ok((views.iter().zip(AXES).map(column).collect(), limit::LATENCY))
}
