//! Numbers: sums, rounding, saturation, and the passage between modular words and numbers.

use std::panic::Location;
use std::rc::Rc;

use super::cell::{Cell, Relation, Term};
use super::expression::{Expr, Signal, Sum};
use super::form::StaticForm;
use super::{Builder, Word};
use crate::error::Error;
use crate::fixed::{Range, Rounding};

impl Builder {
    /// The expression as a node.
    #[track_caller]
    pub fn signal(&self, value: impl Into<Expr>) -> Signal {
        match value.into() {
            Expr::Signal(signal) => signal,
            Expr::Sum(sum) => self.build_sum(sum, None),
        }
    }

    /// The expression as a node with a name from the mathematics.
    #[track_caller]
    pub fn wire(&self, name: impl Into<String>, value: impl Into<Expr>) -> Signal {
        let signal = self.signal(value);
        let signal = if signal.name().is_some() { self.alias(&signal) } else { signal };
        self.rename(&signal, name.into());
        signal
    }

    #[track_caller]
    fn alias(&self, signal: &Signal) -> Signal {
        self.add(Cell::Wrap { of: signal.id }, signal.word(), signal.time())
    }

    /// The sum as one cell; modulo 2^`modulus` where that is asked for or a term is modular.
    #[track_caller]
    fn build_sum(&self, sum: Sum, modulus: Option<u32>) -> Signal {
        if let ([(1, only)], 0) = (sum.terms.as_slice(), sum.constant) {
            return only.clone();
        }
        let mut signals: Vec<Signal> = sum.terms.iter().map(|(_, s)| s.clone()).collect();
        let time = self.align(&mut signals);
        let Some(first) = signals.first() else {
            return self.constant(sum.constant, Range::point(sum.constant).into());
        };
        let (fraction, point) = (first.word().fraction, first.clone());
        for signal in &signals {
            if signal.word().fraction != fraction {
                self.fail_at(sum.place, |m| {
                    let (a, b) = (m.describe(point.id), m.describe(signal.id));
                    let (fa, fb) = (point.word(), signal.word());
                    Error::usage(format!("a sum of {a} ({fa}) and {b} ({fb}): the binary points differ"))
                        .help("bring them to one binary point with `rescale`")
                });
            }
        }
        let coefficients = sum.terms.iter().map(|(c, _)| *c);
        // A modular word times 2^t is known modulo 2^t as much; no sum is wider than its widest operand for that.
        let modular =
            || coefficients.clone().zip(&signals).map(|(c, s)| (c, s.word())).filter(|(_, w)| w.modular);
        let widest = modular().map(|(_, word)| word.width()).max();
        let known = modular().map(|(c, word)| word.width() + c.trailing_zeros());
        let modulus = known.chain(widest).chain(modulus).min();
        let terms = coefficients.clone().zip(&signals).flat_map(|(c, s)| digits(c, s)).collect();
        let cell = Cell::Sum { terms, constant: sum.constant };
        if let Some(width) = modulus {
            let word = Word::modular(width).fraction(fraction);
            let cell = match cell {
                Cell::Sum { terms, constant } => {
                    let terms = terms.into_iter().filter(|t| t.shift < width).collect();
                    Cell::Sum { terms, constant: word.range.wrap(constant) }
                }
                other => other,
            };
            return self.add_at(sum.place, cell, word, time, None);
        }
        let interval = coefficients
            .clone()
            .zip(&signals)
            .fold(Range::point(sum.constant), |range, (c, s)| range + s.word().range * c);
        let start = StaticForm { constant: sum.constant, ..StaticForm::default() };
        let form = coefficients.zip(&signals).try_fold(start, |form, (c, s)| form.add(c, &self.form(s)));
        let range = match &form {
            Some(form) => interval.intersect(form.range(|id| self.node(id, |n| n.word.range))),
            None => interval,
        };
        let word = Word { range, fraction, modular: false };
        self.add_at(sum.place, cell, word, time, form.map(Rc::new))
    }

    /// The terms of a sum with every coefficient a signed power of two.
    pub(super) fn shifted_terms(&self, sum: &Sum) -> Vec<(i128, Signal)> {
        let digit = |t: Term| if t.negate { -(1i128 << t.shift) } else { 1i128 << t.shift };
        let split = |(c, s): &(i128, Signal)| -> Vec<(i128, Signal)> {
            digits(*c, s).into_iter().map(|t| (digit(t), s.clone())).collect()
        };
        sum.terms.iter().flat_map(split).collect()
    }

    fn add_at(
        &self,
        place: &'static Location<'static>,
        cell: Cell,
        word: Word,
        time: Option<u32>,
        form: Option<Rc<StaticForm>>,
    ) -> Signal {
        let signal = self.add_with_form(cell, word, time, form);
        self.0.borrow_mut().module.nodes[signal.id.index()].place = place;
        signal
    }

    fn form(&self, signal: &Signal) -> StaticForm {
        let state = self.0.borrow();
        match (&state.forms[signal.id.index()], &state.module.node(signal.id).cell) {
            (Some(form), _) => form.as_ref().clone(),
            (None, Cell::Constant(value)) => StaticForm { constant: *value, ..StaticForm::default() },
            (None, _) => StaticForm::atom(signal.id),
        }
    }

    /// The product of two numbers: a multiplier. Multiples by constants need none, write `3 * &x`.
    #[track_caller]
    pub fn product(&self, left: impl Into<Expr>, right: impl Into<Expr>) -> Signal {
        let mut operands = vec![self.signal(left), self.signal(right)];
        let time = self.align(&mut operands);
        let [a, b] = [operands[0].word(), operands[1].word()];
        if a.modular || b.modular {
            self.fail(|m| {
                let (l, r) = (m.describe(operands[0].id), m.describe(operands[1].id));
                Error::usage(format!("a product of {l} ({a}) and {r} ({b})"))
                    .help("claim the range of a modular word first")
            });
        }
        let (low, high) = (a.range * b.range.min, a.range * b.range.max);
        let word = Word { range: low.union(high), fraction: a.fraction + b.fraction, modular: false };
        self.add(Cell::Product { left: operands[0].id, right: operands[1].id }, word, time)
    }

    /// The number modulo 2^`width`: from here on sums wrap round instead of growing.
    #[track_caller]
    pub fn modulo(&self, value: impl Into<Expr>, width: u32) -> Signal {
        let of = self.signal(value);
        let word = of.word();
        if word.modular && word.width() < width {
            self.fail(|m| {
                let of = m.describe(of.id);
                Error::usage(format!("{of} is known only modulo 2^{}, not modulo 2^{width}", word.width()))
                    .help("claim its range first")
            });
        }
        self.add(Cell::Wrap { of: of.id }, Word::modular(width).fraction(word.fraction), of.time())
    }

    /// The bits of `value` read as another word: a deliberate change of meaning, for control and buses.
    #[track_caller]
    pub fn wrap(&self, value: impl Into<Expr>, word: Word) -> Signal {
        let of = match value.into() {
            // Only the low bits of a sum are wanted, so only they are added.
            Expr::Sum(sum) => self.build_sum(sum, Some(word.width())),
            Expr::Signal(signal) => signal,
        };
        self.add(Cell::Wrap { of: of.id }, word.fraction(of.word().fraction), of.time())
    }

    /// States that the number lies in `word` (whenever `when` is 1, if given). The statement is an
    /// obligation: a design with a claim that is not proved is not emitted.
    #[track_caller]
    pub fn claim(&self, name: &str, value: impl Into<Expr>, word: Word, when: Option<&Signal>) -> Signal {
        let mut operands = vec![self.signal(value)];
        operands.extend(when.cloned());
        let time = self.align(&mut operands);
        let when = operands.get(1).map(|w| w.id);
        let claim = self.add(Cell::Claim { of: operands[0].id, when }, word, time);
        self.rename(&claim, name.into());
        claim
    }

    /// `value / 2^drop` in a named rounding mode; the binary point moves along.
    #[track_caller]
    pub fn round(&self, value: impl Into<Expr>, drop: u32, mode: Rounding) -> Signal {
        let of = self.signal(value);
        if drop == 0 {
            return of;
        }
        let word = of.word();
        if word.modular {
            self.fail(|m| {
                let name = m.describe(of.id);
                Error::usage(format!(
                    "{name} is known only modulo 2^{}: its high bits cannot be read",
                    word.width()
                ))
                .help("claim its range first")
            });
        }
        if drop > Range::WIDEST {
            self.fail(|m| {
                let name = m.describe(of.id);
                Error::usage(format!("{drop} bits dropped of {name}, which is {word}"))
                    .help("no word has so many bits")
            });
            return of;
        }
        // Rounding keeps the order, so equal ends decide all between. What is proved exact stays a cell.
        if let (Some(low), Some(high)) = (mode.apply(word.range.min, drop), mode.apply(word.range.max, drop))
            && low == high
            && mode != Rounding::Exact
        {
            let fraction = word.fraction - drop as i32;
            return self.constant(low, Word::from(Range::point(low)).fraction(fraction));
        }
        let half = 1i128 << (drop - 1);
        let biased = match mode {
            Rounding::Floor | Rounding::Exact => of,
            Rounding::HalfUp => self.signal(&of + half),
            Rounding::HalfEven => {
                // Above a number's highest bit stand copies of its sign, or zeros.
                let bit = match of.width() {
                    width if drop < width => self.slice(&of, drop, 1),
                    width if word.is_signed() => self.slice(&of, width - 1, 1),
                    _ => self.bit(false),
                };
                let odd = self.rescale(&bit, word.fraction);
                self.signal(&of + &odd + (half - 1))
            }
            Rounding::Truncate if word.range.min >= 0 => of,
            Rounding::Truncate => {
                // A negative number is lifted by just less than a unit, so that its floor is its ceiling.
                let negative = self.slice(&of, word.width() - 1, 1);
                let point = |value| self.constant(value, Word { range: Range::point(value), ..word });
                let lift = self.select(&negative, point(2 * half - 1), point(0));
                self.signal(&of + &lift)
            }
        };
        self.shift_right(&biased, drop, mode == Rounding::Exact)
    }

    /// The same bits with another binary point: the number is multiplied by a power of two, for free.
    #[track_caller]
    pub fn rescale(&self, value: &Signal, fraction: i32) -> Signal {
        self.add(Cell::Wrap { of: value.id }, value.word().fraction(fraction), value.time())
    }

    #[track_caller]
    fn shift_right(&self, of: &Signal, amount: u32, exact: bool) -> Signal {
        let word = of.word();
        let range = word.range.shift_right(amount);
        let result = Word { range, fraction: word.fraction - amount as i32, modular: false };
        self.add(Cell::ShiftRight { of: of.id, amount, exact }, result, of.time())
    }

    /// The nearest number within `range`.
    #[track_caller]
    pub fn saturate(&self, value: impl Into<Expr>, range: Range) -> Signal {
        let of = self.signal(value);
        let word = of.word();
        let bound = |value| self.constant(value, Word { range: Range::point(value), ..word });
        let (low, high) = (bound(range.min), bound(range.max));
        let below = self.compare(Relation::Less, &of, &low);
        let above = self.compare(Relation::Less, &high, &of);
        let inner = self.add(Cell::Wrap { of: of.id }, Word { range, ..word }, of.time());
        let upper = self.select(&above, &high, &inner);
        let clamped = self.select(&below, &low, &upper);
        self.add(Cell::Wrap { of: clamped.id }, Word { range, ..word }, clamped.time())
    }

    /// `condition ? on_true : on_false`; no multiplexer where the condition is a constant.
    #[track_caller]
    pub fn select(&self, condition: &Signal, on_true: impl Into<Expr>, on_false: impl Into<Expr>) -> Signal {
        let mut operands = vec![condition.clone(), self.signal(on_true), self.signal(on_false)];
        let time = self.align(&mut operands);
        let [condition, on_true, on_false] = [&operands[0], &operands[1], &operands[2]];
        let (a, b) = (on_true.word(), on_false.word());
        let chosen = match condition.cell() {
            Cell::Constant(0) => Some(on_false.clone()),
            Cell::Constant(_) => Some(on_true.clone()),
            _ => None,
        };
        if a.fraction != b.fraction || condition.word() != Word::bit() {
            self.fail(|m| {
                let names =
                    [condition, on_true, on_false].map(|s| format!("{} ({})", m.describe(s.id), s.word()));
                Error::usage(format!("select {} ? {} : {}", names[0], names[1], names[2]))
                    .help("the condition is one bit, and both choices have one binary point")
            });
        }
        let word = match (a.modular, b.modular) {
            (false, false) => Word { range: a.range.union(b.range), ..a },
            _ => {
                let widths = [a, b].into_iter().filter(|w| w.modular).map(Word::width);
                Word::modular(widths.min().unwrap_or(1)).fraction(a.fraction)
            }
        };
        // The choice itself, in the word that it has whatever the condition.
        match chosen {
            Some(chosen) if chosen.word() == word => return chosen,
            Some(chosen) => return self.add(Cell::Wrap { of: chosen.id }, word, chosen.time()),
            None => {}
        }
        let (condition, on_true, on_false) = (condition.id, on_true.id, on_false.id);
        self.add(Cell::Select { condition, on_true, on_false }, word, time)
    }

    /// A relation between two numbers; a constant where their words decide it.
    #[track_caller]
    pub fn compare(&self, relation: Relation, left: impl Into<Expr>, right: impl Into<Expr>) -> Signal {
        let mut operands = vec![self.signal(left), self.signal(right)];
        let time = self.align(&mut operands);
        let (left, right) = (&operands[0], &operands[1]);
        let (a, b) = (left.word(), right.word());
        if a.modular || b.modular || a.fraction != b.fraction {
            self.fail(|m| {
                let (l, r) = (m.describe(left.id), m.describe(right.id));
                Error::usage(format!("a comparison of {l} ({a}) with {r} ({b})"))
                    .help("compare numbers of one binary point; claim the range of a modular word first")
            });
        }
        if let Some(known) = decided(relation, left.all_bits(), right.all_bits()) {
            return self.bit(known);
        }
        self.add(Cell::Compare { relation, left: left.id, right: right.id }, Word::bit(), time)
    }

    /// 1 where the signal differs from the constant.
    #[track_caller]
    pub fn is_not(&self, signal: &Signal, value: i128) -> Signal {
        let word = Word { range: Range::point(value), ..signal.word() };
        let constant = self.constant(value, word);
        self.compare(Relation::NotEqual, signal, &constant)
    }

    /// 1 where the signal equals the constant.
    #[track_caller]
    pub fn is(&self, signal: &Signal, value: i128) -> Signal {
        let word = Word { range: Range::point(value), ..signal.word() };
        let constant = self.constant(value, word);
        self.compare(Relation::Equal, signal, &constant)
    }
}

impl Signal {
    /// Every number that the bits of the word can make, whatever its range says.
    fn all_bits(&self) -> Range {
        match (self.cell(), self.word()) {
            (Cell::Constant(value), _) => Range::point(value),
            (_, word) if word.is_signed() => Range::signed(word.width()),
            (_, word) => Range::unsigned(word.width()),
        }
    }
}

/// What a comparison of any two numbers of these ranges gives, where it is always the same.
fn decided(relation: Relation, a: Range, b: Range) -> Option<bool> {
    match relation {
        Relation::Less if a.max < b.min => Some(true),
        Relation::Less if a.min >= b.max => Some(false),
        Relation::LessOrEqual if a.max <= b.min => Some(true),
        Relation::LessOrEqual if a.min > b.max => Some(false),
        Relation::Equal | Relation::NotEqual if a.max < b.min || b.max < a.min => {
            Some(relation == Relation::NotEqual)
        }
        Relation::Equal | Relation::NotEqual if a == b && a.min == a.max => Some(relation == Relation::Equal),
        _ => None,
    }
}

/// The non-adjacent signed binary digits of a coefficient: the fewest shifts and adds.
fn digits(coefficient: i128, signal: &Signal) -> Vec<Term> {
    let (mut rest, mut shift, mut terms) = (coefficient, 0, vec![]);
    while rest != 0 {
        if rest & 1 == 1 {
            let digit = 2 - (rest & 3);
            terms.push(Term { negate: digit < 0, shift, of: signal.id });
            rest -= digit;
        }
        rest >>= 1;
        shift += 1;
    }
    terms.reverse();
    // A sum that begins with a plus prints without a negation.
    terms.sort_by_key(|t| t.negate);
    terms
}
