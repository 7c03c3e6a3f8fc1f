//! Time: registers, pipeline stages, delays and memories.

use super::cell::{Cell, NodeId};
use super::expression::{Expr, Signal, Sum};
use super::module::{MadeOf, Memory, MemoryWrite};
use super::{Builder, Word};
use crate::error::Error;
use crate::fixed::Range;

impl Builder {
    /// A register that holds its value until [`Builder::on`] or [`Builder::always`] gives it another.
    #[track_caller]
    pub fn register(&self, name: impl Into<String>, word: Word) -> Signal {
        self.register_at(name, word, None, 0)
    }

    /// A register that takes `reset` while the reset is active.
    #[track_caller]
    pub fn register_reset(&self, name: impl Into<String>, word: Word, reset: i128) -> Signal {
        self.register_at(name, word, Some(reset), 0)
    }

    #[track_caller]
    pub fn register_at(&self, name: impl Into<String>, word: Word, reset: Option<i128>, time: u32) -> Signal {
        let register = self.add(Cell::Register { next: None, enable: None, reset }, word, Some(time));
        self.rename(&register, name.into());
        self.check_reset(&register, reset);
        self.0.borrow_mut().clauses.insert(register.id, vec![]);
        register
    }

    /// What is derived from a register's range must hold after a reset, too.
    #[track_caller]
    fn check_reset(&self, register: &Signal, reset: Option<i128>) {
        let word = register.word();
        if let Some(reset) = reset.filter(|&value| !word.range.contains(Range::point(value))) {
            self.fail(|m| {
                Error::usage(format!(
                    "register {} is {word}, but its reset is {reset}",
                    m.describe(register.id)
                ))
                .help("reset it to a number of its range, or widen the register")
            });
        }
    }

    /// At an edge where `condition` is 1, and no clause given before for this register applies, the
    /// register takes `value`.
    #[track_caller]
    pub fn on(&self, condition: &Signal, register: &Signal, value: impl Into<Expr>) {
        self.clause(Some(condition), register, value.into());
    }

    /// At every edge where no clause given before applies, the register takes `value`.
    #[track_caller]
    pub fn always(&self, register: &Signal, value: impl Into<Expr>) {
        self.clause(None, register, value.into());
    }

    #[track_caller]
    fn clause(&self, condition: Option<&Signal>, register: &Signal, value: Expr) {
        let value = self.signal(value);
        let (have, want) = (value.word(), register.word());
        let agrees = match (have.modular, want.modular) {
            (true, false) => false,
            (true, true) => have.width() >= want.width(),
            (false, true) => true,
            (false, false) => want.range.contains(have.range),
        };
        if !agrees || (have.fraction != want.fraction && !matches!(value.cell(), Cell::Constant(_))) {
            self.fail(|m| {
                let (register, value) = (m.describe(register.id), m.describe(value.id));
                Error::usage(format!("register {register} is {want}, but {value} that it takes is {have}"))
                    .help("widen the register, wrap the value, or claim its range so that it is proved")
            });
        }
        let time = register.time();
        for signal in condition.into_iter().chain([&value]) {
            if signal.time().is_some_and(|t| Some(t) != time) {
                self.fail(|m| {
                    let (register, signal) = (m.describe(register.id), m.describe(signal.id));
                    Error::usage(format!(
                        "register {register} of clock {time:?} takes {signal} of another clock"
                    ))
                    .help("a register that keeps state lives in one clock; delay or restart the signal")
                });
            }
        }
        if let Some(clauses) = self.0.borrow_mut().clauses.get_mut(&register.id) {
            clauses.push((condition.map(|c| c.id), value.id));
        }
    }

    /// Turns the clauses of every register into one next value and one enable.
    pub(super) fn resolve_registers(&self) {
        let clauses = std::mem::take(&mut self.0.borrow_mut().clauses);
        for (id, clauses) in clauses {
            let signal = |id| Signal { builder: self.clone(), id };
            let decisive = clauses.iter().position(|(c, _)| c.is_none()).map_or(clauses.len(), |p| p + 1);
            let Some(((_, last), earlier)) = clauses[..decisive].split_last() else { continue };
            let mut next = signal(*last);
            for (condition, value) in earlier.iter().rev() {
                if let Some(condition) = condition {
                    next = self.select(&signal(*condition), signal(*value), &next);
                }
            }
            let conditions: Vec<Signal> =
                clauses[..decisive].iter().filter_map(|(c, _)| c.map(signal)).collect();
            let enable = match conditions.len() {
                n if n < decisive => None,
                1 => Some(conditions[0].id),
                _ => Some(self.any(&conditions.iter().collect::<Vec<_>>()).id),
            };
            let place = self.node(id, |n| n.place);
            let mut state = self.0.borrow_mut();
            for node in state.module.nodes.iter_mut().rev().take(2 * clauses.len()) {
                if node.place.file() == file!() {
                    node.place = place;
                }
            }
            if let Cell::Register { next: n, enable: e, .. } = &mut state.module.nodes[id.index()].cell {
                (*n, *e) = (Some(next.id), enable);
            }
        }
    }

    /// The value one clock later, under a name: a pipeline stage.
    #[track_caller]
    pub fn pipe(&self, name: impl Into<String>, value: impl Into<Expr>) -> Signal {
        let value = self.signal(value);
        let time = value.time().unwrap_or(0) + 1;
        let cell = Cell::Register { next: Some(value.id), enable: None, reset: None };
        let register = self.add(cell, value.word(), Some(time));
        self.rename(&register, name.into());
        register
    }

    /// A pipeline stage of its own, where one register could not reach all that read it within a clock: synthesis
    /// is told not to merge it with others that take the same value.
    #[track_caller]
    pub fn copy(&self, name: impl Into<String>, value: impl Into<Expr>) -> Signal {
        self.unmerged(self.pipe(name, value))
    }

    /// The register, which synthesis is told not to merge with others.
    pub fn unmerged(&self, register: Signal) -> Signal {
        self.0.borrow_mut().module.copies.insert(register.id);
        register
    }

    /// A pipeline stage that takes `reset` while the reset is active.
    #[track_caller]
    pub fn pipe_reset(&self, name: impl Into<String>, value: impl Into<Expr>, reset: i128) -> Signal {
        let register = self.pipe(name, value);
        self.check_reset(&register, Some(reset));
        if let Cell::Register { reset: r, .. } =
            &mut self.0.borrow_mut().module.nodes[register.id.index()].cell
        {
            *r = Some(reset);
        }
        register
    }

    /// The signal `clocks` later, through registers that take `reset` while the reset is active.
    #[track_caller]
    pub fn delay_reset(&self, signal: &Signal, clocks: u32, reset: i128) -> Signal {
        let base = signal.name().unwrap_or_else(|| "delayed".into());
        (1..=clocks).fold(signal.clone(), |s, nth| self.pipe_reset(format!("{base}_r{nth}"), &s, reset))
    }

    /// A sum as a balanced tree of two-operand adders with a register behind each: one adder per clock
    /// whatever the number of terms. Operands that come early are added first.
    #[track_caller]
    pub fn pipelined(&self, name: &str, sum: impl Into<Sum>) -> Signal {
        let sum = sum.into();
        let place = sum.place;
        let terms = self.shifted_terms(&sum);
        let mut open: Vec<(Sum, u32)> =
            terms.into_iter().map(|(c, s)| (c * &s, s.time().unwrap_or(0))).collect();
        let mut constant = sum.constant;
        let mut number = 0;
        loop {
            open.sort_by_key(|(_, time)| *time);
            let (a, b) = match open.len() {
                0 => return self.signal(Sum::from(constant)),
                1 => (open.remove(0).0, None),
                _ => (open.remove(0).0, Some(open.remove(0).0)),
            };
            // The constant goes in with the last adder but one operand, where it is free of its own.
            let last = open.is_empty();
            // Two operands to be subtracted are added, and their sum is subtracted later.
            let negative = |sum: &Sum| sum.terms.iter().all(|(coefficient, _)| *coefficient < 0);
            let later = !last && negative(&a) && b.as_ref().is_some_and(negative);
            let mut sum = match b {
                Some(b) if later => -a - b,
                Some(b) => a + b,
                None => a,
            };
            sum.place = place;
            let sum = if last { sum + std::mem::take(&mut constant) } else { sum };
            let label = if last { name.to_string() } else { format!("{name}_part{number}") };
            let part = self.pipe(label, sum);
            if last {
                return part;
            }
            number += 1;
            let sum = if later { -&part } else { Sum::from(&part) };
            open.push((sum, part.time().unwrap_or(0)));
        }
    }

    /// The signal `clocks` later; delays of one signal are shared.
    #[track_caller]
    pub fn delay(&self, signal: &Signal, clocks: u32) -> Signal {
        let base = signal.name().unwrap_or_else(|| "delayed".into());
        self.delay_named(signal, clocks, &base, 1)
    }

    #[track_caller]
    fn delay_named(&self, signal: &Signal, clocks: u32, base: &str, nth: u32) -> Signal {
        if clocks == 0 || signal.time().is_none() {
            return signal.clone();
        }
        // Wiring costs nothing on either side of a register: what it comes from is delayed, once for all.
        if let (Some(of), true) = (signal.cell().wiring(), signal.name().is_none()) {
            let source = self.delay(&Signal { builder: self.clone(), id: of }, clocks);
            let mut cell = signal.cell();
            cell.visit_mut(|id| *id = source.id);
            // Its own time, which a restart has set.
            return self.add(cell, signal.word(), signal.time().map(|time| time + clocks));
        }
        let known = self.0.borrow().delays.get(&signal.id).copied();
        let next = match known {
            Some(id) => Signal { builder: self.clone(), id },
            None => {
                let next = self.pipe(format!("{base}_d{nth}"), signal);
                self.0.borrow_mut().delays.insert(signal.id, next.id);
                next
            }
        };
        self.delay_named(&next, clocks - 1, base, nth + 1)
    }

    /// The signal at a later time of the module.
    #[track_caller]
    pub fn at_time(&self, signal: &Signal, time: u32) -> Signal {
        match signal.time() {
            Some(now) if now > time => {
                self.fail(|m| {
                    Error::usage(format!("{} is of clock {now}, later than {time}", m.describe(signal.id)))
                });
                signal.clone()
            }
            Some(now) => self.delay(signal, time - now),
            None => signal.clone(),
        }
    }

    /// The signal on a new axis of time: where a handshake, not a count of clocks, says what belongs
    /// together. No hardware.
    #[track_caller]
    pub fn restart(&self, signal: &Signal, time: u32) -> Signal {
        self.add(Cell::Wrap { of: signal.id }, signal.word(), Some(time))
    }

    /// A memory of `depth` words, inferred as block RAM; with `contents` and no write port, a ROM.
    #[track_caller]
    pub fn memory(&self, name: &str, depth: u32, word: Word, contents: Vec<i128>) -> MemoryHandle {
        if contents.len() > depth as usize || contents.iter().any(|&c| !word.range.contains(Range::point(c)))
        {
            self.fail(|_| {
                Error::usage(format!("memory {name}: its contents do not fit {depth} words of {word}"))
                    .help("give it more or wider words")
            });
        }
        let (name, made_of, write, apart) = (name.into(), MadeOf::Any, None, false);
        let memory = Memory { name, depth, word, contents, write, made_of, apart };
        MemoryHandle { index: self.add_memory(memory), word, builder: self.clone() }
    }
}

impl Signal {
    pub(super) fn cell(&self) -> Cell {
        self.builder.node(self.id, |n| n.cell.clone())
    }
}

/// A memory under construction.
pub struct MemoryHandle {
    index: usize,
    word: Word,
    builder: Builder,
}

impl MemoryHandle {
    /// The same memory made of lookup tables: a block RAM is slower to read.
    pub fn distributed(self) -> Self {
        self.builder.0.borrow_mut().module.memories[self.index].made_of = MadeOf::LookupTables;
        self
    }

    /// The same memory made of block RAM, however small it is.
    pub fn block(self) -> Self {
        self.builder.0.borrow_mut().module.memories[self.index].made_of = MadeOf::BlockRam;
        self
    }

    /// States that no word is read at the edge at which it is written: the cells that would give the old one are spared.
    /// Where it is not so, the word that is read is unset: the proof fails if anything depends on it.
    pub fn apart(self) -> Self {
        self.builder.0.borrow_mut().module.memories[self.index].apart = true;
        self
    }

    /// The write port: at an edge where `enable` is 1, `data` goes to `address`. Signals that come early wait for
    /// the others.
    #[track_caller]
    pub fn write(&self, enable: &Signal, address: &Signal, data: &Signal) {
        let m = &self.builder;
        if data.word() != self.word {
            m.fail(|module| {
                let memory = &module.memories[self.index].name;
                let (data, word) = (format!("{} ({})", module.describe(data.id), data.word()), self.word);
                Error::usage(format!("memory {memory} holds {word}, but {data} is written to it"))
                    .help("declare the memory with the word of what is written")
            });
        }
        self.check_address(address);
        let mut port = [enable, address, data].map(Signal::clone);
        m.align(&mut port);
        let [enable, address, data] = port.map(|signal| signal.id);
        let write = MemoryWrite { enable, address, data };
        m.0.borrow_mut().module.memories[self.index].write = Some(write);
    }

    /// A read port: the word appears one clock after its address, and stays while `enable` is 0. Of the two, the
    /// earlier one waits for the other.
    #[track_caller]
    pub fn read(&self, name: &str, address: &Signal, enable: Option<&Signal>) -> Signal {
        self.check_address(address);
        // Without an enable, the address stands in for it.
        let mut port = [address, enable.unwrap_or(address)].map(Signal::clone);
        let time = self.builder.align(&mut port).unwrap_or(0);
        let cell =
            Cell::MemoryRead { memory: self.index, address: port[0].id, enable: enable.map(|_| port[1].id) };
        let read = self.builder.add(cell, self.word, Some(time + 1));
        self.builder.rename(&read, name.into());
        read
    }

    #[track_caller]
    fn check_address(&self, address: &Signal) {
        let (memory, depth): (String, NodeRange) = {
            let state = self.builder.0.borrow();
            let memory = &state.module.memories[self.index];
            (memory.name.clone(), NodeRange(address.id, memory.depth))
        };
        let range = address.word().range;
        if range.min < 0 || range.max >= depth.1.into() {
            self.builder.fail(|m| {
                let name = m.describe(depth.0);
                Error::usage(format!(
                    "memory {memory} has {} words, but {name} is {}",
                    depth.1,
                    address.word()
                ))
                .help("narrow the address or deepen the memory")
            });
        }
    }
}

/// A node and the number of words it addresses.
struct NodeRange(NodeId, u32);
