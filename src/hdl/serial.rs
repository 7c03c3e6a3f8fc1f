//! Digits in series: the same module with one adder of a few bits in place of each wide one, and as many clocks for a
//! number as it has digits.
//!
//! ```text
//!   clock      t      t + 1    t + 2   ...  t + n - 1
//!   digit      0      1        2            n - 1          of every number that lives at clock t
//!   first      1      0        0            0              (a clock earlier: see LEAD)
//! ```
//!
//! An adder keeps its carry in a register between digits. A shift to the left by whole digits is a delay with zeros in
//! the lowest ones; by bits, a register for those that cross over. The digits of a number are those of a word of n of
//! them: numbers that a module keeps in narrower words, and that fit those, have their sign in the digits above. Such
//! words are proved to hold their numbers; here they cost nothing.
//!
//! A number in digits on a bus of one digit is a number in [skewed](super::skew) chunks, of which chunk c comes at clock
//! t + c; so that a module in chunks can read it without anything between.

use std::rc::Rc;

use super::cell::{Cell, NodeId, Term};
use super::live::Live;
use super::skew::LEAD;
use super::{Builder, Module, Signal, Word};
use crate::error::{Error, Result};

/// Numbers in digits, within a module that is being built.
pub struct Digits {
    m: Builder,
    /// Bits of a digit.
    size: u32,
    /// 1 in the clock of digit j of numbers of the clock that `flags[0]` is of.
    flags: Vec<Signal>,
    /// `flags[0]` a clock before.
    ahead: Signal,
    /// 1 in the clocks of last digits, and between numbers.
    done: Signal,
}

impl Digits {
    /// `first` is 1 a clock before digit 0 of the numbers of the clock after it, and 0 in the `count - 1` clocks that
    /// follow.
    pub fn new(m: &Builder, size: u32, count: u32, first: &Signal) -> Digits {
        let name = first.name().unwrap_or_else(|| "first".into());
        let ahead = following(m, first, count, None);
        let more = m.any(&ahead[..count as usize - 1].iter().collect::<Vec<_>>());
        let done = m.pipe(format!("{name}_done"), !&more);
        let flags = ahead.iter().map(|flag| m.pipe(format!("{name}_digit"), flag));
        let (flags, ahead) = (flags.collect(), ahead[0].clone());
        Digits { m: m.clone(), size, flags, ahead, done }
    }

    /// The sum of two numbers of the clock after `first`.
    pub fn sum(&self, a: &Signal, b: &Signal) -> Signal {
        self.add([(a, false), (b, false)], None)
    }

    /// The sum where it is taken only while `when` is 1, through all digits: its carry steps with the registers that take
    /// it, so that they fit into one place.
    pub fn sum_when(&self, when: &Signal, a: &Signal, b: &Signal) -> Signal {
        self.add([(a, false), (b, false)], Some(when))
    }

    /// A flag at the clock of a number.
    fn at(&self, flag: &Signal, number: &Signal) -> Signal {
        self.m.at_time(flag, number.time().unwrap_or(0))
    }

    /// The sum of two digits that come at one time, or the difference: either may be inverted.
    fn add(&self, [a, b]: [(&Signal, bool); 2], when: Option<&Signal>) -> Signal {
        let m = &self.m;
        let time = a.0.time().max(b.0.time()).unwrap_or(0);
        let bits = |(digit, inverted): (&Signal, bool)| {
            let digit = m.at_time(digit, time);
            if inverted { m.wire("inverted", !&digit) } else { digit }
        };
        let start = m.bit(a.1 || b.1);
        let one = m.bit(true);
        // The carry of the number before ends here, where it enters, so that its register needs no reset.
        let carry = m.register_at("carry", Word::bit(), None, time);
        // Each adder is told out of a register beside it.
        let ahead = m.at_time(&self.ahead, time - 1);
        let lowest = m.unmerged(m.pipe("lowest", &ahead));
        let carry_in = m.select(&lowest, &start, &carry);
        let (a, b) = (m.concat(&[&bits(a), &one]), m.concat(&[&bits(b), &carry_in]));
        let sum = m.wrap(&a + &b, Word::unsigned(self.size + 2));
        let carry_out = m.slice(&sum, self.size + 1, 1);
        match when {
            Some(when) => m.on(when, &carry, &carry_out),
            None => m.always(&carry, &carry_out),
        }
        m.slice(&sum, 1, self.size)
    }

    /// The number times 2^`amount`, at the same clock: whole digits are a delay, with zeros in the lowest ones.
    fn shift(&self, digit: &Signal, amount: u32) -> Signal {
        let m = &self.m;
        let (whole, bits) = ((amount / self.size) as usize, amount % self.size);
        let mut digit = self.shift_bits(digit, bits);
        let time = digit.time().unwrap_or(0);
        for place in 1..=whole {
            // Digit j is digit j - whole of the number, which the last of the registers takes a clock before.
            let next = if place < whole {
                digit
            } else {
                let kept = self.flags.iter().take(self.flags.len() - 1).skip(whole - 1).collect::<Vec<_>>();
                let zero = m.constant(0, digit.word());
                if kept.is_empty() { zero } else { m.select(&self.at(&m.any(&kept), &digit), &digit, zero) }
            };
            digit = m.restart(&m.pipe("late", &next), time);
        }
        digit
    }

    /// The number times 2^`bits`, fewer than a digit has.
    pub fn shift_bits(&self, digit: &Signal, bits: u32) -> Signal {
        if bits == 0 {
            return digit.clone();
        }
        let m = &self.m;
        let crossing = m.slice(digit, self.size - bits, bits);
        let crossed = m.register_at("crossed", crossing.word(), None, digit.time().unwrap_or(0));
        // Chosen, not masked: synthesis makes it the reset of the register.
        let done = self.at(&self.done, digit);
        m.always(&crossed, m.select(&done, m.constant(0, crossing.word()), &crossing));
        m.concat(&[&m.slice(digit, 0, self.size - bits), &crossed])
    }

    /// The digits of a constant, for numbers of this clock.
    fn constant(&self, value: i128, time: u32) -> Signal {
        let bit = |place: u32| {
            let set = self
                .flags
                .iter()
                .zip(0..)
                .filter(|(_, digit)| value >> (digit * self.size + place).min(127) & 1 == 1);
            let set: Vec<&Signal> = set.map(|(flag, _)| flag).collect();
            if set.is_empty() { self.m.bit(false) } else { self.m.any(&set) }
        };
        let bits: Vec<Signal> = (0..self.size).rev().map(bit).collect();
        let digit = self.m.concat(&bits.iter().collect::<Vec<_>>());
        self.m.at_time(&self.m.pipe("constant", digit), time.max(self.flags[0].time().unwrap_or(0) + 1))
    }
}

/// The pulse, and where it was 1 so many clocks ago: all of the clock of the pulse, `count` in all.
pub fn following(m: &Builder, pulse: &Signal, count: u32, reset: Option<i128>) -> Vec<Signal> {
    let (time, mut flags) = (pulse.time().unwrap_or(0), vec![]);
    let name = pulse.name().unwrap_or_else(|| "pulse".into());
    for clocks in 0..count {
        let later = |last: &Signal| {
            let name = format!("{name}_after_{clocks}");
            reset.map_or_else(|| m.pipe(name.clone(), last), |reset| m.pipe_reset(name.clone(), last, reset))
        };
        flags.push(flags.last().map_or_else(|| pulse.clone(), |last| m.restart(&later(last), time)));
    }
    flags
}

/// What takes some clocks, one after the other.
pub struct Turn {
    clocks: u32,
    /// 1 in the clocks behind the first one, in which no other may begin.
    pub busy: Signal,
}

impl Turn {
    pub fn new(m: &Builder, clocks: u32) -> Turn {
        let busy = if clocks > 1 { m.forward("turning", Word::bit()) } else { m.bit(false) };
        Turn { clocks, busy }
    }

    /// Where one begins.
    pub fn begins(&self, m: &Builder, pulse: &Signal) {
        if self.clocks > 1 {
            let behind = following(m, pulse, self.clocks - 1, Some(0));
            let next = m.any(&behind.iter().collect::<Vec<_>>());
            m.drive(&self.busy, m.restart(&m.pipe_reset("turning_now", &next, 0), 0));
        }
    }
}

/// The module in `count` digits of `digit` bits. Its inputs are the bit `first`, a clock before digit 0, and those of the
/// module, numbers as digits; those in `held` are no numbers, and keep their value for all digits. All outputs are
/// numbers, at one clock.
///
/// # Errors
/// Anything but sums, choices and stages of pipelines; a stage that is held or reset.
pub fn serial(module: &Rc<Module>, digit: u32, count: u32, held: &[&str]) -> Result<Rc<Module>> {
    let m = Builder::new(&module.name);
    module.purpose.iter().for_each(|line| m.purpose(line));
    m.purpose(format!("Numbers in {count} digits of {digit} bits, one a clock, the lowest first."));
    module.parameters.iter().for_each(|(name, value)| m.parameter(name, value));
    m.parameter("digit", digit);
    m.separate();
    let first = m.input("first", Word::bit());
    let digits = Digits::new(&m, digit, count, &first);
    let mut values: Vec<Option<Value>> = vec![None; module.nodes.len()];
    for &id in &module.inputs {
        let node = module.node(id);
        let name = node.name.clone().unwrap_or_default();
        values[id.index()] = Some(match held.contains(&name.as_str()) {
            true => Value::Held(m.input_at(name, node.word, LEAD)),
            false => Value::Number(m.input_at(name, Word::unsigned(digit), LEAD)),
        });
    }
    let live = Live::of(module).nodes;
    for index in (0..module.nodes.len()).filter(|&index| live[index]) {
        if values[index].is_none() {
            values[index] = Some(translate(&digits, module, NodeId(index as u32), &values)?);
        }
    }
    let outputs: Vec<Signal> = module
        .outputs
        .iter()
        .map(|output| number(&digits, module, &values, output.node))
        .collect::<Result<_>>()?;
    let last = outputs.iter().filter_map(Signal::time).max().unwrap_or(0);
    for (output, digit) in module.outputs.iter().zip(&outputs) {
        m.output(&output.name, m.at_time(digit, last));
    }
    m.finish()
}

/// What a node of the module has become.
#[derive(Clone)]
enum Value {
    Number(Signal),
    Constant(i128),
    Held(Signal),
}

fn translate(digits: &Digits, module: &Module, id: NodeId, values: &[Option<Value>]) -> Result<Value> {
    let (m, node) = (&digits.m, module.node(id));
    let refused = |what: &str| {
        let what = format!("{} is {what} in a module that is to be emitted in digits", module.describe(id));
        Error::usage(what).at(module.place(id)).help("keep it outside of the module")
    };
    let of = |id: NodeId| values[id.index()].as_ref().ok_or_else(|| refused("used before it is driven"));
    let name = |signal: Signal| {
        if let (Some(name), None) = (&node.name, signal.name()) {
            m.rename(&signal, name.clone());
        }
        signal
    };
    Ok(match &node.cell {
        Cell::Constant(value) => Value::Constant(*value),
        Cell::Sum { terms, constant } => Value::Number(sum(digits, module, terms, *constant, values)?),
        Cell::Wrap { of: id } | Cell::Claim { of: id, .. } => of(*id)?.clone(),
        Cell::Slice { of: id, low } => match of(*id)? {
            Value::Held(signal) => Value::Held(m.slice(signal, *low, node.word.width())),
            Value::Constant(value) => Value::Constant(value >> low & ((1 << node.word.width()) - 1)),
            Value::Number(_) => return Err(refused("a slice of a number")),
        },
        Cell::Select { condition, on_true, on_false } => {
            let Value::Held(condition) = of(*condition)? else {
                return Err(refused("a choice by a number"));
            };
            let [yes, no] = [*on_true, *on_false].map(|id| number(digits, module, values, id));
            let (yes, no) = (yes?, no?);
            let time = yes.time().max(no.time()).unwrap_or(0);
            let condition = m.at_time(condition, time);
            Value::Number(m.select(&condition, m.at_time(&yes, time), m.at_time(&no, time)))
        }
        Cell::Register { next: Some(next), enable: None, reset: None } => match of(*next)? {
            Value::Number(digit) => Value::Number(name(m.pipe("stage", digit))),
            other => other.clone(),
        },
        _ => return Err(refused("no sum, choice or stage")),
    })
}

fn number(digits: &Digits, module: &Module, values: &[Option<Value>], id: NodeId) -> Result<Signal> {
    match &values[id.index()] {
        Some(Value::Number(digit)) => Ok(digit.clone()),
        Some(Value::Constant(value)) => Ok(digits.constant(*value, 0)),
        _ => {
            Err(Error::usage(format!("{} is no number in digits", module.describe(id))).at(module.place(id)))
        }
    }
}

fn sum(
    digits: &Digits,
    module: &Module,
    terms: &[Term],
    constant: i128,
    values: &[Option<Value>],
) -> Result<Signal> {
    let mut operands: Vec<(Signal, bool)> = vec![];
    let mut constant = constant;
    for term in terms {
        match &values[term.of.index()] {
            Some(Value::Constant(value)) => {
                let value = value << term.shift;
                constant += if term.negate { -value } else { value };
            }
            _ => {
                let digit = number(digits, module, values, term.of)?;
                operands.push((digits.shift(&digit, term.shift), term.negate));
            }
        }
    }
    if constant != 0 || operands.is_empty() {
        let time = operands.iter().filter_map(|(digit, _)| digit.time()).max().unwrap_or(0);
        operands.push((digits.constant(constant, time), false));
    }
    // The inverted bits of x are -x less one, which a carry into the adder mends, once for each adder.
    operands.sort_by_key(|(_, inverted)| *inverted);
    let zero = |digit: &Signal| digits.m.constant(0, digit.word());
    let mut operands = operands.into_iter();
    let Some((first, inverted)) = operands.next() else { return Ok(digits.constant(0, 0)) };
    let mut sum = if inverted { digits.add([(&zero(&first), false), (&first, true)], None) } else { first };
    for (digit, inverted) in operands {
        sum = digits.add([(&sum, false), (&digit, inverted)], None);
    }
    Ok(sum)
}
