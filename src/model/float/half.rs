//! Half precision (IEEE 754 binary16), emulated: each operation in `f64`, where sums and products of two
//! halves are exact, then one rounding to 11 significant bits, to the nearest with ties to even.

use super::Float;

/// A number of half precision: 11 significant bits, from 2^-24 (below 2^-14 with fewer bits) to 65504.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Half(f64);

impl Float for Half {
    const ZERO: Self = Half(0.0);

    fn rounded(x: f64) -> Self {
        if !x.is_finite() || x == 0.0 {
            return Half(x);
        }
        // Below 2^-14 the unit of the last place stays 2^-24.
        let exponent = x.abs().log2().floor().max(-14.0);
        let unit = (exponent - 10.0).exp2();
        let rounded = (x / unit).round_ties_even() * unit;
        Half(if rounded.abs() >= 65536.0 { f64::INFINITY.copysign(x) } else { rounded })
    }
    fn plus(self, other: Self) -> Self {
        Half::rounded(self.0 + other.0)
    }
    fn minus(self, other: Self) -> Self {
        Half::rounded(self.0 - other.0)
    }
    fn times(self, other: Self) -> Self {
        Half::rounded(self.0 * other.0)
    }
    fn wide(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of a bit pattern, by the definition of the format.
    fn number(bits: u16) -> f64 {
        let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
        let magnitude = match exponent {
            0 => mantissa * (-24f64).exp2(),
            31 => f64::INFINITY,
            e => (1024.0 + mantissa) * f64::from(e - 25).exp2(),
        };
        if bits >> 15 == 1 { -magnitude } else { magnitude }
    }

    #[test]
    fn every_number_of_the_format_is_kept_and_the_middle_of_two_goes_to_the_even_one() {
        for bits in 0..0x7c00u16 {
            let (x, next) = (number(bits), number(bits + 1));
            assert_eq!(Half::rounded(x).wide(), x);
            assert_eq!(Half::rounded(-x).wide(), -x);
            let next = if next.is_infinite() { 65536.0 } else { next };
            let middle = (x + next) / 2.0;
            let even = if bits % 2 == 0 { x } else { number(bits + 1) };
            assert_eq!(Half::rounded(middle).wide(), even, "between {x} and {next}");
            assert_eq!(Half::rounded(middle.next_down()).wide(), x);
        }
    }
}
