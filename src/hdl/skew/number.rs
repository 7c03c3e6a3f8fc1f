//! Numbers in chunks: their bits, their clocks, other words.

use super::Skew;
use crate::hdl::cell::Cell;
use crate::hdl::{Signal, Word};

/// A number as its chunks, lowest first, unsigned; chunk c comes c clocks after chunk 0. What logic makes is one chunk
/// of any width.
#[derive(Clone)]
pub(super) struct Number {
    pub(super) word: Word,
    /// Bits of a chunk.
    pub(super) size: u32,
    pub(super) chunks: Vec<Signal>,
}

impl Number {
    /// The clock of chunk 0; nothing for constants.
    pub(super) fn time(&self) -> Option<u32> {
        let times =
            self.chunks.iter().zip(0..).filter_map(|(chunk, c)| Some(chunk.time()?.saturating_sub(c)));
        times.max()
    }
}

impl Skew<'_> {
    pub(super) fn count(&self, word: Word) -> u32 {
        word.width().div_ceil(self.chunk).max(1)
    }

    /// Bits of chunk c of a word.
    pub(super) fn size(&self, word: Word, c: u32) -> u32 {
        (word.width() - c * self.chunk).min(self.chunk)
    }

    pub(super) fn label(&self, name: &str, c: u32, count: usize) -> String {
        if count > 1 { format!("{name}_c{c}") } else { name.to_string() }
    }

    pub(super) fn name(&self, number: &Number, name: &str) {
        for (chunk, c) in number.chunks.iter().zip(0..) {
            if chunk.name().is_none() && chunk.time().is_some() {
                self.m.rename(chunk, self.label(name, c, number.chunks.len()));
            }
        }
    }

    pub(super) fn constant_bits(&self, value: i128, low: u32, size: u32) -> Signal {
        self.m.constant((value >> low.min(127)) & ((1 << size) - 1), Word::unsigned(size))
    }

    /// Bits `low .. low + size` of a number, zeros below it and its sign or zeros above.
    pub(super) fn bits(&self, number: &Number, low: i64, size: u32) -> Signal {
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
    pub(super) fn cut(&self, number: &Number, low: i64, word: Word) -> Number {
        if number.size > self.chunk && number.chunks.len() == 1 {
            return Number { word, size: word.width(), chunks: vec![self.bits(number, low, word.width())] };
        }
        let chunk = |c| self.bits(number, low + i64::from(c * self.chunk), self.size(word, c));
        self.settled(word, self.chunk, (0..self.count(word)).map(chunk).collect())
    }

    /// The number in chunks of the usual size.
    pub(super) fn chunked(&self, number: &Number) -> Number {
        if number.size <= self.chunk {
            return number.clone();
        }
        let chunk = |c| self.bits(number, i64::from(c * self.chunk), self.size(number.word, c));
        self.settled(number.word, self.chunk, (0..self.count(number.word)).map(chunk).collect())
    }

    /// Chunks brought to their clocks: each one clock after the one below.
    pub(super) fn settled(&self, word: Word, size: u32, chunks: Vec<Signal>) -> Number {
        let number = Number { word, size, chunks };
        let Some(start) = number.time() else { return number };
        let chunks = number.chunks.iter().zip(start..).map(|(chunk, time)| self.m.at_time(chunk, time));
        Number { word, size, chunks: chunks.collect() }
    }

    pub(super) fn restart(&self, number: Number, time: u32) -> Number {
        let chunks = number.chunks.iter().zip(time..).map(|(chunk, time)| self.m.restart(chunk, time));
        Number { chunks: chunks.collect(), ..number }
    }

    /// The chunks of a signal whose bits come all at once, or each chunk a clock later already.
    pub(super) fn split(&self, signal: &Signal, skewed: bool) -> Number {
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
    pub(super) fn whole(&self, number: &Number) -> Signal {
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
