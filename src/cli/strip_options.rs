//! Options of the strip core that `generate` and `simulate` share.

use crate::cores::cc_strip;
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
