//! How the columns of a strip lie in the beats of the output: whole, in slices, or two in a beat.
//!
//! ```text
//! whole     a beat a column       rows 0 .. 2^l
//! slices    S beats a column      rows 2c p .. 2c (p + 1) - 1 of slice p, and in the last one row 2^l too
//! double    a beat two columns    the second half of the lanes; the last column of a strip stands alone
//! ```

use super::beat::{Beat, Port};
use crate::cores::cc_strip::{Parameters, Schedule};
use crate::model::cc_strip::OutputColumn;

/// The lanes of a core at a level of the strips.
#[derive(Clone, Copy, Debug)]
pub struct Lanes {
    /// Rows of the port for a column.
    rows: usize,
    /// Lanes of the port, three of an axis each.
    lanes: usize,
    slices: usize,
    /// Cells between rows in a beat.
    cells: usize,
    columns: usize,
}

impl Lanes {
    pub fn new(parameters: Parameters, level: u32) -> Self {
        let cells = 1usize << (level - 1);
        let (most, half) =
            (1usize << parameters.levels, parameters.rows_per_clock.map(|rows| rows as usize / 2));
        let slices = half.map_or(1, |half| (cells / half).max(1));
        let rows = half.map_or(most, |half| 2 * half) + 1;
        let double = parameters.schedule == Schedule::Double;
        let columns = if double && level == parameters.levels { 2 } else { 1 };
        Lanes { rows, lanes: if double { 2 * rows } else { rows }, slices, cells: cells / slices, columns }
    }

    /// Beats for so many columns.
    pub fn beats_of(self, columns: usize) -> usize {
        columns.div_ceil(self.columns) * self.slices
    }

    /// Column and row of the first lane of a beat.
    pub fn first(self, beat: usize) -> (usize, usize) {
        (beat / self.slices * self.columns, 2 * self.cells * (beat % self.slices))
    }

    /// Lane, column and row of every vertex of a beat, for a strip of so many columns.
    pub fn places(self, beat: usize, columns: usize) -> Vec<(usize, usize, usize)> {
        let (column, row) = self.first(beat);
        let last = beat % self.slices + 1 == self.slices;
        let here = (0..self.columns).filter(|second| column + second < columns);
        let rows = 2 * self.cells + usize::from(last);
        here.flat_map(|second| (0..rows).map(move |u| (second * self.rows + u, column + second, row + u)))
            .collect()
    }

    /// The beats of a strip.
    pub fn beats(self, port: &Port, columns: &[OutputColumn]) -> Vec<Beat> {
        let count = self.beats_of(columns.len());
        let beat = |index: usize| {
            let mut numbers = vec![0; 3 * self.lanes];
            let mut present = vec![false; self.lanes];
            for (lane, column, row) in self.places(index, columns.len()) {
                present[lane] = true;
                for (axis, &x) in columns[column].vertices[row].iter().enumerate() {
                    numbers[3 * lane + axis] = x.into();
                }
            }
            let mut beat = port.beat_of(&numbers);
            for lane in (0..self.lanes).filter(|&lane| !present[lane]) {
                (0..3).for_each(|axis| port.drop_lane(&mut beat, 3 * lane + axis));
            }
            beat.last = index + 1 == count;
            beat.user = u64::from(port.user > 0 && index % self.slices + 1 == self.slices);
            beat
        };
        (0..count).map(beat).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Format;

    fn lanes(schedule: Schedule, rows_per_clock: Option<u32>, level: u32) -> Lanes {
        let exact = Parameters::exact(Format { integer: 4, fraction: 4 }, 3, 4);
        Lanes::new(Parameters { schedule, rows_per_clock, ..exact }, level)
    }

    /// Every vertex of a strip lies in exactly one lane of one beat.
    #[test]
    fn every_vertex_has_its_place() {
        for level in 1..=3 {
            for (schedule, rows) in
                [(Schedule::Pipelined, None), (Schedule::Pipelined, Some(4)), (Schedule::Double, None)]
            {
                let lanes = lanes(schedule, rows, level);
                let columns = 2 * (1 << level) + 1;
                let mut seen: Vec<_> = (0..lanes.beats_of(columns))
                    .flat_map(|beat| lanes.places(beat, columns))
                    .map(|p| (p.1, p.2))
                    .collect();
                seen.sort_unstable();
                let all: Vec<_> = (0..columns).flat_map(|c| (0..=1 << level).map(move |r| (c, r))).collect();
                assert_eq!(seen, all, "{schedule} {rows:?} {level}");
            }
        }
    }

    #[test]
    fn the_lanes_of_two_columns_do_not_meet() {
        let lanes = lanes(Schedule::Double, None, 3);
        assert_eq!((lanes.rows, lanes.lanes), (9, 18));
        assert_eq!(lanes.places(0, 17).len(), 18);
        assert_eq!(lanes.places(8, 17), (0..9).map(|row| (row, 16, row)).collect::<Vec<_>>());
    }
}
