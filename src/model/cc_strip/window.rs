//! All levels at work: three columns of each are kept, and every new column goes down as far as it can.
//!
//! ```text
//!   column c arrives at level l:    c >= 1:  vertex column 2(c-1) of level l+1, from c-2, c-1, c
//!                                   c >= 0:  face column 2c-1 of level l+1, from c-1, c
//! ```
//!
//! Every level then receives exactly the indices -1 .. 2^l M + 1 in order (Hall, section 4.1, Figure 4.3).

use super::around::{Around, Three, plus};
use super::level::{LevelColumn, Step};
use super::{CcStrip, OutputColumn, Point, rounded};
use crate::fixed::Rounding;

/// The last three columns of each level.
pub(super) struct Windows<'a, Made, Put> {
    core: &'a CcStrip,
    levels: u32,
    /// 2^L M, the last column that is put out.
    last: i64,
    /// By level: the columns c-2, c-1, c; none before the strip has begun and at a rim.
    columns: Vec<[Option<LevelColumn>; 3]>,
    made: Made,
    put: Put,
}

impl<'a, Made, Put> Windows<'a, Made, Put>
where
    Made: FnMut(u32, i64, Option<&LevelColumn>),
    Put: FnMut(OutputColumn),
{
    pub(super) fn new(core: &'a CcStrip, levels: u32, quads: usize, made: Made, put: Put) -> Self {
        let columns = vec![[None, None, None]; levels as usize + 1];
        Windows { core, levels, last: (quads as i64) << levels, columns, made, put }
    }

    /// Column `index` of a level, -1 first; none in place of the guard of a rim.
    pub(super) fn arrive(&mut self, level: u32, index: i64, column: Option<LevelColumn>) {
        (self.made)(level, index, column.as_ref());
        let window = &mut self.columns[level as usize];
        window.rotate_left(1);
        window[2] = column;
        if level == self.levels {
            return self.put_out(index);
        }
        let numbers = self.core.parameters.numbers;
        let more = numbers.fraction(level + 1) - numbers.fraction(level);
        let rounding = self.core.parameters.rounding;
        let step = Step { more, rounding, table: &self.core.table };
        if index >= 1 {
            let [previous, column, next] = &self.columns[level as usize];
            let column = column.as_ref().map(|column| {
                step.vertex_column(Three { previous: previous.as_ref(), column, next: next.as_ref() })
            });
            self.arrive(level + 1, 2 * (index - 1), column);
        }
        if index >= 0 {
            let column = match &self.columns[level as usize] {
                [_, Some(left), Some(right)] => Some(step.face_column(left, right)),
                _ => None,
            };
            self.arrive(level + 1, 2 * index - 1, column);
        }
    }

    /// What the arrival of column `index` at the finest level puts out: it, or its left neighbour's limit.
    fn put_out(&mut self, index: i64) {
        let core = self.core;
        let [previous, column, next] = &self.columns[self.levels as usize];
        let index = if core.parameters.limit { index - 1 } else { index };
        let column = if core.parameters.limit { column } else { next };
        let (true, Some(column)) = ((0..=self.last).contains(&index), column) else { return };
        let fraction = core.parameters.numbers.fraction(self.levels) as i32;
        let shift = fraction - core.parameters.extra_fraction;
        let narrow = |p: Point, shift: i32| p.map(|x| rounded(x, shift, Rounding::HalfUp) as i64);
        let vertices = if core.parameters.limit {
            let three = Three { previous: previous.as_ref(), column, next: next.as_ref() };
            let bits = core.table.bits();
            let limit = |r: usize| narrow(core.limit(column.rows[r], three.around(r)), shift + bits as i32);
            (0..column.rows.len()).map(limit).collect()
        } else {
            column.rows.iter().map(|&p| narrow(p, shift)).collect()
        };
        (self.put)(OutputColumn { index: index as usize, vertices });
    }
}

impl CcStrip {
    /// 2^b times the limit position: S + lambda_d (4 sum A + sum D - 5d S), or V + (A + B - 2V)/6 on a rim.
    fn limit(&self, s: Point, around: Around) -> Point {
        let (spread, weight) = match around {
            Around::Rim { neighbours } => (plus(neighbours, -2, s), self.table.sixth()),
            Around::Ring { valence, neighbours, diagonals } => {
                (plus(plus(diagonals, 4, neighbours), -5 * valence as i128, s), self.table.lambda(valence))
            }
        };
        std::array::from_fn(|x| (s[x] << self.table.bits()) + spread[x] * i128::from(weight))
    }
}
