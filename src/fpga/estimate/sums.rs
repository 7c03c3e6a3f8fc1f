//! Where the operands of a sum meet, and the choices that go into its cells.
//!
//! ```text
//!   a  a a a a a a a          a + 4 b: two operands meet in the bits from the second on;
//!      b b b b b b            below there is only wiring
//! ```

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

/// The sum of two numbers that is one side of a choice, and the other side: the choice goes into the adder.
pub(super) fn folded(flat: &Flat, id: NodeId) -> Option<(NodeId, NodeId)> {
    let Cell::Select { on_true, on_false, .. } = &flat.node(id).cell else { return None };
    [(on_true, on_false), (on_false, on_true)].into_iter().find_map(|(side, other)| {
        let mut id = *side;
        loop {
            match &flat.node(id).cell {
                Cell::Wrap { of } | Cell::Claim { of, .. } | Cell::Slice { of, .. } => id = *of,
                Cell::Sum { terms, constant: 0 } if terms.len() == 1 => id = terms[0].of,
                Cell::Sum { terms, constant } => {
                    return (terms.len() + usize::from(*constant != 0) == 2).then_some((id, *other));
                }
                _ => return None,
            }
        }
    })
}

/// Whether a node is a choice of which one side is a sum of two numbers.
pub(super) fn folds(flat: &Flat, id: NodeId) -> bool {
    folded(flat, id).is_some()
}
