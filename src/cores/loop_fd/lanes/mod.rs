//! Lanes: neighbouring strips of a patch at once, from columns that they share.
//!
//! ```text
//!   start-up ─► outer differences ─► heads of the next group: K + 1 columns ─► columns 0 .. K ─► rounders ─► FIFO
//!               (step by step)       (one a step)                              (all at once)
//!
//!   strip i       between columns i and i + 1        lane 0
//!   strip i + 1   between columns i + 1 and i + 2    lane 1       2 K triangles from K + 1 vertices a clock
//! ```
//!
//! Where numbers come in chunks, the outer differences, which step once for each column, are kept as digits in
//! shift registers, with an adder of one digit each; a step takes as many clocks as there are digits, and the columns that
//! run meanwhile do not wait for it. Digit after digit, a head goes from the outer differences to its column, whose
//! chunks take it one clock after the other, as skewed numbers do.
//!
//! One lane does without heads that wait: the columns take them as they come. For large patches alone it also does
//! without differences that wait, see [`Parameters::differences_wait`](super::Parameters).
//!
//! Buffered, one lane has one column that runs, and a memory of the rounded vertices of the column before:
//!
//! ```text
//!   pass 0       p(0,j), j = 0 .. n                                          into the memory, nothing is sent
//!   pass k       p(k-1,j) out of it, p(k,j) sent beside and put in its place, j = 0 .. n - k
//!                p(k-1,n-k+1) out of it, alone                               the last beat of strip k - 1
//! ```
//!
//! A vertex is a numerator over 3 * 2^s, rounded. Half a unit for the rounding is added once, to the first difference of
//! the patch: the basis sums to 1, so that every vertex has it.

mod buffer;
mod columns;
mod control;
mod outer;
mod single;
mod top;

pub use buffer::AHEAD;
pub use single::LATER;
pub use top::HOP;
pub(super) use top::build;
