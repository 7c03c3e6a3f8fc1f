//! `cc-strip`: Catmull-Clark subdivision of quad strips by a sliding window (Hall, chapters 4 to 6).
//!
//! ```text
//! s_axis ──► loader ──► level 0 ──► level 1 ──► ... ──► level L-1 ──► rounding ──► m_axis
//! a word     a column   window of 3 columns; a vertex column and a face column     a column
//! a clock               for every column that comes in                             a clock
//! ```
//!
//! A strip of M quads is the sequence of its columns -1 .. M + 1: columns 0 .. M bound the quads, the
//! other two are guards. Every level turns columns into twice as many, with twice as many rows less one,
//! and the finest level sends a column per clock: 2^L clocks for each column that comes in.
//!
//! **In**: a vertex per beat, x, y and z in lanes. `tuser` says what it is (see [`Role`]), `tlast` ends the
//! strip. A column is its top vertex, what lies outside of it, its bottom vertex, what lies outside.
//! **Out**: columns 0 .. 2^L M of the fine strip, top to bottom, a column a beat; `tlast` ends the strip.
//!
//! **Numbers**: exact, 6 fraction bits more on every level; or `guard` fraction bits on every level and
//! one rounding for every vertex, taken from unrounded sums. No rule divides by three.

mod columns;
mod control;
mod level;
mod loader;
pub mod longitudinal;
mod outside;
pub mod proof;
mod top;
pub mod view;

use std::rc::Rc;

use crate::error::{Error, Result};
use crate::fixed::{Format, Range};
use crate::hdl::{Module, Word};

/// How the intermediate columns are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 6 fraction bits more on every level: nothing is lost on regular vertices.
    Exact,
    /// This many fraction bits more than the coordinates on every level, rounded half up.
    Guard(u32),
}

/// What a word of the input stream is; the low bits of `tuser`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A vertex of the strip; its valence stands beside it.
    Vertex = 0,
    /// An entry of the fan of the vertex before: a_1, x_2, a_2, ...
    Fan = 1,
    /// The outside vertex of the face column on its left, where the fan does not say (valence 3, guards).
    OutsideLeft = 2,
    /// The same on its right.
    OutsideRight = 3,
}

/// `tuser` of the input: role (2 bits), valence (5 bits), last word of its column, in the first column.
pub const USER_BITS: u32 = 9;

/// The number of bits in which a valence travels.
pub const VALENCE_BITS: u32 = 5;

/// What a `cc-strip` is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    pub coordinates: Format,
    pub output_fraction: u32,
    /// L: how often the strip is subdivided.
    pub levels: u32,
    /// The largest valence of a control vertex.
    pub max_valence: u32,
    pub precision: Precision,
    /// Fraction bits of the table kappa_d = 1 / (4 d^2).
    pub table_bits: u32,
}

impl Parameters {
    /// # Errors
    /// Numbers that no core has; the message names the option that mends it.
    pub fn check(self) -> Result<Self> {
        if !(1..=7).contains(&self.levels) {
            return Err(Error::usage(format!("{} levels", self.levels)).help("choose --max-level 1 to 7"));
        }
        if !(4..=16).contains(&self.max_valence) {
            return Err(Error::usage(format!("a maximum valence of {}", self.max_valence))
                .help("choose --max-valence 4 to 16"));
        }
        if !(8..=52).contains(&self.table_bits) {
            return Err(
                Error::usage(format!("a table of {} bits", self.table_bits)).help("choose --table 8 to 52")
            );
        }
        let widest = self.word(self.levels).width() + 6 + self.table_bits + 12;
        if widest > Range::WIDEST {
            return Err(Error::usage(format!("products of {widest} bits"))
                .help("choose guard bits (--guard 4), a narrower table or fewer levels"));
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

    /// Fraction bits of a replaced vertex beyond those of the sums over 64.
    fn replacement_bits(self) -> u32 {
        self.table_bits - 6
    }

    /// A vertex as it comes in.
    fn input_word(self) -> Word {
        Word::signed(self.coordinates.width()).fraction(self.coordinates.fraction as i32)
    }

    /// A vertex of a level: the convex hull of the control points never grows.
    pub fn word(self, level: u32) -> Word {
        let extra = self.extra_fraction(level);
        let hull = Range::signed(self.coordinates.width()) * (1i128 << extra);
        Word::from(hull).fraction((self.coordinates.fraction + extra) as i32)
    }

    /// Strip vertices of a column of a level.
    pub fn rows(self, level: u32) -> usize {
        1 + (1 << level)
    }

    /// Edge neighbours outside of the strip: a_1 .. a_{d-3}.
    pub fn outside_neighbours(self) -> usize {
        (self.max_valence - 3) as usize
    }

    /// Bits of a vertex that leaves.
    pub fn output_width(self) -> u32 {
        self.coordinates.integer + self.output_fraction
    }
}

/// The complete core.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    top::build(parameters.check()?)
}
