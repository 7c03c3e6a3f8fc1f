//! How a forward-difference engine keeps its numbers: exactly, or with fewer fraction bits.
//!
//! ```text
//!   a difference D(k,l) of order m = k + l is kept as an integer, rnd(D * 2^F_m)
//!
//!   uniform      F_0 = F_1 = ... = F_4      adds are exact, only the start-up rounds
//!   progressive  F_0 <= F_1 <= ... <= F_4   an add rounds its addend to the coarser order below
//! ```
//!
//! Fraction bits count from the unit of the control coordinates downwards. The higher the order, the more
//! often it is added up and the smaller it is: progressive fractions give each order the bits it needs.

use std::fmt;
use std::str::FromStr;

use super::Rounding;
use crate::error::{Error, Result};

/// The highest order of a difference.
pub const HIGHEST_ORDER: usize = 4;

/// F_0 <= F_1 <= ... <= F_4.
///
/// ```
/// use subdiv_rtl::fixed::Fractions;
/// let f: Fractions = "7,11,15,18,18".parse().unwrap();
/// assert_eq!((f.of(2), f.dropped(1), f.dropped(3)), (15, 4, 0));
/// assert!("17".parse::<Fractions>().unwrap().is_uniform());
/// assert!("7,11,10,18,18".parse::<Fractions>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Fractions([u32; HIGHEST_ORDER + 1]);

impl Fractions {
    /// More fraction bits than this are refused; exact numbers have 4R + 2 <= 42 (and a factor 3).
    pub const MOST: u32 = 48;

    /// # Errors
    /// Fractions that fall with the order, more than [`Fractions::MOST`] bits.
    pub fn new(bits: [u32; HIGHEST_ORDER + 1]) -> Result<Self> {
        let fractions = Fractions(bits);
        if !bits.is_sorted() || bits[HIGHEST_ORDER] > Self::MOST {
            return Err(Error::usage(format!("fraction bits {fractions}")).help(format!(
                "give five numbers from 0 to {} that do not fall, for example 7,11,15,18,18",
                Self::MOST
            )));
        }
        Ok(fractions)
    }

    /// # Errors
    /// As [`Fractions::new`].
    pub fn uniform(bits: u32) -> Result<Self> {
        Self::new([bits; HIGHEST_ORDER + 1])
    }

    /// F_m.
    pub fn of(self, order: usize) -> u32 {
        self.0[order]
    }

    pub fn all(self) -> [u32; HIGHEST_ORDER + 1] {
        self.0
    }

    /// t_m = F_(m+1) - F_m: bits that an addend loses on its way into order `order` < 4.
    pub fn dropped(self, order: usize) -> u32 {
        self.0[order + 1] - self.0[order]
    }

    pub fn is_uniform(self) -> bool {
        self.0[0] == self.0[HIGHEST_ORDER]
    }
}

impl fmt::Display for Fractions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_uniform() {
            return write!(f, "{}", self.0[0]);
        }
        let [a, b, c, d, e] = self.0;
        write!(f, "{a},{b},{c},{d},{e}")
    }
}

impl FromStr for Fractions {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([one]) => Fractions::uniform(*one),
            Some([a, b, c, d, e]) => Fractions::new([*a, *b, *c, *d, *e]),
            _ => Err(Error::usage(format!("'{text}' are no fraction bits"))
                .help("give one number, or five for the orders 0 to 4, for example 7,11,15,18,18")),
        }
    }
}

/// Fewer bits than exact ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Reduced {
    pub fractions: Fractions,
    /// Of the start-up and, with progressive fractions, of the addends. A vertex is always rounded half up.
    pub rounding: Rounding,
    /// A vertex that rounding moved out of the output format is put back to its end; else the output has
    /// the bits for it.
    pub saturate: bool,
}

impl Reduced {
    /// Half up, without saturation.
    pub fn new(fractions: Fractions) -> Self {
        Reduced { fractions, rounding: Rounding::HalfUp, saturate: false }
    }
}

/// How the differences are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Precision {
    /// Integers over 12 * 16^R: nothing is lost before the one rounding of a vertex.
    #[default]
    Exact,
    Reduced(Reduced),
}

impl Precision {
    pub fn reduced(self) -> Option<Reduced> {
        match self {
            Precision::Exact => None,
            Precision::Reduced(reduced) => Some(reduced),
        }
    }
}

/// `exact`, `17 half-up`, `7,11,15,18,18 floor saturate`.
impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Precision::Exact => f.write_str("exact"),
            Precision::Reduced(Reduced { fractions, rounding, saturate }) => {
                write!(f, "{fractions} {rounding}{}", if *saturate { " saturate" } else { "" })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_that_no_engine_has_are_refused() {
        for bad in ["", "x", "1,2", "1,2,3,4,5,6", "49", "5,4,4,4,4", "-1"] {
            assert!(bad.parse::<Fractions>().unwrap_err().help.is_some(), "{bad}");
        }
    }

    #[test]
    fn what_is_printed_reads_back() {
        for text in ["17", "7,11,15,18,18"] {
            assert_eq!(text.parse::<Fractions>().unwrap().to_string(), text);
        }
    }
}
