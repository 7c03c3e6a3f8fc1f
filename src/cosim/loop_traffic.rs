//! One packet of control points as beats, and the beats that must answer it.
//!
//! ```text
//! 12 points, level ─► 12 beats, tuser = level, tlast on the last     packet
//!                  ─► strips of pairs, or of rows of several strips, tuser = start, end of patch   answer, by the reference
//! ```

use super::beat::{Beat, Port};
use super::core;
use crate::cores::loop_fd::Parameters;
use crate::error::Result;
use crate::hdl::{Direction, Module};
use crate::model::loop_fd::LoopFd;

/// The two streams of a `loop-fd` and what passes over them.
pub(super) struct Traffic {
    pub input: Port,
    pub output: Port,
    model: LoopFd,
    lanes: Option<u32>,
}

impl Traffic {
    pub fn new(core: &Module, parameters: Parameters) -> Result<Traffic> {
        let width = parameters.coordinates.width();
        Ok(Traffic {
            input: core::port(core, "s_axis", Direction::Input),
            output: core::port(core, "m_axis", Direction::Output),
            model: LoopFd::new(width, extra_fraction(parameters), parameters.max_level)?
                .with_precision(parameters.precision)?,
            lanes: parameters.lanes,
        })
    }

    /// The beats of a packet of any number of points.
    pub fn packet(&self, level: u32, points: &[[i128; 3]]) -> impl Iterator<Item = Beat> {
        points.iter().enumerate().map(move |(index, point)| {
            let last = index + 1 == points.len();
            Beat { user: level.into(), last, ..self.input.beat_of(point) }
        })
    }

    /// Appends what must come out for twelve points.
    ///
    /// # Errors
    /// A level above the core's maximum.
    pub fn answer(&self, level: u32, points: &[[i128; 3]; 12], expected: &mut Vec<Beat>) -> Result<()> {
        if let Some(lanes) = self.lanes {
            return self.answer_of_lanes(level, points, lanes as usize, expected);
        }
        self.model.for_each_beat(level, points, |vertices| {
            let [x, y, z] = vertices.left.map(i128::from);
            let [u, v, w] = vertices.right.unwrap_or_default().map(i128::from);
            let mut beat = self.output.beat_of(&[x, y, z, u, v, w]);
            if vertices.right.is_none() {
                (3..6).for_each(|lane| self.output.drop_lane(&mut beat, lane));
            }
            beat.user = u64::from(vertices.patch_start) + 2 * u64::from(vertices.patch_end);
            beat.last = vertices.strip_end;
            expected.push(beat);
        })
    }

    /// The same vertices, those of a row of `lanes` strips in a beat.
    fn answer_of_lanes(
        &self,
        level: u32,
        points: &[[i128; 3]; 12],
        lanes: usize,
        expected: &mut Vec<Beat>,
    ) -> Result<()> {
        let steps = 1usize << level;
        let mut columns: Vec<Vec<[i64; 3]>> = vec![vec![]; steps + 1];
        let mut strip = 0;
        self.model.for_each_beat(level, points, |vertices| {
            columns[strip].push(vertices.left);
            if strip + 1 == steps {
                columns[steps].extend(vertices.right);
            }
            strip += usize::from(vertices.strip_end);
        })?;
        for first in (0..steps).step_by(lanes) {
            let rows = steps - first;
            for row in 0..=rows {
                let vertex = |k: usize| columns.get(first + k).and_then(|column| column.get(row));
                let numbers: Vec<i128> = (0..=lanes)
                    .flat_map(|k| vertex(k).copied().unwrap_or_default().map(i128::from))
                    .collect();
                let mut beat = self.output.beat_of(&numbers);
                for lane in (0..=lanes).filter(|&k| vertex(k).is_none()).flat_map(|k| 3 * k..3 * k + 3) {
                    self.output.drop_lane(&mut beat, lane);
                }
                beat.last = row == rows;
                let (start, end) = (first == 0 && row == 0, first + lanes >= steps && row == rows);
                beat.user = u64::from(start) + 2 * u64::from(end);
                expected.push(beat);
            }
        }
        Ok(())
    }
}

/// Fraction bits of the output beyond those of the coordinates.
pub fn extra_fraction(parameters: Parameters) -> i32 {
    parameters.output_fraction as i32 - parameters.coordinates.fraction as i32
}
