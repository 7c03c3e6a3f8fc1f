//! How the columns of a strip lie in the beats of the output: whole, in slices, or two in a beat.
//!
//! ```text
//! whole     a beat a column       rows 0 .. 2^l
//! slices    S beats a column      rows 2c p .. 2c (p + 1) - 1 of slice p, and in the last one row 2^l too
//! double    a beat two columns    the second half of the lanes; the last column of a strip stands alone
//! ```
//!
//! Normals stand in lanes behind all positions. In row-major output a beat is one vertex.

use super::beat::{Beat, Port};
use crate::cores::cc_strip::{Parameters, Schedule};
use crate::model::cc_strip::OutputColumn;
use crate::model::cc_strip::longitudinal::{Sent, rows_of};

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
    normals: bool,
    /// The most columns of a chunk of row-major output.
    chunk: Option<usize>,
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
        Lanes {
            rows,
            lanes: if double { 2 * rows } else { rows },
            slices,
            cells: cells / slices,
            columns,
            normals: parameters.normals.is_some(),
            chunk: parameters.longitudinal.map(|log| 1 << log),
        }
    }

    /// Rows of a column.
    fn height(self) -> usize {
        2 * self.cells * self.slices + 1
    }

    /// The beats of a strip of so many columns: lane, column and row of every vertex.
    pub fn of_strip(self, columns: usize) -> Vec<Vec<(usize, usize, usize)>> {
        if let Some(chunk) = self.chunk {
            let places: Vec<Vec<_>> =
                (0..columns).map(|c| (0..self.height()).map(|r| (0, c, r)).collect()).collect();
            return rows_of(&places, chunk).into_iter().map(|sent| vec![sent.vertex]).collect();
        }
        let count = columns.div_ceil(self.columns) * self.slices;
        (0..count).map(|beat| self.places(beat, columns)).collect()
    }

    /// Column and row of the first lane of a beat.
    fn first(self, beat: usize) -> (usize, usize) {
        (beat / self.slices * self.columns, 2 * self.cells * (beat % self.slices))
    }

    /// Lane, column and row of every vertex of a beat, for a strip of so many columns.
    fn places(self, beat: usize, columns: usize) -> Vec<(usize, usize, usize)> {
        let (column, row) = self.first(beat);
        let last = beat % self.slices + 1 == self.slices;
        let here = (0..self.columns).filter(|second| column + second < columns);
        let rows = 2 * self.cells + usize::from(last);
        here.flat_map(|second| (0..rows).map(move |u| (second * self.rows + u, column + second, row + u)))
            .collect()
    }

    /// The beats of a strip.
    pub fn beats(self, port: &Port, columns: &[OutputColumn]) -> Vec<Beat> {
        if let Some(chunk) = self.chunk {
            let vertices: Vec<Vec<[i64; 3]>> = columns.iter().map(|column| column.vertices.clone()).collect();
            let beat = |sent: Sent<[i64; 3]>| {
                let mut beat = port.beat_of(&sent.vertex.map(i128::from));
                beat.user = u64::from(sent.row_end) | u64::from(sent.chunk_end) << 1;
                beat.last = sent.strip_end;
                beat
            };
            return rows_of(&vertices, chunk).into_iter().map(beat).collect();
        }
        let strip = self.of_strip(columns.len());
        let count = strip.len();
        let all = if self.normals { self.lanes + self.rows } else { self.lanes };
        let beat = |(index, places): (usize, Vec<(usize, usize, usize)>)| {
            let mut numbers = vec![0; 3 * all];
            let mut present = vec![false; all];
            let mut put = |lane: usize, vertex: &[i64; 3]| {
                present[lane] = true;
                (0..3).for_each(|axis| numbers[3 * lane + axis] = vertex[axis].into());
            };
            for (lane, column, row) in places {
                put(lane, &columns[column].vertices[row]);
                if let Some(normal) = columns[column].normals.get(row) {
                    put(self.lanes + lane, normal);
                }
            }
            let mut beat = port.beat_of(&numbers);
            for lane in (0..all).filter(|&lane| !present[lane]) {
                (0..3).for_each(|axis| port.drop_lane(&mut beat, 3 * lane + axis));
            }
            beat.last = index + 1 == count;
            beat.user = u64::from(port.user > 0 && index % self.slices + 1 == self.slices);
            beat
        };
        strip.into_iter().enumerate().map(beat).collect()
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
                let mut seen: Vec<_> =
                    lanes.of_strip(columns).into_iter().flatten().map(|p| (p.1, p.2)).collect();
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
