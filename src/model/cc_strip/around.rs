//! What surrounds a vertex of a column: the sums that its rules need.
//!
//! ```text
//!    p      c      n          inner row:  valence 4, neighbours p_r + n_r + c_r-1 + c_r+1, diagonals the rest
//!   p_r-1  c_r-1  n_r-1       outer row:  the outside record closes the ring
//!   p_r    c_r    n_r         rim:        the two neighbours along the boundary
//!   p_r+1  c_r+1  n_r+1
//! ```

use super::Point;
use super::level::LevelColumn;

/// The surroundings of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Around {
    /// A closed ring: its valence, the sum of its neighbours, the sum of its diagonals.
    Ring { valence: usize, neighbours: Point, diagonals: Point },
    /// The boundary: the sum of the two neighbours along it.
    Rim { neighbours: Point },
}

/// Sum of points.
pub(super) fn sum<'a>(points: impl IntoIterator<Item = &'a Point>) -> Point {
    points.into_iter().fold([0; 3], |s, p| [s[0] + p[0], s[1] + p[1], s[2] + p[2]])
}

/// `a + factor b`.
pub(super) fn plus(a: Point, factor: i128, b: Point) -> Point {
    std::array::from_fn(|x| a[x] + factor * b[x])
}

/// A column between its neighbours; one of them may be missing at a rim.
#[derive(Clone, Copy)]
pub struct Three<'a> {
    pub previous: Option<&'a LevelColumn>,
    pub column: &'a LevelColumn,
    pub next: Option<&'a LevelColumn>,
}

impl Three<'_> {
    /// The surroundings of the vertex in row `r`.
    pub fn around(&self, r: usize) -> Around {
        let rows = &self.column.rows;
        match r {
            0 => self.around_outer(0),
            _ if r + 1 == rows.len() => self.around_outer(1),
            _ => {
                let (Some(p), Some(n)) = (self.previous, self.next) else {
                    return Around::Rim { neighbours: sum([&rows[r - 1], &rows[r + 1]]) };
                };
                Around::Ring {
                    valence: 4,
                    neighbours: sum([&rows[r - 1], &rows[r + 1], &p.rows[r], &n.rows[r]]),
                    diagonals: sum([&p.rows[r - 1], &p.rows[r + 1], &n.rows[r - 1], &n.rows[r + 1]]),
                }
            }
        }
    }

    fn around_outer(&self, end: usize) -> Around {
        let outside = &self.column.outside[end];
        let inner = *self.column.inner(end);
        let last = outside.valence as usize - 2;
        // a_0 .. a_{d-2}; a neighbour that a rim lacks is replaced by the inner one, the next along the rim
        let neighbour = |i: usize| match i {
            0 => self.previous.map_or(inner, |p| *p.outer(end)),
            _ if i == last => self.next.map_or(inner, |n| *n.outer(end)),
            _ => outside.fan[2 * i - 2],
        };
        if let Some(gap) = outside.gap {
            let gap = gap as usize;
            return Around::Rim { neighbours: sum([&neighbour(gap - 1), &neighbour(gap)]) };
        }
        // A missing guard always leaves a gap, so both neighbours exist here.
        let (Some(p), Some(n)) = (self.previous, self.next) else {
            return Around::Rim { neighbours: [0; 3] };
        };
        let mut diagonals = sum([p.inner(end), n.inner(end), &p.outside[end].right]);
        for i in 2..=last {
            let x = if i == last { &n.outside[end].left } else { &outside.fan[2 * i - 3] };
            diagonals = plus(diagonals, 1, *x);
        }
        let neighbours = (0..=last).fold(inner, |s, i| plus(s, 1, neighbour(i)));
        Around::Ring { valence: last + 2, neighbours, diagonals }
    }
}
