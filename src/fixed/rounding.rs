//! Rounding as a named choice. Dropping two bits (unit = 4), in units of the result:
//!
//! | mode | 1.25 | 1.5 | 1.75 | 2.5 | -1.5 | -1.25 |
//! |---|---|---|---|---|---|---|
//! | `Floor` | 1 | 1 | 1 | 2 | -2 | -2 |
//! | `Truncate` | 1 | 1 | 1 | 2 | -1 | -1 |
//! | `HalfUp` | 1 | 2 | 2 | 3 | -1 | -1 |
//! | `HalfEven` | 1 | 2 | 2 | 2 | -2 | -1 |
//! | `Exact` | error | error | error | error | error | error |

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// How a number loses its last bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rounding {
    /// Towards minus infinity.
    Floor,
    /// Towards zero.
    Truncate,
    /// To the nearest; a tie goes up.
    HalfUp,
    /// To the nearest; a tie goes to the even neighbour.
    HalfEven,
    /// The dropped bits must be proved zero; anything else is an error of the design.
    Exact,
}

impl Rounding {
    /// The modes that give every number a result.
    pub const TOTAL: [Rounding; 4] =
        [Rounding::HalfUp, Rounding::HalfEven, Rounding::Floor, Rounding::Truncate];

    /// `value / 2^drop` rounded; nothing where `Exact` is asked of a number that has bits to lose.
    pub fn apply(self, value: i128, drop: u32) -> Option<i128> {
        if drop == 0 {
            return Some(value);
        }
        let half = 1i128 << (drop - 1);
        match self {
            Rounding::Floor => Some(value >> drop),
            Rounding::Truncate => Some((value + if value < 0 { 2 * half - 1 } else { 0 }) >> drop),
            Rounding::HalfUp => Some((value + half) >> drop),
            Rounding::HalfEven => Some((value + half - 1 + ((value >> drop) & 1)) >> drop),
            Rounding::Exact => (value & ((1 << drop) - 1) == 0).then_some(value >> drop),
        }
    }
}

impl fmt::Display for Rounding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Rounding::Floor => "floor",
            Rounding::Truncate => "truncate",
            Rounding::HalfUp => "half-up",
            Rounding::HalfEven => "half-even",
            Rounding::Exact => "exact",
        })
    }
}

impl FromStr for Rounding {
    type Err = Error;

    /// One of [`Rounding::TOTAL`] by its name.
    fn from_str(text: &str) -> Result<Self, Error> {
        let found = Rounding::TOTAL.into_iter().find(|mode| mode.to_string() == text);
        found.ok_or_else(|| {
            Error::usage(format!("'{text}' is no rounding mode"))
                .help("choose half-up, half-even, floor or truncate")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_documentation_holds() {
        let quarters = [5, 6, 7, 10, -6, -5];
        for (mode, expected) in [
            (Rounding::Floor, [1, 1, 1, 2, -2, -2]),
            (Rounding::Truncate, [1, 1, 1, 2, -1, -1]),
            (Rounding::HalfUp, [1, 2, 2, 3, -1, -1]),
            (Rounding::HalfEven, [1, 2, 2, 2, -2, -1]),
        ] {
            assert_eq!(quarters.map(|q| mode.apply(q, 2).unwrap()), expected, "{mode}");
            assert_eq!(mode.to_string().parse::<Rounding>().unwrap(), mode);
        }
        assert_eq!(Rounding::Truncate.apply(-8, 2), Some(-2));
        assert_eq!(Rounding::Exact.apply(6, 2), None);
        assert_eq!(Rounding::Exact.apply(8, 2), Some(2));
        assert!("exact".parse::<Rounding>().is_err());
    }
}
