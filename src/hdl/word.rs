//! What a signal's numbers can be: exact range and binary point. Widths follow, nobody types them.

use crate::fixed::Range;
use std::fmt;

/// The numbers that a signal carries: integers in `range`, each worth 2^-`fraction`.
///
/// A *modular* word holds a number only up to multiples of 2^width: a sum of modular words wraps round
/// instead of growing. A linear recurrence may run modulo 2^B however large its registers would be; if
/// the result that is read fits B bits, it is exact. `Module::claim` turns a modular word back into a
/// number, and the claim is proved before anything is emitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Word {
    pub range: Range,
    pub fraction: i32,
    pub modular: bool,
}

impl Word {
    /// Integers of a range.
    pub fn range(min: i128, max: i128) -> Self {
        Range::new(min, max).into()
    }
    /// One bit.
    pub fn bit() -> Self {
        Word::unsigned(1)
    }
    /// Unsigned integers of `width` bits. (Far too wide words are cut here and refused by the builder.)
    pub fn unsigned(width: u32) -> Self {
        Range::unsigned(width.min(Range::WIDEST + 1)).into()
    }
    /// Two's-complement integers of `width` bits.
    pub fn signed(width: u32) -> Self {
        Range::signed(width.min(Range::WIDEST + 1)).into()
    }
    /// Two's-complement integers modulo 2^`width`.
    pub fn modular(width: u32) -> Self {
        Word { modular: true, ..Word::signed(width) }
    }
    /// The same word with its binary point `fraction` places from the right.
    pub fn fraction(self, fraction: i32) -> Self {
        Word { fraction, ..self }
    }
    pub fn width(self) -> u32 {
        self.range.width()
    }
    pub fn is_signed(self) -> bool {
        self.range.is_signed()
    }
}

impl From<Range> for Word {
    fn from(range: Range) -> Self {
        Word { range, fraction: 0, modular: false }
    }
}

/// `sQ28.32 mod 2^60`, `uQ3.0 [0, 7]`: the comment beside each declaration.
impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.is_signed() { 's' } else { 'u' };
        write!(f, "{sign}Q{}.{}", self.width() as i32 - self.fraction, self.fraction)?;
        if self.modular { write!(f, " mod 2^{}", self.width()) } else { write!(f, " {}", self.range) }
    }
}
