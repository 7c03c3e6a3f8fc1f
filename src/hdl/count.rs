//! What a design is made of: the figures that say how large it will be.

use std::rc::Rc;

use serde::Serialize;

use super::cell::{Cell, Node};
use super::live::Live;
use super::module::Module;

/// Counts over a whole design, each instance counted; what nobody needs is not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Two-operand adders and subtractors; a constant addend counts as an operand.
    pub adders: u64,
    /// The widths of all adders together.
    pub adder_bits: u64,
    /// Two-to-one multiplexers.
    pub multiplexers: u64,
    pub multiplexer_bits: u64,
    pub comparators: u64,
    /// Multipliers of two signals. Constant multiples are adders.
    pub multipliers: u64,
    /// Registers as words, and as bits.
    pub registers: u64,
    pub register_bits: u64,
    pub memories: u64,
    pub memory_bits: u64,
}

impl Counts {
    pub fn of(top: &Rc<Module>) -> Counts {
        let mut counts = Counts::default();
        let live = Live::of(top);
        let needed = top.nodes.iter().zip(&live.nodes).filter(|(_, live)| **live);
        needed.for_each(|(node, _)| counts.add_node(node));
        for (memory, _) in top.memories.iter().zip(&live.memories).filter(|(_, live)| **live) {
            counts.memories += 1;
            counts.memory_bits += u64::from(memory.depth) * u64::from(memory.word.width());
        }
        for instance in &top.instances {
            counts = counts.plus(Counts::of(&instance.module));
        }
        counts
    }

    fn add_node(&mut self, node: &Node) {
        let width = u64::from(node.word.width());
        match &node.cell {
            Cell::Sum { terms, constant } => {
                let adders = (terms.len() + usize::from(*constant != 0)).saturating_sub(1) as u64;
                self.adders += adders;
                self.adder_bits += adders * width;
            }
            Cell::Select { .. } => {
                self.multiplexers += 1;
                self.multiplexer_bits += width;
            }
            Cell::Product { .. } => self.multipliers += 1,
            Cell::Compare { .. } => self.comparators += 1,
            Cell::Register { .. } | Cell::MemoryRead { .. } => {
                self.registers += 1;
                self.register_bits += width;
            }
            _ => {}
        }
    }

    fn plus(self, other: Counts) -> Counts {
        Counts {
            adders: self.adders + other.adders,
            adder_bits: self.adder_bits + other.adder_bits,
            multiplexers: self.multiplexers + other.multiplexers,
            multiplexer_bits: self.multiplexer_bits + other.multiplexer_bits,
            comparators: self.comparators + other.comparators,
            multipliers: self.multipliers + other.multipliers,
            registers: self.registers + other.registers,
            register_bits: self.register_bits + other.register_bits,
            memories: self.memories + other.memories,
            memory_bits: self.memory_bits + other.memory_bits,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn every_instance_counts() {
        let m = Builder::new("inner");
        let a = m.input("a", Word::signed(8));
        m.output("y", m.pipe("y", 3 * &a + 1));
        let inner = m.finish().unwrap();
        let m = Builder::new("outer");
        let a = m.input("a", Word::signed(8));
        for name in ["first", "second"] {
            let placed = m.instance(name, &inner, &[("a", &a)]);
            m.output(name.to_string() + "_y", placed.out("y"));
        }
        let counts = Counts::of(&m.finish().unwrap());
        // 3a + 1 = 4a - a + 1: two adders of ten bits.
        assert_eq!((counts.adders, counts.adder_bits, counts.register_bits), (4, 40, 20));
    }
}
