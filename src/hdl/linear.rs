//! The proof by linear forms: the simulator runs with exact forms in the data path, so one run shows what
//! the hardware computes for *all* inputs.
//!
//! Control is run with numbers; where it would have to depend on data, the run stops with the names. A
//! register that nobody set holds [`Value::Unknown`], so nothing uninitialised can reach an output
//! unseen. Each [claim](super::Cell::Claim) met on the way is checked against the exact range of its form.
//! Where a data path rounds in its middle, a form goes on as a number [near](crate::fixed::Near) one.

use std::collections::BTreeMap;

use super::Word;
use super::cell::{Cell, NodeId, Term};
use super::flat::Flat;
use super::simulate::{Domain, Integers};
use crate::error::Error;
use crate::fixed::{Form, Near, Range};

/// What flows through the wires in a proof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<const N: usize> {
    Integer(i128),
    Form(Form<N>),
    /// A linear function of the inputs up to a bounded error.
    Near(Near<N>),
    /// Never set, dead, or nothing that is known of the inputs.
    Unknown,
}

impl<const N: usize> Value<N> {
    /// The number with the bounds of its error, where anything is known of it.
    fn near(&self) -> Option<Near<N>> {
        match self {
            Value::Integer(value) => Some(Near::interval(Range::point(*value))),
            Value::Form(form) => Near::from_form(form),
            Value::Near(near) => Some(*near),
            Value::Unknown => None,
        }
    }
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
                Value::Near(_) | Value::Unknown => return None,
            }
        }
        let word = flat.node(id).word;
        Some(match form {
            Some(form) => self.wrap(word, form.plus_constant(number)?),
            None => Value::Integer(word.range.wrap(number)),
        })
    }

    /// The same sum of numbers that are near forms. A shift right and the highest bit that it drops, added
    /// up, are one rounding half up.
    fn near_sum(&self, flat: &Flat, id: NodeId, values: &[Value<N>]) -> Option<Value<N>> {
        let Cell::Sum { terms, constant } = &flat.node(id).cell else { return None };
        let mut sum = Near::interval(Range::point(*constant));
        let carries: Vec<Option<usize>> = terms.iter().map(|term| rounded_by(flat, terms, term)).collect();
        for (index, term) in terms.iter().enumerate() {
            let carried = carries.contains(&Some(index));
            let addend = match (&flat.node(through_wraps(flat, term.of)).cell, carries[index]) {
                // The bit is accounted for with what it rounds.
                (_, Some(_)) => continue,
                (Cell::ShiftRight { of, amount, .. }, None) if carried => {
                    let half = Near::interval(Range::point(1 << (amount - 1)));
                    values[of.index()].near()?.plus(&half)?.shift_right(*amount)?
                }
                _ => values[term.of.index()].near()?,
            };
            sum = sum.plus(&addend.scaled(term.negate, term.shift)?)?;
        }
        Some(self.wrap_near(flat.node(id).word, sum))
    }

    /// As [`LinearForms::wrap`].
    fn wrap_near(&self, word: Word, near: Near<N>) -> Value<N> {
        let width = word.width();
        if !word.modular && near.modulus >= width && word.range.contains(self.near_range(&near)) {
            return Value::Near(Near { modulus: 0, ..near });
        }
        let known = near.modulus != 0 && near.modulus <= width;
        let fits = known || (!word.modular && word.range.contains(self.near_range(&near)));
        Value::Near(if fits { near } else { Near { modulus: width, ..near } })
    }

    fn near_range(&self, near: &Near<N>) -> Range {
        let variable = if near.is_interval() { Range::point(0) } else { self.groups[near.group as usize] };
        near.range(variable)
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
            Value::Near(_) | Value::Unknown => false,
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
            Value::Near(near) => self.near_range(near),
            Value::Unknown => return Value::Unknown,
        };
        let modulus = match &value {
            Value::Form(form) => form.modulus,
            Value::Near(near) => near.modulus,
            _ => 0,
        };
        let known = match modulus {
            0 => range,
            modulus => {
                // All bits that are read, or all that there are, must be known.
                let bits = word.width().min(flat.node(of).word.width());
                if modulus < bits {
                    let why = format!("it is known only modulo 2^{modulus}, but {word} is claimed");
                    return self.refuse(flat, id, why);
                }
                Range::signed(modulus)
            }
        };
        if !word.range.contains(range) || !known.contains(range) {
            let why = format!("its range is {range}, but {} is claimed", word.range.intersect(known));
            return self.refuse(flat, id, why);
        }
        self.proved.entry(id).and_modify(|r| *r = r.union(range)).or_insert(range);
        match value {
            Value::Form(form) => Value::Form(Form { modulus: 0, ..form }),
            Value::Near(near) => Value::Near(Near { modulus: 0, ..near }),
            other => other,
        }
    }

    /// The form in a word: exact where the word is a number that holds it; else known modulo its width, or in the
    /// fewer bits in which it was known before. All bits of a number that fits them are the number.
    fn wrap(&self, word: Word, form: Form<N>) -> Value<N> {
        let width = word.width();
        if !word.modular && form.modulus >= width && word.range.contains(self.range(&form)) {
            return Value::Form(Form { modulus: 0, ..form });
        }
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
                let sum = self.sum(flat, id, values).or_else(|| self.near_sum(flat, id, values));
                let sum = sum.unwrap_or(Value::Unknown);
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
                    Value::Near(near) if word.modular => self.wrap_near(word, near),
                    Value::Integer(number) => Value::Integer(word.range.wrap(number)),
                    chosen => chosen,
                },
                Value::Unknown => Value::Unknown,
                // Either may be taken.
                _ => match (value(*on_true).near(), value(*on_false).near()) {
                    (Some(a), Some(b)) => a.either(&b).map_or(Value::Unknown, |n| self.wrap_near(word, n)),
                    _ => Value::Unknown,
                },
            },
            Cell::Claim { of, when } => match when.map(value) {
                None => self.claim(flat, id, *of, value(*of)),
                Some(Value::Integer(condition)) if condition != 0 => self.claim(flat, id, *of, value(*of)),
                Some(_) => Value::Unknown,
            },
            Cell::Wrap { of } => match value(*of) {
                Value::Form(form) => self.wrap(word, form),
                Value::Near(near) => self.wrap_near(word, near),
                Value::Integer(number) => Value::Integer(word.range.wrap(number)),
                Value::Unknown => Value::Unknown,
            },
            Cell::ShiftRight { of, amount, exact } => match value(*of) {
                Value::Form(form) => {
                    if *exact && !form.is_multiple(*amount) {
                        return self.refuse(flat, id, format!("the lowest {amount} bits are not all zero"));
                    }
                    let variable = self.groups[form.group as usize];
                    match form.shift_right(*amount, variable) {
                        Some(form) => Value::Form(form),
                        None => Near::from_form(&form)
                            .and_then(|near| near.shift_right(*amount))
                            .map_or(Value::Unknown, Value::Near),
                    }
                }
                Value::Near(near) if !exact => near.shift_right(*amount).map_or(Value::Unknown, Value::Near),
                Value::Integer(number) => Value::Integer(number >> amount),
                Value::Near(_) | Value::Unknown => Value::Unknown,
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
            Value::Near(near) if word.modular => self.wrap_near(word, *near),
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

/// The cell's own rule on integers, where all its operands are integers; where some are only functions of the
/// inputs, any bits at all.
fn by_numbers<const N: usize>(flat: &Flat, id: NodeId, values: &[Value<N>]) -> Value<N> {
    let inputs = flat.node(id).cell.combinational_inputs();
    let mut numbers = Vec::with_capacity(inputs.len());
    let mut any = false;
    for input in inputs {
        match values[input.index()] {
            Value::Integer(number) => numbers.push((input, number)),
            Value::Form(_) | Value::Near(_) => any = true,
            Value::Unknown => return Value::Unknown,
        }
    }
    if any {
        let word = flat.node(id).word;
        return if word.is_signed() {
            Value::Unknown
        } else {
            Value::Near(Near::interval(Range::unsigned(word.width())))
        };
    }
    Value::Integer(Integers::evaluate_with(flat, id, |id| {
        numbers.iter().find(|(i, _)| *i == id).map_or(0, |(_, number)| *number)
    }))
}

/// What a node is another name or another reading of.
fn through_wraps(flat: &Flat, mut id: NodeId) -> NodeId {
    while let Cell::Wrap { of } = flat.node(id).cell {
        if flat.node(of).word.width() != flat.node(id).word.width() {
            break;
        }
        id = of;
    }
    id
}

/// For a term that is one bit of something: the term of the same sum that is the same thing shifted right so
/// far that this is the highest bit it drops.
fn rounded_by(flat: &Flat, terms: &[Term], bit: &Term) -> Option<usize> {
    let node = through_wraps(flat, bit.of);
    let Cell::Slice { of, low } = flat.node(node).cell else { return None };
    let source = through_wraps(flat, of);
    let rounds = |term: &Term| match flat.node(through_wraps(flat, term.of)).cell {
        Cell::ShiftRight { of, amount, .. } => amount == low + 1 && through_wraps(flat, of) == source,
        _ => false,
    };
    let one_bit = flat.node(node).word.width() == 1;
    let alike = |term: &Term| (term.negate, term.shift) == (bit.negate, bit.shift);
    terms.iter().position(|term| one_bit && alike(term) && rounds(term))
}
