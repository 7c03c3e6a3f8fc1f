//! Skewed carry: the same module with every wide number in chunks, so that no carry is longer than a chunk.
//!
//! ```text
//! chunk 0  [13: 0]  clock t      ──► +  ──► register ──► ...
//!                                    │ carry, a register
//! chunk 1  [27:14]  clock t + 1  ──► +  ──► register ──► ...
//!                                    │ carry, a register
//! chunk 2  [41:28]  clock t + 2  ──► +  ──► register ──► ...
//! ```
//!
//! Chunk c of every number lives c clocks behind chunk 0: its adder takes the carry that the chunk below left in a
//! register, and its loads and enables come c clocks later, each from a register of its own. A recurrence still
//! makes one step a clock whatever its width; only the latency grows, by the chunks of the widest output. Inputs
//! are skewed and outputs brought back to one time here, so the module keeps its ports and what it computes.
//!
//! Single bits, which are loads, enables and choices, come a clock before the numbers that they belong to, so that every
//! chunk has them, and what is decided from them, out of a register of its own.
//!
//! A shift to the left takes bits that came earlier; one to the right waits for those that come later, after which
//! all chunks are that much later. Comparisons, logic and products take whole numbers.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::cell::{Cell, Node, NodeId, Term};
use super::live::Live;
use super::{Builder, Module, Signal, Word};
use crate::error::{Error, Result};

/// Clocks by which single bits at the inputs come before numbers.
pub const LEAD: u32 = 1;

/// Which wide ports keep their chunks skewed, so that two modules in chunks need nothing between them. Their clock is
/// that of chunk 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkewedPorts {
    pub inputs: bool,
    pub outputs: bool,
}

/// The module in chunks of `chunk` bits. Instances in it become part of it, and claims, which are proved of the
/// module as it was, turn into wires.
///
/// # Errors
/// Memories, wires that are used before they are driven, and state that depends on what comes later.
pub fn skew(module: &Rc<Module>, chunk: u32, ports: SkewedPorts) -> Result<Rc<Module>> {
    if chunk < 2 {
        return Err(Error::usage(format!("chunks of {chunk} bits")).help("choose 2 bits or more"));
    }
    // A register that depends on another one's higher bits lives later than that one. How much later is found by trying,
    // as it adds up along the way; a loop that would have to live later than itself ends the search.
    let mut late = BTreeMap::new();
    for _ in 0..=MOST_ROUNDS {
        let (skewed, later) = attempt(module, chunk, ports, late.clone())?;
        if later == late {
            return skewed.finish();
        }
        late = later;
    }
    Err(Error::usage(format!("{} has a loop that needs its own higher bits", module.name))
        .help("emit it without chunks"))
}

/// One try, with registers so many clocks late; what it finds of that.
fn attempt(module: &Rc<Module>, chunk: u32, ports: SkewedPorts, late: Late) -> Result<(Builder, Late)> {
    let m = Builder::new(&module.name);
    module.purpose.iter().for_each(|line| m.purpose(line));
    m.purpose(format!("Numbers in chunks of {chunk} bits, each a clock behind the one below it."));
    module.parameters.iter().for_each(|(name, value)| m.parameter(name, value));
    m.parameter("chunk", chunk);
    m.separate();
    let skew = Skew { m: &m, chunk, late: RefCell::new(late) };
    let inputs = module.inputs.iter().map(|&id| {
        let node = module.node(id);
        let name = node.name.clone().unwrap_or_default();
        let lead = if node.word.width() > 1 { LEAD } else { 0 };
        skew.split(&m.input_at(name, node.word, node.time.unwrap_or(0) + lead), ports.inputs)
    });
    let outputs = skew.module(module, inputs.collect(), 0, "")?;
    let last = outputs.iter().filter_map(Number::time).max().unwrap_or(0);
    for (output, number) in module.outputs.iter().zip(outputs) {
        if ports.outputs {
            let chunks = number.chunks.iter().zip(last..);
            let chunks = chunks.map(|(chunk, time)| m.restart(&m.at_time(chunk, time), last));
            m.output(&output.name, skew.whole(&Number { chunks: chunks.collect(), ..number }));
        } else {
            m.output(&output.name, skew.whole(&number));
        }
    }
    let late = skew.late.into_inner();
    Ok((m, late))
}

/// Registers that live later than their node's clock, by their names, and by how much.
type Late = BTreeMap<String, u32>;

/// Tries before a loop is given up.
const MOST_ROUNDS: u32 = 64;

/// A number as its chunks, lowest first, unsigned; chunk c comes c clocks after chunk 0. What logic makes is one chunk
/// of any width.
#[derive(Clone)]
struct Number {
    word: Word,
    /// Bits of a chunk.
    size: u32,
    chunks: Vec<Signal>,
}

impl Number {
    /// The clock of chunk 0; nothing for constants.
    fn time(&self) -> Option<u32> {
        let times =
            self.chunks.iter().zip(0..).filter_map(|(chunk, c)| Some(chunk.time()?.saturating_sub(c)));
        times.max()
    }
}

/// One operand of an adder: `± number * 2^shift`, or a constant.
enum Operand<'a> {
    Number { of: &'a Number, shift: u32, negate: bool },
    Constant(i128),
}

struct Skew<'a> {
    m: &'a Builder,
    chunk: u32,
    late: RefCell<Late>,
}

impl Skew<'_> {
    /// Translates the nodes of a module in their order; returns its outputs. `offset` is the clock of its inputs of
    /// time 0, `prefix` stands before its names.
    fn module(&self, module: &Module, inputs: Vec<Number>, offset: u32, prefix: &str) -> Result<Vec<Number>> {
        let live = Live::of(module).nodes;
        let mut numbers: Vec<Option<Number>> = vec![None; module.nodes.len()];
        for (&id, number) in module.inputs.iter().zip(inputs) {
            numbers[id.index()] = Some(number);
        }
        // State first: it is read before what it takes next is known.
        let state = |node: &Node| match &node.cell {
            Cell::Register { next: Some(next), enable, .. } => {
                enable.is_some() || node.time.is_none() || module.node(*next).time >= node.time
            }
            _ => false,
        };
        for (index, node) in module.nodes.iter().enumerate().filter(|(index, _)| live[*index]) {
            if state(node) {
                numbers[index] = Some(self.state(node, offset, prefix));
            }
        }
        let mut instances: Vec<Option<Vec<Number>>> = vec![None; module.instances.len()];
        for (index, node) in module.nodes.iter().enumerate().filter(|(index, _)| live[*index]) {
            if numbers[index].is_some() {
                continue;
            }
            let first = self.m.0.borrow().module.nodes.len();
            let number = match &node.cell {
                Cell::InstanceOutput { instance, port } => {
                    if instances[*instance].is_none() {
                        let inner = &module.instances[*instance];
                        let given = self.operands(module, &numbers, &inner.inputs)?;
                        let offset = offset + instance_offset(module, *instance);
                        let prefix = format!("{prefix}{}_", inner.name);
                        instances[*instance] = Some(self.module(&inner.module, given, offset, &prefix)?);
                    }
                    instances[*instance].as_ref().map(|outputs| outputs[*port].clone())
                }
                _ => Some(self.cell(module, NodeId(index as u32), &numbers, offset, prefix)?),
            };
            let named = !matches!(node.cell, Cell::InstanceOutput { .. });
            if let (true, Some(number), Some(name)) = (named, &number, &node.name) {
                self.name(number, &format!("{prefix}{name}"));
            }
            self.m.0.borrow_mut().module.nodes[first..].iter_mut().for_each(|new| new.place = node.place);
            numbers[index] = number;
        }
        for (index, node) in module.nodes.iter().enumerate().filter(|(index, _)| live[*index]) {
            if let (true, Some(register)) = (state(node), &numbers[index]) {
                self.close(module, node, register, &numbers, prefix)?;
            }
        }
        self.operands(module, &numbers, &module.outputs.iter().map(|o| o.node).collect::<Vec<_>>())
    }

    fn operands(&self, module: &Module, numbers: &[Option<Number>], ids: &[NodeId]) -> Result<Vec<Number>> {
        ids.iter().map(|&id| operand(module, numbers, id).cloned()).collect()
    }

    fn cell(
        &self,
        module: &Module,
        id: NodeId,
        numbers: &[Option<Number>],
        offset: u32,
        prefix: &str,
    ) -> Result<Number> {
        let (m, node) = (self.m, module.node(id));
        let of = |id: NodeId| operand(module, numbers, id);
        let word = node.word;
        Ok(match &node.cell {
            Cell::Constant(value) => {
                let chunk = |c| self.constant_bits(*value, c * self.chunk, self.size(word, c));
                Number { word, size: self.chunk, chunks: (0..self.count(word)).map(chunk).collect() }
            }
            Cell::Sum { terms, constant } => self.sum(terms, *constant, word, numbers, module)?,
            Cell::ShiftRight { of: id, amount, .. } => self.cut(of(*id)?, i64::from(*amount), word),
            Cell::Slice { of: id, low } => self.cut(of(*id)?, i64::from(*low), word),
            Cell::Wrap { of: id } | Cell::Claim { of: id, .. } => {
                let number = self.cut(of(*id)?, 0, word);
                match (module.node(*id).time, node.time) {
                    (Some(before), Some(now)) if before != now => self.restart(number, now + offset),
                    _ => number,
                }
            }
            Cell::Select { condition, on_true, on_false } => {
                let condition = &of(*condition)?.chunks[0];
                let [yes, no] = [*on_true, *on_false].map(|id| Ok(self.chunked(&self.cut(of(id)?, 0, word))));
                let [yes, no]: [Number; 2] = [yes?, no?];
                let start =
                    [condition.time(), yes.time(), no.time()].into_iter().flatten().max().unwrap_or(0);
                let chunks = yes.chunks.iter().zip(&no.chunks).zip(start..);
                let chunks = chunks.map(|((yes, no), time)| m.select(&m.at_time(condition, time), yes, no));
                self.settled(word, self.chunk, chunks.collect())
            }
            Cell::Register { next: Some(next), reset, .. } => {
                let next = self.cut(of(*next)?, 0, word);
                let name = node.name.clone().unwrap_or_else(|| "stage".into());
                let chunks = next.chunks.iter().zip(0..).map(|(chunk, c)| {
                    let name = self.label(&format!("{prefix}{name}"), c, next.chunks.len());
                    match reset {
                        None => m.pipe(name, chunk),
                        Some(reset) => {
                            let bits = (reset >> (c * next.size)) & ((1 << chunk.width()) - 1);
                            m.pipe_reset(name, chunk, bits)
                        }
                    }
                });
                self.settled(word, next.size, chunks.collect())
            }
            Cell::MemoryRead { .. } | Cell::Wire { .. } | Cell::Register { .. } => {
                let what = module.describe(id);
                return Err(Error::usage(format!("{what} in a module that is to be emitted in chunks"))
                    .at(module.place(id))
                    .help("keep memories and forward wires outside of it"));
            }
            cell => {
                let mut cell = cell.clone();
                let mut signals = vec![];
                for id in cell.combinational_inputs() {
                    signals.push(self.whole(of(id)?));
                }
                let time = m.align(&mut signals);
                let mut next = signals.iter();
                cell.visit_mut(|id| *id = next.next().map_or(*id, |signal| signal.id));
                let made = m.add(cell, word, time);
                let bits = if word.is_signed() { m.slice(&made, 0, word.width()) } else { made };
                Number { word, size: word.width(), chunks: vec![bits] }
            }
        })
    }

    // ---- sums ----------------------------------------------------------------------------------------

    fn sum(
        &self,
        terms: &[Term],
        constant: i128,
        word: Word,
        numbers: &[Option<Number>],
        module: &Module,
    ) -> Result<Number> {
        if let ([Term { negate: false, shift, of }], 0) = (terms, constant) {
            return Ok(self.cut(operand(module, numbers, *of)?, -i64::from(*shift), word));
        }
        // -x is the inverted bits of x, and one more.
        let negated = terms.iter().filter(|term| term.negate).count() as i128;
        let carry = negated > 0;
        let rest = constant + negated - i128::from(carry);
        let mut operands = vec![];
        for term in terms {
            let of = operand(module, numbers, term.of)?;
            operands.push(Operand::Number { of, shift: term.shift, negate: term.negate });
        }
        if rest != 0 || operands.len() < 2 {
            operands.push(Operand::Constant(rest));
        }
        let (first, others) = operands.split_at(2);
        let mut sum = self.add(&first[0], &first[1], carry, word);
        for other in others {
            let of = sum;
            sum = self.add(&Operand::Number { of: &of, shift: 0, negate: false }, other, false, word);
        }
        Ok(sum)
    }

    /// Two operands and a carry, modulo the word's width.
    fn add(&self, a: &Operand, b: &Operand, carry: bool, word: Word) -> Number {
        let (m, one) = (self.m, self.m.bit(true));
        let mut carry = carry.then(|| one.clone());
        let (mut chunks, count) = (vec![], self.count(word));
        for c in 0..count {
            let size = self.size(word, c);
            let [a, b] = [a, b].map(|operand| self.digit(operand, c, size));
            // The carry enters through a bit below the lowest, which the carry chain does not leave.
            let (a, b, low) = match &carry {
                Some(carry) => (m.concat(&[&a, &one]), m.concat(&[&b, carry]), 1),
                None => (a, b, 0),
            };
            let last = c + 1 == count;
            let sum = m.wrap(&a + &b, Word::unsigned(size + low + u32::from(!last)));
            chunks.push(m.slice(&sum, low, size));
            if !last {
                carry = Some(m.pipe("carry", m.slice(&sum, low + size, 1)));
            }
        }
        self.settled(word, self.chunk, chunks)
    }

    /// Bits of an operand that add to chunk c of a sum.
    fn digit(&self, operand: &Operand, c: u32, size: u32) -> Signal {
        let low = c * self.chunk;
        match *operand {
            Operand::Constant(value) => self.constant_bits(value, low, size),
            Operand::Number { of, shift, negate } => {
                let bits = self.bits(of, i64::from(low) - i64::from(shift), size);
                if negate { !&bits } else { bits }
            }
        }
    }

    // ---- state ---------------------------------------------------------------------------------------

    /// The registers of the chunks, not yet given a value.
    fn state(&self, node: &Node, offset: u32, prefix: &str) -> Number {
        let (word, count) = (node.word, self.count(node.word));
        let Cell::Register { reset, .. } = node.cell else {
            return Number { word, size: self.chunk, chunks: vec![] };
        };
        let name = format!("{prefix}{}", node.name.as_deref().unwrap_or("state"));
        let late = self.late.borrow().get(&name).copied().unwrap_or(0);
        let chunk = |c: u32| {
            let size = self.size(word, c);
            let reset = reset.map(|value| (value >> (c * self.chunk)) & ((1 << size) - 1));
            let lead = if word.width() > 1 { LEAD } else { 0 };
            let time = node.time.unwrap_or(0) + offset + lead + late + c;
            let cell = Cell::Register { next: None, enable: None, reset };
            let register = self.m.add(cell, Word::unsigned(size), Some(time));
            self.m.rename(&register, self.label(&name, c, count as usize));
            self.m.0.borrow_mut().module.nodes[register.id.index()].place = node.place;
            register
        };
        Number { word, size: self.chunk, chunks: (0..count).map(chunk).collect() }
    }

    /// Gives the registers what they take.
    fn close(
        &self,
        module: &Module,
        node: &Node,
        state: &Number,
        numbers: &[Option<Number>],
        prefix: &str,
    ) -> Result<()> {
        let Cell::Register { next: Some(next), enable, .. } = &node.cell else { return Ok(()) };
        let next = self.chunked(&self.cut(operand(module, numbers, *next)?, 0, node.word));
        let enable = enable.map(|id| operand(module, numbers, id).cloned()).transpose()?;
        let wanted = next.time().max(enable.as_ref().and_then(Number::time)).unwrap_or(0);
        let behind = wanted.saturating_sub(state.time().unwrap_or(0));
        if behind > 0 {
            let name = format!("{prefix}{}", node.name.as_deref().unwrap_or("state"));
            *self.late.borrow_mut().entry(name).or_default() += behind;
            return Ok(());
        }
        for (register, chunk) in state.chunks.iter().zip(&next.chunks) {
            let time = register.time().unwrap_or(0);
            let chunk = self.m.at_time(chunk, time);
            let enable = enable.as_ref().map(|enable| self.m.at_time(&enable.chunks[0], time).id);
            if let Cell::Register { next, enable: e, .. } =
                &mut self.m.0.borrow_mut().module.nodes[register.id.index()].cell
            {
                (*next, *e) = (Some(chunk.id), enable);
            }
        }
        Ok(())
    }

    // ---- chunks --------------------------------------------------------------------------------------

    fn count(&self, word: Word) -> u32 {
        word.width().div_ceil(self.chunk).max(1)
    }

    /// Bits of chunk c of a word.
    fn size(&self, word: Word, c: u32) -> u32 {
        (word.width() - c * self.chunk).min(self.chunk)
    }

    fn label(&self, name: &str, c: u32, count: usize) -> String {
        if count > 1 { format!("{name}_c{c}") } else { name.to_string() }
    }

    fn name(&self, number: &Number, name: &str) {
        for (chunk, c) in number.chunks.iter().zip(0..) {
            if chunk.name().is_none() && chunk.time().is_some() {
                self.m.rename(chunk, self.label(name, c, number.chunks.len()));
            }
        }
    }

    fn constant_bits(&self, value: i128, low: u32, size: u32) -> Signal {
        self.m.constant((value >> low.min(127)) & ((1 << size) - 1), Word::unsigned(size))
    }

    /// Bits `low .. low + size` of a number, zeros below it and its sign or zeros above.
    fn bits(&self, number: &Number, low: i64, size: u32) -> Signal {
        let (m, width, size_of) = (self.m, i64::from(number.word.width()), i64::from(number.size));
        let (high, mut at, mut parts) = (low + i64::from(size), low, vec![]);
        while at < high {
            let end = if at < 0 {
                high.min(0)
            } else if at < width {
                high.min(width).min((at / size_of + 1) * size_of)
            } else {
                high
            };
            let count = (end - at) as u32;
            if at < 0 || (at >= width && !number.word.is_signed()) {
                parts.push(m.constant(0, Word::unsigned(count)));
            } else if at < width {
                let chunk = &number.chunks[(at / size_of) as usize];
                let inside = (at % size_of) as u32;
                let whole = inside == 0 && count == chunk.width();
                parts.push(if whole { chunk.clone() } else { m.slice(chunk, inside, count) });
            } else if let Some(top) = number.chunks.last() {
                let sign = m.slice(top, top.width() - 1, 1);
                parts.extend(std::iter::repeat_n(sign, count as usize));
            }
            at = end;
        }
        match parts.as_slice() {
            [only] => only.clone(),
            _ => m.concat(&parts.iter().rev().collect::<Vec<_>>()),
        }
    }

    /// The number shifted right by `low` bits, in another word.
    fn cut(&self, number: &Number, low: i64, word: Word) -> Number {
        if number.size > self.chunk && number.chunks.len() == 1 {
            return Number { word, size: word.width(), chunks: vec![self.bits(number, low, word.width())] };
        }
        let chunk = |c| self.bits(number, low + i64::from(c * self.chunk), self.size(word, c));
        self.settled(word, self.chunk, (0..self.count(word)).map(chunk).collect())
    }

    /// The number in chunks of the usual size.
    fn chunked(&self, number: &Number) -> Number {
        if number.size <= self.chunk {
            return number.clone();
        }
        let chunk = |c| self.bits(number, i64::from(c * self.chunk), self.size(number.word, c));
        self.settled(number.word, self.chunk, (0..self.count(number.word)).map(chunk).collect())
    }

    /// Chunks brought to their clocks: each one clock after the one below.
    fn settled(&self, word: Word, size: u32, chunks: Vec<Signal>) -> Number {
        let number = Number { word, size, chunks };
        let Some(start) = number.time() else { return number };
        let chunks = number.chunks.iter().zip(start..).map(|(chunk, time)| self.m.at_time(chunk, time));
        Number { word, size, chunks: chunks.collect() }
    }

    fn restart(&self, number: Number, time: u32) -> Number {
        let chunks = number.chunks.iter().zip(time..).map(|(chunk, time)| self.m.restart(chunk, time));
        Number { chunks: chunks.collect(), ..number }
    }

    /// The chunks of a signal whose bits come all at once, or each chunk a clock later already.
    fn split(&self, signal: &Signal, skewed: bool) -> Number {
        let (m, word) = (self.m, signal.word());
        let count = self.count(word);
        let chunk = |c: u32| {
            let size = self.size(word, c);
            let plain = count == 1 && !word.is_signed();
            let bits = if plain { signal.clone() } else { m.slice(signal, c * self.chunk, size) };
            match (skewed, bits.time()) {
                (true, Some(time)) => m.restart(&bits, time + c),
                _ => m.delay(&bits, c),
            }
        };
        Number { word, size: self.chunk, chunks: (0..count).map(chunk).collect() }
    }

    /// All bits of a number at one time: that of its highest chunk.
    fn whole(&self, number: &Number) -> Signal {
        let m = self.m;
        let bits = match number.chunks.as_slice() {
            [only] => only.clone(),
            chunks => m.concat(&chunks.iter().rev().collect::<Vec<_>>()),
        };
        if bits.word() == number.word {
            bits
        } else {
            m.add(Cell::Wrap { of: bits.id }, number.word, bits.time())
        }
    }
}

fn operand<'a>(module: &Module, numbers: &'a [Option<Number>], id: NodeId) -> Result<&'a Number> {
    numbers[id.index()].as_ref().ok_or_else(|| {
        Error::usage(format!("{} is used before it is driven", module.describe(id))).at(module.place(id))
    })
}

/// The clock of an instance's inputs of time 0.
fn instance_offset(module: &Module, instance: usize) -> u32 {
    let Module { instances, .. } = module;
    let inner = &instances[instance];
    let late = inner.module.inputs.iter().zip(&inner.inputs).map(|(&port, &given)| {
        let (port, given) = (inner.module.node(port).time, module.node(given).time);
        given.unwrap_or(0).saturating_sub(port.unwrap_or(0))
    });
    late.max().unwrap_or(0)
}
