//! Which of the gates become LUTs of their own.
//!
//! ```text
//!   a register, a memory, an output, another LUT reads the gate     a LUT
//!   an adder reads it, whose cell has pins for what it reads        absorbed: part of the adder's cell, where the family
//!                                                                   has cells of carry with four inputs
//! ```

use std::collections::{BTreeMap, BTreeSet};

use super::function::Function;
use super::gates::{Gates, Leaf};
use super::kept::Kept;
use super::sums::{Adder, operand, operands};
use crate::hdl::{Cell, Flat, NodeId};

/// What a node that is no gate reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Reads {
    /// Each by a LUT of its own, if it is a gate.
    pub outside: BTreeSet<Function>,
    /// Gates in the node's own cells.
    pub inside: BTreeSet<Function>,
}

/// The LUTs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cover {
    pub gates: u32,
    pub absorbed: u32,
    /// Bits of registers that are fed by no LUT.
    pub delay: u32,
}

/// What every node reads that is no gate.
pub(super) fn reads(flat: &Flat, kept: &Kept, gates: &Gates) -> BTreeMap<NodeId, Reads> {
    let behind = choices_behind(flat, kept, gates);
    let nodes = flat.order.iter().chain(&flat.clocked).copied().filter(|id| kept.bits(*id) > 0);
    nodes
        .map(|id| (id, Reading { flat, kept, gates }.of(id, &behind)))
        .filter(|(_, reads)| !reads.outside.is_empty() || !reads.inside.is_empty())
        .collect()
}

/// The choice behind each adder that goes into its cells.
fn choices_behind(flat: &Flat, kept: &Kept, gates: &Gates) -> BTreeMap<NodeId, NodeId> {
    let nodes = flat.order.iter().copied().filter(|id| kept.bits(*id) > 0);
    nodes.filter_map(|id| gates.folds.sum(id).map(|sum| (sum, id))).collect()
}

/// What the outside reads: outputs, and memories that are written.
pub(super) fn read_outside(flat: &Flat, gates: &Gates) -> BTreeSet<Function> {
    let writes = flat.memories.iter().filter_map(|memory| memory.write.as_ref());
    let written = writes.flat_map(|write| [write.enable, write.address, write.data]);
    let ids = flat.outputs.iter().map(|(_, id)| *id).chain(written);
    ids.flat_map(|id| (0..flat.node(id).word.width()).map(move |bit| (id, bit)))
        .map(|(id, bit)| gates.bit(id, bit))
        .collect()
}

impl Cover {
    pub fn of(
        flat: &Flat,
        kept: &Kept,
        gates: &mut Gates,
        reads: &BTreeMap<NodeId, Reads>,
        outside: &BTreeSet<Function>,
    ) -> Cover {
        let delay = delayed(flat, kept, gates);
        let roots: BTreeSet<u32> = reads
            .values()
            .flat_map(|reads| &reads.outside)
            .chain(outside)
            .flat_map(|function| gates.close(*function).leaves().to_vec())
            .collect();
        let mut inside: BTreeMap<u32, (u32, usize)> = BTreeMap::new();
        for function in reads.values().flat_map(|reads| &reads.inside) {
            for leaf in gates.close(*function).leaves() {
                inside.entry(*leaf).or_insert((0, function.leaves().len())).0 += 1;
            }
        }
        let mut alive = vec![false; gates.leaves.len()];
        roots.iter().for_each(|leaf| alive[*leaf as usize] = true);
        // Leaves stand before what reads them.
        for leaf in (0..gates.leaves.len()).rev() {
            if let Leaf::Gate(function) = &gates.leaves[leaf]
                && (alive[leaf] || inside.contains_key(&(leaf as u32)))
            {
                function.leaves().iter().for_each(|of| alive[*of as usize] = true);
            }
        }
        let is_gate = |leaf: usize| matches!(gates.leaves[leaf], Leaf::Gate(_));
        let mut cover = Cover { delay, ..Cover::default() };
        cover.gates = (0..alive.len()).filter(|leaf| alive[*leaf] && is_gate(*leaf)).count() as u32;
        for (_, (readers, leaves)) in inside.iter().filter(|(leaf, _)| !alive[**leaf as usize]) {
            // More than two pins are too many for several readers.
            if *readers > 1 && *leaves > 2 { cover.gates += 1 } else { cover.absorbed += 1 }
        }
        cover
    }
}

/// Bits of registers that take a bit of a register, a memory or a port as it is.
fn delayed(flat: &Flat, kept: &Kept, gates: &Gates) -> u32 {
    let stored = |leaf: u32| match gates.leaves[leaf as usize] {
        Leaf::Bit(id) => {
            matches!(flat.node(id).cell, Cell::Register { .. } | Cell::MemoryRead { .. } | Cell::Input)
        }
        Leaf::Gate(_) => false,
    };
    let delayed = |id: &NodeId| match flat.node(*id).cell {
        Cell::Register { next: Some(next), .. } => {
            let bits = kept.zeros[id.index()]..kept.read[id.index()].min(kept.signed[id.index()]);
            bits.filter(|bit| gates.bit(next, *bit).leaves().iter().all(|leaf| stored(*leaf)))
                .filter(|bit| !gates.bit(next, *bit).is_gate())
                .count() as u32
        }
        _ => 0,
    };
    flat.clocked.iter().map(delayed).sum()
}

struct Reading<'a> {
    flat: &'a Flat,
    kept: &'a Kept,
    gates: &'a Gates<'a>,
}

impl Reading<'_> {
    fn of(&self, id: NodeId, behind: &BTreeMap<NodeId, NodeId>) -> Reads {
        let mut reads = Reads::default();
        let width = |id: &NodeId| self.flat.node(*id).word.width();
        let kept = self.kept.zeros[id.index()]..self.kept.read[id.index()].min(self.kept.signed[id.index()]);
        let mut all = |id: &NodeId| reads.outside.extend((0..width(id)).map(|bit| self.gates.bit(*id, bit)));
        match &self.flat.node(id).cell {
            Cell::Register { next, enable, .. } => {
                enable.iter().for_each(all);
                reads
                    .outside
                    .extend(next.iter().flat_map(|next| kept.clone().map(|bit| self.gates.bit(*next, bit))));
            }
            Cell::MemoryRead { address, enable, .. } => [address].into_iter().chain(enable).for_each(all),
            Cell::Product { left, right } => [left, right].into_iter().for_each(all),
            Cell::Compare { left, right, .. } if self.gates.is_opaque(id) => {
                for bit in 0..width(left).max(width(right)) {
                    self.meet(&mut reads, [self.gates.bit(*left, bit), self.gates.bit(*right, bit)], &[]);
                }
            }
            Cell::Select { condition, on_true, on_false } => {
                let Some(sum) = self.gates.folds.sum(id) else { return reads };
                all(condition);
                let sides = [on_true, on_false].into_iter();
                let bits = sides.flat_map(|side| kept.clone().map(|bit| self.gates.bit(*side, bit)));
                reads.outside.extend(bits.filter(|bit| !self.gates.is_bit_of(bit, sum)));
            }
            Cell::Sum { .. } => self.sum(&mut reads, id, behind.get(&id).copied()),
            _ => {}
        }
        reads.outside.remove(&Function::ZERO);
        reads
    }

    fn sum(&self, reads: &mut Reads, id: NodeId, choice: Option<NodeId>) {
        let (Cell::Sum { terms, constant }, Some(adder)) =
            (&self.flat.node(id).cell, Adder::of(self.flat, self.kept, id))
        else {
            return;
        };
        let operands = operands(terms, *constant);
        for bit in adder.start..adder.start + adder.bits {
            let bits: Vec<Function> = operands.iter().map(|of| operand(self.gates, of, bit)).collect();
            match bits[..] {
                [one, two] => self.meet(reads, [one, two], &self.chosen(choice, id, bit)),
                _ => reads.outside.extend(bits),
            }
        }
    }

    /// What the choice behind an adder reads besides; its own bits are about those of the adder.
    fn chosen(&self, choice: Option<NodeId>, sum: NodeId, bit: u32) -> Vec<Function> {
        let Some(Cell::Select { condition, on_true, on_false }) = choice.map(|id| &self.flat.node(id).cell)
        else {
            return vec![];
        };
        // One of the sides is the sum itself, which is inside.
        let sides = [on_true, on_false].map(|side| self.gates.bit(*side, bit));
        let others = sides.into_iter().filter(|side| !self.gates.is_bit_of(side, sum));
        others.chain([self.gates.bit(*condition, 0)]).collect()
    }

    /// Two bits meet in an adder.
    fn meet(&self, reads: &mut Reads, [one, two]: [Function; 2], besides: &[Function]) {
        let gates = [one, two].into_iter().filter(Function::is_gate);
        let room = Function::together(&[&[one, two], besides].concat()).is_some();
        if gates.clone().count() > 0 && room && one.add_in_one_cell(two) {
            reads.inside.extend(gates);
            let leaves = [one, two].into_iter().flat_map(|function| function.leaves().to_vec());
            reads.outside.extend(leaves.map(Function::leaf));
        } else {
            reads.outside.extend([one, two]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    fn cover(m: Builder) -> Cover {
        let flat = Flat::new(&m.finish().unwrap()).unwrap();
        let kept = Kept::of(&flat);
        let mut gates = Gates::of(&flat, &kept);
        let (reads, outside) = (reads(&flat, &kept, &gates), read_outside(&flat, &gates));
        Cover::of(&flat, &kept, &mut gates, &reads, &outside)
    }

    #[test]
    fn a_gate_before_an_adder_is_absorbed_unless_others_read_it() {
        for read in [false, true] {
            let m = Builder::new("m");
            let [a, b, n] = ["a", "b", "n"].map(|name| m.input(name, Word::signed(8)));
            let load = m.input("load", Word::bit());
            let chosen = m.select(&load, &n, &a);
            m.output("y", m.pipe("y", &chosen + &b));
            if read {
                m.output("z", m.pipe("z", &chosen));
            }
            let expected = if read { (8, 0) } else { (0, 8) };
            let Cover { gates, absorbed, .. } = cover(m);
            assert_eq!((gates, absorbed), expected);
        }
    }

    #[test]
    fn five_leaves_before_an_adder_are_too_many() {
        let m = Builder::new("m");
        let [a, b, n, k] = ["a", "b", "n", "k"].map(|name| m.input(name, Word::signed(8)));
        let load = m.input("load", Word::bit());
        let (one, two) = (m.select(&load, &n, &a), m.select(&load, &k, &b));
        m.output("y", m.pipe("y", &one + &two));
        assert_eq!(cover(m).gates, 16);
    }

    #[test]
    fn registers_behind_registers_are_counted() {
        let m = Builder::new("m");
        let a = m.input("a", Word::signed(8));
        m.output("y", m.delay(&m.pipe("x", &a + 1), 2));
        assert_eq!(cover(m), Cover { delay: 18, ..Cover::default() });
    }
}
