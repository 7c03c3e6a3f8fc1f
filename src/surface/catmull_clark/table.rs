//! The look-up tables of vertices whose rule is no shift: kappa_d and lambda_d as integers over 2^bits.
//!
//! ```text
//!   V'    = S + kappa_d  (6 sum A + sum D - 7d S)       kappa_d  = 1/(4 d^2)     d = 4, 8, 16: a shift by 6, 8, 10
//!   limit = S + lambda_d (4 sum A + sum D - 5d S)       lambda_d = 1/(d (d+5))
//!   limit on the boundary = V + sixth (A + B - 2V)      sixth    = 1/6
//! ```
//!
//! In these one-coefficient forms the weights sum to one whatever the rounding of the entry, so a table can
//! neither shift nor scale a model. Hall (section 6.4) has two tables, 1/d^2 and (d-2)/d, and none for d = 3.

use crate::error::{Error, Result};
use crate::surface::catmull_clark::masks::{VALENCES, limit, vertex};

const ENTRIES: usize = *VALENCES.end() + 1;

/// kappa_d and lambda_d for the valences 3..=16, correctly rounded to `bits` fraction bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    bits: u32,
    kappa: [i64; ENTRIES],
    lambda: [i64; ENTRIES],
    sixth: i64,
}

impl Table {
    /// The bits a table may have: from 10 on kappa of 4, 8 and 16 is exact; up to 45 every product with a
    /// ring of 32-bit coordinates at level 7 in the exact format (42 fraction bits) fits 128 bits.
    pub const BITS: std::ops::RangeInclusive<u32> = 10..=45;

    /// # Errors
    /// `bits` outside [`Table::BITS`].
    pub fn new(bits: u32) -> Result<Self> {
        if !Self::BITS.contains(&bits) {
            return Err(Error::usage(format!("a table of {bits} bits cannot be made"))
                .help("use 10 to 45 bits; the coordinate width + 13 is the default"));
        }
        let (mut kappa, mut lambda) = ([0; ENTRIES], [0; ENTRIES]);
        for d in VALENCES {
            kappa[d] = rounded_inverse(vertex(d).denominator, bits);
            lambda[d] = rounded_inverse(limit(d).denominator, bits);
        }
        Ok(Table { bits, kappa, lambda, sixth: rounded_inverse(6, bits) })
    }

    /// The table for coordinates of `width` bits (2..=32): `width + 13` bits.
    ///
    /// Why 13: the table's part of the error of a refined position is at most K_d 2^-b D0 with the ring radius
    /// D0 < 2^width and K_d < 337 (see [`super::error_bound`]), so below 1/24 unit; with the rounding of
    /// irregular vertices in the exact format, below 1/126, and the limit's entry it stays below 1/16.
    ///
    /// # Errors
    /// A width outside 2..=32.
    pub fn for_width(width: u32) -> Result<Self> {
        if !(2..=32).contains(&width) {
            return Err(Error::usage(format!("coordinates of {width} bits"))
                .help("use 2 to 32 bits, for example Q12.12"));
        }
        Self::new(width + 13)
    }

    /// Fraction bits of the entries.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// kappa_d over 2^bits, for a valence 3..=16.
    pub fn kappa(&self, valence: usize) -> i64 {
        self.kappa[valence]
    }

    /// lambda_d over 2^bits, for a valence 3..=16.
    pub fn lambda(&self, valence: usize) -> i64 {
        self.lambda[valence]
    }

    /// 1/6 over 2^bits.
    pub fn sixth(&self) -> i64 {
        self.sixth
    }

    /// The shift by which kappa_d is exact; none for a valence that needs the multiplier.
    pub fn kappa_shift(valence: usize) -> Option<u32> {
        valence.is_power_of_two().then(|| 2 * valence.trailing_zeros() + 2)
    }
}

/// 2^bits / n, half up. No tie can occur for n that is no power of two.
fn rounded_inverse(n: i64, bits: u32) -> i64 {
    ((2 << bits) + n) / (2 * n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_the_nearest_integers() {
        for bits in Table::BITS {
            let table = Table::new(bits).unwrap();
            for d in VALENCES {
                for (entry, n) in
                    [(table.kappa(d), 4 * d * d), (table.lambda(d), d * (d + 5)), (table.sixth(), 6)]
                {
                    let off = (i128::from(entry) * n as i128 - (1 << bits)).abs();
                    assert!(2 * off <= n as i128, "valence {d}, {bits} bits");
                }
            }
        }
    }

    #[test]
    fn sixteen_bit_entries() {
        let table = Table::new(16).unwrap();
        let kappa: Vec<i64> = VALENCES.map(|d| table.kappa(d)).collect();
        assert_eq!(kappa, [1820, 1024, 655, 455, 334, 256, 202, 164, 135, 114, 97, 84, 73, 64]);
        assert_eq!((table.lambda(3), table.lambda(4), table.sixth()), (2731, 1820, 10923));
    }

    #[test]
    fn powers_of_two_are_shifts() {
        let table = Table::new(10).unwrap();
        for d in VALENCES {
            match Table::kappa_shift(d) {
                Some(shift) => assert_eq!(table.kappa(d), 1 << (10 - shift)),
                None => assert!(![4, 8, 16].contains(&d)),
            }
        }
    }
}
