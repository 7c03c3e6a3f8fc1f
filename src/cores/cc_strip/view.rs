//! What the units see of a window: one coordinate of the columns c-1, c, c+1, and of what lies outside.
//!
//! ```text
//!            a_1   x_2   a_2
//!      before   \   |   /   after        before = uR(c-1), after = uL(c+1): the outside vertices that the
//!              \ \  |  / /               faces over the strip edges use
//!    outer[0] ── outer[1] ── outer[2]    an end of the columns: the first or the last row of the strip
//!        │          │           │
//!    inner[0] ── inner[1] ── inner[2]    the rows next to it
//! ```

use crate::hdl::Signal;

/// The window of one coordinate.
#[derive(Clone)]
pub struct View {
    /// Rows from top to bottom of the columns c-1, c, c+1.
    pub rows: [Vec<Signal>; 3],
    /// 1 for the row that is the last one of the strip at the level in use.
    pub is_bottom: Vec<Signal>,
    /// Top and bottom.
    pub ends: [EndView; 2],
}

/// An end vertex of the middle column with everything around it.
#[derive(Clone)]
pub struct EndView {
    /// The end vertices of the columns c-1, c, c+1.
    pub outer: [Signal; 3],
    /// Their neighbours within the columns.
    pub inner: [Signal; 3],
    pub before: Signal,
    pub after: Signal,
    /// a_1 .. a_{D-3} for the largest valence D; of valence d only the first d - 3 are meant.
    pub neighbours: Vec<Signal>,
    /// x_2 .. x_{D-3}: `diagonals[i]` is x_{i+2}.
    pub diagonals: Vec<Signal>,
    /// d, in `VALENCE_BITS` bits.
    pub valence: Signal,
}
