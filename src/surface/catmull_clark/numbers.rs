//! The number formats of a strip engine: how many fraction bits the vertices of a level have.
//!
//! ```text
//!   exact      6l bits at level l     F needs 2 bits more than its source, E 4, V' 6; the integer part stays
//!   guard g    g bits at every level  one rounding per new vertex, of its unrounded sum
//! ```

use std::fmt;

/// The largest number of levels that a strip is subdivided by.
pub const MAX_LEVELS: u32 = 7;

/// Fraction bits of positions beyond those of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// 6 bits a level: nothing is ever rounded where all valences are 4. Other vertices are rounded half up
    /// to the same 6 bits a level.
    Exact,
    /// This many bits at every level.
    Guard(u32),
}

impl Numbers {
    /// The most guard bits: as many as the exact format has at level 7.
    pub const MAX_GUARD: u32 = 6 * MAX_LEVELS;

    /// Fraction bits of a vertex at `level` (0 is the input).
    pub fn fraction(self, level: u32) -> u32 {
        match self {
            Numbers::Exact => 6 * level,
            Numbers::Guard(bits) => bits,
        }
    }

    /// The fewest guard bits with which every output, rounded once more at the end, is at most `excess` over
    /// half a unit off on a regular mesh: L 2^-(g+1) <= excess.
    pub fn guard_for(levels: u32, excess: f64) -> Numbers {
        let enough = |g: &u32| f64::from(levels) * (-f64::from(*g) - 1.0).exp2() <= excess;
        Numbers::Guard((0..Self::MAX_GUARD).find(enough).unwrap_or(Self::MAX_GUARD))
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Numbers::Exact => f.write_str("exact"),
            Numbers::Guard(bits) => write!(f, "{bits} guard bits"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guard_bits_for_a_goal() {
        let table = |excess| [1, 2, 3, 4, 5, 6].map(|levels| Numbers::guard_for(levels, excess));
        assert_eq!(table(0.5), [0, 1, 2, 2, 3, 3].map(Numbers::Guard));
        assert_eq!(table(0.0625), [3, 4, 5, 5, 6, 6].map(Numbers::Guard));
        assert_eq!([1, 6].map(|level| Numbers::Exact.fraction(level)), [6, 36]);
    }
}
