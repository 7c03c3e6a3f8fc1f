//! The look-up table of irregular interior vertices: w_n and g_n as integers over 2^bits.
//!
//! ```text
//!   V' = V + w_n (S - n V)        limit = V + g_n (S - n V)        S = sum of the ring
//! ```
//!
//! In this one-coefficient form the weights sum to one exactly whatever the rounding of the entry, so a
//! quantised table can neither shift nor scale a model. The entries are rounded correctly, from 200-bit
//! integer arithmetic. Source of the weights: Bischoff, Kobbelt, Seidel 2000, Figures 2 and 8.

use crate::error::{Error, Result};
use crate::surface::cosine::cosine_of_turn;
use num_bigint::BigInt;
use num_traits::ToPrimitive;
use std::sync::OnceLock;

/// The largest valence of an interior vertex, and of a boundary vertex.
pub const MAX_VALENCE: usize = 32;

/// Fraction bits of the weights from which the tables are rounded.
pub const WEIGHT_BITS: u32 = 200;

/// w_n and g_n of every interior valence 3..=32, correctly rounded to `bits` fraction bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    bits: u32,
    w: [i64; MAX_VALENCE + 1],
    g: [i64; MAX_VALENCE + 1],
}

impl Table {
    /// The bits a table may have. From 8 on w_3 and w_4 (3/16 and 31/256) are exact; up to 52 the product
    /// 12 g_n (S - nV) of a 32-bit coordinate at level 10 fits 128 bits.
    pub const BITS: std::ops::RangeInclusive<u32> = 8..=52;

    /// # Errors
    /// `bits` outside [`Table::BITS`].
    pub fn new(bits: u32) -> Result<Self> {
        if !Self::BITS.contains(&bits) {
            return Err(Error::usage(format!("a weight table of {bits} bits cannot be made"))
                .help("use 8 to 52 bits; the coordinate width + 16 is the default"));
        }
        let (mut w, mut g) = ([0; MAX_VALENCE + 1], [0; MAX_VALENCE + 1]);
        for (n, weights) in weights().iter().enumerate().skip(3) {
            w[n] = round_to(&weights.w, bits);
            g[n] = round_to(&weights.g, bits);
        }
        Ok(Table { bits, w, g })
    }

    /// The table for coordinates of `width` bits (2..=32): `width + 16` bits.
    ///
    /// Why 16: the table's part of the error of any surface point is at most K_n 2^-bits D0 with the ring
    /// radius D0 < 2^width and K_32 = 105 (see [`crate::surface::error_bound`]), so below 1/600 unit; with
    /// the rounding of irregular vertices, at most 1/30, it stays below 1/16.
    ///
    /// # Errors
    /// A width outside 2..=32.
    pub fn for_width(width: u32) -> Result<Self> {
        if !(2..=32).contains(&width) {
            return Err(Error::usage(format!("coordinates of {width} bits"))
                .help("use 2 to 32 bits, for example Q12.12"));
        }
        Self::new(width + 16)
    }

    /// Fraction bits of the entries.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// w_n over 2^bits, for an interior valence 3..=32.
    pub fn w(&self, valence: usize) -> i64 {
        self.w[valence]
    }

    /// g_n over 2^bits, for an interior valence 3..=32.
    pub fn g(&self, valence: usize) -> i64 {
        self.g[valence]
    }
}

/// The two weights of one valence over 2^[`WEIGHT_BITS`], wrong by less than 2^5 units.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// w_n = alpha_n / n
    pub w: BigInt,
    /// g_n = gamma_n / n
    pub g: BigInt,
}

/// The weights of all valences, indexed by valence (entries 0..=2 are unused zeros), computed once.
pub fn weights() -> &'static [Weights] {
    static WEIGHTS: OnceLock<Vec<Weights>> = OnceLock::new();
    WEIGHTS.get_or_init(|| {
        let one = BigInt::from(1) << WEIGHT_BITS;
        let of_valence = |n: usize| {
            if n < 3 {
                return Weights::default();
            }
            // 64 alpha = 40 - (3 + 2 cos)^2;  gamma = 64 alpha / (24 + 64 alpha)
            let c = &one * 3 + cosine_of_turn(n as u32, WEIGHT_BITS) * 2;
            let alpha64: BigInt = &one * 40 - ((&c * &c) >> WEIGHT_BITS);
            let gamma: BigInt = (&alpha64 << WEIGHT_BITS) / (&one * 24 + &alpha64);
            Weights { w: alpha64 / (64 * n), g: gamma / n }
        };
        (0..=MAX_VALENCE).map(of_valence).collect()
    })
}

/// Half up to `bits` fraction bits. No weight lies near a tie: the exact ones are multiples of 2^-8 or have
/// a denominator 3, 5, 11 or 55, and the test below measures the distance of the others.
fn round_to(weight: &BigInt, bits: u32) -> i64 {
    let shift = WEIGHT_BITS - bits;
    let rounded: BigInt = (weight + (BigInt::from(1) << (shift - 1))) >> shift;
    rounded.to_i64().expect("a weight is below 1/4, so it has at most `bits` <= 52 bits")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::loop_masks::{limit_weight, vertex_weight};

    #[test]
    fn twenty_bit_entries() {
        let w = [
            196608, 126976, 88178, 65536, 51406, 42014, 35426, 30595, 26921, 24040, 21726, 19826, 18240,
            16895,
        ];
        let g = [
            209715, 147754, 110851, 87381, 71579, 60405, 52169, 45885, 40950, 36978, 33717, 30993, 28683,
            26699,
        ];
        let table = Table::new(20).unwrap();
        for n in 3..=16 {
            assert_eq!((table.w(n), table.g(n)), (w[n - 3], g[n - 3]), "valence {n}");
        }
    }

    #[test]
    fn entries_agree_with_floating_point_at_every_valence() {
        let table = Table::new(48).unwrap();
        let unit = (-48f64).exp2();
        for n in 3..=MAX_VALENCE {
            assert!((table.w(n) as f64 * unit - vertex_weight(n)).abs() < 4.0 * unit, "w_{n}");
            assert!((table.g(n) as f64 * unit - limit_weight(n)).abs() < 4.0 * unit, "g_{n}");
        }
    }

    #[test]
    fn no_entry_is_near_a_tie_so_every_one_is_correctly_rounded() {
        let margin: BigInt = BigInt::from(1) << 8; // the weights are wrong by less than 2^5 units
        for bits in Table::BITS {
            let (shift, half) = (WEIGHT_BITS - bits, BigInt::from(1) << (WEIGHT_BITS - bits - 1));
            for (n, weights) in weights().iter().enumerate().skip(3) {
                for weight in [&weights.w, &weights.g] {
                    let fraction = weight - ((weight >> shift) << shift);
                    assert!((fraction - &half).magnitude() > margin.magnitude(), "valence {n}, {bits} bits");
                }
            }
        }
    }

    #[test]
    fn sizes_outside_the_range_are_refused() {
        assert!(Table::new(7).is_err() && Table::new(53).is_err());
        assert!(Table::for_width(1).is_err() && Table::for_width(33).is_err());
        assert_eq!(Table::for_width(24).map(|t| t.bits()), Ok(40));
    }
}
