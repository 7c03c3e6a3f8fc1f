//! cos(2 pi/n) to any precision, in integers: fixed-point numbers of `bits` fraction bits.
//!
//! ```text
//!   pi = 16 atan(1/5) - 4 atan(1/239)            (Machin)
//!   cos x = 1 - x^2/2! + x^4/4! - ...            (Taylor, |x| <= 2 pi/3)
//! ```
//!
//! Both series are summed with [`GUARD`] extra bits; each of their fewer than 2^9 terms (bits <= 400) is
//! wrong by at most 2^5 units of the guarded last place, so the result is wrong by less than one unit of
//! the last place asked for.

use num_bigint::BigInt;
use num_traits::Zero;

/// Extra bits that swallow the truncations of the series.
const GUARD: u32 = 24;

/// atan(1/k) with `bits` fraction bits.
fn arctangent_of_inverse(k: i64, bits: u32) -> BigInt {
    let square = BigInt::from(k * k);
    let mut power = (BigInt::from(1) << bits) / k;
    let mut sum = BigInt::zero();
    let mut odd = 1i64;
    while !power.is_zero() {
        let term = &power / odd;
        if odd % 4 == 1 {
            sum += term
        } else {
            sum -= term
        }
        power /= &square;
        odd += 2;
    }
    sum
}

/// pi with `bits` fraction bits, wrong by less than one unit of the last place.
pub fn pi(bits: u32) -> BigInt {
    let guarded = bits + GUARD;
    let sum = arctangent_of_inverse(5, guarded) * 16 - arctangent_of_inverse(239, guarded) * 4;
    sum >> GUARD
}

/// cos(2 pi/n), n >= 3, with `bits` fraction bits, wrong by less than one unit of the last place.
pub fn cosine_of_turn(n: u32, bits: u32) -> BigInt {
    let guarded = bits + GUARD;
    let x = pi(guarded) * 2 / n;
    let square: BigInt = (&x * &x) >> guarded;
    let mut term = BigInt::from(1) << guarded;
    let mut sum = BigInt::zero();
    let mut k = 0i64;
    while !term.is_zero() {
        sum += &term;
        term = -((term * &square) >> guarded) / ((k + 1) * (k + 2));
        k += 2;
    }
    sum >> GUARD
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pi_has_its_digits() {
        // floor(pi * 10^50) from the published expansion
        let digits: BigInt = "314159265358979323846264338327950288419716939937510".parse().unwrap();
        let scaled = (pi(200) * BigInt::from(10).pow(50)) >> 200;
        assert_eq!(scaled, digits);
    }

    #[test]
    fn rational_cosines_come_out_to_the_last_place() {
        let one = BigInt::from(1) << 200;
        for (n, halves) in [(3, -1), (4, 0), (6, 1)] {
            let error: BigInt = cosine_of_turn(n, 200) * 2 - &one * halves;
            assert!(error.magnitude() <= BigInt::from(2).magnitude(), "n = {n}: {error}");
        }
    }

    #[test]
    fn the_golden_cosine_solves_its_equation() {
        // c = cos(2 pi/5): 4 c^2 + 2 c - 1 = 0
        let c = cosine_of_turn(5, 200);
        let residue: BigInt = ((&c * &c * 4) >> 200) + &c * 2 - (BigInt::from(1) << 200);
        assert!(residue.magnitude() < BigInt::from(16).magnitude());
    }
}
