//! How large a difference can be where a vertex depends on it.
//!
//! ```text
//!   |D(k,l)_{i,j}| <= (2^W - 1) p,   p = sum of the positive weights of the control points in D
//!   a vertex of the patch depends on D(k,l)_{i,j}  exactly if  i + j + k + l <= n
//! ```
//!
//! Such a difference is one of vertices of the patch, all in the hull. The weights are those of the real
//! vertices: where the patch lies at a boundary, ghosts V + B - I are combinations of them. The order of a
//! register's integer bits is then 1 + ceil(log2 p) above W.

use num_rational::Ratio;

use crate::surface::basis;

/// p of D(k,l), largest over the places that a vertex of a patch of level `r` depends on and over all ways
/// a regular patch can lie at boundaries; 0 where there is no such place. (k, l) is not (0, 0).
pub fn largest_weight(r: u32, (k, l): (u32, u32)) -> Ratio<i64> {
    let n = 1u32 << r;
    let mut most = 0;
    for i in 0..=n.saturating_sub(k + l) {
        for j in 0..=n.saturating_sub(k + l + i) {
            if i + j + k + l > n {
                continue;
            }
            let weights = weights(r, (k, l), (i, j));
            for ghosts in boundaries() {
                most = most.max(positive(weights, &ghosts));
            }
        }
    }
    Ratio::new(most, basis::denominator(r))
}

/// The weights of P0..P11 in 12 * 16^r D(k,l)_{i,j}.
fn weights(r: u32, (k, l): (u32, u32), (i, j): (u32, u32)) -> [i64; 12] {
    let choose = |n: u32, k: u32| (0..i64::from(k)).fold(1, |c, x| c * (i64::from(n) - x) / (x + 1));
    let mut sum = [0; 12];
    for (x, y) in (0..=k).flat_map(|x| (0..=l).map(move |y| (x, y))) {
        let sign = if (k - x + l - y) % 2 == 0 { 1 } else { -1 };
        let factor = sign * choose(k, x) * choose(l, y);
        for (s, w) in sum.iter_mut().zip(basis::mask(r, i + x, j + y)) {
            *s += factor * w;
        }
    }
    sum
}

/// Sum of the positive weights once the ghosts are put into terms of the real vertices.
fn positive(mut weights: [i64; 12], ghosts: &[Ghost]) -> i64 {
    for ghost in ghosts {
        let weight = std::mem::take(&mut weights[ghost.point]);
        let [v, b, i] = ghost.of;
        weights[v] += weight;
        weights[b] += weight;
        weights[i] -= weight;
    }
    weights.iter().filter(|&&w| w > 0).sum()
}

/// A control point that is V + B - I.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ghost {
    point: usize,
    of: [usize; 3],
}

/// The six neighbours of each corner, counterclockwise, as numbered in [`crate::surface::regular`].
const RINGS: [(usize, [usize; 6]); 3] =
    [(4, [8, 7, 3, 0, 1, 5]), (5, [4, 1, 2, 6, 9, 8]), (8, [5, 9, 11, 10, 7, 4])];

/// The ghosts of every way the corners can lie at boundaries; the first has none.
fn boundaries() -> Vec<Vec<Ghost>> {
    // h: the gap lies between entries h-1 and h of the four real neighbours; 0 for an inner corner.
    let choices = (0..64).map(|code| [code % 4, code / 4 % 4, code / 16]);
    // Edge (c, c+1) is a boundary edge for both its corners or for none.
    let consistent = choices.filter(|h| (0..3).all(|c| (h[c] == 3) == (h[(c + 1) % 3] == 1)));
    consistent
        .map(|h| {
            let mut ghosts: Vec<Ghost> = vec![];
            for ((centre, ring), h) in RINGS.into_iter().zip(h).filter(|(_, h)| *h > 0) {
                let real: Vec<usize> = (0..6).filter(|e| *e != h && *e != h + 1).map(|e| ring[e]).collect();
                let before = Ghost { point: ring[h], of: [centre, real[h - 1], real[(h + 2) % 4]] };
                let after = Ghost { point: ring[h + 1], of: [centre, real[h % 4], real[(h + 1) % 4]] };
                // Two corners may share a ghost, by the same rule.
                ghosts.extend(
                    [before, after]
                        .into_iter()
                        .filter(|g| !ghosts.iter().any(|o| o.point == g.point))
                        .collect::<Vec<_>>(),
                );
            }
            ghosts
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_fourteen_ways_and_ghosts_are_made_of_real_points() {
        let ways = boundaries();
        assert_eq!(ways.len(), 14);
        assert!(ways[0].is_empty());
        for ghosts in ways {
            let is_ghost = |point: usize| ghosts.iter().any(|g| g.point == point);
            assert!(ghosts.iter().all(|g| !g.of.iter().any(|&p| is_ghost(p))));
        }
    }

    #[test]
    fn weights_of_coarse_patches() {
        // With ghosts; 2/3 without.
        assert_eq!(largest_weight(0, (1, 0)), Ratio::from_integer(1));
        assert_eq!(largest_weight(0, (2, 0)), Ratio::from_integer(0));
        assert_eq!(largest_weight(1, (2, 0)).max(largest_weight(1, (1, 1))), Ratio::new(17, 48));
        assert_eq!(largest_weight(2, (3, 1)), Ratio::new(6, 256));
    }

    #[test]
    fn weights_of_fine_patches_follow_their_laws() {
        let over = |numerator: i64, bits: u32| Ratio::new(numerator, 1i64 << bits);
        for r in 1..=5 {
            let most = |orders: &[(u32, u32)]| orders.iter().map(|&kl| largest_weight(r, kl)).max().unwrap();
            assert_eq!(most(&[(1, 0), (0, 1)]), over(1, r), "r = {r}");
            let second = over(2, 2 * r) - over(7, 4 * r) / 3;
            assert_eq!(most(&[(2, 0), (1, 1), (0, 2)]), second, "r = {r}");
            if r > 1 {
                let third = over(8, 3 * r) - over(12, 4 * r);
                assert_eq!(most(&[(3, 0), (2, 1), (1, 2), (0, 3)]), third, "r = {r}");
                assert_eq!(most(&[(3, 1), (1, 3)]), over(6, 4 * r), "r = {r}");
            }
        }
    }
}
