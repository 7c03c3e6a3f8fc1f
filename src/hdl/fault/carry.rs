//! A sum that loses the carry into one bit, built from sound cells.
//!
//! ```text
//! terms, each alone:      t0  t1  t2  ...  constant              modulo 2^width
//! high parts, bits k ..   h0 + h1 + h2 + ... ──► high ─┐
//! low parts, bits .. k    l0 + l1 + l2 + ... ──► low ──┴─► {high, low}, and nothing from low to high
//! ```

use super::append;
use crate::fixed::Range;
use crate::hdl::Word;
use crate::hdl::cell::{Cell, NodeId, Term};
use crate::hdl::flat::Flat;

/// The cell that takes the place of the sum `id`.
pub(super) fn dropped(flat: &mut Flat, id: NodeId, bit: u32) -> Cell {
    let node = flat.node(id);
    let (word, Cell::Sum { terms, constant }) = (node.word, node.cell.clone()) else {
        return node.cell.clone();
    };
    let width = word.width();
    let whole = Word::modular(width);
    let mut operands: Vec<NodeId> = terms
        .into_iter()
        .map(|term| append(flat, Cell::Sum { terms: vec![term], constant: 0 }, whole, id))
        .collect();
    if constant != 0 {
        operands.push(append(flat, Cell::Constant(whole.range.wrap(constant)), whole, id));
    }
    let high = sum_of_slices(flat, &operands, bit, width - bit, id);
    let low = sum_of_slices(flat, &operands, 0, bit, id);
    Cell::Wrap { of: append(flat, Cell::Concat { parts: vec![high, low] }, Word::unsigned(width), id) }
}

/// The sum of bits `low .. low + width` of each operand, modulo 2^`width`.
fn sum_of_slices(flat: &mut Flat, operands: &[NodeId], low: u32, width: u32, like: NodeId) -> NodeId {
    let mut terms = vec![];
    for &of in operands {
        let slice = append(flat, Cell::Slice { of, low }, Word::unsigned(width), like);
        terms.push(Term { negate: false, shift: 0, of: slice });
    }
    let range = Range::unsigned(width) * terms.len() as i128;
    let sum = append(flat, Cell::Sum { terms, constant: 0 }, range.into(), like);
    append(flat, Cell::Slice { of: sum, low: 0 }, Word::unsigned(width), like)
}
