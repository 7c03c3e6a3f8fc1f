//! A design point: one core in one number format, measured on one mesh.
//!
//! ```text
//!   loop Q12.12 level 5 uniform 17 table 40 half-up registers 20     the canonical text of a design
//!   + blake3 of the mesh's points and faces                          what it is measured on
//!   ────────────────────────────────────────────────────────────
//!   key = the first 128 bits of the blake3 of both, in hexadecimal
//! ```
//!
//! Two runs, on two machines, name the same point by the same key; a mesh that has changed is another point.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::cores::loop_fd::RegisterForm;
use crate::error::{Error, Result};
use crate::fixed::{Format, Rounding};

/// Which surface, and with it which core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Triangles, the core `loop-fd`.
    Loop,
    /// Quads in strips, the core `cc-strip`.
    CatmullClark,
}

/// How the numbers between input and output are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precision {
    /// Nothing is lost before the last rounding.
    Exact,
    /// Loop: all differences with F fraction bits.
    Uniform(u32),
    /// Loop: the differences of order m with F_m fraction bits, F_0 <= ... <= F_4.
    Progressive([u32; 5]),
    /// Catmull-Clark: g fraction bits more than the coordinates, on every level.
    Guard(u32),
}

/// A core, complete but for what the mesh decides (the largest valence, room for ghosts).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Design {
    pub scheme: Scheme,
    /// The format of the control points; also that of the vertices that come out.
    pub coordinates: Format,
    /// The level that the mesh is evaluated at, which is the finest of the core.
    pub level: u32,
    pub precision: Precision,
    /// Fraction bits of the weights of irregular vertices.
    pub table: u32,
    /// How numbers lose their last bits.
    pub rounding: Rounding,
    /// Loop only: registers of a coordinate.
    pub registers: RegisterForm,
}

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// A built-in shape.
    Shape(String),
    /// A file, as the user named it.
    File(String),
}

/// A mesh as a point names it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct MeshName {
    pub name: String,
    pub source: Origin,
    /// The hash of its points and faces.
    pub hash: String,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    pub design: Design,
    pub mesh: MeshName,
}

impl Point {
    /// The name of the point: equal for equal parameters and equal meshes, wherever they come from.
    pub fn key(&self) -> String {
        let text = format!("{}\n{}\n", self.design, self.mesh.hash);
        blake3::hash(text.as_bytes()).to_hex()[..32].to_string()
    }

    /// The order in which points are listed: by mesh and evaluation, so that neighbours share the most.
    pub fn order(&self) -> impl Ord + use<> {
        let design = &self.design;
        let shared = (self.mesh.clone(), design.scheme, design.coordinates, design.level, design.table);
        (shared, design.precision, design.rounding, design.registers)
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Scheme::Loop => "loop",
            Scheme::CatmullClark => "catmull-clark",
        })
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Precision::Exact => f.write_str("exact"),
            Precision::Uniform(bits) => write!(f, "uniform {bits}"),
            Precision::Progressive([a, b, c, d, e]) => write!(f, "progressive {a},{b},{c},{d},{e}"),
            Precision::Guard(bits) => write!(f, "guard {bits}"),
        }
    }
}

impl FromStr for Precision {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse = || {
            Error::input(format!("'{text}' is no number format"))
                .help("exact, uniform F, progressive F0,F1,F2,F3,F4 and guard G exist")
        };
        let number = |text: &str| text.parse::<u32>().map_err(|_| refuse());
        match text.split_once(' ') {
            None if text == "exact" => Ok(Precision::Exact),
            Some(("uniform", bits)) => Ok(Precision::Uniform(number(bits)?)),
            Some(("guard", bits)) => Ok(Precision::Guard(number(bits)?)),
            Some(("progressive", bits)) => {
                let bits = bits.split(',').map(number).collect::<Result<Vec<u32>>>()?;
                Ok(Precision::Progressive(bits.try_into().map_err(|_| refuse())?))
            }
            _ => Err(refuse()),
        }
    }
}

/// The canonical text.
impl fmt::Display for Design {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Design { scheme, coordinates, level, precision, table, rounding, .. } = self;
        write!(f, "{scheme} {coordinates} level {level} {precision} table {table} {rounding}")?;
        match scheme {
            Scheme::Loop => write!(f, " registers {}", self.registers),
            Scheme::CatmullClark => Ok(()),
        }
    }
}

impl Design {
    /// Fraction bits of the table when nothing is said: its part of the error stays far below a unit.
    pub fn usual_table(scheme: Scheme, coordinates: Format) -> u32 {
        match scheme {
            Scheme::Loop => coordinates.width() + 16,
            Scheme::CatmullClark => coordinates.width() + 13,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point() -> Point {
        let design = Design {
            scheme: Scheme::Loop,
            coordinates: Format { integer: 12, fraction: 12 },
            level: 5,
            precision: Precision::Progressive([7, 11, 15, 18, 18]),
            table: 40,
            rounding: Rounding::HalfUp,
            registers: RegisterForm::Minimal20,
        };
        let mesh = MeshName { name: "m".into(), source: Origin::Shape("m".into()), hash: "00".into() };
        Point { design, mesh }
    }

    #[test]
    fn the_canonical_text_says_everything() {
        let text = "loop Q12.12 level 5 progressive 7,11,15,18,18 table 40 half-up registers 20";
        assert_eq!(point().design.to_string(), text);
    }

    #[test]
    fn the_key_changes_with_each_parameter_and_the_mesh_but_not_with_its_name() {
        let first = point();
        let mut keys = vec![first.key()];
        let mut change = |change: fn(&mut Point)| {
            let mut point = first.clone();
            change(&mut point);
            keys.push(point.key());
        };
        change(|p| p.design.coordinates.fraction = 11);
        change(|p| p.design.level = 6);
        change(|p| p.design.precision = Precision::Exact);
        change(|p| p.design.table = 39);
        change(|p| p.design.rounding = Rounding::Floor);
        change(|p| p.design.registers = RegisterForm::Relative19);
        change(|p| p.design.scheme = Scheme::CatmullClark);
        change(|p| p.mesh.hash = "01".into());
        let count = keys.len();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), count);
        let mut renamed = first.clone();
        (renamed.mesh.name, renamed.mesh.source) = ("n".into(), Origin::File("n.obj".into()));
        assert_eq!(renamed.key(), first.key());
    }

    #[test]
    fn a_precision_reads_as_it_is_written() {
        use Precision::{Exact, Guard, Progressive, Uniform};
        for precision in [Exact, Uniform(17), Progressive([1, 2, 3, 4, 5]), Guard(0)] {
            assert_eq!(precision.to_string().parse::<Precision>().unwrap(), precision);
        }
        for bad in ["", "uniform", "uniform x", "progressive 1,2,3", "guard -1", "exact 3"] {
            assert!(bad.parse::<Precision>().is_err(), "{bad}");
        }
    }
}
