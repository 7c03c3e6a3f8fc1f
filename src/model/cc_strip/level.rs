//! One level: a face column or a vertex column from the columns of the level before.
//!
//! ```text
//!   face column:  Fo             outside face over a strip edge: v_c + v_c+1 + uR(c) + uL(c+1), over 4
//!                 E0  F0  E1 ... E = (F above + F below + A + B)/4 from the unrounded sums of the faces
//!                 Fo             new outside records: valence 4, fan [Fo]
//!
//!   vertex column: V' = S + (6 sum A + sum D - 7d S) kappa_d,  E for the vertical edges
//!                  new outside records: a'_i = E(v, a_i), x'_i = f_i, the valence stays
//!
//!   rims:  E = (A + B)/2,  V' = (A + 6V + B)/8
//! ```
//!
//! Each new vertex is an integer sum over 2^bits of its source's unit, rounded once to the fraction bits of
//! its level. With 6 bits more than the source only irregular vertices lose anything.

use super::around::{Around, Three, plus, sum};
use super::{Point, rounded};
use crate::fixed::Rounding;
use crate::surface::catmull_clark::strips::records::Outside;
use crate::surface::catmull_clark::table::Table;

/// A column at some level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelColumn {
    /// 1 + 2^level strip vertices from top to bottom.
    pub rows: Vec<Point>,
    /// Outside records of the top and of the bottom vertex.
    pub outside: [Outside<Point>; 2],
}

impl LevelColumn {
    /// A guard knows one outside vertex at each end: uR (left guard) or uL (right guard).
    pub fn guard(vertices: &[Point; 2], outside: &[Point; 2], left: bool) -> Self {
        let record = |end: usize| {
            let (u, unknown) = (outside[end], vertices[end]);
            Outside {
                valence: 4,
                fan: vec![u],
                left: if left { unknown } else { u },
                right: if left { u } else { unknown },
                gap: None,
            }
        };
        LevelColumn { rows: vertices.to_vec(), outside: [record(0), record(1)] }
    }

    /// The outer vertex at an end: 0 is the top, 1 the bottom.
    pub fn outer(&self, end: usize) -> &Point {
        &self.rows[if end == 0 { 0 } else { self.rows.len() - 1 }]
    }

    /// Its neighbour in the column.
    pub fn inner(&self, end: usize) -> &Point {
        &self.rows[if end == 0 { 1 } else { self.rows.len() - 2 }]
    }
}

/// How one level computes.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Fraction bits of the new vertices beyond those of their sources.
    pub more: u32,
    pub rounding: Rounding,
    pub table: &'a Table,
}

impl Step<'_> {
    /// A sum over 2^bits, rounded.
    fn round(&self, sum: Point, bits: u32) -> Point {
        sum.map(|x| rounded(x, bits as i32 - self.more as i32, self.rounding))
    }

    /// The middle of a face from the sum of its corners.
    fn face(&self, corners: Point) -> Point {
        self.round(corners, 2)
    }

    /// The new vertex of the edge (a, b) from the sums of its faces; of a boundary edge where one is missing.
    fn edge(&self, a: &Point, b: &Point, faces: [Option<Point>; 2]) -> Point {
        let ends = sum([a, b]);
        match faces {
            [Some(f), Some(g)] => self.round(plus(sum([&f, &g]), 4, ends), 4),
            _ => self.round(ends, 1),
        }
    }

    /// The replacement of a vertex.
    fn vertex(&self, s: Point, around: Around) -> Point {
        match around {
            Around::Rim { neighbours } => self.round(plus(neighbours, 6, s), 3),
            Around::Ring { valence, neighbours, diagonals } => {
                let spread = plus(plus(diagonals, 6, neighbours), -7 * valence as i128, s);
                let bits = self.table.bits();
                let kappa = i128::from(self.table.kappa(valence));
                self.round(std::array::from_fn(|x| (s[x] << bits) + spread[x] * kappa), bits)
            }
        }
    }

    /// Face column 2c+1 from the columns c and c+1.
    pub fn face_column(&self, left: &LevelColumn, right: &LevelColumn) -> LevelColumn {
        let last = left.rows.len() - 1;
        let quad = |r: usize| sum([&left.rows[r], &left.rows[r + 1], &right.rows[r], &right.rows[r + 1]]);
        let outer = [0, 1].map(|end| outside_face(left, right, end));
        let mut rows = Vec::with_capacity(2 * last + 1);
        for r in 0..=last {
            let above = if r == 0 { outer[0] } else { Some(quad(r - 1)) };
            let below = if r == last { outer[1] } else { Some(quad(r)) };
            rows.push(self.edge(&left.rows[r], &right.rows[r], [above, below]));
            if r < last {
                rows.push(self.face(quad(r)));
            }
        }
        let ends = [rows[0], rows[2 * last]];
        let record = |end: usize| match outer[end] {
            Some(corners) => {
                let face = self.face(corners);
                Outside { valence: 4, fan: vec![face], left: face, right: face, gap: None }
            }
            None => Outside { valence: 3, fan: vec![], left: ends[end], right: ends[end], gap: Some(1) },
        };
        LevelColumn { rows, outside: [record(0), record(1)] }
    }

    /// Vertex column 2c from the columns c-1, c and c+1.
    pub fn vertex_column(&self, three: Three) -> LevelColumn {
        let column = three.column;
        let last = column.rows.len() - 1;
        let quad = |side: Option<&LevelColumn>, r: usize| {
            Some(sum([&side?.rows[r], &side?.rows[r + 1], &column.rows[r], &column.rows[r + 1]]))
        };
        let mut rows = Vec::with_capacity(2 * last + 1);
        for r in 0..=last {
            rows.push(self.vertex(column.rows[r], three.around(r)));
            if r < last {
                let faces = [quad(three.previous, r), quad(three.next, r)];
                rows.push(self.edge(&column.rows[r], &column.rows[r + 1], faces));
            }
        }
        let ends = [rows[0], rows[2 * last]];
        LevelColumn { rows, outside: [0, 1].map(|end| self.outside(three, end, ends[end])) }
    }

    /// The outside record of the vertex that replaces an outer vertex.
    fn outside(&self, three: Three, end: usize, replacement: Point) -> Outside<Point> {
        let old = &three.column.outside[end];
        let v = three.column.outer(end);
        let last = old.valence as usize - 2; // number of outside faces
        let a = |i: usize| &old.fan[2 * i - 2];
        // corners of the outside face i; none for the gap
        let face = |i: usize| match i {
            _ if old.gap == Some(i as u32) => None,
            1 => outside_face(three.previous?, three.column, end),
            _ if i == last => outside_face(three.column, three.next?, end),
            _ => Some(sum([v, a(i - 1), &old.fan[2 * i - 3], a(i)])),
        };
        let mut fan = Vec::with_capacity(old.fan.len());
        for i in 1..last {
            if i > 1 {
                fan.push(face(i).map_or(replacement, |corners| self.face(corners)));
            }
            fan.push(self.edge(v, a(i), [face(i), face(i + 1)]));
        }
        let (left, right) = match (fan.first(), fan.last()) {
            (Some(first), Some(last)) => (*first, *last),
            // Valence 3: the one outside face borders on both strip edges.
            _ => {
                let to = |side: Option<&LevelColumn>| match side {
                    Some(side) if old.gap.is_none() => {
                        let below = sum([v, three.column.inner(end), side.outer(end), side.inner(end)]);
                        self.edge(v, side.outer(end), [face(1), Some(below)])
                    }
                    _ => replacement,
                };
                (to(three.next), to(three.previous))
            }
        };
        Outside { valence: old.valence, fan, left, right, gap: old.gap }
    }
}

/// The sum of the corners of the outside face over the strip edge between two columns; none at a rim.
fn outside_face(left: &LevelColumn, right: &LevelColumn, end: usize) -> Option<Point> {
    let record = &left.outside[end];
    let rim = record.gap == Some(record.valence - 2) || right.outside[end].gap == Some(1);
    (!rim).then(|| sum([left.outer(end), right.outer(end), &record.right, &right.outside[end].left]))
}
