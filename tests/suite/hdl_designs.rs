//! Random small designs: every cell of the language, in words of every kind, with state, memories and hierarchy.
//!
//! ```text
//! inputs ─► pool of signals ─► an operation on some of them ─► pool ─► ... ─► outputs
//! ```
//!
//! Nothing in a design is ever unknown once it has been reset for [`WARM`] clocks with the input `warm` at 1: memories
//! have contents, which nobody changes while `warm` is 1, and whatever keeps its value for want of an enable is enabled
//! by `warm`. So simulators that know unknown bits and those that do not must agree on every bit from then on.

use std::rc::Rc;

use subdiv_rtl::fixed::{Range, Rounding};
use subdiv_rtl::hdl::{Bitwise, Builder, Module, Relation, Signal, Sum, Word};

use crate::noise::Noise;

/// Clocks of reset: more than any path through a design is long.
pub const WARM: usize = 128;

/// Wider words are cut before they are used again.
const WIDEST: u32 = 40;

/// A design of about `size` operations.
pub fn design(seed: u64, size: usize) -> Rc<Module> {
    let mut noise = Noise(seed);
    let inner = (0..noise.below(3)).map(|k| grown(&format!("inner_{seed}_{k}"), &mut noise, size / 4, &[]));
    let inner: Vec<Rc<Module>> = inner.collect();
    grown(&format!("design_{seed}"), &mut noise, size, &inner)
}

fn grown(name: &str, noise: &mut Noise, size: usize, inner: &[Rc<Module>]) -> Rc<Module> {
    let m = Builder::new(name);
    let warm = m.input("warm", Word::bit());
    let mut garden = Garden { m: m.clone(), warm, pool: vec![], registers: vec![], count: 0 };
    let top = !inner.is_empty() && noise.percent(50);
    if top {
        let words = [0, 1, 2].map(|_| garden.word(noise));
        let lanes: Vec<(&str, Word)> = ["a", "b", "c"].into_iter().zip(words).collect();
        garden.pool.extend(m.input_bus("lanes", WIDEST + 3, &lanes));
    }
    for k in 0..3 + noise.below(3) {
        let word = garden.word(noise);
        garden.pool.push(m.input(format!("in_{k}"), word));
    }
    for k in 0..noise.below(4) {
        let word = garden.word(noise);
        let reset = word.range.wrap(noise.wide());
        let register = m.register_reset(format!("state_{k}"), word, reset);
        garden.registers.push(register.clone());
        garden.pool.push(register);
    }
    for _ in 0..size {
        garden.grow(noise, inner);
    }
    garden.close(noise);
    let fruit: Vec<Signal> = (0..6).map(|_| garden.any(noise)).collect();
    for (k, signal) in fruit.iter().enumerate().skip(2 * usize::from(top)) {
        m.output(format!("out_{k}"), signal);
    }
    if top {
        m.output_bus("fruit", WIDEST + 90, &[("left", &fruit[0]), ("right", &fruit[1])]);
    }
    m.finish().unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A number of the word's range.
fn number(noise: &mut Noise, word: Word) -> i128 {
    word.range.wrap(noise.wide()).clamp(word.range.min, word.range.max)
}

struct Garden {
    m: Builder,
    warm: Signal,
    pool: Vec<Signal>,
    /// Those that still need something to take.
    registers: Vec<Signal>,
    count: usize,
}

impl Garden {
    fn name(&mut self, what: &str) -> String {
        self.count += 1;
        format!("{what}_{}", self.count)
    }

    fn word(&self, noise: &mut Noise) -> Word {
        let width = match noise.below(4) {
            0 => 1,
            1 => 1 + noise.below(6) as u32,
            _ => 1 + noise.below(u64::from(WIDEST) - 8) as u32,
        };
        match noise.below(3) {
            0 => Word::signed(width),
            1 => Word::unsigned(width),
            _ => {
                let (a, b) =
                    (Range::signed(width).wrap(noise.wide()), Range::signed(width).wrap(noise.wide()));
                // A word whose every bit pattern is a number: inputs can be anything.
                let hull = Range::new(a.min(b), a.max(b));
                if hull.is_signed() { Word::signed(hull.width()) } else { Word::unsigned(hull.width()) }
            }
        }
    }

    /// A number of at most [`WIDEST`] bits, its binary point at 0.
    fn any(&mut self, noise: &mut Noise) -> Signal {
        let signal = self.pool[noise.below(self.pool.len() as u64) as usize].clone();
        let word = signal.word();
        if word.modular || word.width() > WIDEST {
            let word = if noise.percent(50) { Word::signed(WIDEST) } else { Word::unsigned(1 + WIDEST / 2) };
            return self.m.wrap(&signal, word);
        }
        signal
    }

    fn bit(&mut self, noise: &mut Noise) -> Signal {
        if noise.percent(8) {
            return self.m.bit(noise.percent(50));
        }
        let of = self.any(noise);
        self.m.slice(&of, noise.below(of.width().into()) as u32, 1)
    }

    fn unsigned(&mut self, noise: &mut Noise, width: u32) -> Signal {
        let of = self.any(noise);
        self.m.wrap(&of, Word::unsigned(width))
    }

    fn sum(&mut self, noise: &mut Noise) -> Sum {
        let terms: Vec<(i128, Signal)> =
            (0..1 + noise.below(4)).map(|_| (noise.below(41) as i128 - 20, self.any(noise))).collect();
        let sum = Sum::weighted(terms.iter().map(|(factor, signal)| (*factor, signal)));
        if noise.percent(40) { sum + (noise.below(200) as i128 - 100) } else { sum }
    }

    /// One operation more; some get a name, some do not.
    fn grow(&mut self, noise: &mut Noise, inner: &[Rc<Module>]) {
        let m = self.m.clone();
        let made = match noise.below(19) {
            0 | 1 => m.signal(self.sum(noise)),
            2 => {
                let sum = self.sum(noise);
                m.wrap(sum, Word::unsigned(1 + noise.below(30) as u32))
            }
            3 => {
                let (a, b) = (self.any(noise), self.any(noise));
                m.product(&a, &b)
            }
            4 | 5 => {
                let of = self.any(noise);
                let mode = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven][noise.below(3) as usize];
                let drop = noise.below(u64::from(of.width()) + 4) as u32;
                m.rescale(&m.round(&of, drop, mode), 0)
            }
            6 => {
                let of = self.any(noise);
                // Known modulo a power of two, a sum wraps round.
                let modular = m.modulo(&of, 1 + noise.below(20) as u32);
                let other = self.any(noise);
                let sum = m.signal(3 * &modular - &other);
                let width = sum.width();
                if noise.percent(50) {
                    m.claim(&self.name("claim"), &sum, Word::signed(width), None)
                } else {
                    sum
                }
            }
            7 => {
                let of = self.any(noise);
                let (a, b) = (noise.below(300) as i128 - 150, noise.below(300) as i128 - 150);
                m.saturate(&of, Range::new(a.min(b), a.max(b)))
            }
            8 | 9 => {
                let (condition, a, b) = (self.bit(noise), self.any(noise), self.any(noise));
                m.select(&condition, &a, &b)
            }
            10 => {
                let (a, b) = (self.any(noise), self.any(noise));
                let relations = [Relation::Equal, Relation::NotEqual, Relation::Less, Relation::LessOrEqual];
                m.compare(relations[noise.below(4) as usize], &a, &b)
            }
            11 => {
                let of = self.any(noise);
                let value = number(noise, of.word());
                if noise.percent(50) { m.is(&of, value) } else { m.is_not(&of, value) }
            }
            12 => {
                let width = 1 + noise.below(12) as u32;
                let operands: Vec<Signal> =
                    (0..2 + noise.below(2)).map(|_| self.unsigned(noise, width)).collect();
                let operation = [Bitwise::And, Bitwise::Or, Bitwise::Xor][noise.below(3) as usize];
                let made = m.logic(operation, &operands.iter().collect::<Vec<_>>());
                if noise.percent(30) { !&made } else { made }
            }
            13 => {
                let of = self.any(noise);
                let low = noise.below(of.width().into()) as u32;
                m.slice(&of, low, 1 + noise.below(u64::from(of.width() - low)) as u32)
            }
            14 => {
                let parts = [self.any(noise), self.any(noise)];
                let twice = if noise.percent(30) {
                    vec![&parts[0], &parts[1], &parts[1]]
                } else {
                    parts.iter().collect()
                };
                m.concat(&twice)
            }
            15 => {
                let of = self.any(noise);
                match noise.below(4) {
                    0 => m.pipe(self.name("pipe"), &of),
                    1 => m.pipe_reset(self.name("pipe"), &of, number(noise, of.word())),
                    2 => m.delay(&of, noise.below(3) as u32),
                    _ => m.delay_reset(&of, noise.below(3) as u32, number(noise, of.word())),
                }
            }
            16 => {
                let name = self.name("tree");
                let sum = self.sum(noise);
                m.pipelined(&name, sum)
            }
            17 => self.memory(noise),
            _ => match inner.get(noise.below(inner.len().max(1) as u64) as usize) {
                Some(module) => self.placed(noise, module),
                None => {
                    let word = self.word(noise);
                    m.constant(word.range.wrap(noise.wide()), word)
                }
            },
        };
        let made = if noise.percent(40) { m.wire(self.name("wire"), &made) } else { made };
        self.pool.push(made);
    }

    fn memory(&mut self, noise: &mut Noise) -> Signal {
        let m = self.m.clone();
        let (word, bits) = (self.word(noise), 1 + noise.below(4) as u32);
        let depth = (1 << bits) - u32::from(bits > 1 && noise.percent(50));
        let contents = (0..depth).map(|_| word.range.wrap(noise.wide())).collect();
        let memory = m.memory(&self.name("memory"), depth, word, contents);
        // Addresses beyond the end are no part of the language: the high bit goes where they would be.
        let bits = if depth == 1 << bits { bits } else { bits - 1 };
        if noise.percent(70) {
            let (enable, address) = (self.bit(noise), self.unsigned(noise, bits));
            let data = m.wrap(self.any(noise), word);
            let time = [&enable, &address, &data].iter().filter_map(|s| s.time()).max().unwrap_or(0);
            // A delayed `warm` would be unknown in the first clocks.
            let known = !m.restart(&self.warm, time);
            memory.write(&m.all(&[&m.at_time(&enable, time), &known]), &address, &data);
        }
        let mut word = None;
        for _ in 0..noise.below(3) {
            let enable = noise.percent(50).then(|| {
                let bit = self.bit(noise);
                m.any(&[&bit, &self.warm])
            });
            let address = self.unsigned(noise, bits);
            word = Some(memory.read(&self.name("read"), &address, enable.as_ref()));
        }
        // Some memories are read by nobody.
        word.unwrap_or_else(|| m.bit(true))
    }

    fn placed(&mut self, noise: &mut Noise, module: &Rc<Module>) -> Signal {
        let m = self.m.clone();
        let ports: Vec<(String, Word)> = module
            .inputs
            .iter()
            .map(|&id| (module.node(id).name.clone().unwrap(), module.node(id).word))
            .collect();
        let mut signals: Vec<Signal> = ports.iter().map(|(_, word)| m.wrap(self.any(noise), *word)).collect();
        let time = signals.iter().filter_map(Signal::time).max().unwrap_or(0);
        for ((name, _), signal) in ports.iter().zip(&mut signals) {
            if name == "warm" {
                *signal = m.restart(&self.warm, time);
            }
        }
        let inputs: Vec<(&str, &Signal)> = ports.iter().map(|(n, _)| n.as_str()).zip(&signals).collect();
        let placed = m.instance(&self.name("instance"), module, &inputs);
        for output in &module.outputs {
            self.pool.push(placed.out(&output.name));
        }
        self.pool[self.pool.len() - 1].clone()
    }

    /// Gives the registers what they take: signals of clock 0, by clauses or always.
    fn close(&mut self, noise: &mut Noise) {
        let m = self.m.clone();
        let now: Vec<Signal> = self.pool.iter().filter(|s| s.time() == Some(0)).cloned().collect();
        for register in self.registers.clone() {
            let mut of = || m.wrap(&now[noise.below(now.len() as u64) as usize], register.word());
            let (first, second, third) = (of(), of(), of());
            let [a, b] = [0, 1].map(|_| {
                let of = &now[noise.below(now.len() as u64) as usize];
                m.slice(of, noise.below(of.width().into()) as u32, 1)
            });
            m.on(&a, &register, &first);
            if noise.percent(60) {
                m.on(&b, &register, &second);
            }
            if noise.percent(30) {
                m.always(&register, &third);
            }
        }
    }
}
