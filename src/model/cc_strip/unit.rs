//! Unit vectors from integer vectors: a reciprocal square root by table and linear interpolation.
//!
//! ```text
//!   e   the least integer with -2^e <= c < 2^e for the three components c
//!   v = round(c 2^(m-e))                m = n + 4         so 2^(m-1) <= |v| <= sqrt(3) 2^m
//!   q = v . v;  u = q if q >= 2^2m, else 4q               u / 2^2m in [1, 4), 1/|v| = y 2^-m, or 2y 2^-m
//!   i = floor(u 2^k), g = the next t bits                 k = ceil(n/2), t = n + 5 - k
//!   y = floor(T_i - (T_i - T_i+1) g 2^-t)                 T_i = round(2^p / sqrt(1 + i 2^-k)), p = n + 5
//!   unit = round(v y 2^(n-m-p)), or of 2 v y              all half up; the zero vector gives zero
//! ```
//!
//! **Error**: every component is within 0.75 * 2^-n of the true one, in units of 2^-n: 0.5 by the last rounding;
//! sqrt(3) 2^(n-m) = 0.109 by that of v; the chord of the table lies above the curve by at most
//! (3/4)/8 2^-2k <= 0.094; entries and truncation move y by less than 2^-p * 1.5, relative to y >= 1/2 that is
//! 0.094; the bits of u below g lie below 2^-(k+t), which moves y by half of that, 0.016. The chord and the
//! truncations have opposite signs.

/// The vector over 2^`n`: components -2^n ..= 2^n.
pub fn unit(vector: [i128; 3], n: u32) -> [i64; 3] {
    if vector == [0; 3] {
        return [0; 3];
    }
    let (m, p) = (n + 4, n + 5);
    let fits = |e: &u32| vector.iter().all(|&c| -(1 << e) <= c && c < 1 << e);
    let e = (0..126).find(fits).unwrap_or(126);
    let v = vector.map(|c| super::rounded(c, e as i32 - m as i32));
    let q: i128 = v.iter().map(|c| c * c).sum();
    let below = q < 1 << (2 * m);
    let y = reciprocal_root(if below { 4 * q } else { q }, n);
    let doubled = u32::from(below);
    v.map(|c| super::rounded((c * y) << doubled, (m + p - n) as i32) as i64)
}

/// 2^p / sqrt(u / 2^2m) for u in [2^2m, 2^2m+2).
fn reciprocal_root(u: i128, n: u32) -> i128 {
    let (m, p) = (n + 4, n + 5);
    let k = n.div_ceil(2);
    let t = n + 5 - k;
    let i = (u >> (2 * m - k)) - (1 << k);
    let g = (u >> (2 * m - k - t)) & ((1 << t) - 1);
    let [at, next] = [i, i + 1].map(|i| entry(i, k, p));
    ((at << t) - (at - next) * g) >> t
}

/// round(2^p / sqrt(1 + i 2^-k)): the largest T with (2T - 1)^2 (2^k + i) <= 2^(2p + k + 2).
fn entry(i: i128, k: u32, p: u32) -> i128 {
    let fits = |t: i128| (2 * t - 1).pow(2) * ((1 << k) + i) <= 1 << (2 * p + k + 2);
    (0..=p).rev().fold(0, |t, bit| if fits(t + (1 << bit)) { t + (1 << bit) } else { t })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest deviation from the true unit vector, in units of 2^-n.
    fn deviation(vector: [i128; 3], n: u32) -> f64 {
        let exact = vector.map(|c| c as f64);
        let length = exact.iter().map(|c| c * c).sum::<f64>().sqrt();
        let off = |(unit, c): (i64, f64)| (unit as f64 - c / length * f64::from(n).exp2()).abs();
        unit(vector, n).into_iter().zip(exact).map(off).fold(0.0, f64::max)
    }

    #[test]
    fn every_small_vector_and_every_scale_is_within_three_quarters() {
        for n in [8, 9, 14, 16] {
            let mut most: f64 = 0.0;
            for x in -40..=40 {
                for y in -40..=40 {
                    for z in (-40..=40).filter(|&z| [x, y, z] != [0; 3]) {
                        most = most.max(deviation([x, y, z], n));
                    }
                }
            }
            let mut state = 1u64;
            let mut random = |bits: u32| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                i128::from((state ^ state >> 29) as i64) >> (64 - bits)
            };
            for round in 0..300_000 {
                let vector = [0, 1, 2].map(|_| random(1 + round % 62));
                if vector != [0; 3] {
                    most = most.max(deviation(vector, n));
                }
            }
            println!("unit normals over 2^{n}: within {most:.3} of the last place");
            assert!(most <= 0.75, "n = {n}: {most}");
        }
        assert_eq!(unit([0; 3], 14), [0; 3]);
    }

    #[test]
    fn axes_are_exact() {
        for n in 8..=16 {
            for c in [1, 2, 3, 1000, 1 << 61, (1 << 62) - 1] {
                assert_eq!(unit([c, 0, 0], n), [1 << n, 0, 0], "{c} {n}");
                assert_eq!(unit([0, -c, 0], n), [0, -1 << n, 0], "{c} {n}");
            }
        }
    }

    #[test]
    fn entries_are_the_nearest_integers() {
        for (k, p) in [(4, 13), (7, 19), (8, 21)] {
            for i in 0..=3i128 << k {
                let exact = f64::from(p).exp2() / (1.0 + i as f64 * (-f64::from(k)).exp2()).sqrt();
                assert!((entry(i, k, p) as f64 - exact).abs() <= 0.5 + 1e-9, "{i} {k}");
            }
        }
    }
}
