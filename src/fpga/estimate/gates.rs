//! A cover of gates by LUTs of four inputs, bit by bit.
//!
//! ```text
//!   a ─┐
//!   b ─┴ & ─┐                   one LUT of a, b, c, d: a gate takes in the gates before it
//!   c ──────┴ | ─┐              as long as all leaves together are at most four
//!   d ───────────┴ ^ ──► register
//! ```
//!
//! Every bit of a word is a [`Function`] of leaves. A leaf is a bit that no gate makes (of a register, a sum, a memory),
//! or a gate that was closed, because what reads it had no room for its leaves. Wires, shifts and copies of signs are
//! followed; what is constant, and what makes no difference, vanishes.

use std::collections::BTreeMap;

use super::folds::Folds;
use super::function::Function;
use super::kept::Kept;
use super::sums::Adder;
use crate::hdl::{Bitwise, Cell, Flat, NodeId, Relation};

/// What a leaf is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Leaf {
    /// A bit of a node that is no gate.
    Bit(NodeId),
    /// A LUT, of leaves before this one.
    Gate(Function),
}

const ZERO: Function = Function::ZERO;

/// The functions of all bits.
pub(super) struct Gates<'a> {
    flat: &'a Flat,
    kept: &'a Kept,
    /// For each node its bits, the lowest first.
    bits: Vec<Vec<Function>>,
    /// Each after those that it is made of.
    pub leaves: Vec<Leaf>,
    /// How many LUTs are behind each leaf, on the longest way.
    depths: Vec<u32>,
    closed: BTreeMap<Function, u32>,
    /// Choices that are no gates.
    pub folds: Folds,
}

impl<'a> Gates<'a> {
    pub fn of(flat: &'a Flat, kept: &'a Kept) -> Gates<'a> {
        let bits = vec![vec![]; flat.nodes.len()];
        let folds = Folds::of(flat, kept);
        let mut gates =
            Gates { flat, kept, bits, leaves: vec![], depths: vec![], closed: BTreeMap::new(), folds };
        let stored = (0..flat.nodes.len() as u32).map(NodeId);
        let stored = stored.filter(|id| {
            matches!(flat.node(*id).cell, Cell::Input | Cell::Register { .. } | Cell::MemoryRead { .. })
        });
        for id in stored.chain(flat.order.iter().copied()).filter(|id| kept.read[id.index()] > 0) {
            gates.bits[id.index()] = gates.made(id);
        }
        gates
    }

    /// A bit of a number, which beyond its width is the sign or 0.
    pub fn bit(&self, id: NodeId, bit: u32) -> Function {
        let bits = &self.bits[id.index()];
        match bits.get(bit as usize) {
            Some(function) => *function,
            None if self.flat.node(id).word.is_signed() => bits.last().copied().unwrap_or(ZERO),
            None => ZERO,
        }
    }

    /// Whether a bit is one of a node that is no gate.
    pub fn is_bit_of(&self, bit: &Function, id: NodeId) -> bool {
        matches!(bit.leaves(), [leaf] if self.leaves[*leaf as usize] == Leaf::Bit(id))
    }

    /// Whether bits of a node are no gates.
    pub fn is_opaque(&self, id: NodeId) -> bool {
        self.bits[id.index()].iter().any(|bit| self.is_bit_of(bit, id))
    }

    /// The leaf that a function is where it cannot go into what reads it.
    pub fn close(&mut self, function: Function) -> Function {
        if !function.is_gate() {
            return function;
        }
        let next = self.leaves.len() as u32;
        let leaf = *self.closed.entry(function).or_insert(next);
        if leaf == next {
            self.depths.push(self.depth(function) + 1);
            self.leaves.push(Leaf::Gate(function));
        }
        Function::leaf(leaf)
    }

    /// The deepest of its leaves.
    fn depth(&self, function: Function) -> u32 {
        function.leaves().iter().map(|leaf| self.depths[*leaf as usize]).max().unwrap_or(0)
    }

    /// Behind a node that is no gate: an adder is as deep as a LUT, together with a choice behind it.
    fn depth_of_node(&self, id: NodeId) -> u32 {
        let inputs = self.flat.node(id).cell.combinational_inputs();
        let bits = inputs.iter().flat_map(|of| &self.bits[of.index()]);
        let own = u32::from(!matches!(self.flat.node(id).cell, Cell::Select { .. }));
        bits.map(|bit| self.depth(*bit) + own).max().unwrap_or(0)
    }

    fn made(&mut self, id: NodeId) -> Vec<Function> {
        let (flat, width) = (self.flat, self.flat.node(id).word.width());
        let bits = 0..width;
        match &flat.node(id).cell {
            Cell::Constant(value) => {
                bits.map(|bit| Function::constant(value >> bit.min(127) & 1 == 1)).collect()
            }
            Cell::Wrap { of } | Cell::Claim { of, .. } => bits.map(|bit| self.bit(*of, bit)).collect(),
            Cell::ShiftRight { of, amount: low, .. } | Cell::Slice { of, low } => {
                bits.map(|bit| self.bit(*of, bit + low)).collect()
            }
            Cell::Concat { parts } => {
                let of = |part: &NodeId| {
                    (0..flat.node(*part).word.width()).map(|bit| self.bit(*part, bit)).collect::<Vec<_>>()
                };
                parts.iter().rev().flat_map(of).collect()
            }
            Cell::Not { of } => bits.map(|bit| self.bit(*of, bit).inverted()).collect(),
            Cell::Sum { .. } => self.sum(id, width),
            Cell::Select { .. } if self.is_folded(id) => self.opaque(id, width),
            Cell::Select { condition, on_true, on_false } => {
                let condition = self.bit(*condition, 0);
                bits.map(|bit| self.chosen([condition, self.bit(*on_true, bit), self.bit(*on_false, bit)]))
                    .collect()
            }
            Cell::Logic { operation, operands } => bits
                .map(|bit| self.joined(operands.iter().map(|of| self.bit(*of, bit)).collect(), *operation))
                .collect(),
            Cell::Compare { relation, left, right } => vec![self.compared(id, *relation, *left, *right)],
            Cell::Input | Cell::Register { .. } | Cell::MemoryRead { .. } | Cell::Product { .. } => {
                self.opaque(id, width)
            }
            Cell::Wire { .. } | Cell::InstanceOutput { .. } => self.opaque(id, width),
        }
    }

    /// Bits that no gate makes; low ones are 0, and high ones are copies of the sign.
    fn opaque(&mut self, id: NodeId, width: u32) -> Vec<Function> {
        let (zeros, last) = (self.kept.zeros[id.index()], self.kept.signed[id.index()]);
        let depth = self.depth_of_node(id);
        let mut bits: Vec<Function> = vec![];
        for bit in 0..width {
            bits.push(match bits.last() {
                _ if bit < zeros => ZERO,
                Some(sign) if bit >= last => *sign,
                _ => {
                    self.leaves.push(Leaf::Bit(id));
                    self.depths.push(depth);
                    Function::leaf(self.leaves.len() as u32 - 1)
                }
            });
        }
        bits
    }

    /// Below the bits where two operands meet there is the one that begins lowest.
    fn sum(&mut self, id: NodeId, width: u32) -> Vec<Function> {
        let adder = Adder::of(self.flat, self.kept, id);
        let meet = adder.as_ref().map_or(0, |adder| adder.start);
        let mut bits = self.opaque(id, width);
        let Cell::Sum { terms, constant } = &self.flat.node(id).cell else { return bits };
        let lowest = terms.iter().min_by_key(|term| term.shift + self.kept.zeros[term.of.index()]);
        let Some(lowest) = lowest.filter(|term| !term.negate) else { return bits };
        let through = match adder {
            None => width,
            // The constant may be what begins lowest.
            Some(_) if *constant != 0 && constant.trailing_zeros() < meet => 0,
            Some(_) => meet.min(width),
        };
        for bit in 0..through {
            let below = bit < lowest.shift;
            bits[bit as usize] = if below { ZERO } else { self.bit(lowest.of, bit - lowest.shift) };
        }
        bits
    }

    /// Whether a choice goes into an adder. It does not where that lacks pins.
    fn is_folded(&mut self, id: NodeId) -> bool {
        let Some(sum) = self.folds.sum(id) else { return false };
        let fits = Folds::fits(self.flat, self.kept, self, id, sum);
        if !fits {
            self.folds.forget(id);
        }
        fits
    }

    /// A choice, with those of its inputs closed, as few as may be, whose leaves find no room.
    fn chosen(&mut self, inputs: [Function; 3]) -> Function {
        if let Some(function) = Function::select(inputs) {
            return function;
        }
        let open = |input: usize, set: u32| set >> input & 1 == 0 || !inputs[input].is_gate();
        // The fastest; a gate that is closed already costs nothing more; a wide one is worth closing.
        let cost = |set: u32| -> (u32, u32, u32) {
            (0..3).fold((0, 0, 0), |(depth, gates, spare), input| {
                let function = inputs[input];
                if open(input, set) {
                    return (depth.max(self.depth(function)), gates, spare);
                }
                let fresh = u32::from(!self.closed.contains_key(&function));
                let spare = spare + 4 - function.leaves().len() as u32;
                (depth.max(self.depth(function) + 1), gates + fresh, spare)
            })
        };
        let mut sets: Vec<u32> = (1..8).collect();
        sets.sort_by_key(|set| cost(*set));
        for set in sets {
            let stub = |input: usize| {
                if open(input, set) { inputs[input] } else { Function::leaf(u32::MAX - input as u32) }
            };
            if Function::together(&[stub(0), stub(1), stub(2)]).is_some() {
                let mut tried = inputs;
                for input in 0..3 {
                    if !open(input, set) {
                        tried[input] = self.close(inputs[input]);
                    }
                }
                return Function::select(tried).unwrap_or(ZERO);
            }
        }
        ZERO
    }

    /// Many operands: as many as fit make a gate, which is one operand less wide, and so on until one is left. What
    /// comes early goes first.
    fn joined(&mut self, mut operands: Vec<Function>, operation: Bitwise) -> Function {
        loop {
            operands.sort_by_key(|of| (self.depth(*of), std::cmp::Reverse(of.leaves().len())));
            let mut rest = vec![];
            let mut operands_left = operands.into_iter();
            let Some(mut joined) = operands_left.next() else { return ZERO };
            for operand in operands_left {
                match joined.bitwise(operand, operation) {
                    Some(both) => joined = both,
                    None => rest.push(operand),
                }
            }
            match rest.first_mut() {
                None => return joined,
                // One bit found no room in another operand, which has four.
                Some(first) if !joined.is_gate() => *first = self.close(*first),
                Some(_) => joined = self.close(joined),
            }
            rest.push(joined);
            operands = rest;
        }
    }

    fn compared(&mut self, id: NodeId, relation: Relation, left: NodeId, right: NodeId) -> Function {
        let word = |id: NodeId| self.flat.node(id).word;
        let zero = |id: NodeId| matches!(self.flat.node(id).cell, Cell::Constant(0));
        let sign = |id: NodeId| self.bit(id, word(id).width() - 1);
        match relation {
            Relation::Equal | Relation::NotEqual => {
                let bits = 0..word(left).width().max(word(right).width());
                let differ = bits
                    .map(|bit| self.joined(vec![self.bit(left, bit), self.bit(right, bit)], Bitwise::Xor));
                let differ: Vec<Function> = differ.collect();
                let differ = self.joined(differ, Bitwise::Or);
                if relation == Relation::Equal { differ.inverted() } else { differ }
            }
            // An order against 0 is a sign.
            Relation::Less if zero(right) && word(left).is_signed() => sign(left),
            Relation::LessOrEqual if zero(left) && word(right).is_signed() => sign(right).inverted(),
            _ => self.opaque(id, 1).first().copied().unwrap_or(ZERO),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Signal, Word};

    /// Gates that were closed, and the leaves of the lowest bit of the register.
    fn covered(build: impl Fn(&Builder) -> Signal) -> (usize, usize) {
        let m = Builder::new("m");
        m.output("y", m.pipe("y", build(&m)));
        let flat = Flat::new(&m.finish().unwrap()).unwrap();
        let kept = Kept::of(&flat);
        let gates = Gates::of(&flat, &kept);
        let Cell::Register { next: Some(next), .. } = flat.node(flat.clocked[0]).cell else { panic!() };
        let closed = gates.leaves.iter().filter(|leaf| matches!(leaf, Leaf::Gate(_))).count();
        (closed, gates.bit(next, 0).leaves().len())
    }

    #[test]
    fn seven_bits_are_one_gate_before_another_one() {
        let all = |m: &Builder, bits: usize| {
            let bits: Vec<Signal> = (0..bits).map(|bit| m.input(format!("b{bit}"), Word::bit())).collect();
            m.all(&bits.iter().collect::<Vec<_>>())
        };
        assert_eq!(covered(|m| all(m, 4)), (0, 4));
        assert_eq!(covered(|m| all(m, 7)), (1, 4));
        assert_eq!(covered(|m| all(m, 16)), (4, 4));
    }

    #[test]
    fn an_equality_takes_two_bits_of_both_numbers_into_a_gate() {
        let same = |m: &Builder, width: u32| {
            let [a, b] = ["a", "b"].map(|name| m.input(name, Word::unsigned(width)));
            m.compare(Relation::Equal, &a, &b)
        };
        assert_eq!(covered(|m| same(m, 2)), (0, 4));
        assert_eq!(covered(|m| same(m, 8)), (4, 4));
    }

    #[test]
    fn what_is_below_the_second_operand_of_a_sum_is_wiring() {
        let low = |m: &Builder| {
            let [a, b] = ["a", "b"].map(|name| m.input(name, Word::unsigned(4)));
            let c = m.input("c", Word::bit());
            let sum = m.signal(&a + 4 * &b);
            let (first, third) = (m.slice(&sum, 0, 1), m.slice(&sum, 2, 1));
            m.all(&[&first, &third, &m.slice(&a, 0, 1), &c])
        };
        assert_eq!(covered(low), (0, 3));
    }
}
