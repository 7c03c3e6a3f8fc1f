//! Faults put into a design on purpose, one cell at a time: who checks the checkers.
//!
//! ```text
//! carry     a sum loses the carry into bit k          operand   a sign flipped, branches exchanged
//! shift     one place too far, or not far enough      enable    always, or never
//! gate      and for or, an inverter left out          reset     to the wrong value
//! stuck     a bit that is always 0, or always 1
//! ```
//!
//! A fault is put into the [flat](super::Flat) design and leaves everything else as it is, so the broken
//! design runs wherever the sound one does: a check that does not fail there has seen nothing. Faults that
//! cannot change anything by the shape of the design alone are not listed: those in cells that no output
//! depends on, and dropped carries where no carry can arise.

mod carry;
mod list;

use std::fmt;
use std::panic::Location;

use super::Word;
use super::cell::{Bitwise, Cell, NodeId, Relation};
use super::flat::{Flat, FlatNode};
use crate::error::Result;

pub use list::all;

/// The families of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Carry,
    Shift,
    Operand,
    Enable,
    Gate,
    Reset,
    Stuck,
}

/// What happens to the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// The carry into this bit is lost.
    Carry(u32),
    /// A term of a sum is shifted to the left by this amount instead of its own.
    TermShift(usize, u32),
    /// A shift right, or the low end of a slice, is this amount instead of its own.
    ShiftRight(u32),
    /// A term of a sum is subtracted instead of added, or the other way round.
    TermSign(usize),
    /// The choices of a selection, or the sides of a comparison, change places.
    Exchange,
    /// A part of a concatenation and the next one change places.
    Parts(usize),
    Enable(bool),
    Gate,
    Reset(i128),
    Stuck(bool),
}

/// Where it happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Node(NodeId),
    /// The write port of a memory.
    Write(usize),
}

/// One fault of one cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    target: Target,
    change: Change,
    signal: String,
    place: &'static Location<'static>,
}

impl Fault {
    pub fn kind(&self) -> Kind {
        match self.change {
            Change::Carry(_) => Kind::Carry,
            Change::TermShift(..) | Change::ShiftRight(_) => Kind::Shift,
            Change::TermSign(_) | Change::Exchange | Change::Parts(_) => Kind::Operand,
            Change::Enable(_) => Kind::Enable,
            Change::Gate => Kind::Gate,
            Change::Reset(_) => Kind::Reset,
            Change::Stuck(_) => Kind::Stuck,
        }
    }

    /// The signal of the cell, with the instances on the way to it.
    pub fn signal(&self) -> &str {
        &self.signal
    }

    /// The Rust line that built the cell.
    pub fn place(&self) -> &'static Location<'static> {
        self.place
    }

    /// The sum that loses a carry, and the bit that it would go into.
    pub fn dropped_carry(&self) -> Option<(NodeId, u32)> {
        match (self.target, self.change) {
            (Target::Node(id), Change::Carry(bit)) => Some((id, bit)),
            _ => None,
        }
    }

    /// The design with this fault in it.
    ///
    /// # Errors
    /// A fault that closes a combinational loop.
    pub fn apply(&self, flat: &Flat) -> Result<Flat> {
        let mut broken = flat.clone();
        match self.target {
            Target::Write(memory) => {
                if let Change::Enable(always) = self.change
                    && let Some(write) = &flat.memories[memory].write
                {
                    let enable = bit(&mut broken, always, write.data);
                    if let Some(write) = &mut broken.memories[memory].write {
                        write.enable = enable;
                    }
                }
            }
            Target::Node(id) => {
                let cell = self.cell(&mut broken, id);
                broken.nodes[id.index()].node.cell = cell;
            }
        }
        broken.sort()?;
        Ok(broken)
    }

    /// The cell in place of the sound one; what it needs beside it is appended.
    fn cell(&self, flat: &mut Flat, id: NodeId) -> Cell {
        let mut cell = flat.node(id).cell.clone();
        match (&mut cell, self.change) {
            (_, Change::Carry(at)) => return carry::dropped(flat, id, at),
            (_, Change::Stuck(value)) => return Cell::Constant(value.into()),
            (Cell::Sum { terms, .. }, Change::TermShift(term, shift)) => terms[term].shift = shift,
            (Cell::Sum { terms, .. }, Change::TermSign(term)) => terms[term].negate ^= true,
            (Cell::ShiftRight { of, .. }, Change::ShiftRight(amount)) => {
                // One place less leaves a bit more than the word has.
                let word = flat.node(*of).word;
                let shifted = Word::from(word.range.shift_right(amount)).fraction(word.fraction);
                let shift = Cell::ShiftRight { of: *of, amount, exact: false };
                return Cell::Wrap { of: append(flat, shift, shifted, id) };
            }
            (Cell::Slice { low, .. }, Change::ShiftRight(other)) => *low = other,
            (Cell::Select { on_true, on_false, .. }, Change::Exchange) => std::mem::swap(on_true, on_false),
            (Cell::Compare { left, right, .. }, Change::Exchange) => std::mem::swap(left, right),
            (Cell::Concat { parts }, Change::Parts(first)) => parts.swap(first, first + 1),
            (Cell::Register { enable, .. } | Cell::MemoryRead { enable, .. }, Change::Enable(always)) => {
                *enable = if always { None } else { Some(bit(flat, false, id)) };
            }
            (Cell::Logic { operation, .. }, Change::Gate) => {
                *operation = match operation {
                    Bitwise::And => Bitwise::Or,
                    Bitwise::Or | Bitwise::Xor => Bitwise::And,
                }
            }
            (Cell::Compare { relation, .. }, Change::Gate) => {
                *relation = match relation {
                    Relation::Equal => Relation::NotEqual,
                    Relation::NotEqual => Relation::Equal,
                    Relation::Less => Relation::LessOrEqual,
                    Relation::LessOrEqual => Relation::Less,
                }
            }
            (Cell::Not { of }, Change::Gate) => return Cell::Wrap { of: *of },
            (Cell::Register { reset, .. }, Change::Reset(value)) => *reset = Some(value),
            // The list makes no other pairs.
            _ => {}
        }
        cell
    }
}

/// A new node, of the time and the source line of another one.
fn append(flat: &mut Flat, cell: Cell, word: Word, like: NodeId) -> NodeId {
    let mut node = flat.node(like).clone();
    (node.cell, node.word, node.name) = (cell, word, None);
    flat.nodes.push(FlatNode { node, path: None });
    NodeId(flat.nodes.len() as u32 - 1)
}

fn bit(flat: &mut Flat, value: bool, like: NodeId) -> NodeId {
    append(flat, Cell::Constant(value.into()), Word::bit(), like)
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.signal)?;
        match self.change {
            Change::Carry(bit) => write!(f, "the carry into bit {bit} is dropped"),
            Change::TermShift(term, shift) => write!(f, "term {term} is shifted left by {shift}"),
            Change::ShiftRight(amount) => write!(f, "shifted right by {amount}"),
            Change::TermSign(term) => write!(f, "the sign of term {term} is flipped"),
            Change::Exchange => write!(f, "its two operands are exchanged"),
            Change::Parts(first) => write!(f, "parts {first} and {} are exchanged", first + 1),
            Change::Enable(true) => write!(f, "always enabled"),
            Change::Enable(false) => write!(f, "never enabled"),
            Change::Gate => write!(f, "another gate"),
            Change::Reset(value) => write!(f, "reset to {value}"),
            Change::Stuck(value) => write!(f, "stuck at {}", u8::from(value)),
        }?;
        write!(f, " ({}:{})", self.place.file(), self.place.line())
    }
}
