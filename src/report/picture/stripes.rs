//! Reflection lines: parallel lines of light around the scene, seen in the surface as in a mirror.
//!
//! The lines are very long and far away, so a mirrored direction meets line number `n` when its angle
//! around their common axis is `n` of `LINES` turns. What a pixel shows is the exact mean of that pattern over
//! the angles it covers: lines too dense for the pixels fade to grey and never to a moire pattern.

use super::{
    arithmetic::{smooth_step, turns},
    camera::Camera,
};
use glam::Vec3;

const LINES: f32 = 22.0;
/// The part of the circle that shines.
const SHINING: f32 = 0.5;
/// The soft rim of a line, in distances between lines.
const SOFT: f32 = 0.07;

/// What a mirrored direction meets.
#[derive(Clone, Copy)]
pub struct Meeting {
    /// The number of the line; whole numbers are the beginnings of lines. Defined up to multiples of `LINES`.
    pub phase: f32,
    /// 1 on the lines, falling to 0 beyond their ends: they are long but not endless, else they would all
    /// meet in one point at each end.
    pub within: f32,
}

pub fn meet(toward: Vec3, camera: &Camera) -> Meeting {
    // The axis lies level in the picture, tilted away from the photographer, so that the lines flow around the
    // shape instead of along its outline.
    let axis = (camera.right * 0.88 + camera.up * 0.30 - camera.back * 0.37).normalize();
    let first = axis.cross(camera.back).normalize();
    let second = axis.cross(first);
    let phase = LINES * turns(toward.dot(second), toward.dot(first));
    Meeting { phase, within: smooth_step(0.985, 0.945, toward.dot(axis).abs()) }
}

/// The width that a pixel covers around one of its samples, from the phases of all those on the same piece of
/// surface.
pub fn footprint(phase: f32, others: impl Iterator<Item = f32>) -> f32 {
    let (mut low, mut high) = (0.0_f32, 0.0_f32);
    for other in others {
        // The nearest of the two ways around.
        let mut step = other - phase;
        if step > LINES / 2.0 {
            step -= LINES;
        } else if step < -LINES / 2.0 {
            step += LINES;
        }
        (low, high) = (low.min(step), high.max(step));
    }
    (high - low).max(SOFT)
}

/// The mean light over `width` around a phase.
pub fn light(phase: f32, width: f32) -> f32 {
    // The light from line 0 up to x.
    let total = |x: f32| {
        let whole = x as i32 as f32;
        SHINING * whole + (x - whole).min(SHINING)
    };
    // Some turns further it is the same, and positive.
    let phase = phase + 4.0 * LINES;
    let (low, high) = (phase - width / 2.0, phase + width / 2.0);
    ((total(high) - total(low)) / width).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_pixels_see_the_mean() {
        for phase in [0.0, 0.3, 7.9, -3.2] {
            assert!((light(phase, 40.0) - SHINING).abs() < 0.01);
        }
        assert_eq!(light(0.25, 0.1), 1.0);
        assert_eq!(light(-0.25, 0.1), 0.0);
        assert!((light(3.0, 0.1) - 0.5).abs() < 1e-4);
    }

    #[test]
    fn the_footprint_does_not_jump_where_the_circle_closes() {
        let (left, right) = (LINES / 2.0 - 0.1, 0.1 - LINES / 2.0);
        assert!((footprint(left, [right].into_iter()) - 0.2).abs() < 1e-5);
    }
}
