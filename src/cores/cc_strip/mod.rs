//! `cc-strip`: Catmull-Clark subdivision of quad strips by a sliding window (Hall, chapters 4 to 6).
//!
//! ```text
//! s_axis ──► loader ──► level 0 ──► level 1 ──► ... ──► level L-1 ──► rounding ──► m_axis
//! a word     a column   window of 3 columns; a vertex column and a face column     a column, or
//! a clock               for every column that comes in                             a slice of it
//! ```
//!
//! A strip of M quads is the sequence of its columns -1 .. M + 1: columns 0 .. M bound the quads, the
//! other two are guards. Every level turns columns into twice as many, with twice as many rows less one.
//! Which levels share a unit, and how many rows it makes in a clock, is a matter of the [`schedule`]. A strip
//! says how often it is subdivided; its columns leave from that level.
//!
//! **In**: a vertex per beat, x, y and z in lanes. `tuser` says what it is (see [`Role`] and the loader),
//! `tlast` ends the strip. A column is its top vertex, what lies outside of it, its bottom vertex, what lies
//! outside.
//! **Out**: columns 0 .. 2^l M of the fine strip, top to bottom; `tkeep` says which rows are there, `tlast` ends
//! the strip.
//!
//! **Numbers**: exact, 6 fraction bits more on every level; or `guard` fraction bits on every level and
//! one rounding for every vertex, taken from unrounded sums. No rule divides by three.

pub mod buffer;
pub mod buffered;
mod columns;
pub mod control;
mod engine;
mod fan;
mod fan_registered;
pub mod finish;
pub mod finish_proof;
mod finishing;
mod limit;
mod loader;
pub mod longitudinal;
mod normals;
mod output;
mod parameters;
mod places;
pub mod proof;
mod registered;
mod ring_walk;
mod row_filter;
mod row_reader;
pub mod schedule;
pub mod sending;
mod tangents;
mod top;
mod turns;
mod unit;
mod vectors;
pub mod view;
pub mod view_ports;
mod wait;
mod walked;
mod walked_control;
mod walked_proof;
mod window;
mod word_stage;

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Cell, Flat, Module};

pub use parameters::{Parameters, Precision};
pub use schedule::Schedule;

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

/// `tuser` of the input: role (2 bits), valence (5 bits), last word of its column, level (3 bits, on the first
/// word of a strip).
pub const USER_BITS: u32 = 11;

/// The number of bits in which a valence travels.
pub const VALENCE_BITS: u32 = 5;

/// The number of bits in which a level travels.
pub const LEVEL_BITS: u32 = 3;

/// The complete core.
///
/// # Errors
/// Those of [`Parameters::check`].
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    top::build(parameters.check()?)
}

/// Vertices that the core stores, counted from its registers and memories: words of a coordinate's width or more,
/// three for a vertex. Control has no register as wide as a coordinate of 9 bits or more.
///
/// # Errors
/// A design with a combinational loop.
pub fn stored_vertices(core: &Rc<Module>, parameters: Parameters) -> Result<u64> {
    let flat = Flat::new(core)?;
    let wide = |width: u32| width >= parameters.coordinates.width().min(parameters.output_word().width());
    let registers = flat.clocked.iter().filter(|&&id| {
        matches!(flat.node(id).cell, Cell::Register { .. }) && wide(flat.node(id).word.width())
    });
    let memories =
        flat.memories.iter().filter(|m| wide(m.word.width())).map(|m| u64::from(m.depth)).sum::<u64>();
    Ok((registers.count() as u64 + memories) / 3)
}
