//! What an estimate is made from, counted in the flattened core.
//!
//! ```text
//!   from the outputs back      how many low bits of each word anybody reads: synthesis trims the others
//!   from the inputs on         how many of them are always 0: synthesis trims these too
//!   bits of each kind          adders, gates in LUTs, choices behind adders, memory, registers
//!   registers to registers     adders, gates, carry, multipliers: of every path that no other one exceeds in all of them
//! ```

use std::rc::Rc;

use super::Load;
use super::cover::{Cover, read_outside, reads};
use super::gates::Gates;
use super::kept::Kept;
use super::paths::{Path, longest};
use super::sums::Adder;
use crate::error::Result;
use crate::hdl::{Cell, Flat, MadeOf, Memory, Module, NodeId};

/// Memories up to this depth are made of LUTs, deeper ones are block RAM.
const LUT_MEMORY_DEPTH: u32 = 64;

/// Bits of a word of one memory made of LUTs.
const MEMORY_BITS: u32 = 4;

/// Operand bits of one multiplier block.
const DSP_BITS: u32 = 18;

/// The counts of a core.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Bits, and blocks, of each kind.
    pub load: Load,
    pub register_bits: u64,
    pub dsps: u64,
    /// The paths that are longest in some respect.
    pub paths: Vec<Path>,
    /// Bits that the busiest bit of control steers.
    pub fan_out: u64,
}

impl Features {
    /// Counts a core.
    ///
    /// # Errors
    /// A combinational loop.
    pub fn of(core: &Rc<Module>) -> Result<Features> {
        let flat = Flat::new(core)?;
        let kept = Kept::of(&flat);
        let mut gates = Gates::of(&flat, &kept);
        let reads = reads(&flat, &kept, &gates);
        let outside = read_outside(&flat, &gates);
        let paths = longest(&flat, &kept, &gates, &reads, &outside);
        let cover = Cover::of(&flat, &kept, &mut gates, &reads, &outside);
        let mut features = Features { paths, ..Features::default() };
        features.load.gates = cover.gates.into();
        features.load.absorbed = cover.absorbed.into();
        features.load.delay = cover.delay.into();
        let mut steered = vec![0u64; flat.nodes.len()];
        for id in flat.order.iter().chain(&flat.clocked).copied().filter(|id| kept.bits(*id) > 0) {
            features.count(&flat, &kept, &gates, id);
            let width = u64::from(kept.bits(id));
            match &flat.node(id).cell {
                Cell::Select { condition, .. } => steered[condition.index()] += width,
                Cell::Register { enable: Some(enable), .. } => steered[enable.index()] += width,
                _ => {}
            }
        }
        features.fan_out = steered.into_iter().max().unwrap_or(0);
        let in_luts = |memory: &&Memory| match memory.made_of {
            MadeOf::Any => memory.depth <= LUT_MEMORY_DEPTH,
            MadeOf::LookupTables => true,
            MadeOf::BlockRam => false,
        };
        for memory in flat.memories.iter().filter(in_luts) {
            let words = memory.depth.div_ceil(16);
            features.load.memory += f64::from(words * memory.word.width().next_multiple_of(MEMORY_BITS));
        }
        Ok(features)
    }

    fn count(&mut self, flat: &Flat, kept: &Kept, gates: &Gates, id: NodeId) {
        let width = f64::from(kept.bits(id));
        let full = |id: &NodeId| flat.node(*id).word.width();
        match &flat.node(id).cell {
            Cell::Sum { .. } => {
                if let Some(adder) = Adder::of(flat, kept, id) {
                    self.load.adder += f64::from(adder.bits);
                    self.load.further += f64::from(adder.bits * (adder.operands - 2));
                }
            }
            Cell::Select { .. } if gates.folds.sum(id).is_some() => self.load.folded += width,
            Cell::Compare { left, right, .. } if gates.is_opaque(id) => {
                self.load.adder += f64::from(full(left).max(full(right)));
            }
            Cell::Product { left, right } => {
                self.load.product += f64::from(full(left)) * f64::from(full(right));
                let blocks = |id| u64::from(full(id).div_ceil(DSP_BITS));
                self.dsps += blocks(left) * blocks(right);
            }
            Cell::Register { .. } | Cell::MemoryRead { .. } => self.register_bits += u64::from(kept.bits(id)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn only_bits_that_are_read_are_counted() {
        let m = Builder::new("m");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(15)));
        let sum = m.pipe("sum", &a + &b);
        m.output("y", m.slice(&sum, 0, 8));
        let features = Features::of(&m.finish().unwrap()).unwrap();
        assert_eq!((features.load.adder, features.register_bits), (8.0, 8));
        assert_eq!(features.paths, [Path { adders: 1.0, carry: 8.0, ..Path::default() }]);
    }

    #[test]
    fn only_the_first_choice_behind_an_adder_is_part_of_it() {
        let m = Builder::new("m");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(7)));
        let choose = m.input("choose", Word::unsigned(1));
        let word = Word::signed(8);
        let (sum, wide) = (m.signal(&a + &b), m.wrap(&a, word));
        let chosen = m.select(&choose, &sum, &wide);
        m.output("y", m.pipe("y", m.select(&choose, &wide, &chosen)));
        let features = Features::of(&m.finish().unwrap()).unwrap();
        assert_eq!((features.load.adder, features.load.folded, features.load.gates), (8.0, 8.0, 8.0));
        assert_eq!(features.fan_out, 16);
        assert_eq!(features.paths, [Path { adders: 1.0, gates: 1.0, carry: 8.0, multipliers: 0.0 }]);
    }
}
