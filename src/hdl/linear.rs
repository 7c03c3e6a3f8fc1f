//! The proof by linear forms: the simulator runs with exact forms in the data path, so one run shows what
//! the hardware computes for *all* inputs.
//!
//! Control is run with numbers; where it would have to depend on data, the run stops with the names. A
//! register that nobody set holds [`Value::Unknown`], so nothing uninitialised can reach an output
//! unseen. Each [claim](super::Cell::Claim) met on the way is checked against the exact range of its form.

use std::collections::BTreeMap;

use super::Word;
use super::cell::{Cell, NodeId};
use super::flat::Flat;
use super::simulate::{Domain, Integers};
use crate::error::Error;
use crate::fixed::{Form, Range};

/// What flows through the wires in a proof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<const N: usize> {
    Integer(i128),
    Form(Form<N>),
    /// Never set, dead, or no linear function of the inputs.
    Unknown,
}

/// The domain of a proof with `N` variables in a group.
pub struct LinearForms<const N: usize> {
    /// The range of the variables of each group.
    pub groups: Vec<Range>,
    /// For each claim the union of the ranges that its forms had.
    pub proved: BTreeMap<NodeId, Range>,
    /// What did not hold.
    pub failures: Vec<Error>,
    /// A sum that loses the carry into this bit; the proof shows whether it matters.
    pub dropped_carry: Option<(NodeId, u32)>,
}

impl<const N: usize> LinearForms<N> {
    pub fn new(groups: Vec<Range>) -> Self {
        LinearForms { groups, proved: BTreeMap::new(), failures: vec![], dropped_carry: None }
    }

    fn range(&self, form: &Form<N>) -> Range {
        form.range(self.groups[form.group as usize])
    }

    fn refuse(&mut self, flat: &Flat, id: NodeId, why: String) -> Value<N> {
        // The first few say it all; a broken core breaks at every clock.
        if self.failures.len() < 8 {
            let place = flat.node(id).place;
            let error = Error::usage(format!("{}: {why}", flat.describe(id)));
            self.failures.push(error.at(format!("{}:{}", place.file(), place.line())));
        }
        Value::Unknown
    }

    fn sum(&self, flat: &Flat, id: NodeId, values: &[Value<N>]) -> Option<Value<N>> {
        let Cell::Sum { terms, constant } = &flat.node(id).cell else { return None };
        let (mut number, mut form) = (*constant, None::<Form<N>>);
        for term in terms {
            match &values[term.of.index()] {
                Value::Integer(value) => {
                    let shifted = value.checked_shl(term.shift)?;
                    number = number.checked_add(if term.negate { -shifted } else { shifted })?;
                }
                Value::Form(other) => {
                    let scaled = other.scaled(term.negate, term.shift)?;
                    form = Some(match form {
                        Some(form) => form.plus(&scaled)?,
                        None => scaled,
                    });
                }
                Value::Unknown => return None,
            }
        }
        let word = flat.node(id).word;
        Some(match form {
            Some(form) => self.wrap(word, form.plus_constant(number)?),
            None => Value::Integer(word.range.wrap(number)),
        })
    }

    /// The sum where no carry into the bit can arise, as no two operands have bits below it; otherwise only
    /// what lies below the bit is sure.
    fn without_carry(
        &self,
        flat: &Flat,
        id: NodeId,
        bit: u32,
        values: &[Value<N>],
        sum: Value<N>,
    ) -> Value<N> {
        let Cell::Sum { terms, constant } = &flat.node(id).cell else { return sum };
        let mask = (1i128 << bit) - 1;
        let ends_in_zeros = |value: Value<N>, shift: u32| match value {
            Value::Integer(number) => number.wrapping_shl(shift) & mask == 0,
            Value::Form(form) => form.is_multiple(bit.saturating_sub(shift)),
            Value::Unknown => false,
        };
        let operands =
            terms.iter().filter(|term| !ends_in_zeros(values[term.of.index()], term.shift)).count();
        match sum {
            _ if operands + usize::from(constant & mask != 0) <= 1 => sum,
            Value::Form(form) if form.modulus == 0 || form.modulus > bit => {
                Value::Form(Form { modulus: bit, ..form })
            }
            Value::Form(form) => Value::Form(form),
            _ => Value::Unknown,
        }
    }

    fn claim(&mut self, flat: &Flat, id: NodeId, of: NodeId, value: Value<N>) -> Value<N> {
        let word = flat.node(id).word;
        let range = match &value {
            Value::Integer(number) => Range::point(*number),
            Value::Form(form) => self.range(form),
            Value::Unknown => return Value::Unknown,
        };
        let known = match &value {
            Value::Form(form) if form.modulus != 0 => {
                // All bits that are read, or all that there are, must be known.
                let bits = word.width().min(flat.node(of).word.width());
                if form.modulus < bits {
                    let why = format!("it is known only modulo 2^{}, but {word} is claimed", form.modulus);
                    return self.refuse(flat, id, why);
                }
                Range::signed(form.modulus)
            }
            _ => range,
        };
        if !word.range.contains(range) || !known.contains(range) {
            let why = format!("its range is {range}, but {} is claimed", word.range.intersect(known));
            return self.refuse(flat, id, why);
        }
        self.proved.entry(id).and_modify(|r| *r = r.union(range)).or_insert(range);
        match value {
            Value::Form(form) => Value::Form(Form { modulus: 0, ..form }),
            other => other,
        }
    }

    /// The form in a word: exact where the word is a number that holds it; else known modulo its width, or in the
    /// fewer bits in which it was known before.
    fn wrap(&self, word: Word, form: Form<N>) -> Value<N> {
        let width = word.width();
        let known = form.modulus != 0 && form.modulus <= width;
        let fits = known || (!word.modular && word.range.contains(self.range(&form)));
        Value::Form(if fits { form } else { Form { modulus: width, ..form } })
    }
}

impl<const N: usize> Domain for LinearForms<N> {
    type Value = Value<N>;

    fn unset(&self) -> Value<N> {
        Value::Unknown
    }
    fn integer(&self, value: i128) -> Value<N> {
        Value::Integer(value)
    }
    fn as_integer(&self, value: &Value<N>) -> Option<i128> {
        match value {
            Value::Integer(value) => Some(*value),
            _ => None,
        }
    }

    fn evaluate(&mut self, flat: &Flat, id: NodeId, values: &[Value<N>]) -> Value<N> {
        let value = |id: NodeId| values[id.index()];
        let word = flat.node(id).word;
        match &flat.node(id).cell {
            Cell::Sum { .. } => {
                let sum = self.sum(flat, id, values).unwrap_or(Value::Unknown);
                match self.dropped_carry {
                    Some((at, bit)) if at == id => self.without_carry(flat, id, bit, values, sum),
                    _ => sum,
                }
            }
            Cell::Product { left, right } => match (value(*left), value(*right)) {
                (Value::Form(form), Value::Integer(factor)) | (Value::Integer(factor), Value::Form(form)) => {
                    multiple(form, factor).map_or(Value::Unknown, Value::Form)
                }
                (Value::Integer(left), Value::Integer(right)) => Value::Integer(left * right),
                _ => Value::Unknown,
            },
            Cell::Select { condition, on_true, on_false } => match value(*condition) {
                Value::Integer(condition) => match value(if condition == 0 { *on_false } else { *on_true }) {
                    Value::Form(form) if word.modular => self.wrap(word, form),
                    Value::Integer(number) => Value::Integer(word.range.wrap(number)),
                    chosen => chosen,
                },
                _ => Value::Unknown,
            },
            Cell::Claim { of, when } => match when.map(value) {
                None => self.claim(flat, id, *of, value(*of)),
                Some(Value::Integer(condition)) if condition != 0 => self.claim(flat, id, *of, value(*of)),
                Some(_) => Value::Unknown,
            },
            Cell::Wrap { of } => match value(*of) {
                Value::Form(form) => self.wrap(word, form),
                Value::Integer(number) => Value::Integer(word.range.wrap(number)),
                Value::Unknown => Value::Unknown,
            },
            Cell::ShiftRight { of, amount, exact } => match value(*of) {
                Value::Form(form) => {
                    if *exact && !form.is_multiple(*amount) {
                        return self.refuse(flat, id, format!("the lowest {amount} bits are not all zero"));
                    }
                    let variable = self.groups[form.group as usize];
                    form.shift_right(*amount, variable).map_or(Value::Unknown, Value::Form)
                }
                Value::Integer(number) => Value::Integer(number >> amount),
                Value::Unknown => Value::Unknown,
            },
            // Logic on what is known; a zero decides a conjunction, a one a disjunction of bits.
            Cell::Logic { operation, operands } => {
                use super::cell::Bitwise;
                let decisive = match operation {
                    Bitwise::And => Some(0),
                    Bitwise::Or if word.width() == 1 => Some(1),
                    _ => None,
                };
                if decisive.is_some_and(|d| operands.iter().any(|&o| value(o) == Value::Integer(d))) {
                    return Value::Integer(decisive.unwrap_or(0));
                }
                by_numbers(flat, id, values)
            }
            _ => by_numbers(flat, id, values),
        }
    }

    fn latch(&self, word: Word, value: &Value<N>) -> Value<N> {
        match value {
            Value::Form(form) if word.modular => self.wrap(word, *form),
            Value::Integer(number) if word.modular => Value::Integer(word.range.wrap(*number)),
            other => *other,
        }
    }
}

/// `factor * form`: by the digits of the factor.
fn multiple<const N: usize>(form: Form<N>, factor: i128) -> Option<Form<N>> {
    let mut sum: Option<Form<N>> = None;
    for bit in (0..127).filter(|bit| factor.unsigned_abs() >> bit & 1 == 1) {
        let part = form.scaled(factor < 0, bit)?;
        sum = Some(match sum {
            Some(sum) => sum.plus(&part)?,
            None => part,
        });
    }
    sum.or(form.plus(&form.scaled(true, 0)?))
}

/// The cell's own rule on integers, where all its operands are integers.
fn by_numbers<const N: usize>(flat: &Flat, id: NodeId, values: &[Value<N>]) -> Value<N> {
    let inputs = flat.node(id).cell.combinational_inputs();
    let mut numbers = Vec::with_capacity(inputs.len());
    for input in inputs {
        match values[input.index()] {
            Value::Integer(number) => numbers.push((input, number)),
            _ => return Value::Unknown,
        }
    }
    Value::Integer(Integers::evaluate_with(flat, id, |id| {
        numbers.iter().find(|(i, _)| *i == id).map_or(0, |(_, number)| *number)
    }))
}
