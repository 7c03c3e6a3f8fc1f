//! The vertices of the column before the one that runs, of all coordinates.
//!
//! ```text
//!   row j ─► place ─┬─► read ────────► register ─► left    p(k-1,j)
//!                   └─► a clock later: write
//!                                        ▲
//!   rounder ─► made ─────────────────────┴► register ─► right   p(k,j)
//! ```
//!
//! A pass has two rows at least, and a vertex is written a clock after the one before it was read: it is there when the
//! next pass reads it, and no word is read and written at once.

use std::rc::Rc;

use super::super::{AXES, Parameters};
use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

/// Clocks by which a row is announced before its vertex is there.
pub const AHEAD: u32 = 1;

/// The level from which on a column fills block RAMs, not lookup tables.
const BLOCK_LEVEL: u32 = 5;

/// Inputs: `row` (one comes, the last of its pass where `ends`), and [`AHEAD`] later `made_x` ... , the vertex of the column
/// that runs. Outputs: `left_x` ... , the vertex of the column before, and `right_x` ... , the one that was made.
pub fn build(parameters: Parameters, vertex: Word) -> Result<Rc<Module>> {
    let m = Builder::new("column_buffer");
    m.purpose("The column before the one that runs: for each row a vertex of it out, and one of the next column in.");
    let [row, ends] = ["row", "ends"].map(|name| m.input(name, Word::bit()));

    let rows = 1u32 << parameters.max_level;
    let word = Word::range(0, rows.into());
    let place = m.register_reset("place", word, 0);
    m.on(&row, &place, m.select(&ends, m.constant(0, word), m.wrap(&place + 1, word)));
    // Behind the last vertex of a column nothing that is written is read again.
    let (writes, written) = (m.pipe_reset("writes", &row, 0), m.pipe("written", &place));

    let (mut left, mut right) = (vec![], vec![]);
    for axis in AXES {
        let made = m.input_at(format!("made_{axis}"), vertex, AHEAD);
        let ram = m.memory(&format!("ram_{axis}"), rows + 1, vertex, vec![]).apart();
        let ram = if parameters.max_level < BLOCK_LEVEL { ram } else { ram.block() };
        ram.write(&writes, &written, &made);
        left.push(m.pipe(format!("left_{axis}"), ram.read(&format!("read_{axis}"), &place, None)));
        right.push(m.pipe(format!("right_{axis}"), &made));
    }
    for (side, vertices) in [("left", left), ("right", right)] {
        AXES.iter().zip(vertices).for_each(|(axis, vertex)| m.output(format!("{side}_{axis}"), &vertex));
    }
    m.finish()
}
