//! The built-in simulator: cycle by cycle, over whatever flows through the wires.
//!
//! It is generic over a [`Domain`]: integers make it a simulator, exact linear forms make it a prover.
//! Both walk the same cells as the Verilog printer. A cell is evaluated only after something it reads has
//! changed, so parts of a design that rest cost next to nothing.

use super::Word;
use super::cell::{Bitwise, Cell, NodeId, Relation};
use super::flat::Flat;
use super::module::MemoryWrite;
use crate::error::{Error, Result};
use crate::fixed::Range;

/// What flows through the wires.
pub trait Domain {
    type Value: Clone + PartialEq;

    /// What a register without a reset, or a word of a RAM, holds at first.
    fn unset(&self) -> Self::Value;
    fn integer(&self, value: i128) -> Self::Value;
    /// The integer, where the value is one: addresses and conditions must be.
    fn as_integer(&self, value: &Self::Value) -> Option<i128>;
    /// The value of a combinational cell.
    fn evaluate(&mut self, flat: &Flat, id: NodeId, values: &[Self::Value]) -> Self::Value;
    /// What a register of this word holds after being given the value.
    fn latch(&self, word: Word, value: &Self::Value) -> Self::Value;
}

/// A design with its state.
pub struct Simulator<D: Domain> {
    pub flat: Flat,
    pub domain: D,
    values: Vec<D::Value>,
    memories: Vec<Vec<D::Value>>,
    /// Whether something that the node reads has changed since it was last evaluated.
    stale: Vec<bool>,
    /// Who reads a node: `readers[starts[id] .. starts[id + 1]]`.
    readers: Vec<u32>,
    starts: Vec<u32>,
    /// What the clocked nodes take at the edge, gathered before any of them changes.
    next: Vec<(NodeId, D::Value)>,
    clock: u64,
}

impl<D: Domain> Simulator<D> {
    pub fn new(flat: Flat, domain: D) -> Self {
        let mut values = vec![domain.unset(); flat.nodes.len()];
        for (node, value) in flat.nodes.iter().zip(&mut values) {
            if let Cell::Constant(constant) = node.node.cell {
                *value = domain.integer(constant);
            }
        }
        let memories = flat
            .memories
            .iter()
            .map(|m| {
                let mut words = vec![domain.unset(); m.depth as usize];
                m.contents.iter().zip(&mut words).for_each(|(&c, word)| *word = domain.integer(c));
                words
            })
            .collect();
        let (readers, starts) = readers(&flat);
        let stale = vec![true; flat.nodes.len()];
        Simulator { flat, domain, values, memories, stale, readers, starts, next: vec![], clock: 0 }
    }

    /// Rising edges so far.
    pub fn clock_count(&self) -> u64 {
        self.clock
    }

    /// Puts a value on an input; [`Simulator::settle`] lets it through.
    pub fn set(&mut self, input: NodeId, value: D::Value) {
        self.change(input, value);
    }

    fn change(&mut self, id: NodeId, value: D::Value) {
        let slot = &mut self.values[id.index()];
        if *slot != value {
            *slot = value;
            let (from, to) = (self.starts[id.index()] as usize, self.starts[id.index() + 1] as usize);
            for &reader in &self.readers[from..to] {
                self.stale[reader as usize] = true;
            }
        }
    }

    /// Puts a value into a word of a memory, by the memory's number in the flat design.
    pub fn set_word(&mut self, memory: usize, address: usize, value: D::Value) {
        if let Some(word) = self.memories.get_mut(memory).and_then(|words| words.get_mut(address)) {
            *word = value;
        }
    }

    pub fn get(&self, id: NodeId) -> &D::Value {
        &self.values[id.index()]
    }

    /// Evaluates all combinational cells that something has changed for.
    pub fn settle(&mut self) {
        for index in 0..self.flat.order.len() {
            let id = self.flat.order[index];
            if std::mem::replace(&mut self.stale[id.index()], false) {
                let value = self.domain.evaluate(&self.flat, id, &self.values);
                self.change(id, value);
            }
        }
    }

    /// One rising clock edge, with the reset active or not. Call after [`Simulator::settle`].
    ///
    /// While the reset is active, control may still be unset: what it steers is unset then, too.
    pub fn edge(&mut self, reset: bool) -> Result<()> {
        self.clock += 1;
        let mut next = std::mem::take(&mut self.next);
        for &id in &self.flat.clocked {
            let node = self.flat.node(id);
            // A register that took, or did not take, the same value at the last edge will not change. A
            // memory read may, as its memory is written.
            let resting = !std::mem::replace(&mut self.stale[id.index()], reset);
            if resting && matches!(node.cell, Cell::Register { .. }) {
                continue;
            }
            let (enable, value) = match &node.cell {
                Cell::Register { reset: Some(value), .. } if reset => {
                    next.push((id, self.domain.integer(*value)));
                    continue;
                }
                Cell::Register { next: Some(source), enable, .. } => (*enable, *source),
                Cell::MemoryRead { address, enable, .. } => (*enable, *address),
                _ => continue,
            };
            let enabled = match self.enabled(enable, id) {
                Ok(enabled) => enabled,
                Err(_) if reset => {
                    next.push((id, self.domain.unset()));
                    continue;
                }
                Err(error) => return Err(error),
            };
            if !enabled {
                continue;
            }
            let taken = match &node.cell {
                Cell::MemoryRead { memory, .. } => match self.integer(value, id) {
                    Ok(address) if self.collides(*memory, address) => None,
                    Ok(address) => self.memories[*memory].get(address as usize).cloned(),
                    Err(_) if reset => None,
                    Err(error) => return Err(error),
                },
                _ => Some(self.domain.latch(node.word, &self.values[value.index()])),
            };
            next.push((id, taken.unwrap_or_else(|| self.domain.unset())));
        }
        for (index, memory) in self.flat.memories.iter().enumerate() {
            let Some(write) = &memory.write else { continue };
            let target = match self.written(write) {
                Ok(target) => target,
                Err(_) if reset => None,
                Err(error) => return Err(error),
            };
            if let Some(word) = target.and_then(|address| self.memories[index].get_mut(address as usize)) {
                *word = self.values[write.data.index()].clone();
            }
        }
        for (id, value) in next.drain(..) {
            self.change(id, value);
        }
        self.next = next;
        Ok(())
    }

    /// The address at which a memory takes a word at the next edge.
    fn written(&self, write: &MemoryWrite) -> Result<Option<i128>> {
        let enabled = self.enabled(Some(write.enable), write.data)?;
        if enabled { self.integer(write.address, write.data).map(Some) } else { Ok(None) }
    }

    /// Whether the word of a memory is written at the next edge, where reads and writes should be apart.
    fn collides(&self, memory: usize, address: i128) -> bool {
        let memory = &self.flat.memories[memory];
        let write = memory.write.as_ref().filter(|_| memory.apart);
        write.is_some_and(|write| matches!(self.written(write), Ok(Some(written)) if written == address))
    }

    fn enabled(&self, enable: Option<NodeId>, of: NodeId) -> Result<bool> {
        enable.map_or(Ok(true), |enable| Ok(self.integer(enable, of)? != 0))
    }

    fn integer(&self, control: NodeId, of: NodeId) -> Result<i128> {
        self.domain.as_integer(&self.values[control.index()]).ok_or_else(|| {
            let (control, of) = (self.flat.describe(control), self.flat.describe(of));
            Error::usage(format!("at clock {}, {control} steers {of} but depends on data", self.clock))
                .help("control that depends on data cannot be proved by linear forms; reset what is not set")
        })
    }
}

fn readers(flat: &Flat) -> (Vec<u32>, Vec<u32>) {
    let mut lists: Vec<Vec<u32>> = vec![vec![]; flat.nodes.len()];
    for (reader, node) in flat.nodes.iter().enumerate() {
        let cell = &node.node.cell;
        for read in cell.combinational_inputs().into_iter().chain(cell.clocked_inputs()) {
            lists[read.index()].push(reader as u32);
        }
    }
    let mut starts = vec![0];
    starts.extend(lists.iter().scan(0, |sum, list| {
        *sum += list.len() as u32;
        Some(*sum)
    }));
    (lists.concat(), starts)
}

impl Simulator<Integers> {
    /// The integer at the n-th node of the flat design.
    pub fn value_at(&self, index: usize) -> i128 {
        self.values[index]
    }

    /// Noise in every register and in every word of RAM, as when the power comes on: who relies on a state
    /// that no reset sets is seen. The seed decides.
    pub fn scramble(&mut self, seed: u64) {
        let mut state = seed;
        // Two steps of Vigna's splitmix64.
        let mut noise = |range: Range| {
            let mut half = || {
                state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                mixed ^ (mixed >> 31)
            };
            range.wrap((u128::from(half()) << 64 | u128::from(half())) as i128)
        };
        for index in 0..self.flat.clocked.len() {
            let id = self.flat.clocked[index];
            self.change(id, noise(self.flat.node(id).word.range));
        }
        for (memory, words) in self.flat.memories.iter().zip(&mut self.memories) {
            // The contents of a memory are there when the power comes on.
            words.iter_mut().skip(memory.contents.len()).for_each(|word| *word = noise(memory.word.range));
        }
    }
}

/// Plain integers: exactly what the emitted Verilog does.
pub struct Integers;

impl Domain for Integers {
    type Value = i128;

    fn unset(&self) -> i128 {
        0
    }
    fn integer(&self, value: i128) -> i128 {
        value
    }
    fn as_integer(&self, value: &i128) -> Option<i128> {
        Some(*value)
    }

    fn evaluate(&mut self, flat: &Flat, id: NodeId, values: &[i128]) -> i128 {
        Integers::evaluate_with(flat, id, |id| values[id.index()])
    }

    fn latch(&self, word: Word, value: &i128) -> i128 {
        if word.modular { word.range.wrap(*value) } else { *value }
    }
}

impl Integers {
    /// The rule of every combinational cell, given the numbers of its operands.
    #[inline]
    pub(super) fn evaluate_with(flat: &Flat, id: NodeId, value: impl Fn(NodeId) -> i128) -> i128 {
        let node = flat.node(id);
        let range = node.word.range;
        match &node.cell {
            Cell::Constant(constant) => *constant,
            Cell::Sum { terms, constant } => {
                let sum = terms.iter().fold(*constant, |sum, term| {
                    let shifted = value(term.of).wrapping_shl(term.shift);
                    if term.negate { sum.wrapping_sub(shifted) } else { sum.wrapping_add(shifted) }
                });
                // Outside of the range only in a modular word, or behind a fault: as many bits as there are.
                if range.contains(Range::point(sum)) { sum } else { range.wrap(sum) }
            }
            Cell::Product { left, right } => value(*left).wrapping_mul(value(*right)),
            Cell::ShiftRight { of, amount, .. } => value(*of) >> amount,
            Cell::Wrap { of } | Cell::Claim { of, .. } => range.wrap(value(*of)),
            Cell::Select { condition, on_true, on_false } => {
                let chosen = value(if value(*condition) != 0 { *on_true } else { *on_false });
                if node.word.modular { range.wrap(chosen) } else { chosen }
            }
            Cell::Compare { relation, left, right } => {
                let (left, right) = (value(*left), value(*right));
                i128::from(match relation {
                    Relation::Equal => left == right,
                    Relation::NotEqual => left != right,
                    Relation::Less => left < right,
                    Relation::LessOrEqual => left <= right,
                })
            }
            Cell::Logic { operation, operands } => {
                let bits = operands.iter().map(|&id| value(id));
                match operation {
                    Bitwise::And => bits.fold(-1, |a, b| a & b),
                    Bitwise::Or => bits.fold(0, |a, b| a | b),
                    Bitwise::Xor => bits.fold(0, |a, b| a ^ b),
                }
            }
            Cell::Not { of } => range.wrap(!value(*of)),
            Cell::Slice { of, low } => range.wrap(value(*of) >> low),
            Cell::Concat { parts } => parts.iter().fold(0, |bits, &part| {
                let word = flat.node(part).word;
                (bits << word.width()) | Range::unsigned(word.width()).wrap(value(part))
            }),
            // Not combinational: their values are set at the clock edge or from outside.
            Cell::Input | Cell::Wire { .. } | Cell::Register { .. } => value(id),
            Cell::MemoryRead { .. } | Cell::InstanceOutput { .. } => value(id),
        }
    }
}
