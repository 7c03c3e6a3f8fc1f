//! All levels at work: three columns of each are kept, and every new column goes down as far as it can.
//!
//! ```text
//!   column c arrives at level l:    c >= 1:  vertex column 2(c-1) of level l+1, from c-2, c-1, c
//!                                   c >= 0:  face column 2c-1 of level l+1, from c-1, c
//! ```
//!
//! Every level then receives exactly the indices -1 .. 2^l M + 1 in order (Hall, section 4.1, Figure 4.3).

use super::around::Three;
use super::level::{LevelColumn, Step};
use super::{CcStrip, OutputColumn};

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
        let step = Step { more, table: &self.core.table };
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

    /// What the arrival of column `index` at the finest level puts out: it, or its left neighbour where limits or
    /// normals look to both sides.
    fn put_out(&mut self, index: i64) {
        let [previous, column, next] = &self.columns[self.levels as usize];
        let (index, column, sides) = match self.core.parameters.looks_sideways() {
            true => (index - 1, column, [previous.as_ref(), next.as_ref()]),
            false => (index, next, [None, None]),
        };
        let (true, Some(column)) = ((0..=self.last).contains(&index), column) else { return };
        let three = Three { previous: sides[0], column, next: sides[1] };
        (self.put)(self.core.finish(self.levels, index as usize, three));
    }
}
