//! The options of `explore` that say what varies, and what they become: meshes and axes.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::cli::values::Registers;
use crate::error::{Error, Result};
use crate::explore::axes::{Axes, Sweep};
use crate::explore::meshes::Subject;
use crate::explore::pareto::Price;
use crate::explore::point::{Origin, Precision, Scheme};
use crate::explore::ranges::{Fractions, Numbers};
use crate::fixed::{Format, Rounding};

/// What varies.
#[derive(Clone, Debug, clap::Args)]
pub struct Varying {
    /// Control meshes: OBJ, OFF, PLY, STL or SGI Inventor
    #[arg(value_name = "MESH")]
    pub meshes: Vec<PathBuf>,

    /// Built-in shapes beside the meshes or in place of them; 'subdiv-rtl shapes' lists them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub shape: Vec<String>,

    /// Split polygons into triangles
    #[arg(long)]
    pub triangulate: bool,

    /// The subdivision scheme [default: triangles go by Loop's, other meshes by Catmull and Clark's]
    #[arg(long, value_enum)]
    pub scheme: Option<SchemeName>,

    /// Levels
    #[arg(long, value_name = "LIST", default_value = "5")]
    pub level: Numbers,

    /// Formats of the control points and vertices [default: the widest fraction that fits in 24 bits]
    #[arg(long, value_name = "Qi.f,..", value_delimiter = ',')]
    pub coordinates: Vec<Format>,

    /// The exact format; without any other it is the default
    #[arg(long, help_heading = "Number formats")]
    pub exact: bool,

    /// Loop: fraction bits of all differences
    #[arg(long, value_name = "LIST", help_heading = "Number formats")]
    pub fraction: Option<Numbers>,

    /// Loop: fraction bits of the differences of order 0 to 4, each a number or a range; again for more
    #[arg(long, value_name = "F0,F1,F2,F3,F4", help_heading = "Number formats")]
    pub fractions: Vec<Fractions>,

    /// Catmull-Clark: fraction bits beyond those of the coordinates
    #[arg(long, value_name = "LIST", help_heading = "Number formats")]
    pub guard: Option<Numbers>,

    /// Fraction bits of the weights of irregular vertices [default: as many as the coordinates need]
    #[arg(long, value_name = "LIST", help_heading = "Number formats")]
    pub table: Option<Numbers>,

    /// How bits are dropped: half-up, half-even, floor, truncate
    #[arg(long, value_name = "MODE,..", value_delimiter = ',', default_value = "half-up")]
    #[arg(help_heading = "Number formats")]
    pub rounding: Vec<Rounding>,

    /// Loop: registers of each coordinate
    #[arg(long, value_name = "COUNT,..", value_enum, value_delimiter = ',', default_value = "20")]
    pub registers: Vec<Registers>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchemeName {
    Loop,
    CatmullClark,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PriceName {
    /// Bits of all registers of the core, counted
    #[default]
    RegisterBits,
    /// Bits of the registers of the difference engines alone, which every further lane needs again
    EngineBits,
    /// Four-input LUTs, estimated (or counted with --synth)
    Luts,
}

impl PriceName {
    pub fn price(self) -> Price {
        match self {
            PriceName::RegisterBits => Price::RegisterBits,
            PriceName::EngineBits => Price::EngineBits,
            PriceName::Luts => Price::Luts,
        }
    }
}

impl Varying {
    /// Reads the meshes.
    ///
    /// # Errors
    /// None is named; those of reading.
    pub fn subjects(&self) -> Result<Vec<Subject>> {
        let files = self.meshes.iter().map(|path| Origin::File(path.display().to_string()));
        let sources: Vec<Origin> = files.chain(self.shape.iter().cloned().map(Origin::Shape)).collect();
        if sources.is_empty() {
            return Err(Error::usage("no mesh to explore").help("give a file, or --shape NAME"));
        }
        sources.iter().map(|source| Subject::load(source, self.triangulate)).collect()
    }

    /// Whether number formats are named; else a search is free to choose them.
    pub fn formats_are_named(&self) -> bool {
        self.exact || self.fraction.is_some() || !self.fractions.is_empty() || self.guard.is_some()
    }

    pub fn axes(&self) -> Axes {
        let mut precisions = vec![];
        if self.exact || !self.formats_are_named() {
            precisions.push(Precision::Exact);
        }
        let values =
            |list: &Option<Numbers>| list.iter().flat_map(|l| l.values().to_vec()).collect::<Vec<_>>();
        precisions.extend(values(&self.fraction).into_iter().map(Precision::Uniform));
        let progressive = self.fractions.iter().flat_map(|fractions| fractions.values());
        precisions.extend(progressive.copied().map(Precision::Progressive));
        precisions.extend(values(&self.guard).into_iter().map(Precision::Guard));
        Axes {
            scheme: self.scheme.map(|name| match name {
                SchemeName::Loop => Scheme::Loop,
                SchemeName::CatmullClark => Scheme::CatmullClark,
            }),
            levels: self.level.clone(),
            coordinates: self.coordinates.clone(),
            precisions,
            tables: self.table.clone(),
            roundings: self.rounding.clone(),
            registers: self.registers.iter().map(|registers| registers.form()).collect(),
        }
    }

    /// The meshes and the points of the sweep.
    ///
    /// # Errors
    /// As [`Varying::subjects`] and [`Axes::sweep`].
    pub fn sweep(&self) -> Result<(Vec<Subject>, Sweep)> {
        let subjects = self.subjects()?;
        let sweep = self.axes().sweep(&subjects)?;
        Ok((subjects, sweep))
    }
}

/// `1lsb`, `0.75`: a positive number of units of the last place.
pub fn target(text: &str) -> Result<f64> {
    let number = text.strip_suffix("lsb").unwrap_or(text).trim().parse::<f64>();
    match number {
        Ok(lsb) if lsb > 0.0 && lsb.is_finite() => Ok(lsb),
        _ => Err(Error::usage(format!("'{text}' is no error"))
            .help("write units of the last place, for example 1lsb or 0.5625")),
    }
}
