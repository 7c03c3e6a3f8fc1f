//! Bits: logic, slices, concatenations, and bringing signals to one time.

use super::Builder;
use super::cell::{Bitwise, Cell};
use super::expression::Signal;
use super::word::Word;
use crate::error::Error;

impl Builder {
    #[track_caller]
    pub fn logic(&self, operation: Bitwise, operands: &[&Signal]) -> Signal {
        let mut operands: Vec<Signal> = operands.iter().map(|s| (*s).clone()).collect();
        let time = self.align(&mut operands);
        let word = operands[0].word();
        if let Some(odd) = operands.iter().find(|s| s.width() != word.width() || s.word().is_signed()) {
            self.fail(|m| {
                let (a, b) = (m.describe(operands[0].id), m.describe(odd.id));
                Error::usage(format!("logic between {a} ({word}) and {b} ({})", odd.word()))
                    .help("both must be unsigned words of one width; take a slice")
            });
        }
        let ids = operands.iter().map(|s| s.id).collect();
        self.add(Cell::Logic { operation, operands: ids }, Word::unsigned(word.width()), time)
    }

    /// 1 where every bit of the list is 1.
    #[track_caller]
    pub fn all(&self, bits: &[&Signal]) -> Signal {
        self.logic(Bitwise::And, bits)
    }

    /// 1 where any bit of the list is 1.
    #[track_caller]
    pub fn any(&self, bits: &[&Signal]) -> Signal {
        self.logic(Bitwise::Or, bits)
    }

    #[track_caller]
    pub(super) fn not(&self, of: &Signal) -> Signal {
        let word = Word::unsigned(of.width());
        if of.word().is_signed() {
            self.fail(|m| {
                Error::usage(format!("the bits of {} ({}) inverted", m.describe(of.id), of.word()))
            });
        }
        self.add(Cell::Not { of: of.id }, word, of.time())
    }

    /// Bits `low .. low + width`, unsigned.
    #[track_caller]
    pub fn slice(&self, of: &Signal, low: u32, width: u32) -> Signal {
        if low + width > of.width() {
            self.fail(|m| {
                let name = m.describe(of.id);
                Error::usage(format!("bits {low} to {} of {name}, which is {}", low + width - 1, of.word()))
                    .help("the word has fewer bits; a narrower range may have made it so")
            });
        }
        self.add(Cell::Slice { of: of.id, low }, Word::unsigned(width), of.time())
    }

    /// Bit strings side by side, the first one highest.
    #[track_caller]
    pub fn concat(&self, parts: &[&Signal]) -> Signal {
        let mut parts: Vec<Signal> = parts.iter().map(|s| (*s).clone()).collect();
        let time = self.align(&mut parts);
        let width = parts.iter().map(Signal::width).sum();
        self.add(Cell::Concat { parts: parts.iter().map(|s| s.id).collect() }, Word::unsigned(width), time)
    }

    /// Brings the signals to one time by delaying the early ones; in a strict module, refuses.
    #[track_caller]
    pub(super) fn align(&self, signals: &mut [Signal]) -> Option<u32> {
        let time = signals.iter().filter_map(Signal::time).max()?;
        let early = signals.iter().find(|s| s.time().is_some_and(|t| t < time)).cloned();
        let strict = self.0.borrow().strict;
        if let (Some(early), true) = (&early, strict) {
            let late = signals.iter().find(|s| s.time() == Some(time)).cloned();
            self.fail(|m| {
                let late = late.map(|l| m.describe(l.id)).unwrap_or_default();
                let (name, at) = (m.describe(early.id), early.time().unwrap_or(0));
                Error::usage(format!("{name} is of clock {at}, but {late} of clock {time}"))
                    .help("delay the earlier one with `at_time`, or let the module balance latencies")
            });
        }
        if early.is_some() {
            signals.iter_mut().for_each(|s| *s = self.at_time(s, time));
        }
        Some(time)
    }
}
