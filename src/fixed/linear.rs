//! Exact linear forms, and floors of them: what a linear datapath computes, for all inputs at once.
//!
//! A [`Form`] stands for
//!
//! ```text
//! multiplier * floor((c_0 x_0 + ... + c_{N-1} x_{N-1} + constant) / divisor) + addend      (mod 2^modulus)
//! ```
//!
//! with integer coefficients over the variables of one group (say, the twelve x coordinates of one
//! patch). It is closed under everything a linear core does: adding, shifting left, rounding by a shift
//! right, and multiplying by a reciprocal.

use super::Range;

/// See the formula above. A modulus of 0 means that the number is known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form<const N: usize> {
    pub group: u32,
    pub coefficients: [i64; N],
    pub constant: i128,
    pub divisor: i128,
    pub multiplier: i64,
    pub addend: i128,
    pub modulus: u32,
}

impl<const N: usize> Form<N> {
    /// The variable x_`index` of a group.
    pub fn variable(group: u32, index: usize) -> Self {
        let mut coefficients = [0; N];
        coefficients[index] = 1;
        Form { group, coefficients, constant: 0, divisor: 1, multiplier: 1, addend: 0, modulus: 0 }
    }

    fn is_linear(&self) -> bool {
        self.divisor == 1
    }

    /// `± 2^shift * self`; nothing where the numbers get out of hand.
    pub fn scaled(mut self, negate: bool, shift: u32) -> Option<Self> {
        if !negate && shift == 0 {
            return Some(self);
        }
        let factor = 1i64.checked_shl(shift).filter(|f| *f > 0)? * if negate { -1 } else { 1 };
        if self.is_linear() {
            for c in &mut self.coefficients {
                *c = c.checked_mul(factor)?;
            }
            self.constant = self.constant.checked_mul(factor.into())?;
        } else {
            self.multiplier = self.multiplier.checked_mul(factor)?;
            self.addend = self.addend.checked_mul(factor.into())?;
        }
        if self.modulus != 0 {
            self.modulus += shift;
        }
        Some(self)
    }

    /// The sum of a floor, taken once, and a linear form.
    fn into_floor(mut self, linear: &Self) -> Option<Self> {
        let factor = i64::try_from(self.divisor).ok()?;
        if self.group != linear.group || self.modulus != 0 || linear.modulus != 0 {
            return None;
        }
        for (a, &b) in self.coefficients.iter_mut().zip(&linear.coefficients) {
            *a = a.checked_add(b.checked_mul(factor)?)?;
        }
        self.constant = self.constant.checked_add(linear.constant.checked_mul(self.divisor)?)?;
        Some(self)
    }

    pub fn plus_constant(mut self, constant: i128) -> Option<Self> {
        let part = if self.is_linear() { &mut self.constant } else { &mut self.addend };
        *part = part.checked_add(constant)?;
        Some(self)
    }

    /// The sum; nothing for different groups, or for floors of different things. What is no floor goes into one:
    /// floor(L / d) + M = floor((L + d M) / d).
    pub fn plus(mut self, other: &Self) -> Option<Self> {
        match (self.is_linear(), other.is_linear()) {
            (false, true) if self.multiplier == 1 => return self.into_floor(other),
            (true, false) if other.multiplier == 1 => return other.into_floor(&self),
            _ => {}
        }
        if self.group != other.group || self.divisor != other.divisor {
            return None;
        }
        self.modulus = match (self.modulus, other.modulus) {
            (0, m) | (m, 0) => m,
            (a, b) => a.min(b),
        };
        if self.is_linear() {
            let mut overflow = 0;
            for (a, &b) in self.coefficients.iter_mut().zip(&other.coefficients) {
                let sum = a.wrapping_add(b);
                overflow |= (*a ^ sum) & (b ^ sum);
                *a = sum;
            }
            self.constant = self.constant.checked_add(other.constant)?;
            return (overflow >= 0).then_some(self);
        }
        let same = self.coefficients == other.coefficients && self.constant == other.constant;
        self.multiplier = self.multiplier.checked_add(other.multiplier)?;
        self.addend = self.addend.checked_add(other.addend)?;
        (same && self.multiplier != 0).then_some(self)
    }

    /// Every value, where each variable of the group lies in `variable`.
    pub fn range(&self, variable: Range) -> Range {
        let linear =
            self.coefficients.iter().fold(Range::point(self.constant), |sum, &c| sum + variable * c.into());
        let floor = Range::new(linear.min.div_euclid(self.divisor), linear.max.div_euclid(self.divisor));
        floor * self.multiplier.into() + Range::point(self.addend)
    }

    /// `floor(self / 2^amount)`; nothing where that has no such form.
    ///
    /// A multiple m of a floor X needs the reciprocal's lemma: with D the least integer for which
    /// e = m D - 2^k >= 0, floor(m X / 2^k) = floor(X / D) for all 0 <= X with X e < 2^k.
    pub fn shift_right(mut self, amount: u32, variable: Range) -> Option<Self> {
        if self.modulus != 0 {
            return None;
        }
        let unit = 1i128 << amount;
        if self.multiplier != 1 {
            let factor = i128::from(self.multiplier);
            // m floor(x / d) + m a = m floor((x + a d) / d).
            let absorbed = (self.addend / factor).checked_mul(self.divisor)?;
            let constant = self.constant.checked_add(absorbed)?;
            let once = Form { multiplier: 1, addend: 0, constant, ..self };
            let largest = once.range(variable);
            if factor < 0 || self.addend % factor != 0 || largest.min < 0 {
                return None;
            }
            let quotient = (unit + factor - 1) / factor;
            let excess = factor * quotient - unit;
            if largest.max.checked_mul(excess)? >= unit {
                return None;
            }
            return Some(Form { divisor: self.divisor.checked_mul(quotient)?, ..once });
        }
        self.constant = self.constant.checked_add(self.addend.checked_mul(self.divisor)?)?;
        self.addend = 0;
        self.divisor = self.divisor.checked_mul(unit)?;
        Some(self)
    }

    /// Whether every value is a multiple of 2^`amount`.
    pub fn is_multiple(&self, amount: u32) -> bool {
        let mask = (1i128 << amount) - 1;
        (self.modulus == 0 || self.modulus >= amount)
            && self.is_linear()
            && self.coefficients.iter().all(|&c| i128::from(c) & mask == 0)
            && self.constant & mask == 0
    }

    /// The same function with everything that cancels cancelled, so that equal functions compare equal:
    /// floor((g L + c) / (g d)) = floor((L + floor(c / g)) / d).
    pub fn canonical(mut self) -> Self {
        if self.multiplier == 1 && self.modulus == 0 {
            self.constant += self.addend * self.divisor;
            self.addend = 0;
            let common = self.coefficients.iter().fold(self.divisor, |g, &c| gcd(g, c.into()));
            self.coefficients.iter_mut().for_each(|c| *c = (i128::from(*c) / common) as i64);
            self.constant = self.constant.div_euclid(common);
            self.divisor /= common;
        }
        self
    }
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTE: Range = Range { min: -128, max: 127 };

    #[test]
    fn a_division_by_three_is_recognised_and_only_where_it_is_right() {
        let x = Form::<1>::variable(0, 0).plus_constant(128).unwrap();
        // 171 / 2^9 is 1/3 for all x < 2^8 ...
        let times = |m: i64| Form { multiplier: m, divisor: 2, ..x };
        let third = times(171).shift_right(9, BYTE).unwrap();
        assert_eq!(third.divisor, 6);
        for v in -128..=127i128 {
            assert_eq!((((v + 128) >> 1) * 171) >> 9, (v + 128).div_euclid(6));
        }
        // ... and 43 / 2^7 no longer is, once x is large enough.
        assert!(times(43).shift_right(7, BYTE).is_some());
        let wide = Range::new(-128, 1 << 12);
        assert!(times(43).shift_right(7, wide).is_none());
        // What was added behind the floor goes into it, where it was multiplied too.
        let biased = Form { addend: 171 * 5, ..times(171) }.shift_right(9, BYTE).unwrap();
        assert_eq!((biased.constant, biased.divisor, biased.addend), (128 + 2 * 5, 6, 0));
        for v in -128..=127i128 {
            assert_eq!((((v + 128) >> 1) * 171 + 171 * 5) >> 9, (v + 138).div_euclid(6));
        }
        assert!(Form { addend: 171 * 5 + 1, ..times(171) }.shift_right(9, BYTE).is_none());
    }

    #[test]
    fn equal_functions_have_one_canonical_form() {
        let x = Form::<1>::variable(0, 0);
        let doubled = x.scaled(false, 1).unwrap().plus_constant(1).unwrap().shift_right(3, BYTE).unwrap();
        let plain = x.shift_right(2, BYTE).unwrap();
        assert_eq!(doubled.canonical(), plain.canonical());
        assert_ne!(x.plus_constant(1).unwrap().shift_right(2, BYTE).unwrap().canonical(), plain.canonical());
    }

    /// floor(x / 4) + 3 y is floor((x + 12 y) / 4).
    #[test]
    fn a_whole_number_goes_into_a_floor() {
        let [x, y] = [0, 1].map(|index| Form::<2>::variable(0, index));
        let floor = x.shift_right(2, BYTE).unwrap();
        let triple = y.plus(&y).unwrap().plus(&y).unwrap();
        let whole = x.plus(&triple.scaled(false, 2).unwrap()).unwrap().shift_right(2, BYTE).unwrap();
        assert_eq!(floor.plus(&triple), Some(whole));
        assert_eq!(triple.plus(&floor), Some(whole));
    }

    #[test]
    fn sums_of_different_things_have_no_form() {
        let (a, b) = (Form::<2>::variable(0, 0), Form::<2>::variable(1, 0));
        assert!(a.plus(&b).is_none());
        let floor = a.shift_right(1, BYTE).unwrap();
        assert!(floor.plus(&a.shift_right(2, BYTE).unwrap()).is_none());
        let twice = floor.plus(&floor).unwrap();
        assert_eq!(twice.multiplier, 2);
        assert!(twice.plus(&a).is_none());
    }
}
