//! Which triangle each sample of the picture shows: eight samples a pixel, decided in integers.
//!
//! Corners are rounded to 1/256 pixel; from there coverage is exact, so that neighbouring triangles share their
//! edge without gap or overlap. A sample is inside when all three edge functions are positive; on an edge the
//! rule of the top-left edge decides.

use glam::Vec2;
use num_traits::PrimInt;
use std::ops::Range;

pub const SAMPLES: usize = 8;
/// Units of a pixel in which corners are given.
pub const UNIT: i32 = 256;
/// Places of the samples inside a pixel: eight rooks, no two in one row or column.
pub const PLACES: [[i32; 2]; SAMPLES] =
    [[144, 80], [112, 176], [208, 144], [80, 48], [48, 208], [16, 112], [176, 240], [240, 16]];
/// The triangle of a sample that shows none.
pub const NOTHING: u32 = u32::MAX;

/// A vertex in the picture.
#[derive(Clone, Copy)]
pub struct Corner {
    /// Units right and down.
    pub x: i32,
    pub y: i32,
    /// Inverse of the depth: straight across the picture, larger is nearer.
    pub near: f32,
}

impl Corner {
    pub fn new(place: Vec2, near: f32) -> Self {
        let unit = UNIT as f32;
        Corner { x: (place.x * unit).round() as i32, y: (place.y * unit).round() as i32, near }
    }
}

/// Twice the area in square units, positive where the corners run counterclockwise as seen (y points down).
pub fn doubled_area([a, b, c]: [Corner; 3]) -> i64 {
    let wide = |from: i32, to: i32| i64::from(to) - i64::from(from);
    wide(a.y, b.y) * wide(a.x, c.x) - wide(a.x, b.x) * wide(a.y, c.y)
}

/// Rows of the picture with their samples.
pub struct Band {
    pub width: usize,
    pub rows: Range<usize>,
    /// Eight triangles a pixel, row by row.
    pub triangles: Vec<[u32; SAMPLES]>,
    /// The inverse depths; 0 is infinitely far.
    pub near: Vec<[f32; SAMPLES]>,
}

impl Band {
    pub fn new(width: usize) -> Self {
        Band { width, rows: 0..0, triangles: Vec::new(), near: Vec::new() }
    }

    /// Empties the band and moves it to other rows.
    pub fn clear(&mut self, rows: Range<usize>) {
        let pixels = self.width * rows.len();
        self.rows = rows;
        self.triangles.clear();
        self.triangles.resize(pixels, [NOTHING; SAMPLES]);
        self.near.clear();
        self.near.resize(pixels, [0.0; SAMPLES]);
    }

    /// Draws a triangle where it is the nearest; of two at the same depth the first one stays.
    pub fn draw(&mut self, number: u32, mut corners: [Corner; 3], cull_backs: bool) {
        let area = doubled_area(corners);
        if area == 0 || (area < 0 && cull_backs) {
            return;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let [low_x, high_x] = bounds(corners.map(|c| c.x));
        let [low_y, high_y] = bounds(corners.map(|c| c.y));
        let columns = clip(low_x, high_x, 0..self.width);
        let rows = clip(low_y, high_y, self.rows.clone());
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let plane = Plane::new(corners, area.unsigned_abs(), columns.start, rows.start);
        // Edge functions of a small triangle near its own pixels stay below 2^29.
        if high_x - low_x < 40 * UNIT && high_y - low_y < 40 * UNIT {
            self.cover::<i32>(number, corners, columns, rows, &plane);
        } else {
            self.cover::<i64>(number, corners, columns, rows, &plane);
        }
    }

    fn cover<T: PrimInt + From<i32>>(
        &mut self,
        number: u32,
        corners: [Corner; 3],
        columns: Range<usize>,
        rows: Range<usize>,
        plane: &Plane,
    ) {
        let unit = int::<T>(UNIT);
        let origin = [columns.start as i32 * UNIT, rows.start as i32 * UNIT];
        let edges: [Edge<T>; 3] =
            std::array::from_fn(|k| Edge::new(corners[(k + 1) % 3], corners[(k + 2) % 3], origin));
        let offsets = edges.each_ref().map(|edge| edge.samples());
        for row in rows.clone() {
            let down = int::<T>((row - rows.start) as i32) * unit;
            let mut values = edges.each_ref().map(|edge| edge.start + edge.down * down);
            let first = (row - self.rows.start) * self.width;
            for column in columns.clone() {
                let mut inside = [false; SAMPLES];
                for s in 0..SAMPLES {
                    let signs = (values[0] + offsets[0][s])
                        | (values[1] + offsets[1][s])
                        | (values[2] + offsets[2][s]);
                    inside[s] = signs >= T::zero();
                }
                if inside != [false; SAMPLES] {
                    let near = plane.at(column - columns.start, row - rows.start);
                    let pixel = first + column;
                    for s in 0..SAMPLES {
                        if inside[s] && near[s] > self.near[pixel][s] {
                            self.near[pixel][s] = near[s];
                            self.triangles[pixel][s] = number;
                        }
                    }
                }
                for (value, edge) in values.iter_mut().zip(&edges) {
                    *value = *value + edge.across * unit;
                }
            }
        }
    }
}

/// Either integer: most triangles are small and get by with the faster one.
fn int<T: From<i32>>(x: i32) -> T {
    T::from(x)
}

/// `start + across x + down y`, positive to the left of the directed edge; x and y in units from the origin.
struct Edge<T> {
    start: T,
    across: T,
    down: T,
}

impl<T: PrimInt + From<i32>> Edge<T> {
    fn new(from: Corner, to: Corner, origin: [i32; 2]) -> Self {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let (x, y) = (int::<T>(from.x - origin[0]), int::<T>(from.y - origin[1]));
        let (across, down) = (int::<T>(dy), int::<T>(-dx));
        // Samples on the edge belong to it only when it is a left or a top edge.
        let shared = if dy > 0 || (dy == 0 && dx < 0) { T::zero() } else { T::one() };
        Edge { start: T::zero() - across * x - down * y - shared, across, down }
    }

    fn samples(&self) -> [T; SAMPLES] {
        PLACES.map(|[x, y]| self.across * int::<T>(x) + self.down * int::<T>(y))
    }
}

/// The inverse depth over the picture, as seen from the first pixel.
struct Plane {
    samples: [f32; SAMPLES],
    across: f32,
    down: f32,
}

impl Plane {
    fn new([a, b, c]: [Corner; 3], area: u64, column: usize, row: usize) -> Self {
        let pixel = UNIT as f32;
        let [bx, by] = [b.x - a.x, b.y - a.y].map(|d| d as f32);
        let [cx, cy] = [c.x - a.x, c.y - a.y].map(|d| d as f32);
        let (to_b, to_c) = (b.near - a.near, c.near - a.near);
        let area = area as f32;
        // y points down, so the doubled area is by cx - bx cy.
        let across = (to_c * by - to_b * cy) / area;
        let down = (to_b * cx - to_c * bx) / area;
        let left = (column as i32 * UNIT - a.x) as f32;
        let top = (row as i32 * UNIT - a.y) as f32;
        let samples = PLACES.map(|[x, y]| a.near + across * (left + x as f32) + down * (top + y as f32));
        Plane { samples, across: across * pixel, down: down * pixel }
    }

    fn at(&self, column: usize, row: usize) -> [f32; SAMPLES] {
        let base = self.across * column as f32 + self.down * row as f32;
        self.samples.map(|near| near + base)
    }
}

fn bounds([a, b, c]: [i32; 3]) -> [i32; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// The pixels from unit `low` to unit `high`, inside the limits.
fn clip(low: i32, high: i32, limits: Range<usize>) -> Range<usize> {
    let start = low.div_euclid(UNIT).max(limits.start as i32);
    let end = (high.div_euclid(UNIT) + 1).min(limits.end as i32);
    if start < end { start as usize..end as usize } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: i32, y: i32, near: f32) -> Corner {
        Corner { x, y, near }
    }

    fn cleared(width: usize, height: usize) -> Band {
        let mut band = Band::new(width);
        band.clear(0..height);
        band
    }

    /// A fan around an odd point covers a rectangle: every sample exactly once.
    #[test]
    fn neighbours_share_their_edges_without_gap_or_overlap() {
        let (width, height) = (70, 50);
        let rim = [[0, 0], [0, 25], [0, 50], [35, 50], [70, 50], [70, 25], [70, 0], [35, 0]];
        for centre in [[9001, 6417], [8960, 6400], [300, 12000]] {
            let mut covered = vec![0; width * height * SAMPLES];
            for k in 0..rim.len() {
                let at = |i: usize| corner(rim[i % rim.len()][0] * UNIT, rim[i % rim.len()][1] * UNIT, 1.0);
                let mut band = cleared(width, height);
                band.draw(0, [corner(centre[0], centre[1], 1.0), at(k), at(k + 1)], true);
                for (count, triangle) in covered.iter_mut().zip(band.triangles.as_flattened()) {
                    *count += usize::from(*triangle == 0);
                }
            }
            assert!(covered.iter().all(|count| *count == 1), "{centre:?}");
        }
    }

    #[test]
    fn the_nearer_triangle_is_seen() {
        let corners = |near| [corner(0, 0, near), corner(0, 4096, near), corner(4096, 0, near)];
        let mut band = cleared(16, 16);
        band.draw(7, corners(0.5), false);
        band.draw(8, corners(0.25), false);
        assert_eq!(band.triangles[0], [7; SAMPLES]);
        band.draw(9, corners(0.75), false);
        assert_eq!(band.triangles[0], [9; SAMPLES]);
    }

    #[test]
    fn backs_are_seen_only_when_asked_for() {
        let back = [corner(0, 0, 0.5), corner(4096, 0, 0.5), corner(0, 4096, 0.5)];
        let mut band = cleared(16, 16);
        band.draw(1, back, true);
        assert_eq!(band.triangles[0], [NOTHING; SAMPLES]);
        band.draw(1, back, false);
        assert_eq!(band.triangles[0], [1; SAMPLES]);
    }

    #[test]
    fn depth_is_a_plane_over_the_picture() {
        let mut band = cleared(32, 32);
        // near = 1/2 + x/64 + y/128 in pixels.
        let at = |x: i32, y: i32| corner(x * UNIT, y * UNIT, 0.5 + x as f32 / 64.0 + y as f32 / 128.0);
        band.draw(3, [at(0, 0), at(0, 32), at(32, 0)], true);
        let [x, y] = PLACES[2].map(|u| u as f32 / UNIT as f32);
        let wanted = 0.5 + (9.0 + x) / 64.0 + (5.0 + y) / 128.0;
        assert!((band.near[5 * 32 + 9][2] - wanted).abs() < 1e-5);
    }
}
