//! Points and results as lines of JSON, the form in which plans and results travel.
//!
//! ```text
//!   {"key":"..","mesh":{..},"scheme":"loop","coordinates":"Q2.22","level":5,"precision":"uniform 17",..}   a plan
//!   the same and "bound_lsb", "error_lsb", "cracks", "cost", "command"                                     a result
//! ```
//!
//! A line holds nothing that depends on the run (no time, no machine), so the same point gives the same bytes.

use serde::{Deserialize, Serialize};

use super::cost::Cost;
use super::point::{Design, MeshName, Point, Scheme};
use super::synth::Synthesis;
use super::tally::Cracks;
use crate::cores::loop_fd::RegisterForm;
use crate::error::{Error, Result};

/// A point as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    pub key: String,
    pub mesh: MeshName,
    pub scheme: Scheme,
    pub coordinates: String,
    pub level: u32,
    pub precision: String,
    pub table: u32,
    pub rounding: String,
    /// Loop only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registers: Option<u32>,
}

/// Errors in units of the output's last place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorLsb {
    /// Over all vertices of the mesh.
    pub max: f64,
    pub rms: f64,
    /// Over control points made to be the worst; none where nothing is derived.
    pub worst_case: Option<f64>,
    /// How far these may be off themselves.
    pub uncertainty: f64,
}

/// A point with all that was found out about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    #[serde(flatten)]
    pub point: Planned,
    /// The proven bound of the error on this mesh.
    pub bound_lsb: f64,
    pub error_lsb: ErrorLsb,
    pub cracks: Cracks,
    pub cost: Cost,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub synthesis: Option<Synthesis>,
    /// The command that writes the core.
    pub command: String,
}

impl From<&Point> for Planned {
    fn from(point: &Point) -> Self {
        let Point { design, mesh } = point;
        Planned {
            key: point.key(),
            mesh: mesh.clone(),
            scheme: design.scheme,
            coordinates: design.coordinates.to_string(),
            level: design.level,
            precision: design.precision.to_string(),
            table: design.table,
            rounding: design.rounding.to_string(),
            registers: (design.scheme == Scheme::Loop).then(|| design.registers.count()),
        }
    }
}

impl Planned {
    /// The point of a line.
    ///
    /// # Errors
    /// A format or a name that does not exist; a key that is not that of the point.
    pub fn point(&self) -> Result<Point> {
        let registers = self.registers.unwrap_or(20);
        let design = Design {
            scheme: self.scheme,
            coordinates: self.coordinates.parse()?,
            level: self.level,
            precision: self.precision.parse()?,
            table: self.table,
            rounding: self.rounding.parse()?,
            registers: RegisterForm::from_count(registers)
                .ok_or_else(|| Error::input(format!("no core has {registers} registers a coordinate")))?,
        };
        let point = Point { design, mesh: self.mesh.clone() };
        if point.key() != self.key {
            return Err(Error::input(format!("the key {} is not that of '{}'", self.key, point.design))
                .help("the line was changed by hand, or comes from another version: plan again"));
        }
        Ok(point)
    }
}

impl Record {
    /// The error that the format adds in the worst case known: on the mesh, or on the worst control points.
    pub fn worst(&self) -> f64 {
        self.error_lsb.worst_case.unwrap_or(0.0).max(self.error_lsb.max)
    }

    /// Whether everything measured lies within the proven bound.
    pub fn within_bound(&self) -> bool {
        self.worst() <= self.bound_lsb + self.error_lsb.uncertainty
    }

    /// The design in a few words, for tables.
    pub fn label(&self) -> String {
        let point = &self.point;
        let registers = point.registers.map(|count| format!(", {count} registers")).unwrap_or_default();
        let rounding =
            if point.rounding == "half-up" { String::new() } else { format!(" {}", point.rounding) };
        format!(
            "{} L{} {}{rounding}, table {}{registers}",
            point.coordinates, point.level, point.precision, point.table
        )
    }
}

/// One line, with its end.
pub fn line(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value)
        .map_err(|error| Error::input(format!("the point cannot be written as JSON: {error}")))?;
    Ok(text + "\n")
}

/// Reads every line of a text; blank ones do not count.
///
/// # Errors
/// The first line that is not what it should be, with its number.
pub fn read<T: for<'a> Deserialize<'a>>(text: &str, place: &str) -> Result<Vec<T>> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let parse = |(index, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|error| {
            Error::input(format!("this line is no point: {error}"))
                .at(format!("{place}:{}", index + 1))
                .help("give a file that 'explore' wrote; remove the line if it was damaged")
        })
    };
    lines.map(parse).collect()
}
