//! Which choices go into the adder behind which they stand.
//!
//! ```text
//!   load ? n : a + b       all four pins of a cell of carry: a, b, load, n
//! ```
//!
//! Nobody else may read the sum, below what the choice takes of it; what is chosen by must be one bit.

use super::function::Function;
use super::gates::Gates;
use super::kept::Kept;
use super::sums::{Adder, operand, operands};
use crate::hdl::{Cell, Flat, NodeId};

/// Choices and the sums that they may go into.
pub(super) struct Folds {
    /// For each node the sum of two numbers.
    sums: Vec<Option<NodeId>>,
}

impl Folds {
    /// What the readers of the sums allow.
    pub fn of(flat: &Flat, kept: &Kept) -> Folds {
        let mut readers: Vec<Vec<(NodeId, u32)>> = vec![vec![]; flat.nodes.len()];
        let nodes = flat.order.iter().chain(&flat.clocked).copied().filter(|id| kept.bits(*id) > 0);
        for id in nodes.filter(|id| !is_wiring(flat, *id)) {
            let cell = &flat.node(id).cell;
            for of in cell.combinational_inputs().into_iter().chain(cell.clocked_inputs()) {
                let (source, low) = source(flat, of);
                readers[source.index()].push((id, low));
            }
        }
        let written = flat.memories.iter().filter_map(|memory| memory.write.as_ref());
        let outside = flat.outputs.iter().map(|(_, id)| *id).chain(written.map(|write| write.data));
        for id in outside {
            let (source, low) = source(flat, id);
            readers[source.index()].push((id, low));
        }
        let sums = (0..flat.nodes.len() as u32).map(NodeId).map(|id| {
            let width = flat.node(id).word.width();
            let alone =
                |sum: &NodeId| readers[sum.index()].iter().all(|(by, low)| *by == id || *low >= width);
            sums_behind(flat, id).into_iter().find(alone)
        });
        Folds { sums: sums.collect() }
    }

    /// The sum that a choice goes into.
    pub fn sum(&self, id: NodeId) -> Option<NodeId> {
        self.sums[id.index()]
    }

    /// Whether the pins suffice for all bits; else the choice is forgotten.
    pub fn fits(flat: &Flat, kept: &Kept, gates: &Gates, id: NodeId, sum: NodeId) -> bool {
        let Cell::Select { condition, on_true, on_false } = &flat.node(id).cell else { return false };
        let Cell::Sum { terms, constant } = &flat.node(sum).cell else { return false };
        let Some(adder) = Adder::of(flat, kept, sum) else { return false };
        let other = if source(flat, *on_true).0 == sum { on_false } else { on_true };
        let low = source(flat, if other == on_false { *on_true } else { *on_false }).1;
        let condition = gates.bit(*condition, 0);
        let operands = operands(terms, *constant);
        let stub =
            |at: usize, of: Function| if of.is_gate() { Function::leaf(u32::MAX - at as u32) } else { of };
        (adder.start..adder.start + adder.bits).all(|bit| {
            let other = if bit < low { Function::ZERO } else { gates.bit(*other, bit - low) };
            let own: Vec<Function> =
                operands.iter().enumerate().map(|(at, of)| stub(at, operand(gates, of, bit))).collect();
            // The LUT of the choice also reads the sum.
            let alone = Function::together(&[condition, other, Function::leaf(u32::MAX - 2)]).is_none();
            let (condition, other) =
                if alone { (stub(3, condition), stub(4, other)) } else { (condition, other) };
            let pins = [&own[..], &[condition, other]].concat();
            !condition.is_gate() && Function::together(&pins).is_some()
        })
    }

    pub fn forget(&mut self, id: NodeId) {
        self.sums[id.index()] = None;
    }
}

/// Views of other nodes, and sums of one number.
fn is_wiring(flat: &Flat, id: NodeId) -> bool {
    match &flat.node(id).cell {
        Cell::Wrap { .. } | Cell::Claim { .. } | Cell::Slice { .. } | Cell::ShiftRight { .. } => true,
        Cell::Sum { terms, constant: 0 } => terms.len() == 1 && !terms[0].negate,
        _ => false,
    }
}

/// Back through wiring: where the bits come from, and the lowest of them.
fn source(flat: &Flat, mut id: NodeId) -> (NodeId, u32) {
    let mut low = 0;
    while is_wiring(flat, id) {
        match &flat.node(id).cell {
            Cell::Wrap { of } | Cell::Claim { of, .. } => id = *of,
            Cell::Slice { of, low: more } | Cell::ShiftRight { of, amount: more, .. } => {
                (id, low) = (*of, low + more);
            }
            Cell::Sum { terms, .. } => (id, low) = (terms[0].of, u32::saturating_sub(low, terms[0].shift)),
            _ => break,
        }
    }
    (id, low)
}

/// The sums of two numbers that are sides of a choice.
fn sums_behind(flat: &Flat, id: NodeId) -> Vec<NodeId> {
    let Cell::Select { on_true, on_false, .. } = &flat.node(id).cell else { return vec![] };
    let sides = [on_true, on_false].into_iter().map(|side| source(flat, *side).0);
    let of_two = |id: &NodeId| match &flat.node(*id).cell {
        Cell::Sum { terms, constant } => operands(terms, *constant).len() == 2,
        _ => false,
    };
    sides.filter(of_two).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Signal, Word};

    /// How many choices go into adders.
    fn folded(build: impl Fn(&Builder, &[Signal; 4], &Signal) -> Signal) -> usize {
        let m = Builder::new("m");
        let [a, b, n, k] = ["a", "b", "n", "k"].map(|name| m.input(name, Word::modular(8)));
        let sum = m.modulo(&a + &b, 8);
        m.output("y", m.pipe("y", build(&m, &[a, b, n, k], &sum)));
        let flat = Flat::new(&m.finish().unwrap()).unwrap();
        let kept = Kept::of(&flat);
        let gates = Gates::of(&flat, &kept);
        let chosen = flat.order.iter().filter(|id| gates.folds.sum(**id).is_some());
        chosen.count()
    }

    #[test]
    fn a_choice_folds_where_its_sum_has_no_other_reader() {
        let load = |m: &Builder| m.input("load", Word::bit());
        assert_eq!(folded(|m, [_, _, n, _], sum| m.select(&load(m), n, sum)), 1);
        let read = |m: &Builder, [_, _, n, _]: &[Signal; 4], sum: &Signal| {
            m.output("sum", m.pipe("sum", sum));
            m.select(&load(m), n, sum)
        };
        assert_eq!(folded(read), 0);
    }

    #[test]
    fn what_is_chosen_by_is_one_bit_and_what_is_taken_may_be_a_gate() {
        let chosen = |m: &Builder, [_, _, n, k]: &[Signal; 4], sum: &Signal| {
            let [load, odd] = ["load", "odd"].map(|name| m.input(name, Word::bit()));
            m.select(&load, m.select(&odd, n, k), sum)
        };
        // The inner choice has a LUT of its own, and then a pin suffices.
        assert_eq!(folded(chosen), 1);
        let both = |m: &Builder, [_, _, n, _]: &[Signal; 4], sum: &Signal| {
            let [load, odd] = ["load", "odd"].map(|name| m.input(name, Word::bit()));
            m.select(&m.all(&[&load, &odd]), n, sum)
        };
        assert_eq!(folded(both), 0);
    }
}
