//! `Qi.f`: a two's-complement fixed-point format with `i` integer bits (the sign included) and
//! `f` fraction bits.
//!
//! ```
//! use subdiv_rtl::fixed::Format;
//! let q: Format = "Q4.8".parse().unwrap();
//! assert_eq!((q.width(), q.lsb()), (12, 1.0 / 256.0));
//! assert_eq!(q.quantise(0.5), Some(128));
//! assert_eq!(q.quantise(8.0), None);      // the largest number is 8 - 1/256
//! assert_eq!(q.decimal(-1), "-0.00390625");
//! ```

use crate::error::Error;
use std::{fmt, str::FromStr};

/// A signed fixed-point format of `integer + fraction` bits; the unit of the last place is 2^-fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Format {
    /// Integer bits, the sign included; at least 1.
    pub integer: u32,
    /// Fraction bits.
    pub fraction: u32,
}

impl Format {
    /// The widest coordinate that the cores accept.
    pub const WIDEST: u32 = 32;

    pub fn new(integer: u32, fraction: u32) -> Option<Self> {
        (integer >= 1 && (2..=Self::WIDEST).contains(&(integer + fraction)))
            .then_some(Format { integer, fraction })
    }

    /// Total bits, W.
    pub fn width(self) -> u32 {
        self.integer + self.fraction
    }

    pub fn lsb(self) -> f64 {
        (-f64::from(self.fraction)).exp2()
    }

    pub fn min(self) -> i64 {
        -(1 << (self.width() - 1))
    }

    pub fn max(self) -> i64 {
        (1 << (self.width() - 1)) - 1
    }

    /// The nearest representable integer (half up), or nothing where the number does not fit.
    pub fn quantise(self, x: f64) -> Option<i64> {
        let scaled = (x * f64::from(self.fraction).exp2() + 0.5).floor();
        (scaled >= self.min() as f64 && scaled <= self.max() as f64).then_some(scaled as i64)
    }

    /// Whether the number is a multiple of the unit, so that quantising loses nothing.
    pub fn represents(self, x: f64) -> bool {
        self.quantise(x).is_some_and(|q| q as f64 * self.lsb() == x)
    }

    /// The widest fraction, at `width` bits in all, whose range holds every number up to `largest` in magnitude.
    pub fn widest_fraction(largest: f64, width: u32) -> Option<Self> {
        (1..=width).find_map(|integer| {
            let format = Format::new(integer, width - integer)?;
            (format.quantise(largest).is_some() && format.quantise(-largest).is_some()).then_some(format)
        })
    }

    /// `value` units as an exact decimal number.
    pub fn decimal(self, value: i64) -> String {
        decimal(value.into(), self.fraction)
    }
}

/// `value / 2^fraction` as an exact decimal number, without trailing zeros.
pub fn decimal(value: i128, fraction: u32) -> String {
    let magnitude = value.unsigned_abs();
    let (whole, mut rest) = (magnitude >> fraction, magnitude & ((1u128 << fraction) - 1));
    let mut text = format!("{}{whole}", if value < 0 { "-" } else { "" });
    if rest != 0 {
        text.push('.');
    }
    while rest != 0 {
        rest *= 10;
        text.push(char::from(b'0' + (rest >> fraction) as u8));
        rest &= (1u128 << fraction) - 1;
    }
    text
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Q{}.{}", self.integer, self.fraction)
    }
}

impl FromStr for Format {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let parts = text.strip_prefix(['Q', 'q']).and_then(|t| t.split_once('.'));
        let numbers = parts.and_then(|(i, f)| Some((i.parse::<u16>().ok()?, f.parse::<u16>().ok()?)));
        let (integer, fraction) = numbers.ok_or_else(|| {
            Error::usage(format!("'{text}' is no fixed-point format")).help(
                "write Qi.f with i integer bits (the sign included) and f fraction bits, for example Q12.12",
            )
        })?;
        Format::new(integer.into(), fraction.into()).ok_or_else(|| {
            Error::usage(format!("{text} has {} bits", u32::from(integer) + u32::from(fraction))).help(
                format!("use at least one integer bit (the sign) and 2 to {} bits in all", Self::WIDEST),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact() {
        assert_eq!(decimal(5, 1), "2.5");
        assert_eq!(decimal(-5, 3), "-0.625");
        assert_eq!(decimal(8, 3), "1");
        assert_eq!(decimal(0, 12), "0");
    }

    #[test]
    fn the_widest_fraction_holds_both_signs() {
        assert_eq!(Format::widest_fraction(1.0, 24), Some(Format { integer: 2, fraction: 22 }));
        assert_eq!(Format::widest_fraction(0.99, 24), Some(Format { integer: 1, fraction: 23 }));
        assert_eq!(Format::widest_fraction(1e300, 24), None);
    }

    #[test]
    fn text_that_is_no_format_is_refused_with_a_remedy() {
        for bad in ["", "12.12", "Q12", "Qx.3", "Q0.8", "Q20.20", "Q1.0"] {
            assert!(bad.parse::<Format>().unwrap_err().help.is_some(), "{bad}");
        }
    }
}
