//! Where the operands of a sum meet.
//!
//! ```text
//!   a  a a a a a a a          a + 4 b: two operands meet in the bits from the second on;
//!      b b b b b b            below there is only wiring
//! ```

use super::function::Function;
use super::gates::Gates;
use super::kept::Kept;
use crate::hdl::{Cell, Flat, NodeId, Term};

/// The carry chain of a sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Adder {
    pub operands: u32,
    /// The lowest bit in which two operands meet.
    pub start: u32,
    /// How many bits from there on are read.
    pub bits: u32,
}

impl Adder {
    /// Nothing for a node that is no sum, and for a sum that is only wiring.
    pub fn of(flat: &Flat, kept: &Kept, id: NodeId) -> Option<Adder> {
        let Cell::Sum { terms, constant } = &flat.node(id).cell else { return None };
        let mut starts: Vec<u32> =
            terms.iter().map(|term| term.shift + kept.zeros[term.of.index()]).collect();
        if *constant != 0 {
            starts.push(constant.trailing_zeros());
        }
        // A negative number alone is subtracted from zero.
        if starts.len() == 1 && terms.iter().any(|term| term.negate) {
            starts.push(starts[0]);
        }
        starts.sort_unstable();
        let start = *starts.get(1)?;
        Some(Adder {
            operands: starts.len() as u32,
            start,
            bits: kept.read[id.index()].saturating_sub(start),
        })
    }
}

/// An operand of a sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operand {
    Of(Term),
    Number(i128),
}

/// The operands of a sum, and 0 where a number is alone.
pub(super) fn operands(terms: &[Term], constant: i128) -> Vec<Operand> {
    let mut operands: Vec<Operand> = terms.iter().map(|term| Operand::Of(*term)).collect();
    if constant != 0 || operands.len() == 1 {
        operands.push(Operand::Number(constant));
    }
    operands
}

/// A bit of an operand, as if none of them were inverted: that is within the adder.
pub(super) fn operand(gates: &Gates, operand: &Operand, bit: u32) -> Function {
    match operand {
        Operand::Number(number) => Function::constant(number >> bit.min(127) & 1 == 1),
        Operand::Of(term) if bit < term.shift => Function::ZERO,
        Operand::Of(term) => gates.bit(term.of, bit - term.shift),
    }
}
