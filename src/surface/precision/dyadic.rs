//! Non-negative numbers over a power of two, exact.

use std::cmp::Ordering;
use std::fmt;

/// `numerator / 2^bits`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dyadic {
    pub numerator: u128,
    pub bits: u32,
}

impl Dyadic {
    pub const HALF: Dyadic = Dyadic { numerator: 1, bits: 1 };

    pub fn new(numerator: u128, bits: u32) -> Self {
        Dyadic { numerator, bits }
    }

    /// Times 2^power; exact while the number fits.
    pub fn scaled(self, power: i32) -> Self {
        if power <= 0 {
            return Dyadic { bits: self.bits + power.unsigned_abs(), ..self };
        }
        let (cancelled, power) = (self.bits.min(power as u32), power as u32);
        Dyadic { numerator: self.numerator << (power - cancelled), bits: self.bits - cancelled }
    }

    pub fn plus(self, other: Self) -> Self {
        let bits = self.bits.max(other.bits);
        let over = |x: Dyadic| x.numerator << (bits - x.bits);
        Dyadic { numerator: over(self) + over(other), bits }
    }

    /// The number in `f64`, rounded up where it does not fit.
    pub fn to_f64_up(self) -> f64 {
        let nearest = self.numerator as f64;
        // Above 2^53 a conversion may have rounded down.
        let up = if nearest as u128 >= self.numerator { nearest } else { nearest.next_up() };
        up * (-f64::from(self.bits)).exp2()
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        let trim = |x: Dyadic| {
            let zeros = x.numerator.trailing_zeros().min(x.bits);
            (x.numerator >> zeros, x.bits - zeros)
        };
        let ((a, p), (b, q)) = (trim(*self), trim(*other));
        // Bits of the whole part decide unless they are equal; then the shift is small enough to fit.
        let whole = |x: u128, bits: u32| (128 - x.leading_zeros()) as i64 - i64::from(bits);
        match (a, b) {
            (0, _) | (_, 0) => a.cmp(&b),
            _ => whole(a, p).cmp(&whole(b, q)).then_with(|| {
                let bits = p.max(q);
                (a << (bits - p)).cmp(&(b << (bits - q)))
            }),
        }
    }
}

impl fmt::Display for Dyadic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/2^{}", self.numerator, self.bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_sums_are_those_of_the_numbers() {
        let d = Dyadic::new;
        assert_eq!(d(4, 3), Dyadic::HALF);
        assert!(d(3, 3) < Dyadic::HALF && d(5, 3) > Dyadic::HALF && d(0, 0) < d(1, 100));
        assert_eq!(d(1, 2).plus(d(1, 2)), Dyadic::HALF);
        assert_eq!(d(3, 1).scaled(4), d(24, 0));
        assert_eq!(d(3, 1).scaled(-2), d(3, 3));
        assert_eq!(d(u128::MAX >> 1, 0).cmp(&d(1, 0)), Ordering::Greater);
        assert!(d((1 << 60) + 1, 0).to_f64_up() > (60f64).exp2());
    }
}
