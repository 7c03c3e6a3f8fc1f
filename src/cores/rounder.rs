//! The one rounding of the exact format: a numerator over 3 * 2^s becomes the nearest integer, half up.
//!
//! ```text
//! y = floor(N / (3 * 2^s) + 1/2) = floor((floor((N + 3 * 2^(s-1)) / 2^s)) / 3)
//! ```
//!
//! The division by 3 is a multiplication by m = (2^k + 1) / 3 and a shift right by k, exact for every
//! biased dividend x < 2^q when k is the first odd number from q on: m x / 2^k exceeds x / 3 by
//! x / (3 * 2^k), which is less than 1/3. The digits of m are 1010...1011, so m x is log2(k/2) adders deep.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::error::Result;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// A rounder of numerators known modulo 2^`modulus`, for results of this range with `fraction` bits behind
/// the point.
pub struct Rounder {
    pub modulus: u32,
    pub shift: u32,
    pub result: Range,
    pub fraction: u32,
    pub division: Division,
    /// Whether the numerators have [`half`] a unit in them already.
    pub halved: bool,
}

/// Half a unit of the result: 3 * 2^(shift - 1).
pub fn half(shift: u32) -> i128 {
    3i128 << shift >> 1
}

/// Inputs: `numerator`, and `valid`, which says when it means anything. Output: `rounded`.
/// Whenever `valid` is 1 the numerator lies within 3 * 2^`shift` times the range of the result; that is
/// the claim to be proved.
pub fn build(rounder: Rounder) -> Result<Rc<Module>> {
    let Rounder { modulus, shift, result, fraction, division, halved } = rounder;
    let m = Builder::new("rounder");
    let rounding = if halved { "" } else { " + 1/2" };
    m.purpose(format!(
        "rounded = floor(numerator / (3 * 2^{shift}){rounding}), the nearest for every numerator"
    ));
    m.parameter("modulus", format!("2^{modulus}"));
    m.parameter("result", result);
    let numerator = m.input("numerator", Word::modular(modulus));
    let valid = m.input("valid", Word::bit());

    let mut claimed = result * (3i128 << shift);
    if halved {
        claimed = claimed + Range::point(half(shift));
    }
    // Read as a fixed-point number, it is three times the coordinate.
    let point = (shift + fraction) as i32;
    let claimed = Word::from(claimed).fraction(point);
    let numerator = m.rescale(&numerator, point);
    let exact = m.claim("exact_numerator", &numerator, claimed, Some(&valid));
    // A bias makes the dividend non-negative; of a power of two it takes few bits.
    let bias = 3 * -result.min;
    let dividend = if halved {
        m.pipe("biased", &m.round(&exact, shift, Rounding::Floor) + bias)
    } else {
        let biased = m.pipe("biased", &exact + (half(shift) + (bias << shift)));
        m.wire("dividend", m.round(&biased, shift, Rounding::Floor))
    };
    let quotient = match division {
        Division::Reciprocal => third(&m, &dividend),
        Division::Digits => third_by_digits(&m, &dividend),
    };
    m.output("rounded", m.pipe("rounded", &quotient - (-result.min)));
    m.finish()
}

/// How a division by 3 is done. Both give the same quotient of every dividend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// Multiplication by the reciprocal, which the proof by linear forms follows.
    Reciprocal,
    /// Long division in base 4: of the carry so far and a digit, four LUTs make the next carry and digit.
    Digits,
}

/// A rounder of exact differences to a word of a reduced format.
///
/// Inputs: `numerator`, and `live`, which says when a vertex depends on it; then it fits the word, which is
/// the claim to be proved. Output: `rounded`.
///
/// ```text
///   N / 2^exact * 2^fraction        a shift, s = exact - fraction, in the mode of the language
///   N / (3 * 2^exact) * 2^fraction  q = floor((N + h) / (3 * 2^s)),  h = 3 * 2^(s-1) to the nearest, else 0
///                                   half even: q - 1 where N + h is a multiple of 3 * 2^s (a tie) and q is odd
///                                   truncate:  q + 1 where N is negative and no multiple
/// ```
pub struct Difference {
    /// Of the module.
    pub name: String,
    pub numerator: Word,
    /// Whether there is the factor 3.
    pub thirds: bool,
    pub exact: u32,
    pub fraction: u32,
    /// What it is rounded to.
    pub word: Word,
    pub mode: Rounding,
}

impl Difference {
    pub fn build(&self) -> Result<Rc<Module>> {
        let Difference { exact, fraction, word, mode, .. } = *self;
        let m = Builder::new(&self.name);
        let factor = if self.thirds { "3 * " } else { "" };
        m.purpose(format!("rounded = numerator / ({factor}2^{exact}) with {fraction} fraction bits, {mode}"));
        let numerator = m.input("numerator", self.numerator);
        let live = m.input("live", Word::bit());
        // Where fewer bits are dropped than needed, zeros are appended; a division by 3 follows one at least.
        let least = u32::from(self.thirds);
        let appended = (fraction + least).saturating_sub(exact);
        let shift = exact + appended - fraction;
        let unit = if self.thirds { 3i128 << shift } else { 1 << shift };
        let bounds = word.range * unit;
        let claimed = Range::new(bounds.min >> appended, bounds.max >> appended);
        let exact = m.claim("exact_numerator", &numerator, claimed.into(), Some(&live));
        let exact = m.rescale(&m.signal(&exact << appended), shift as i32 + word.fraction);
        let rounded = if self.thirds {
            self.divide(&m, &exact, shift)
        } else {
            m.pipe("rounded", m.round(&exact, shift, mode))
        };
        m.output("rounded", m.modulo(&rounded, word.width()));
        m.finish()
    }

    /// `n / (3 * 2^shift)`.
    fn divide(&self, m: &Builder, n: &Signal, shift: u32) -> Signal {
        let Difference { word, mode, .. } = *self;
        let nearest = matches!(mode, Rounding::HalfUp | Rounding::HalfEven);
        let half = if nearest { 3i128 << shift >> 1 } else { 0 };
        let bias = 3 * -word.range.min;
        let biased = m.pipe("biased", n + (half + (bias << shift)));
        let dividend = m.wire("dividend", m.round(&biased, shift, Rounding::Floor));
        let quotient = third(m, &dividend);
        let rounded = m.pipe("quotient", &quotient - (-word.range.min));
        if !matches!(mode, Rounding::HalfEven | Rounding::Truncate) {
            return rounded;
        }
        let unit_of = |bit: &Signal| m.rescale(bit, word.fraction);
        let multiple = m.compare(Relation::Equal, &dividend, m.signal(3 * &quotient));
        let whole = m.is(&m.slice(&biased, 0, shift), 0);
        let no_rest = m.pipe("no_rest", &multiple & &m.at_time(&whole, multiple.time().unwrap_or(0)));
        if mode == Rounding::HalfEven {
            let odd = m.slice(&rounded, 0, 1);
            return m.pipe("rounded", &rounded - &unit_of(&(&no_rest & &odd)));
        }
        let negative = m.slice(n, n.width() - 1, 1);
        let negative = m.at_time(&negative, no_rest.time().unwrap_or(0));
        m.pipe("rounded", &rounded + &unit_of(&(&negative & &!&no_rest)))
    }
}

/// floor(x / 3) for 0 <= x, pipelined, one adder per clock.
fn third(m: &Builder, x: &Signal) -> Signal {
    let k = x.width() | 1;
    // m = 1 + 2 * (1 + 4 + 16 + ... ), with (k - 1) / 2 ones.
    let ones = repeated(m, x, (k - 1) / 2, &mut BTreeMap::new());
    let product = m.pipe("product", x + 2 * &ones);
    m.rescale(&m.round(&product, k, Rounding::Floor), x.word().fraction)
}

/// floor(x / 3) for 0 <= x by long division, two digits of base 4 a clock, the highest first.
///
/// ```text
///   4 rest + digit = 3 quotient digit + next rest,  0 <= rest <= 2
/// ```
fn third_by_digits(m: &Builder, x: &Signal) -> Signal {
    let digits = x.width().div_ceil(2);
    let bits = m.wrap(x, Word::unsigned(2 * digits));
    let digit = |of: &Signal, place: u32| m.slice(of, 2 * place, 2);
    // The places of the partial dividend that are still to come, the rest, and the quotient's digits so far.
    let (mut open, mut rest, mut quotient) = (bits, m.constant(0, Word::unsigned(2)), None::<Signal>);
    let mut left = digits;
    while left > 0 {
        let now = left.min(2);
        for place in (left - now..left).rev() {
            let dividend = m.concat(&[&rest, &digit(&open, place)]);
            let one_of = |list: &[i128]| {
                let all: Vec<Signal> = list.iter().map(|&value| m.is(&dividend, value)).collect();
                m.any(&all.iter().collect::<Vec<_>>())
            };
            rest = m.concat(&[&one_of(&[2, 5, 8, 11]), &one_of(&[1, 4, 7, 10])]);
            let next = [one_of(&[6, 7, 8, 9, 10, 11]), one_of(&[3, 4, 5, 9, 10, 11])];
            let parts: Vec<&Signal> = quotient.iter().chain(&next).collect();
            quotient = Some(m.concat(&parts));
        }
        left -= now;
        let stage = |name: &str, of: &Signal| m.pipe(format!("{name}_{left}"), of);
        rest = stage("rest", &rest);
        quotient = quotient.map(|quotient| stage("quotient", &quotient));
        if left > 0 {
            open = stage("digits", &m.slice(&open, 0, 2 * left));
        }
    }
    let range = Range::new(0, x.word().range.max / 3);
    let quotient = quotient.unwrap_or(rest);
    m.wrap(
        m.rescale(&quotient, x.word().fraction),
        Word { range, fraction: x.word().fraction, modular: false },
    )
}

/// x * (1 + 4 + ... + 4^(count-1)): the sum of the largest power of two of digits below, and of the rest.
fn repeated(m: &Builder, x: &Signal, count: u32, known: &mut BTreeMap<u32, Signal>) -> Signal {
    if count <= 1 {
        return x.clone();
    }
    if let Some(sum) = known.get(&count) {
        return sum.clone();
    }
    let low = count.next_power_of_two() / 2;
    let (half, rest) = (repeated(m, x, low, known), repeated(m, x, count - low, known));
    let sum = m.pipe(format!("times_{count}_digits"), &half + (&rest << (2 * low)));
    known.insert(count, sum.clone());
    sum
}
