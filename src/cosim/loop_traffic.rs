//! One packet of control points as beats, and the beats that must answer it.
//!
//! ```text
//! 12 points, level ─► 12 beats, tuser = level, tlast on the last     packet
//!                  ─► strips of pairs, tuser = start, end of patch   answer, by the reference
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
}

impl Traffic {
    pub fn new(core: &Module, parameters: Parameters) -> Result<Traffic> {
        let width = parameters.coordinates.width();
        Ok(Traffic {
            input: core::port(core, "s_axis", Direction::Input),
            output: core::port(core, "m_axis", Direction::Output),
            model: LoopFd::new(width, extra_fraction(parameters), parameters.max_level)?
                .with_precision(parameters.precision)?,
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
}

/// Fraction bits of the output beyond those of the coordinates.
pub fn extra_fraction(parameters: Parameters) -> i32 {
    parameters.output_fraction as i32 - parameters.coordinates.fraction as i32
}
