//! What an estimate is made from, counted in the flattened core.
//!
//! ```text
//!   from the outputs back      how many low bits of each word anybody reads: synthesis trims the others
//!   from the inputs on         how many of them are always 0: synthesis trims these too
//!   bits of each kind          adders, multiplexers, comparisons and logic, memory, registers
//!   registers to registers     levels of logic, carry, multipliers: of every path that no other one exceeds in all three
//! ```

use std::rc::Rc;

use super::Load;
use super::kept::Kept;
use crate::error::Result;
use crate::hdl::{Cell, Flat, Module, NodeId, Relation};

/// Memories up to this depth are made of LUTs, deeper ones are block RAM.
const LUT_MEMORY_DEPTH: u32 = 64;

/// Operand bits of one multiplier block.
const DSP_BITS: u32 = 18;

/// A path between registers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// LUTs in a row, an adder being one.
    pub levels: f64,
    /// Bits of the longest carry chain on it.
    pub carry: f64,
    pub multipliers: f64,
}

impl Path {
    fn within(&self, other: &Path) -> bool {
        self.levels <= other.levels && self.carry <= other.carry && self.multipliers <= other.multipliers
    }
}

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
        let mut features = Features { paths: paths(&flat, &kept), ..Features::default() };
        let mut steered = vec![0u64; flat.nodes.len()];
        for id in flat.order.iter().chain(&flat.clocked).copied().filter(|id| kept.bits(*id) > 0) {
            features.count(&flat, &kept, id);
            let width = u64::from(kept.bits(id));
            match &flat.node(id).cell {
                Cell::Select { condition, .. } => steered[condition.index()] += width,
                Cell::Register { enable: Some(enable), .. } => steered[enable.index()] += width,
                _ => {}
            }
        }
        features.fan_out = steered.into_iter().max().unwrap_or(0);
        for memory in flat.memories.iter().filter(|m| m.distributed || m.depth <= LUT_MEMORY_DEPTH) {
            let words = memory.depth.div_ceil(16);
            features.load.memory += f64::from(words * memory.word.width());
        }
        Ok(features)
    }

    fn count(&mut self, flat: &Flat, kept: &Kept, id: NodeId) {
        let width = f64::from(kept.bits(id));
        let full = |id: &NodeId| flat.node(*id).word.width();
        let constant = |id: &NodeId| matches!(flat.node(*id).cell, Cell::Constant(_));
        match &flat.node(id).cell {
            Cell::Sum { .. } => {
                let (operands, bits) = adder(flat, kept, id);
                if operands > 1 {
                    self.load.adder += bits;
                    self.load.further += bits * f64::from(operands - 2);
                }
            }
            Cell::Select { on_true, on_false, .. } => {
                if folds(flat, id) {
                    self.load.folded += width;
                } else if constant(on_true) || constant(on_false) {
                    self.load.logic += width;
                } else {
                    self.load.multiplexer += width;
                }
            }
            Cell::Compare { relation, left, right } => {
                let bits = f64::from(full(left).max(full(right)));
                let operands = if constant(left) || constant(right) { 1.0 } else { 2.0 };
                match relation {
                    Relation::Equal | Relation::NotEqual => self.load.logic += bits * operands / 3.0,
                    Relation::Less | Relation::LessOrEqual => self.load.adder += bits,
                }
            }
            Cell::Logic { operands, .. } => {
                self.load.logic += width * (operands.len() as f64 - 1.0) / 3.0;
            }
            Cell::Product { left, right } => {
                self.load.product += f64::from(full(left)) * f64::from(full(right));
                let blocks = |id| u64::from(full(id).div_ceil(DSP_BITS));
                self.dsps += blocks(left) * blocks(right);
            }
            Cell::Register { next, .. } => {
                self.register_bits += u64::from(kept.bits(id));
                if next.is_some_and(|next| stored(flat, next)) {
                    self.load.delay += width;
                }
            }
            Cell::MemoryRead { .. } => self.register_bits += u64::from(kept.bits(id)),
            _ => {}
        }
    }
}

/// The number of operands of a sum, and the bits in which at least two of them meet.
fn adder(flat: &Flat, kept: &Kept, id: NodeId) -> (u32, f64) {
    let Cell::Sum { terms, constant } = &flat.node(id).cell else { return (0, 0.0) };
    let mut starts: Vec<u32> = terms.iter().map(|term| term.shift + kept.zeros[term.of.index()]).collect();
    if *constant != 0 {
        starts.push(constant.trailing_zeros());
    }
    // A negative number alone is subtracted from zero.
    if starts.len() == 1 && terms.iter().any(|term| term.negate) {
        starts.push(starts[0]);
    }
    starts.sort_unstable();
    let second = starts.get(1).copied().unwrap_or(0);
    (starts.len() as u32, f64::from(kept.read[id.index()].saturating_sub(second)))
}

/// Whether a node is a choice of which one side is a sum of two numbers.
fn folds(flat: &Flat, id: NodeId) -> bool {
    let Cell::Select { on_true, on_false, .. } = &flat.node(id).cell else { return false };
    [on_true, on_false].into_iter().any(|side| {
        let mut id = *side;
        loop {
            match &flat.node(id).cell {
                Cell::Wrap { of } | Cell::Claim { of, .. } | Cell::Slice { of, .. } => id = *of,
                Cell::Sum { terms, constant: 0 } if terms.len() == 1 => id = terms[0].of,
                Cell::Sum { terms, constant } => {
                    return terms.len() + usize::from(*constant != 0) == 2;
                }
                _ => return false,
            }
        }
    })
}

/// Whether a node is a register, a memory or a port, or a part of one.
fn stored(flat: &Flat, mut id: NodeId) -> bool {
    loop {
        let cell = &flat.node(id).cell;
        match cell.wiring() {
            Some(of) => id = of,
            None => return matches!(cell, Cell::Register { .. } | Cell::MemoryRead { .. } | Cell::Input),
        }
    }
}

/// The longest paths between registers.
fn paths(flat: &Flat, kept: &Kept) -> Vec<Path> {
    let mut arrivals: Vec<Vec<Path>> = vec![vec![Path::default()]; flat.nodes.len()];
    for id in flat.order.iter().copied().filter(|id| kept.bits(*id) > 0) {
        let cell = &flat.node(id).cell;
        let (levels, carry, multipliers) = delay(flat, kept, id);
        let mut longest = vec![];
        for of in cell.combinational_inputs() {
            // A claim is no hardware.
            if matches!(cell, Cell::Claim { when: Some(when), .. } if *when == of) {
                continue;
            }
            for path in &arrivals[of.index()] {
                let path = Path {
                    levels: path.levels + levels,
                    carry: path.carry.max(carry),
                    multipliers: path.multipliers + multipliers,
                };
                keep(&mut longest, path);
            }
        }
        arrivals[id.index()] = longest;
    }
    let mut longest = vec![];
    let ends = flat.clocked.iter().filter(|id| kept.bits(**id) > 0);
    let ends = ends.flat_map(|id| flat.node(*id).cell.clocked_inputs());
    for id in ends.chain(flat.outputs.iter().map(|(_, id)| *id)) {
        arrivals[id.index()].iter().for_each(|path| keep(&mut longest, *path));
    }
    longest
}

/// Keeps a path unless another one exceeds it.
fn keep(longest: &mut Vec<Path>, path: Path) {
    if !longest.iter().any(|other| path.within(other)) {
        longest.retain(|other| !other.within(&path));
        longest.push(path);
    }
}

/// What a cell adds to a path: levels, carry, multipliers.
fn delay(flat: &Flat, kept: &Kept, id: NodeId) -> (f64, f64, f64) {
    let full = |id: &NodeId| f64::from(flat.node(*id).word.width());
    match &flat.node(id).cell {
        Cell::Sum { .. } => match adder(flat, kept, id) {
            (0 | 1, _) => (0.0, 0.0, 0.0),
            (operands, bits) => (f64::from(operands - 1), bits, 0.0),
        },
        Cell::Select { .. } if folds(flat, id) => (0.0, 0.0, 0.0),
        // Gates of one bit share LUTs: each takes the share of its inputs.
        Cell::Select { .. } if kept.bits(id) == 1 => (0.5, 0.0, 0.0),
        Cell::Select { .. } => (1.0, 0.0, 0.0),
        Cell::Compare { relation, left, right } => match relation {
            Relation::Equal | Relation::NotEqual => {
                let constant = |id: &NodeId| matches!(flat.node(*id).cell, Cell::Constant(_));
                let operands = if constant(left) || constant(right) { 1.0 } else { 2.0 };
                ((operands * full(left).min(full(right)).max(1.0)).log(4.0).max(0.25), 0.0, 0.0)
            }
            Relation::Less | Relation::LessOrEqual => (1.0, full(left).max(full(right)), 0.0),
        },
        Cell::Logic { operands, .. } => ((operands.len() as f64).log(8.0), 0.0, 0.0),
        Cell::Product { .. } => (0.0, 0.0, 1.0),
        _ => (0.0, 0.0, 0.0),
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
        assert_eq!(features.paths, [Path { levels: 1.0, carry: 8.0, multipliers: 0.0 }]);
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
        assert_eq!((features.load.adder, features.load.folded, features.load.multiplexer), (8.0, 8.0, 8.0));
        assert_eq!(features.fan_out, 16);
        assert_eq!(features.paths, [Path { levels: 2.0, carry: 8.0, multipliers: 0.0 }]);
    }
}
