//! The face column and the vertex column: separable sums over the rows of two and three columns.
//!
//! ```text
//! s = c + next                  F = (s_k + s_{k+1}) / 4          E_row = (s_{k-1} + 6 s_k + s_{k+1}) / 16
//! t = s_old + s + 4 c           E_col = (t_k + t_{k+1}) / 16     V = (t_{k-1} + 6 t_k + t_{k+1}) / 64
//! ```
//!
//! where s_old = previous + c is the s of the column before. Everything is computed over 64, so nothing is divided here; where vertices are kept with guard bits, each
//! new one is rounded once, from its unrounded sum. A unit works on q cells: rows 0 .. q, and the rows above
//! and below them, which lie outside of the strip at its ends. Source: Hall, sections 4.3 and 4.4.

use std::rc::Rc;

use super::Parameters;
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal};

/// Names of the rows that a unit of `cells` cells sees: above, 0, .., q, below.
pub fn row_names(cells: u32) -> Vec<String> {
    let inner = (0..=cells).map(|k| k.to_string());
    std::iter::once("above".to_string()).chain(inner).chain(["below".to_string()]).collect()
}

/// A sum over 64 of vertices of the unit's level as a vertex of the next level.
fn vertex(m: &Builder, parameters: Parameters, level: u32, name: String, sum: impl Into<crate::hdl::Sum>) {
    let sum = m.wire(format!("{name}_sum"), sum.into());
    let over64 = m.rescale(&sum, parameters.word(level).fraction + 6);
    let rounded = m.round(&over64, parameters.drop(), parameters.rounding);
    m.output(name.clone(), m.wire(name, &rounded));
}

/// The column between two: `edge_k` on row k, `face_k` between the rows k and k + 1, `face_above` and
/// `face_below` beyond the ends. Inputs `s_..` by [`row_names`].
pub fn face_column(parameters: Parameters, level: u32, cells: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("face_column_{level}"));
    m.purpose(format!("Face points and edge points between two columns of level {level}, {cells} cells."));
    let names = row_names(cells);
    let s: Vec<Signal> =
        names.iter().map(|row| m.input(format!("s_{row}"), parameters.sum_word(level))).collect();
    let pairs: Vec<Signal> =
        s.windows(2).zip(&names).map(|(w, row)| m.wire(format!("s_pair_{row}"), &w[0] + &w[1])).collect();
    let last = cells as usize + 1;
    for (k, pair) in pairs.iter().enumerate() {
        let name = match k {
            0 => "face_above".to_string(),
            _ if k == last => "face_below".to_string(),
            _ => format!("face_{}", k - 1),
        };
        vertex(&m, parameters, level, name, 16 * pair);
    }
    for k in 1..=last {
        // s_{k-1} + 6 s_k + s_{k+1} is two neighbouring pairs and four times the middle.
        let sum = 4 * &pairs[k - 1] + 4 * &pairs[k] + 16 * &s[k];
        vertex(&m, parameters, level, format!("edge_{}", k - 1), sum);
    }
    m.finish()
}

/// The new rows of a column itself: `edge_k` between the rows k and k + 1, `vertex_k` in place of row k where
/// both neighbours are in the strip: k = 1 .. q - 1, and k = 0 where the unit works on `sliced` columns. Inputs
/// `old_..` (s_old), `s_..` and `column_..`.
pub fn vertex_column(parameters: Parameters, level: u32, cells: u32, sliced: bool) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("vertex_column_{level}"));
    m.purpose(format!("Edge points and replaced vertices of a column of level {level}, {cells} cells."));
    let names = &row_names(cells)[usize::from(!sliced)..=cells as usize + 1];
    let t: Vec<Signal> = names
        .iter()
        .map(|row| {
            let [old, s] =
                ["old", "s"].map(|sum| m.input(format!("{sum}_{row}"), parameters.sum_word(level)));
            let column = m.input(format!("column_{row}"), parameters.word(level));
            m.wire(format!("t_{row}"), &old + &s + 4 * &column)
        })
        .collect();
    let pairs: Vec<Signal> =
        t.windows(2).zip(names).map(|(w, row)| m.wire(format!("t_pair_{row}"), &w[0] + &w[1])).collect();
    for (k, pair) in pairs.iter().enumerate() {
        if names[k] != "above" {
            vertex(&m, parameters, level, format!("edge_{}", names[k]), 4 * pair);
        }
        if k > 0 {
            let sum = &pairs[k - 1] + pair + 4 * &t[k];
            vertex(&m, parameters, level, format!("vertex_{}", names[k]), sum);
        }
    }
    m.finish()
}
