//! Thin lines over the surface: the control mesh, and the borders of patches.
//!
//! A line covers a pixel by its distance to the middle of the pixel; what part of it is hidden is told by the
//! depths of the pixel's samples. Of several lines in one pixel the strongest counts, so joints leave no knots.

use super::raster::{Band, SAMPLES};
use glam::{Vec2, Vec3};

/// One straight line in the picture, or a dot where both ends are the same.
#[derive(Clone, Copy)]
pub struct Line {
    /// Places in pixels and inverse depths.
    pub ends: [(Vec2, f32); 2],
    /// Half the width in pixels.
    pub radius: f32,
}

pub struct Ink {
    /// Linear light.
    pub colour: Vec3,
    /// How much of it covers what lies below, in front of the surface and behind it.
    pub front: f32,
    pub behind: f32,
}

/// Lines lie this much (of their depth) in front of where they are, so that those on the surface are seen.
const LIFT: f32 = 1.003;

/// Draws lines over the pixels of a band, given in linear light.
pub fn draw(pixels: &mut [Vec3], band: &Band, lines: &[Line], ink: &Ink) {
    let mut cover = vec![[0.0_f32; 2]; pixels.len()];
    for line in lines {
        let [(from, near_from), (to, near_to)] = line.ends;
        let reach = line.radius + 1.0;
        let rows = overlap(from.y.min(to.y) - reach, from.y.max(to.y) + reach, band.rows.clone());
        for row in rows {
            let y = row as f32 + 0.5;
            let [left, right] = span(from, to, y, reach);
            for column in overlap(left, right, 0..band.width) {
                let here = Vec2::new(column as f32 + 0.5, y);
                let (distance, along) = distance(here, from, to);
                let covered = (line.radius + 0.5 - distance).clamp(0.0, 1.0).min(2.0 * line.radius);
                if covered > 0.0 {
                    let pixel = (row - band.rows.start) * band.width + column;
                    let near = near_from + (near_to - near_from) * along;
                    let hidden = band.near[pixel].iter().filter(|sample| **sample > near * LIFT).count();
                    let behind = covered * hidden as f32 / SAMPLES as f32;
                    cover[pixel][0] = cover[pixel][0].max(covered - behind);
                    cover[pixel][1] = cover[pixel][1].max(behind);
                }
            }
        }
    }
    for (pixel, [front, behind]) in pixels.iter_mut().zip(cover) {
        *pixel = pixel.lerp(ink.colour, (front * ink.front).max(behind * ink.behind));
    }
}

/// The columns in which a line, widened by `reach`, can touch the row at height y.
fn span(from: Vec2, to: Vec2, y: f32, reach: f32) -> [f32; 2] {
    let rise = to.y - from.y;
    let [mut first, mut last] = [0.0, 1.0];
    if rise.abs() > 1e-3 {
        let at = [(y - reach - from.y) / rise, (y + reach - from.y) / rise];
        first = at[0].min(at[1]).clamp(0.0, 1.0);
        last = at[0].max(at[1]).clamp(0.0, 1.0);
    }
    let x = [first, last].map(|along| from.x + (to.x - from.x) * along);
    [x[0].min(x[1]) - reach, x[0].max(x[1]) + reach]
}

/// The distance to a line, and where along it (0 to 1) the nearest point lies.
pub fn distance(p: Vec2, from: Vec2, to: Vec2) -> (f32, f32) {
    let direction = to - from;
    let length_squared = direction.length_squared();
    let along = if length_squared > 0.0 { (p - from).dot(direction) / length_squared } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    (p.distance(from + direction * along), along)
}

fn overlap(low: f32, high: f32, limits: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let start = (low.floor().max(0.0) as usize).max(limits.start);
    let end = (high.ceil().max(0.0) as usize).min(limits.end);
    start..end.max(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(near: f32) -> Vec<Vec3> {
        let mut band = Band::new(20);
        band.clear(10..20);
        band.near.iter_mut().for_each(|samples| *samples = [0.5; SAMPLES]);
        let mut pixels = vec![Vec3::ZERO; 200];
        let line = Line { ends: [(Vec2::new(2.5, 2.5), near), (Vec2::new(17.5, 17.5), near)], radius: 0.7 };
        draw(&mut pixels, &band, &[line], &Ink { colour: Vec3::ONE, front: 1.0, behind: 0.25 });
        pixels
    }

    #[test]
    fn a_line_is_as_thick_as_it_is_said_to_be() {
        // A diagonal of width 1.4 covers 1.4 sqrt(2) pixels in each row that it crosses.
        let row: f32 = drawn(0.7)[3 * 20..4 * 20].iter().map(|p| p.x).sum();
        assert!((row - 1.4 * 2_f32.sqrt()).abs() < 0.15, "{row}");
    }

    #[test]
    fn behind_the_surface_it_is_faint() {
        assert!((drawn(0.7)[3 * 20 + 13].x - 1.0).abs() < 1e-6);
        assert!((drawn(0.3)[3 * 20 + 13].x - 0.25).abs() < 1e-6);
    }
}
