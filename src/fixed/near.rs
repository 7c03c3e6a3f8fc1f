//! Numbers that are a linear form up to an error whose bounds are known: what rounding in the middle of a
//! linear data path leaves of a form.
//!
//! ```text
//! (c_0 x_0 + ... + c_{N-1} x_{N-1} + e) / divisor,    low <= e <= high            (mod 2^modulus)
//! ```
//!
//! The number itself is always an integer. Where several roundings are added up their errors are taken as
//! independent, so bounds are safe; where they all can point the same way, bounds are sharp.

use super::{Form, Range};

/// See the formula above. A modulus of 0 means that the number is known, up to its error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Near<const N: usize> {
    /// The group of the variables; of no meaning without any.
    pub group: u32,
    pub coefficients: [i64; N],
    pub divisor: i128,
    pub low: i128,
    pub high: i128,
    pub modulus: u32,
}

impl<const N: usize> Near<N> {
    /// Some integer of a range.
    pub fn interval(range: Range) -> Self {
        let (low, high) = (range.min, range.max);
        Near { group: 0, coefficients: [0; N], divisor: 1, low, high, modulus: 0 }
    }

    /// A floor is less than one below what it is the floor of.
    pub fn from_form(form: &Form<N>) -> Option<Self> {
        let factor = i128::from(form.multiplier);
        let mut coefficients = form.coefficients;
        for c in &mut coefficients {
            *c = c.checked_mul(form.multiplier)?;
        }
        let addend = form.addend.checked_mul(form.divisor)?;
        let least = form.constant.checked_sub(form.divisor - 1)?;
        let (a, b) = (least.checked_mul(factor)?, form.constant.checked_mul(factor)?);
        Some(Near {
            group: form.group,
            coefficients,
            divisor: form.divisor,
            low: a.min(b).checked_add(addend)?,
            high: a.max(b).checked_add(addend)?,
            modulus: form.modulus,
        })
    }

    /// Without variables.
    pub fn is_interval(&self) -> bool {
        self.coefficients.iter().all(|&c| c == 0)
    }

    /// `± 2^shift * self`; nothing where the numbers get out of hand.
    pub fn scaled(mut self, negate: bool, shift: u32) -> Option<Self> {
        let factor = 1i64.checked_shl(shift).filter(|f| *f > 0)? * if negate { -1 } else { 1 };
        for c in &mut self.coefficients {
            *c = c.checked_mul(factor)?;
        }
        let (a, b) = (self.low.checked_mul(factor.into())?, self.high.checked_mul(factor.into())?);
        (self.low, self.high) = (a.min(b), a.max(b));
        if self.modulus != 0 {
            self.modulus += shift;
        }
        Some(self)
    }

    /// The same number over a multiple of its divisor.
    fn over(mut self, divisor: i128) -> Option<Self> {
        let factor = divisor / self.divisor;
        let small = i64::try_from(factor).ok()?;
        for c in &mut self.coefficients {
            *c = c.checked_mul(small)?;
        }
        (self.low, self.high) = (self.low.checked_mul(factor)?, self.high.checked_mul(factor)?);
        self.divisor = divisor;
        Some(self)
    }

    /// The sum; nothing for variables of different groups.
    pub fn plus(self, other: &Self) -> Option<Self> {
        if self.group != other.group && !self.is_interval() && !other.is_interval() {
            return None;
        }
        let group = if self.is_interval() { other.group } else { self.group };
        let modulus = match (self.modulus, other.modulus) {
            (0, m) | (m, 0) => m,
            (a, b) => a.min(b),
        };
        let divisor = num_integer::lcm(self.divisor, other.divisor);
        let (mut sum, other) = (self.over(divisor)?, other.over(divisor)?);
        for (a, b) in sum.coefficients.iter_mut().zip(other.coefficients) {
            *a = a.checked_add(b)?;
        }
        sum.low = sum.low.checked_add(other.low)?;
        sum.high = sum.high.checked_add(other.high)?;
        Some(Near { group, modulus, ..sum })
    }

    /// `floor(self / 2^amount)`: the number is an integer, so at most 2^amount - 1 of it is lost.
    pub fn shift_right(mut self, amount: u32) -> Option<Self> {
        if self.modulus != 0 {
            self.modulus = self.modulus.checked_sub(amount).filter(|&m| m > 0)?;
        }
        let unit = 1i128 << amount;
        self.low = self.low.checked_sub((unit - 1).checked_mul(self.divisor)?)?;
        self.divisor = self.divisor.checked_mul(unit)?;
        Some(self)
    }

    /// One or the other; nothing where they are different functions.
    pub fn either(self, other: &Self) -> Option<Self> {
        let divisor = num_integer::lcm(self.divisor, other.divisor);
        let (a, b) = (self.over(divisor)?, other.over(divisor)?);
        let same = a.coefficients == b.coefficients && (a.group == b.group || a.is_interval());
        (same && a.modulus == b.modulus).then(|| Near {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            ..a
        })
    }

    /// Every value, where each variable of the group lies in `variable`.
    pub fn range(&self, variable: Range) -> Range {
        let linear = self.coefficients.iter().fold(Range::point(0), |sum, &c| sum + variable * c.into());
        let sum = linear + Range::new(self.low, self.high);
        let (min, max) = (-(-sum.min).div_euclid(self.divisor), sum.max.div_euclid(self.divisor));
        // Bounds that only an error could reach may leave no integer between them.
        Range::new(min.min(max), max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTE: Range = Range { min: -128, max: 127 };

    /// A third of the byte, to the nearest, in units of 2^-`fraction`.
    fn third(fraction: u32) -> Form<1> {
        let mut form = Form::<1>::variable(0, 0).scaled(false, fraction + 1).unwrap();
        form.constant = 3;
        form.divisor = 6;
        form
    }

    #[test]
    fn a_sum_of_roundings_is_within_the_sum_of_their_bounds() {
        let (fine, coarse) = (third(4), third(1));
        let as_numbers = |x: i128, fraction: u32| (2 * (x << fraction) + 3).div_euclid(6);
        let (a, b) = (Near::from_form(&fine).unwrap(), Near::from_form(&coarse).unwrap());
        // floor((fine + 4) / 8) + coarse
        let half = a.plus(&Near::interval(Range::point(4))).unwrap().shift_right(3).unwrap();
        let sum = half.plus(&b).unwrap();
        let mut range: Option<Range> = None;
        for x in -128..=127 {
            let y = ((as_numbers(x, 4) + 4) >> 3) + as_numbers(x, 1);
            let e = y * sum.divisor - i128::from(sum.coefficients[0]) * x;
            assert!(sum.low <= e && e <= sum.high, "{x}: {e} in {} .. {}", sum.low, sum.high);
            let point = Range::point(y);
            range = Some(range.map_or(point, |r| r.union(point)));
        }
        assert!(sum.range(BYTE).contains(range.unwrap()));
        assert!(sum.high - sum.low <= 2 * sum.divisor + sum.divisor / 8);
    }

    #[test]
    fn negated_and_chosen_numbers() {
        let near = Near::from_form(&third(0)).unwrap();
        let negated = near.scaled(true, 1).unwrap();
        assert_eq!((negated.low, negated.high), (-2 * near.high, -2 * near.low));
        let bit = Near::<1>::interval(Range::new(0, 1));
        assert_eq!(bit.either(&Near::interval(Range::point(7))).unwrap().range(BYTE), Range::new(0, 7));
        assert!(near.either(&bit).is_none());
        let modular = Near { modulus: 4, ..near };
        assert_eq!(modular.shift_right(3).unwrap().modulus, 1);
        assert!(modular.shift_right(4).is_none());
    }
}
