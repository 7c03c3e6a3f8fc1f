//! What a `cc-strip` is generated for, and the words and sizes that follow from it.

use super::finish::{self, Normals};
use super::schedule::{Group, Schedule, groups};
use crate::error::{Error, Result};
use crate::fixed::{Format, Range, Rounding};
use crate::hdl::Word;

/// How the intermediate columns are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 6 fraction bits more on every level: nothing is lost on regular vertices.
    Exact,
    /// This many fraction bits more than the coordinates on every level, rounded.
    Guard(u32),
}

/// What a `cc-strip` is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    pub coordinates: Format,
    pub output_fraction: u32,
    /// L: the most that a strip can be subdivided at run time, 1 to 7.
    pub levels: u32,
    /// The largest valence of a control vertex.
    pub max_valence: u32,
    pub precision: Precision,
    /// How new vertices lose their last bits; what leaves is rounded half up.
    pub rounding: Rounding,
    /// Fraction bits of the table kappa_d = 1 / (4 d^2).
    pub table_bits: u32,
    pub schedule: Schedule,
    /// Coarse levels share a unit as far as that costs no clock.
    pub folded: bool,
    /// New rows of the finest column in one clock, a power of two from 2 on; all of them without.
    pub rows_per_clock: Option<u32>,
    /// A register behind every adder, for a high clock: control runs ahead of the data.
    pub registered: bool,
    /// The coarsest levels, so many, work on x, y and z one after the other, with a unit for all three.
    pub axes_in_turn: u32,
    /// Limit positions leave, not refined control points.
    pub limit: bool,
    /// Normals that leave beside the positions.
    pub normals: Option<Normals>,
    /// Row-major output, in chunks of up to 2^this columns; columns without.
    pub longitudinal: Option<u32>,
}

impl Parameters {
    /// Exact numbers, whole columns, one unit a level: what is not said otherwise.
    pub fn exact(coordinates: Format, levels: u32, max_valence: u32) -> Self {
        Parameters {
            coordinates,
            output_fraction: coordinates.fraction,
            levels,
            max_valence,
            precision: Precision::Exact,
            rounding: Rounding::HalfUp,
            table_bits: coordinates.width() + 13,
            schedule: Schedule::Pipelined,
            folded: false,
            rows_per_clock: None,
            registered: false,
            axes_in_turn: 0,
            limit: false,
            normals: None,
            longitudinal: None,
        }
    }

    /// # Errors
    /// Numbers that no core has; the message names the option that mends it.
    pub fn check(self) -> Result<Self> {
        let refuse = |what: String, help: &str| Err(Error::usage(what).help(help));
        if !(1..=7).contains(&self.levels) {
            return refuse(format!("{} levels", self.levels), "choose --max-level 1 to 7");
        }
        if !(4..=16).contains(&self.max_valence) {
            let what = format!("a maximum valence of {}", self.max_valence);
            return refuse(what, "choose --max-valence 4 to 16");
        }
        if !(8..=52).contains(&self.table_bits) {
            return refuse(format!("a table of {} bits", self.table_bits), "choose --table 8 to 52");
        }
        if self.rounding == Rounding::Exact {
            return refuse("rounding that loses nothing".into(), "choose half-up, half-even or floor");
        }
        if let Some(rows) = self.rows_per_clock {
            if !rows.is_power_of_two() || !(2..=1 << self.levels).contains(&rows) {
                let help = format!("choose --rows-per-clock 2, 4, 8, .. {}", 1u32 << self.levels);
                return refuse(format!("{rows} rows in a clock"), &help);
            }
            if self.schedule == Schedule::Double {
                return refuse(
                    "part of a column in a clock, and two columns in a clock".into(),
                    "leave out --rows-per-clock, or choose another --schedule",
                );
            }
        }
        let whole = self.rows_per_clock.is_none() && self.schedule != Schedule::Double;
        for (asked, what) in [
            (self.limit, "limit positions"),
            (self.normals.is_some(), "normals"),
            (self.longitudinal.is_some(), "row-major output"),
        ] {
            if asked && !whole {
                return refuse(
                    format!("{what} of slices of a column, or of two columns in a clock"),
                    "leave out --rows-per-clock, and choose --schedule pipelined or shared",
                );
            }
        }
        let finishes = self.limit || self.normals.is_some() || self.longitudinal.is_some();
        if self.registered && (finishes || self.folded || self.schedule != Schedule::Pipelined) {
            return refuse(
                "registered adders in a core that folds levels or finishes columns".into(),
                "leave out --registered, or choose --schedule pipelined alone",
            );
        }
        if self.axes_in_turn > 0 && !self.walked() {
            return refuse(
                "coordinates in turn in a core that has all of them at once".into(),
                "choose --registered and --rows-per-clock too, or leave out --axes-in-turn",
            );
        }
        if self.axes_in_turn >= self.levels {
            let help = format!("choose --axes-in-turn 0 to {}", self.levels - 1);
            return refuse(format!("coordinates in turn at {} levels", self.axes_in_turn), &help);
        }
        if self.walked() && !matches!(self.rounding, Rounding::Floor | Rounding::HalfUp) {
            return refuse(
                format!("slices of registered adders rounded {}", self.rounding),
                "choose --rounding half-up or floor, or leave out --registered or --rows-per-clock",
            );
        }
        if self.normals.is_some() && self.longitudinal.is_some() {
            return refuse(
                "normals in row-major output".into(),
                "leave out one of --normals and --row-major",
            );
        }
        if let Some(finish) = self.finish() {
            finish.check()?;
        }
        // The weights of a ring of 16 add up to 224 and more, and one bit is for a rounded limit.
        let widest = self.word(self.levels).width() + self.table_bits + 9;
        if widest > Range::WIDEST {
            let help = "choose guard bits (--guard 4), a narrower table or fewer levels";
            return refuse(format!("products of {widest} bits"), help);
        }
        Ok(self)
    }

    /// Fraction bits of the columns of a level beyond those of the coordinates.
    pub fn extra_fraction(self, level: u32) -> u32 {
        match self.precision {
            Precision::Exact => 6 * level,
            Precision::Guard(bits) => bits,
        }
    }

    /// Bits that a sum over 64 of vertices of one level loses to become a vertex of the next.
    pub(super) fn drop(self) -> u32 {
        match self.precision {
            Precision::Exact => 0,
            Precision::Guard(_) => 6,
        }
    }

    /// Fraction bits of a replaced vertex beyond those of the sums over 64.
    pub(super) fn replacement_bits(self) -> u32 {
        self.table_bits - 6
    }

    /// A vertex as it comes in.
    pub fn input_word(self) -> Word {
        Word::signed(self.coordinates.width()).fraction(self.coordinates.fraction as i32)
    }

    /// A vertex of a level: the convex hull of the control points never grows.
    pub fn word(self, level: u32) -> Word {
        let extra = self.extra_fraction(level);
        let hull = Range::signed(self.coordinates.width()) * (1i128 << extra);
        Word::from(hull).fraction((self.coordinates.fraction + extra) as i32)
    }

    /// The sum of two vertices of a level.
    pub(super) fn sum_word(self, level: u32) -> Word {
        let word = self.word(level);
        Word { range: word.range + word.range, ..word }
    }

    /// A vertex as it leaves: the largest one rounds up where the output has fewer fraction bits.
    pub fn output_word(self) -> Word {
        let more = u32::from(self.output_fraction < self.coordinates.fraction);
        let width = self.coordinates.integer + self.output_fraction + more;
        Word::signed(width).fraction(self.output_fraction as i32)
    }

    /// Strip vertices of a column of a level.
    pub fn rows(self, level: u32) -> usize {
        1 + (1 << level)
    }

    /// Edge neighbours outside of the strip: a_1 .. a_{d-3}.
    pub fn outside_neighbours(self) -> usize {
        (self.max_valence - 3) as usize
    }

    /// The ends of columns are walked around, a neighbour a clock: in slices, a column takes its time.
    pub fn walked(self) -> bool {
        self.registered && self.rows_per_clock.is_some()
    }

    /// Whether a level works on one coordinate after the other.
    pub fn in_turn(self, level: u32) -> bool {
        level < self.axes_in_turn
    }

    /// Whether the inner rows of a level are in RAMs, read in their order (see [`super::row_reader`]): where the slices
    /// are cells, and so many that a choice among them would be slow.
    pub fn reads_rows(self, level: u32) -> bool {
        self.walked() && !self.in_turn(level) && self.rows_per_clock == Some(2) && level >= 3
    }

    /// The finishing stage; none where refined positions leave alone.
    pub fn finish(self) -> Option<finish::Parameters> {
        (self.limit || self.normals.is_some()).then(|| finish::Parameters {
            word: self.word(self.levels),
            output: self.output_word(),
            rounding: Rounding::HalfUp,
            levels: [1, self.levels],
            max_valence: self.max_valence,
            limit: self.limit.then_some(self.table_bits),
            normals: self.normals,
        })
    }

    /// Which unit makes the columns of which levels.
    pub fn groups(self) -> Vec<Group> {
        let groups = groups(self.schedule, self.folded, self.levels, self.rows_per_clock);
        groups
            .into_iter()
            .map(|group| Group { walked: self.walked(), in_turn: self.in_turn(group.finest()), ..group })
            .collect()
    }
}
