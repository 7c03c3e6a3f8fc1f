//! Options of the strip core that `generate` and `simulate` share.

use crate::cores::cc_strip::{self, finish};
use clap::ValueEnum;

/// The units of the strip core.
#[derive(Clone, Debug, Default, PartialEq, Eq, clap::Args)]
#[command(next_help_heading = "Units of the strip core")]
pub struct StripUnits {
    /// Who makes the columns of the levels
    #[arg(long, value_enum, default_value_t)]
    pub schedule: Schedule,

    /// Coarse levels share a unit as far as that costs no clock
    #[arg(long)]
    pub fold: bool,

    /// Make a column in slices of this many rows a clock, for small devices: 2, 4, 8, ... [default: whole columns]
    #[arg(long, value_name = "N")]
    pub rows_per_clock: Option<u32>,

    /// A register behind every adder, for a high clock; control runs ahead of the data
    #[arg(long)]
    pub registered: bool,

    /// The N coarsest levels work on x, y and z one after the other, which takes a third of the area
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub axes_in_turn: u32,
}

/// What leaves the strip core.
#[derive(Clone, Debug, Default, PartialEq, Eq, clap::Args)]
#[command(next_help_heading = "Output of the strip core")]
pub struct StripOutput {
    /// Put out points of the limit surface, not refined control points
    #[arg(long)]
    pub limit: bool,

    /// Put out a normal for each vertex
    #[arg(long, value_enum, value_name = "KIND")]
    pub normals: Option<Normals>,

    /// Fraction bits of the points that normals are computed from [default: those of the vertices]
    #[arg(long, value_name = "N", requires = "normals")]
    pub normal_fraction: Option<u32>,

    /// Normals of unit length over 2^N, within 0.75 of their last place, 8 to 16
    #[arg(long, value_name = "N", requires = "normals", value_parser = clap::value_parser!(u32).range(8..=16))]
    pub unit_normals: Option<u32>,

    /// Send vertices row by row along the strip, one in a clock, in chunks of up to 2^N columns
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=12))]
    pub row_major: Option<u32>,
}

/// Which normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Normals {
    /// The sum of the normals of the faces around the vertex
    Faces,
    /// The normal of the limit surface
    Limit,
}

impl StripUnits {
    /// The same core with these units.
    pub fn on(&self, parameters: cc_strip::Parameters) -> cc_strip::Parameters {
        cc_strip::Parameters {
            schedule: self.schedule.into(),
            folded: self.fold,
            rows_per_clock: self.rows_per_clock,
            registered: self.registered,
            axes_in_turn: self.axes_in_turn,
            ..parameters
        }
    }
}

impl StripOutput {
    /// The same core with this output.
    pub fn on(&self, parameters: cc_strip::Parameters) -> cc_strip::Parameters {
        let normals = |kind: Normals| finish::Normals {
            kind: match kind {
                Normals::Faces => finish::Kind::Faces,
                Normals::Limit => finish::Kind::Limit,
            },
            point_fraction: self.normal_fraction.unwrap_or(parameters.output_fraction),
            unit: self.unit_normals,
        };
        cc_strip::Parameters {
            limit: self.limit,
            normals: self.normals.map(normals),
            longitudinal: self.row_major,
            ..parameters
        }
    }
}

/// Who makes the columns, for L levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Schedule {
    /// One unit for all levels: 2^(L+1) - 2 clocks for each column that comes in
    Shared,
    /// A unit for each level: 2^L clocks
    #[default]
    Pipelined,
    /// The finest unit makes two columns at once: 2^(L-1) clocks
    Double,
}

impl From<Schedule> for cc_strip::Schedule {
    fn from(schedule: Schedule) -> Self {
        match schedule {
            Schedule::Shared => cc_strip::Schedule::Shared,
            Schedule::Pipelined => cc_strip::Schedule::Pipelined,
            Schedule::Double => cc_strip::Schedule::Double,
        }
    }
}
