//! The rules in exact integers: a point at depth k is scaled by 16^k, so that every regular rule is exact.
//!
//! ```text
//!   edge      2 (3 (A+B) + C + D)       boundary edge    8 (A + B)
//!   vertex    n = 6: 10 V + S           boundary vertex  2 (A + 6V + B)
//!             else   16 V + ((16 w_n (S - nV) + 2^(b-1)) >> b)
//!   limit (times 12, same depth)
//!             n = 6: 6 V + S            boundary limit   2 (A + 4V + B)
//!             else   12 V + ((12 g_n (S - nV) + 2^(b-1)) >> b)
//! ```
//!
//! Every value is exact, or (irregular vertices) a function of one ring alone: integer sums do not depend on
//! their order, so all patches that share a point compute the same integer and no crack can open.
//! All rules are convex and the hull has integer corners, so a coordinate of `width` bits at depth 0 needs
//! `width + 4k` bits at depth k, and 4 more as a limit position.

use crate::surface::arithmetic::Arithmetic;
use crate::surface::table::Table;
use crate::surface::word::Word;

/// Exact integer rules over words of 64 or 128 bits.
#[derive(Clone, Copy, Debug)]
pub struct Exact<'a, W> {
    table: &'a Table,
    word: std::marker::PhantomData<W>,
}

impl<'a, W: Word> Exact<'a, W> {
    pub fn new(table: &'a Table) -> Self {
        Exact { table, word: std::marker::PhantomData }
    }

    /// round-half-up(factor * weight * (S - nV) / 2^bits) per axis, the weight being over 2^bits.
    fn towards_ring(&self, v: &[W; 3], ring: &[[W; 3]], factor_times_weight: i64) -> [W; 3] {
        let bits = self.table.bits();
        std::array::from_fn(|x| {
            // The sum may need up to 6 bits more than a coordinate, so it is formed in 128 bits.
            let spread: i128 = ring.iter().map(|c| c[x].wide() - v[x].wide()).sum();
            W::narrow((spread * i128::from(factor_times_weight) + (1 << (bits - 1))) >> bits)
        })
    }
}

/// a * x + b * y + ... per axis, modulo the word size (the results fit).
fn combine<W: Word, const N: usize>(terms: [(i64, &[W; 3]); N]) -> [W; 3] {
    std::array::from_fn(|x| terms.iter().fold(W::ZERO, |sum, (k, p)| sum.plus(p[x].times(*k))))
}

fn ring_sum<W: Word>(ring: &[[W; 3]]) -> [W; 3] {
    let add = |s: [W; 3], p: &[W; 3]| [s[0].plus(p[0]), s[1].plus(p[1]), s[2].plus(p[2])];
    ring.iter().fold([W::ZERO; 3], add)
}

impl<W: Word> Arithmetic for Exact<'_, W> {
    type Point = [W; 3];

    fn edge(&self, a: &[W; 3], b: &[W; 3], c: &[W; 3], d: &[W; 3]) -> [W; 3] {
        combine([(6, a), (6, b), (2, c), (2, d)])
    }

    fn boundary_edge(&self, a: &[W; 3], b: &[W; 3]) -> [W; 3] {
        combine([(8, a), (8, b)])
    }

    fn vertex(&self, v: &[W; 3], ring: &[[W; 3]]) -> [W; 3] {
        if ring.len() == 6 {
            return combine([(10, v), (1, &ring_sum(ring))]);
        }
        combine([(16, v), (1, &self.towards_ring(v, ring, 16 * self.table.w(ring.len())))])
    }

    fn boundary_vertex(&self, a: &[W; 3], v: &[W; 3], b: &[W; 3]) -> [W; 3] {
        combine([(2, a), (12, v), (2, b)])
    }

    fn limit12(&self, v: &[W; 3], ring: &[[W; 3]]) -> [W; 3] {
        if ring.len() == 6 {
            return combine([(6, v), (1, &ring_sum(ring))]);
        }
        combine([(12, v), (1, &self.towards_ring(v, ring, 12 * self.table.g(ring.len())))])
    }

    fn boundary_limit12(&self, a: &[W; 3], v: &[W; 3], b: &[W; 3]) -> [W; 3] {
        combine([(2, a), (8, v), (2, b)])
    }

    fn ghost(&self, v: &[W; 3], b: &[W; 3], i: &[W; 3]) -> [W; 3] {
        combine([(1, v), (1, b), (-1, i)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irregular_vertices_round_half_up() {
        // valence 3: 16 w_3 = 3 exactly; valence 5 at 8 bits: w = 22/256, 16 w = 1.375
        let table = Table::new(8).unwrap();
        let exact = Exact::<i64>::new(&table);
        assert_eq!(exact.vertex(&[0; 3], &[[1, 0, 0], [1, 0, 0], [0, 1, -5]]), [6, 3, -15]);
        let ring = [[1, -1, 2], [0; 3], [0; 3], [0; 3], [0; 3]];
        assert_eq!(exact.vertex(&[0; 3], &ring), [1, -1, 3]);
    }

    #[test]
    fn both_words_agree_at_the_extremes_of_their_common_range() {
        let table = Table::new(40).unwrap();
        let (narrow, wide) = (Exact::<i64>::new(&table), Exact::<i128>::new(&table));
        let extreme = 1i64 << 55;
        let ring: Vec<[i64; 3]> = (0..32).map(|j| [extreme, -extreme, extreme * (j % 2)]).collect();
        let v = [-extreme, extreme, 12345];
        let wide_ring: Vec<[i128; 3]> = ring.iter().map(|p| p.map(i128::from)).collect();
        let expected = wide.limit12(&v.map(i128::from), &wide_ring);
        assert_eq!(narrow.limit12(&v, &ring).map(i128::from), expected);
    }
}
