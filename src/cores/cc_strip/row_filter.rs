//! The face column and the vertex column by one filter over the rows, a register behind every adder.
//!
//! ```text
//! clock 1    s = c + next
//! clock 2    u = face ? 0 : s_old + 4 c            w = face ? 4 s : s
//! clock 3    r = u + w                             4 s, or t = s_old + s + 4 c
//! clock 4    pair_k = r_k + r_{k+1}                odd rows: pair / 16
//! clock 5    half_k = pair_{k-1} + 4 r_k
//! clock 6    half_k + pair_k                       even rows: (r_{k-1} + 6 r_k + r_{k+1}) / 64
//! ```
//!
//! The rules of both columns are the same sums over the rows, of 4 s and of t (see [`super::columns`]), and a unit that
//! makes one column in a clock needs one of them.

use std::rc::Rc;

use super::Parameters;
use super::columns::row_names;
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Sum, Word};

/// Inputs: `face`; `s_..` of every row (see [`row_names`]), `old_..` and `column_..` of those in the strip; or, where the
/// ends are walked around, `previous_..`, `middle_..` and `next_..`, a clock later.
/// Outputs: `row_0` to `row_2q`, and `face_above` and `face_below`, which only a face column has.
pub fn build(parameters: Parameters, level: u32, cells: u32, sliced: bool) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("row_filter_{level}"));
    m.purpose(format!("The new rows of a face or vertex column of level {level}, {cells} cells."));
    let word = parameters.word(level);
    let face = m.input("face", Word::bit());
    let names = row_names(cells);
    let inside = usize::from(!sliced)..=cells as usize + 1;
    let mut r: Vec<Signal> = vec![];
    for (at, row) in names.iter().enumerate() {
        let inside = inside.contains(&at);
        r.push(match parameters.walked() {
            true => of_rows(&m, parameters, level, &face, row, inside),
            false => of_sums(&m, parameters, level, &face, row, inside),
        });
    }
    let put = |name: String, sum: Sum| {
        let sum = m.pipelined(&format!("{name}_sum"), sum);
        let over64 = m.rescale(&sum, word.fraction + 6);
        let rounded = m.round(&over64, parameters.drop(), parameters.rounding);
        let exact = parameters.drop() == 0 || parameters.rounding == crate::fixed::Rounding::Floor;
        m.output(name.clone(), if exact { m.wire(name, &rounded) } else { m.pipe(name, &rounded) });
    };
    let pairs: Vec<Signal> =
        r.windows(2).zip(&names).map(|(w, row)| m.pipe(format!("pair_{row}"), &w[0] + &w[1])).collect();
    let plain = |name: String, pair: &Signal| {
        let over16 = m.rescale(&m.signal(4 * pair), word.fraction + 6);
        let rounded = m.round(&over16, parameters.drop(), parameters.rounding);
        let exact = parameters.drop() == 0 || parameters.rounding == crate::fixed::Rounding::Floor;
        m.output(name.clone(), if exact { m.wire(name, &rounded) } else { m.pipe(name, &rounded) });
    };
    plain("face_above".into(), &pairs[0]);
    for k in 0..=cells as usize {
        let half = m.pipe(format!("half_{k}"), &pairs[k] + 4 * &r[k + 1]);
        put(format!("row_{}", 2 * k), &half + &pairs[k + 1]);
        let name = if k == cells as usize { "face_below".into() } else { format!("row_{}", 2 * k + 1) };
        plain(name, &pairs[k + 1]);
    }
    m.finish()
}

/// Four sums of two vertices, or the eight vertices of t.
fn eight(m: &Builder, parameters: Parameters, level: u32, row: &str, sum: Sum) -> Signal {
    let word = parameters.word(level);
    let eightfold = Word { range: word.range * 8, ..word };
    m.pipe(format!("r_{row}"), m.claim(&format!("r_of_{row}"), sum, eightfold, None))
}

/// r of a row from the sums of columns that the window keeps. Only face columns see what is not `inside`.
fn of_sums(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    face: &Signal,
    row: &str,
    inside: bool,
) -> Signal {
    let (word, sum_word) = (parameters.word(level), parameters.sum_word(level));
    let s = m.input(format!("s_{row}"), sum_word);
    let fourfold = m.signal(4 * &s);
    if !inside {
        return m.pipe(format!("r_{row}"), m.pipe(format!("w_{row}"), &fourfold));
    }
    let scaled = m.pipe(format!("w_{row}"), m.select(face, &fourfold, &s));
    let old = m.input(format!("old_{row}"), sum_word);
    let column = m.input(format!("column_{row}"), word);
    let zero = m.constant(0, Word { range: crate::fixed::Range::point(0), ..word });
    let rest = m.pipe(format!("u_{row}"), m.select(face, &zero, &old + 4 * &column));
    eight(m, parameters, level, row, &rest + &scaled)
}

/// r of a row from three columns, which come a clock behind `face`; every row has a copy of that. Of 4 (c + n) or
/// p + n + 6 c, the outer columns first.
fn of_rows(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    face: &Signal,
    row: &str,
    inside: bool,
) -> Signal {
    let word = parameters.word(level);
    let [c, n] = ["middle", "next"].map(|column| m.input_at(format!("{column}_{row}"), word, 1));
    if !inside {
        let outer = m.pipe(format!("outer_{row}"), &c + &n);
        return m.pipe(format!("r_{row}"), 4 * &outer);
    }
    let face = m.copy(format!("face_{row}"), face);
    let p = m.input_at(format!("previous_{row}"), word, 1);
    let outer = m.pipe(format!("outer_{row}"), m.select(&face, 4 * &n, &p + &n));
    let inner = m.pipe(format!("inner_{row}"), m.select(&face, 4 * &c, 4 * &c + 2 * &c));
    eight(m, parameters, level, row, &outer + &inner)
}
