//! The forward-difference operator Q_r: from twelve control points to the mixed differences of a patch.
//!
//! ```text
//!   D(k,l)_{i,j} = k-th difference in u, l-th in v, of the samples p(i/n, j/n), n = 2^r
//!   N(k,l) = 12 * 16^r * D(k,l) is an integer combination of the control points;  N = Q_r P at (0, 0)
//!
//!   stage 1 (no r)      rm = P0-2P1+P2   r0 = P3-2P4+P5   r0' = P4-2P5+P6   r1 = P7-2P8+P9
//!                       sm = P3-2P7+P10  s0 = P0-2P4+P8   s0' = P4-2P8+P11  s1 = P1-2P5+P9
//!                       C30 = rm-2r0+r1  C20 = r0  C21 = r1-r0  G = r0+r0'-rm-r1
//!                       C03 = sm-2s0+s1  C02 = s0  C12 = s1-s0  H = s0+s0'-sm-s1
//!                       C11 = r0+(P0-P1)+(P8-P7)       C10 = (P1-P0)+(P8-P7)+2(P5-P3)
//!                       C01 = (P7-P1)+(P5-P3)+2(P8-P0) C00 = P0+P1+P3+P5+P7+P8+6P4
//!   stage 2 (shifts)    N00 = 16^r C00             N10 = 2*8^r C10 + 6*4^r C20 + 2*2^r C30 + G
//!                       N20 = 12(4^r C20 + 2^r C30) + 14G     N11 = 6(4^r C11 + 2^r (C21+C12)) + 2(G+H)
//!                       N30 = 12(2^r C30 + 3G)  N21 = 12(2^r C21 + G)  N31 = 12G  N40 = 24G  N22 = 0
//!                       and N01, N02, N03, N12, N13, N04 likewise with C01, C02, C03, C12, H
//! ```
//!
//! Source: Bischoff, Kobbelt, Seidel 2000, appendix A.4; the matrix printed there repeats the column of P4
//! in every column, and the one here is derived from the box spline (and tested against its samples).
//! N40 = 2 N31, N04 = 2 N13 and N22 = 0 on every patch, so 12 of the 15 differences are independent.

/// Integer weights of P0..P11.
pub type Row = [i64; 12];

/// `sum` of factor * row.
const fn combine<const N: usize>(terms: [(i64, Row); N]) -> Row {
    let mut sum = [0; 12];
    let mut t = 0;
    while t < N {
        let mut m = 0;
        while m < 12 {
            sum[m] += terms[t].0 * terms[t].1[m];
            m += 1;
        }
        t += 1;
    }
    sum
}

/// The row of one control point.
const fn point(index: usize) -> Row {
    let mut row = [0; 12];
    row[index] = 1;
    row
}

/// P_a - 2 P_b + P_c.
const fn second(a: usize, b: usize, c: usize) -> Row {
    combine([(1, point(a)), (-2, point(b)), (1, point(c))])
}

/// Second differences along u, in the lattice rows -1, 0 (twice) and 1.
pub const R_M: Row = second(0, 1, 2);
pub const R_0: Row = second(3, 4, 5);
pub const R_0P: Row = second(4, 5, 6);
pub const R_1: Row = second(7, 8, 9);
/// Second differences along v, in the lattice columns -1, 0 (twice) and 1.
pub const S_M: Row = second(3, 7, 10);
pub const S_0: Row = second(0, 4, 8);
pub const S_0P: Row = second(4, 8, 11);
pub const S_1: Row = second(1, 5, 9);

pub const C30: Row = combine([(1, R_M), (-2, R_0), (1, R_1)]);
pub const C03: Row = combine([(1, S_M), (-2, S_0), (1, S_1)]);
pub const C20: Row = R_0;
pub const C02: Row = S_0;
pub const C21: Row = combine([(1, R_1), (-1, R_0)]);
pub const C12: Row = combine([(1, S_1), (-1, S_0)]);
/// N31 = 12 G.
pub const G: Row = combine([(1, R_0), (1, R_0P), (-1, R_M), (-1, R_1)]);
/// N13 = 12 H.
pub const H: Row = combine([(1, S_0), (1, S_0P), (-1, S_M), (-1, S_1)]);
pub const C11: Row = combine([(1, R_0), (1, point(0)), (-1, point(1)), (1, point(8)), (-1, point(7))]);
pub const C10: Row =
    combine([(1, point(1)), (-1, point(0)), (1, point(8)), (-1, point(7)), (2, point(5)), (-2, point(3))]);
pub const C01: Row =
    combine([(1, point(7)), (-1, point(1)), (1, point(5)), (-1, point(3)), (2, point(8)), (-2, point(0))]);
pub const C00: Row = [1, 1, 0, 1, 6, 1, 0, 1, 1, 0, 0, 0];

/// The orders (k, l) in the sequence of the paper's matrix.
pub const ORDERS: [(usize, usize); 15] = [
    (4, 0),
    (3, 0),
    (2, 0),
    (1, 0),
    (0, 0),
    (3, 1),
    (2, 1),
    (1, 1),
    (0, 1),
    (2, 2),
    (1, 2),
    (0, 2),
    (1, 3),
    (0, 3),
    (0, 4),
];

/// The twelve orders that the engine keeps in its outer registers.
pub const OUTER: [(usize, usize); 12] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1), (0, 2), (1, 2), (0, 3), (1, 3)];

/// The row N(k,l) of Q_r; zero where k + l > 4.
pub fn row(k: usize, l: usize, r: u32) -> Row {
    let [a, b, c, d] = [1i64 << r, 1 << (2 * r), 1 << (3 * r), 1 << (4 * r)];
    match (k, l) {
        (0, 0) => combine([(d, C00)]),
        (1, 0) => combine([(2 * c, C10), (6 * b, C20), (2 * a, C30), (1, G)]),
        (0, 1) => combine([(2 * c, C01), (6 * b, C02), (2 * a, C03), (1, H)]),
        (2, 0) => combine([(12 * b, C20), (12 * a, C30), (14, G)]),
        (0, 2) => combine([(12 * b, C02), (12 * a, C03), (14, H)]),
        (1, 1) => combine([(6 * b, C11), (6 * a, C21), (6 * a, C12), (2, G), (2, H)]),
        (3, 0) => combine([(12 * a, C30), (36, G)]),
        (2, 1) => combine([(12 * a, C21), (12, G)]),
        (1, 2) => combine([(12 * a, C12), (12, H)]),
        (0, 3) => combine([(12 * a, C03), (36, H)]),
        (3, 1) => combine([(12, G)]),
        (1, 3) => combine([(12, H)]),
        (4, 0) => combine([(24, G)]),
        (0, 4) => combine([(24, H)]),
        _ => [0; 12],
    }
}

/// The full matrix Q_r over 12 * 16^r, rows in the sequence of [`ORDERS`].
pub fn matrix(r: u32) -> [Row; 15] {
    ORDERS.map(|(k, l)| row(k, l, r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::basis;

    /// The matrix as derived by hand, one column entry after the other.
    fn typed(r: u32) -> [Row; 15] {
        let [a, b, c, d] = [1i64 << r, 1 << (2 * r), 1 << (3 * r), 1 << (4 * r)];
        [
            [-24, 48, -24, 24, -24, -24, 24, -24, 48, -24, 0, 0],
            [
                12 * a - 36,
                -24 * a + 72,
                12 * a - 36,
                -24 * a + 36,
                48 * a - 36,
                -24 * a - 36,
                36,
                12 * a - 36,
                -24 * a + 72,
                12 * a - 36,
                0,
                0,
            ],
            [
                12 * a - 14,
                -24 * a + 28,
                12 * a - 14,
                12 * b - 24 * a + 14,
                -24 * b + 48 * a - 14,
                12 * b - 24 * a - 14,
                14,
                12 * a - 14,
                -24 * a + 28,
                12 * a - 14,
                0,
                0,
            ],
            [
                -2 * c + 2 * a - 1,
                2 * c - 4 * a + 2,
                2 * a - 1,
                -4 * c + 6 * b - 4 * a + 1,
                -12 * b + 8 * a - 1,
                4 * c + 6 * b - 4 * a - 1,
                1,
                -2 * c + 2 * a - 1,
                2 * c - 4 * a + 2,
                2 * a - 1,
                0,
                0,
            ],
            [d, d, 0, d, 6 * d, d, 0, d, d, 0, 0, 0],
            [-12, 24, -12, 12, -12, -12, 12, -12, 24, -12, 0, 0],
            [
                -12,
                24,
                -12,
                -12 * a + 12,
                24 * a - 12,
                -12 * a - 12,
                12,
                12 * a - 12,
                -24 * a + 24,
                12 * a - 12,
                0,
                0,
            ],
            [
                6 * b - 6 * a,
                -6 * b + 6 * a + 2,
                -2,
                6 * b - 6 * a,
                -12 * b + 24 * a - 4,
                6 * b - 18 * a + 2,
                2,
                -6 * b + 6 * a + 2,
                6 * b - 18 * a + 2,
                12 * a - 4,
                -2,
                2,
            ],
            [
                -4 * c + 6 * b - 4 * a + 1,
                -2 * c + 2 * a - 1,
                0,
                -2 * c + 2 * a - 1,
                -12 * b + 8 * a - 1,
                2 * c - 4 * a + 2,
                0,
                2 * c - 4 * a + 2,
                4 * c + 6 * b - 4 * a - 1,
                2 * a - 1,
                2 * a - 1,
                1,
            ],
            [0; 12],
            [
                -12 * a + 12,
                12 * a - 12,
                0,
                -12,
                24 * a - 12,
                -24 * a + 24,
                0,
                24,
                -12 * a - 12,
                12 * a - 12,
                -12,
                12,
            ],
            [
                12 * b - 24 * a + 14,
                12 * a - 14,
                0,
                12 * a - 14,
                -24 * b + 48 * a - 14,
                -24 * a + 28,
                0,
                -24 * a + 28,
                12 * b - 24 * a - 14,
                12 * a - 14,
                12 * a - 14,
                14,
            ],
            [12, -12, 0, -12, -12, 24, 0, 24, -12, -12, -12, 12],
            [
                -24 * a + 36,
                12 * a - 36,
                0,
                12 * a - 36,
                48 * a - 36,
                -24 * a + 72,
                0,
                -24 * a + 72,
                -24 * a - 36,
                12 * a - 36,
                12 * a - 36,
                36,
            ],
            [24, -24, 0, -24, -24, 48, 0, 48, -24, -24, -24, 24],
        ]
    }

    #[test]
    fn the_stages_multiply_to_the_matrix() {
        for r in 0..=10 {
            assert_eq!(matrix(r), typed(r), "r = {r}");
        }
    }

    #[test]
    fn rows_are_the_differences_of_the_box_spline() {
        let choose = |n: usize, k: usize| (0..k).fold(1i64, |c, x| c * (n - x) as i64 / (x as i64 + 1));
        // r = 2: all orders fit into the patch (k + l <= 4 steps)
        let r = 2;
        for (k, l) in ORDERS {
            let mut difference = [0; 12];
            for (x, y) in (0..=k).flat_map(|x| (0..=l).map(move |y| (x, y))) {
                let sign = if (k - x + l - y) % 2 == 0 { 1 } else { -1 };
                let mask = basis::mask(r, x as u32, y as u32);
                difference = combine([(1, difference), (sign * choose(k, x) * choose(l, y), mask)]);
            }
            assert_eq!(difference, row(k, l, r), "N{k}{l}");
        }
    }

    #[test]
    fn three_differences_are_not_independent() {
        for r in 0..=10 {
            assert_eq!(row(4, 0, r), row(3, 1, r).map(|x| 2 * x));
            assert_eq!(row(0, 4, r), row(1, 3, r).map(|x| 2 * x));
            assert_eq!(row(2, 2, r), [0; 12]);
        }
    }
}
