//! The two integer words that exact points are kept in: 64 bits where the bound fits, else 128.
//!
//! A patch hierarchy over coordinates of W bits at maximum level R keeps all points, limits and samples in
//! W + 4R + 4 bits. Sums wrap: intermediate overflow is harmless where the result fits.

/// A two's-complement integer with wrapping arithmetic.
pub trait Word: Copy + Default + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    const ZERO: Self;
    const BITS: u32;

    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    /// Times a small constant.
    fn times(self, factor: i64) -> Self;
    /// Times 2^bits.
    fn shifted_left(self, bits: u32) -> Self;
    /// floor(self / 2^bits).
    fn shifted_right(self, bits: u32) -> Self;
    /// floor(self / 3).
    fn third(self) -> Self;
    fn wide(self) -> i128;
    /// The low bits of a wide integer.
    fn narrow(wide: i128) -> Self;
}

macro_rules! word {
    ($integer:ty) => {
        impl Word for $integer {
            const ZERO: Self = 0;
            const BITS: u32 = <$integer>::BITS;

            #[inline]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline]
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline]
            fn times(self, factor: i64) -> Self {
                self.wrapping_mul(factor as $integer)
            }
            #[inline]
            fn shifted_left(self, bits: u32) -> Self {
                self << bits
            }
            #[inline]
            fn shifted_right(self, bits: u32) -> Self {
                self >> bits
            }
            #[inline]
            fn third(self) -> Self {
                self.div_euclid(3)
            }
            #[inline]
            fn wide(self) -> i128 {
                self.into()
            }
            #[inline]
            fn narrow(wide: i128) -> Self {
                wide as $integer
            }
        }
    };
}

word!(i64);
word!(i128);
