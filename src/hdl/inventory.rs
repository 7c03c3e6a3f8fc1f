//! What a design keeps and what it computes with, one by one: for figures that ask what is where.
//!
//! ```text
//! stored      every register and memory, with the instance it is in
//! Operators   adders by their number of operands, multipliers, tables
//! ```
//!
//! A table is a tree of choices between constants, such as `valence == 3 ? k3 : valence == 5 ? k5 : k4`.
//! Only what somebody needs is counted, as only that is printed.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::Word;
use super::cell::{Cell, NodeId};
use super::live::Live;
use super::module::Module;

/// A register, or a memory of `depth` words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The instances on the way to it: `level_0_x`, `loader.fifo`; empty at the top.
    pub instance: String,
    pub name: String,
    pub word: Word,
    pub depth: u32,
}

impl Stored {
    /// In all its words.
    pub fn bits(&self) -> u64 {
        u64::from(self.depth) * u64::from(self.word.width())
    }
}

/// Everything that the design keeps, in the order in which it was built. The register behind the read port of a
/// memory is listed beside the memory.
pub fn stored(top: &Rc<Module>) -> Vec<Stored> {
    let mut found = vec![];
    gather(top, "", &mut found);
    found
}

fn gather(module: &Module, instance: &str, found: &mut Vec<Stored>) {
    let live = Live::of(module);
    let stored =
        |name: &str, word, depth| Stored { instance: instance.into(), name: name.into(), word, depth };
    for (node, _) in module.nodes.iter().zip(&live.nodes).filter(|(_, live)| **live) {
        if let Cell::Register { .. } | Cell::MemoryRead { .. } = node.cell {
            found.push(stored(node.name.as_deref().unwrap_or_default(), node.word, 1));
        }
    }
    for (memory, _) in module.memories.iter().zip(&live.memories).filter(|(_, live)| **live) {
        found.push(stored(&memory.name, memory.word, memory.depth));
    }
    let dot = if instance.is_empty() { "" } else { "." };
    for inner in &module.instances {
        gather(&inner.module, &format!("{instance}{dot}{}", inner.name), found);
    }
}

/// The operators of a design, each instance counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Operators {
    /// Sums by their number of operands, two at least. A multiple by a constant is an operand for each signed
    /// binary digit, a constant addend is one too.
    pub adders: BTreeMap<u32, u64>,
    /// Of two signals.
    pub multipliers: u64,
    /// The number of different constants in each table.
    pub tables: Vec<u64>,
}

impl Operators {
    pub fn of(top: &Rc<Module>) -> Operators {
        let mut operators = Operators::default();
        operators.add(top);
        operators
    }

    /// As two-operand adders.
    pub fn two_operand_adders(&self) -> u64 {
        self.adders.iter().map(|(operands, count)| u64::from(operands - 1) * count).sum()
    }

    fn add(&mut self, module: &Module) {
        let live = Live::of(module);
        let constants = tables(module);
        let mut inside = vec![false; module.nodes.len()];
        // A node stands behind what it reads, so the root of a tree is met first from the end.
        for index in (0..module.nodes.len()).rev().filter(|&index| live.nodes[index]) {
            match &module.nodes[index].cell {
                Cell::Sum { terms, constant } => {
                    let operands = terms.len() as u32 + u32::from(*constant != 0);
                    if operands > 1 {
                        *self.adders.entry(operands).or_default() += 1;
                    }
                }
                Cell::Product { .. } => self.multipliers += 1,
                Cell::Select { on_true, on_false, .. } => {
                    if let Some(entries) = constants.get(&NodeId(index as u32)) {
                        [on_true, on_false].into_iter().for_each(|id| inside[id.index()] = true);
                        if !inside[index] {
                            self.tables.push(entries.len() as u64);
                        }
                    }
                }
                _ => {}
            }
        }
        module.instances.iter().for_each(|instance| self.add(&instance.module));
    }
}

/// The constants below each choice that leads to nothing else.
fn tables(module: &Module) -> BTreeMap<NodeId, BTreeSet<i128>> {
    let mut found: BTreeMap<NodeId, BTreeSet<i128>> = BTreeMap::new();
    for (index, node) in module.nodes.iter().enumerate() {
        let Cell::Select { on_true, on_false, .. } = &node.cell else { continue };
        let below = |id: &NodeId| match module.node(*id).cell {
            Cell::Constant(value) => Some(BTreeSet::from([value])),
            _ => found.get(id).cloned(),
        };
        if let (Some(mut entries), Some(others)) = (below(on_true), below(on_false)) {
            entries.extend(others);
            found.insert(NodeId(index as u32), entries);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::Builder;

    #[test]
    fn registers_and_memories_are_listed_with_their_instance_and_dead_ones_are_not() {
        let m = Builder::new("inner");
        let (a, address) = (m.input("a", Word::signed(8)), m.input("address", Word::unsigned(2)));
        m.pipe("dead", &a);
        let lost = m.memory("lost", 4, Word::signed(8), vec![]);
        lost.write(&m.bit(true), &address, &a);
        let kept = m.memory("kept", 4, Word::signed(8), vec![]);
        kept.write(&m.bit(true), &address, &a);
        m.output("y", kept.read("word", &address, None));
        let inner = m.finish().unwrap();
        let m = Builder::new("outer");
        let (a, address) = (m.input("a", Word::signed(8)), m.input("address", Word::unsigned(2)));
        let placed = m.instance("one", &inner, &[("a", &a), ("address", &address)]);
        m.output("y", m.pipe("last", placed.out("y")));
        let found: Vec<_> = stored(&m.finish().unwrap())
            .into_iter()
            .map(|s| (format!("{}/{}", s.instance, s.name), s.depth, s.bits()))
            .collect();
        let expected = [("/last", 1, 8), ("one/word", 1, 8), ("one/kept", 4, 32)];
        assert_eq!(found, expected.map(|(name, depth, bits)| (name.to_string(), depth, bits)));
    }

    #[test]
    fn a_tree_of_constants_is_one_table_and_a_mask_is_one_adder() {
        let m = Builder::new("m");
        let (a, b) = (m.input("a", Word::unsigned(8)), m.input("b", Word::unsigned(8)));
        let entry = |value| m.constant(value, Word::unsigned(8));
        let inner = m.select(&m.is(&a, 5), entry(25), entry(16));
        let table = m.select(&m.is(&a, 3), entry(9), &inner);
        let half = m.select(&m.is(&a, 7), entry(1), &b);
        m.output("y", m.product(&table, &half));
        m.output("z", m.signal(6 * &a + &b + 1));
        let operators = Operators::of(&m.finish().unwrap());
        assert_eq!((operators.multipliers, operators.tables.clone()), (1, vec![3]));
        assert_eq!((operators.adders.clone(), operators.two_operand_adders()), (BTreeMap::from([(4, 1)]), 3));
    }
}
