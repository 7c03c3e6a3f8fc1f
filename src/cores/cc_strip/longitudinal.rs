//! Row-major output: whole columns in, the vertices of their rows out, one a clock (Hall, section 4.6).
//!
//! ```text
//! columns ──► one row a clock ──► RAM, half 0 and half 1 ──► row 0 from left to right, row 1, ... ──► vertices
//!                                 a chunk of N columns each
//! ```
//!
//! The window makes strips across the input strip. Strips along it are longer, and their vertices come out of
//! this buffer: it gathers up to N columns, then sends them row by row while it gathers the next ones. Chunks of
//! one strip share the column between them, so that the quad strips between two rows join.
//!
//! **Order**, for a chunk of columns c_0 .. c_n: row 0 of c_0, of c_1, ... of c_n, row 1 of c_0, and so on to the
//! last row. A strip of C columns has the chunks 0 .. N-1, N-1 .. 2(N-1), ... up to column C-1.
//!
//! **RAM**: a word is one vertex, not a column. Only one vertex leaves a clock, so one a clock is all that need come
//! in: the column waits at the input while it is written row by row. Words of a whole column, or a bank for each
//! row, would fill in one clock what takes as many clocks to leave as the column has rows; and they would need wide
//! memories with few words, which block RAMs are not. Here each coordinate has one memory of 2 N R words, R rows.
//!
//! While columns come and vertices go without stalls, a vertex leaves in every clock.

use std::rc::Rc;

use crate::cores::loop_fd::AXES;
use crate::error::{Error, Result};
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// A buffer for chunks of 2^`log_columns` columns, of up to 1 + 2^`levels` rows of `vertex`.
///
/// | port | |
/// |---|---|
/// | `column_valid`, `column_ready` | a column moves where both are 1; it stays the same until then |
/// | `column_last` | it is the last one of its strip |
/// | `last_row` | the rows in use are 0 to this; the same in all columns of a strip |
/// | `row_{k}_{axis}` | the vertices of the column |
/// | `valid`, `ready` | a vertex moves where both are 1; it stays the same until then |
/// | `x`, `y`, `z` | the vertex |
/// | `row_end`, `chunk_end`, `strip_end` | it is the last one of its row in the chunk, of its chunk, of its strip |
///
/// # Errors
/// Chunks of one column, which no quad fits in, or of more than 4096.
pub fn build(log_columns: u32, levels: u32, vertex: Word) -> Result<Rc<Module>> {
    if !(1..=12).contains(&log_columns) {
        return Err(Error::usage(format!("chunks of 2^{log_columns} columns"))
            .help("choose a power of two from 2 to 4096"));
    }
    let rows = 1 + (1usize << levels);
    let longest = 1i128 << log_columns;
    let m = Builder::new("longitudinal");
    m.purpose("Gathers columns and sends their vertices row by row: strips along the input strip.");
    m.parameter("columns", longest);
    m.parameter("rows", rows);

    let [column_valid, column_last, ready] =
        ["column_valid", "column_last", "ready"].map(|name| m.input(name, Word::bit()));
    let row_word = Word::range(0, rows as i128 - 1);
    let last_row = m.input("last_row", row_word);
    let lanes: Vec<[Signal; 3]> =
        (0..rows).map(|k| AXES.map(|axis| m.input(format!("row_{k}_{axis}"), vertex))).collect();
    let column_word = Word::unsigned(log_columns);

    // A half is full from the clock after its last vertex was written until its last one is read.
    let full = [0, 1].map(|half| m.register_reset(format!("full_{half}"), Word::bit(), 0));
    let filled = |half: &Signal| m.select(half, &full[1], &full[0]);

    // Writing: the row `write_row` of the column at the input goes to the column `write_column` of a half.
    let write = Place::new(&m, "write", row_word, column_word);
    let room = m.wire("room", !filled(&write.half));
    let writes = m.wire("writes", &column_valid & &room);
    let column_ends = m.wire("column_ends", m.compare(Relation::Equal, &write.row, &last_row));
    let longest_chunk = m.wire("longest_chunk", m.is(&write.column, longest - 1));
    let chunk_ends = m.wire("chunk_ends", &longest_chunk | &column_last);
    let written = m.wire("written", &writes & &column_ends);
    let closed = m.wire("closed", &written & &chunk_ends);
    // The column between two chunks stays at the input: it is the first one of the next chunk, too.
    let shared = m.wire("shared", &longest_chunk & !&column_last);
    m.output("column_ready", m.wire("column_ready", m.all(&[&room, &column_ends, &!&shared])));
    write.step(&m, &writes, &written, &closed, Order::Columns);
    let closes = write.of_halves(&m, "closes", &closed);

    // Reading, a row after the other, until the half's last column and row.
    let read = Place::new(&m, "read", row_word, column_word);
    let valid = m.register_reset("valid", Word::bit(), 0);
    let take = m.wire("take", filled(&read.half) & (!&valid | &ready));
    let of_half = |name: &str, word: Word, value: &Signal| {
        let kept = [0, 1].map(|half| {
            let kept = m.register(format!("{name}_{half}"), word);
            m.on(&closes[half], &kept, value);
            kept
        });
        m.wire(name, m.select(&read.half, &kept[1], &kept[0]))
    };
    let last_column = of_half("last_column", column_word, &write.column);
    let bottom_row = of_half("bottom_row", row_word, &last_row);
    let ends_strip = of_half("ends_strip", Word::bit(), &column_last);
    let equal = |a: &Signal, b: &Signal| m.compare(Relation::Equal, a, b);
    let row_done = m.wire("row_done", equal(&read.column, &last_column));
    let chunk_done = m.wire("chunk_done", &row_done & equal(&read.row, &bottom_row));
    let sent = m.wire("sent", &take & &chunk_done);
    read.step(&m, &take, &m.wire("row_sent", &take & &row_done), &sent, Order::Rows);

    for ((register, closes), empties) in full.iter().zip(&closes).zip(&read.of_halves(&m, "empties", &sent)) {
        m.on(closes, register, m.bit(true));
        m.on(empties, register, m.bit(false));
    }
    m.on(&take, &valid, m.bit(true));
    m.on(&ready, &valid, m.bit(false));
    m.output("valid", &valid);
    for (axis, name) in AXES.iter().enumerate() {
        let depth = 2 * rows as u32 * (1 << log_columns);
        let ram = m.memory(&format!("ram_{name}"), depth, vertex, vec![]);
        let choices: Vec<Signal> = lanes.iter().map(|lane| lane[axis].clone()).collect();
        let chosen = m.wire(format!("written_{name}"), choice(&m, &write.row, &choices));
        ram.write(&writes, &write.address(&m, depth), &m.wrap(&chosen, vertex));
        m.output(
            *name,
            m.restart(&ram.read(&format!("read_{name}"), &read.address(&m, depth), Some(&take)), 0),
        );
    }
    for (name, end) in [("row_end", &row_done), ("chunk_end", &chunk_done)] {
        let register = m.register(name, Word::bit());
        m.on(&take, &register, end);
        m.output(name, &register);
    }
    let strip_end = m.register("strip_end", Word::bit());
    m.on(&take, &strip_end, &chunk_done & &ends_strip);
    m.output("strip_end", &strip_end);
    m.finish()
}

/// What a place runs through first.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    Columns,
    Rows,
}

/// A vertex in the RAM.
struct Place {
    half: Signal,
    row: Signal,
    column: Signal,
}

impl Place {
    fn new(m: &Builder, name: &str, row: Word, column: Word) -> Place {
        Place {
            half: m.register_reset(format!("{name}_half"), Word::bit(), 0),
            row: m.register_reset(format!("{name}_row"), row, 0),
            column: m.register_reset(format!("{name}_column"), column, 0),
        }
    }

    /// At an edge where `step` is 1: on within a column (or row); at its end (`turn`) to the next one; at the end of
    /// the chunk (`close`) to the other half.
    fn step(&self, m: &Builder, step: &Signal, turn: &Signal, close: &Signal, order: Order) {
        let (fast, slow) = match order {
            Order::Columns => (&self.row, &self.column),
            Order::Rows => (&self.column, &self.row),
        };
        let zero = |register: &Signal| m.constant(0, register.word());
        m.on(close, slow, zero(slow));
        m.on(turn, slow, m.wrap(slow + 1, slow.word()));
        m.on(turn, fast, zero(fast));
        m.on(step, fast, m.wrap(fast + 1, fast.word()));
        m.on(close, &self.half, !&self.half);
    }

    /// The event in one half, and in the other.
    fn of_halves(&self, m: &Builder, name: &str, event: &Signal) -> [Signal; 2] {
        [(0, !&self.half), (1, self.half.clone())]
            .map(|(half, here)| m.wire(format!("{name}_{half}"), event & here))
    }

    /// row * 2N + half * N + column: the words of the RAM without gaps.
    fn address(&self, m: &Builder, depth: u32) -> Signal {
        m.wrap(m.concat(&[&self.row, &self.half, &self.column]), Word::range(0, i128::from(depth) - 1))
    }
}

/// `choices[index]`, in as many levels as the index has bits.
fn choice(m: &Builder, index: &Signal, choices: &[Signal]) -> Signal {
    let mut level = choices.to_vec();
    for bit in 0..index.width() {
        let bit = m.slice(index, bit, 1);
        level = level
            .chunks(2)
            .map(|pair| match pair {
                [even, odd] => m.select(&bit, odd, even),
                // Beyond the last choice nothing is asked for.
                _ => pair[0].clone(),
            })
            .collect();
    }
    level.swap_remove(0)
}
