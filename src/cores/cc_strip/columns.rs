//! The face column and the vertex column: separable sums over the rows of two and three columns.
//!
//! ```text
//! s = left + right          F = (s_k + s_{k+1}) / 4          E_row = (s_{k-1} + 6 s_k + s_{k+1}) / 16
//! t = previous + 6 c + next E_col = (t_k + t_{k+1}) / 16     V = (t_{k-1} + 6 t_k + t_{k+1}) / 64
//! ```
//!
//! Everything is computed over 64, so nothing is divided here.

use crate::hdl::{Builder, Signal};

/// One column in the window: its strip vertices from top to bottom, and what lies outside at both ends.
pub struct Column {
    pub rows: Vec<Signal>,
    pub top: Outside,
    pub bottom: Outside,
}

/// What lies outside of an end of a column.
#[derive(Clone)]
pub struct Outside {
    /// The outside vertex that the face columns to the left and to the right use.
    pub left: Signal,
    pub right: Signal,
    /// a_1 .. a_{d-3}: the outside edge neighbours from left to right.
    pub neighbours: Vec<Signal>,
    /// x_2 .. x_{d-3}: the diagonals of the outside faces between them; `diagonals[i]` is x_{i+2}.
    pub diagonals: Vec<Signal>,
}

/// A new column, over 64, with the outside faces at its ends.
pub struct FaceColumn {
    pub rows: Vec<Signal>,
    pub top: Signal,
    pub bottom: Signal,
}

/// The column between two: edge points of the rows, and face points between them (Hall, section 4.3).
pub fn face_column(m: &Builder, left: &Column, right: &Column) -> FaceColumn {
    // s runs over the outside rows too: s[0] lies above the strip, s[rows + 1] below.
    let mut s = vec![m.wire("s_above", &left.top.right + &right.top.left)];
    for (k, (a, b)) in left.rows.iter().zip(&right.rows).enumerate() {
        s.push(m.wire(format!("s_{k}"), a + b));
    }
    s.push(m.wire("s_below", &left.bottom.right + &right.bottom.left));

    let pairs: Vec<Signal> =
        s.windows(2).enumerate().map(|(k, w)| m.wire(format!("s_pair_{k}"), &w[0] + &w[1])).collect();
    let face = |k: usize| m.wire(format!("face_{k}"), &pairs[k] << 4);
    let mut rows = vec![];
    for k in 1..s.len() - 1 {
        // s_{k-1} + 6 s_k + s_{k+1} is two neighbouring pairs and four times the middle.
        rows.push(m.wire(format!("edge_row_{}", k - 1), 4 * &pairs[k - 1] + 4 * &pairs[k] + 16 * &s[k]));
        if k + 2 < s.len() {
            rows.push(face(k));
        }
    }
    FaceColumn { rows, top: face(0), bottom: face(pairs.len() - 1) }
}

/// The new rows of a column itself, but for the replacement of its two end vertices: edge points between
/// the rows, replacement vertices on the inner rows (Hall, section 4.4).
pub fn vertex_column(
    m: &Builder,
    previous: &Column,
    column: &Column,
    next: &Column,
    ends: [Signal; 2],
) -> Vec<Signal> {
    let count = column.rows.len();
    let t: Vec<Signal> = (0..count)
        .map(|k| {
            let around = m.wire(format!("around_{k}"), &previous.rows[k] + &next.rows[k]);
            m.wire(format!("t_{k}"), &around + 6 * &column.rows[k])
        })
        .collect();
    let pairs: Vec<Signal> =
        t.windows(2).enumerate().map(|(k, w)| m.wire(format!("t_pair_{k}"), &w[0] + &w[1])).collect();
    let [top, bottom] = ends;
    let mut rows = vec![top];
    for k in 0..count - 1 {
        rows.push(m.wire(format!("edge_column_{k}"), &pairs[k] << 2));
        if k + 2 < count {
            rows.push(m.wire(format!("replacement_{}", k + 1), &pairs[k] + &pairs[k + 1] + 4 * &t[k + 1]));
        }
    }
    rows.push(bottom);
    rows
}
