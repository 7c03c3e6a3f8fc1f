//! What part of a distant light a point sees: one depth map for each direction of light.
//!
//! ```text
//!   light  \ \ \ \         each map keeps, for each of its squares, how near the surface comes to the light;
//!           \ \o\ \        a point is in shadow where the map holds something nearer than the point itself
//!            \/  \ \
//!        ___/ x   \_\__    x is in the shadow of o
//! ```
//!
//! Many directions with soft edges add up to area lights, ambient occlusion and the shadow on the floor.

use super::Surface;
use crate::parallel;
use glam::Vec3;

/// Squares along the side of a map, and the width of a square in radii of the scene.
const SIDE: usize = 160;
const SQUARE: f32 = 2.1 / SIDE as f32;

/// All lengths in here are in squares.
pub struct DepthMap {
    /// Right, down, and to the light.
    axes: [Vec3; 3],
    /// For each square the largest depth along the last axis.
    nearest: Vec<f32>,
    /// The spread of the light: the width of a penumbra over the distance of what casts it.
    spread: f32,
    /// For the areas of the map up to each corner of a square: how many squares hold something, and the sum
    /// of their depths.
    totals: Vec<[f32; 2]>,
}

/// One map for each light: its direction and its spread.
pub fn depth_maps(surface: &Surface, lights: &[(Vec3, f32)], threads: usize) -> Vec<DepthMap> {
    let cloud = point_cloud(surface);
    parallel::map(threads, lights.len(), |k| DepthMap::new(lights[k].0, lights[k].1, &cloud))
}

/// A depth where nothing is.
const EMPTY: f32 = -1e6;

/// The sharpest shadow on the floor: as wide as the lattice of the floor is.
const FLOOR: f32 = 4.0;

impl DepthMap {
    fn new(toward: Vec3, spread: f32, cloud: &[Vec3]) -> Self {
        let aside = if toward.y.abs() < 0.7 { Vec3::Y } else { Vec3::X };
        let right = aside.cross(toward).normalize();
        let axes = [right, toward.cross(right), toward].map(|axis| axis / SQUARE);
        let mut map = DepthMap { axes, nearest: vec![EMPTY; SIDE * SIDE], spread, totals: Vec::new() };
        for &point in cloud {
            let ([x, y], depth) = map.locate(point);
            // A point covers the four squares around it, so that the cloud leaves no holes.
            let corner = y as usize * SIDE + x as usize;
            for square in [corner, corner + 1, corner + SIDE, corner + SIDE + 1] {
                if let Some(nearest) = map.nearest.get_mut(square) {
                    *nearest = nearest.max(depth);
                }
            }
        }
        map.add_up();
        map
    }

    fn add_up(&mut self) {
        self.totals = vec![[0.0; 2]; (SIDE + 1) * (SIDE + 1)];
        for row in 0..SIDE {
            let mut line = [0.0; 2];
            for column in 0..SIDE {
                let depth = self.nearest[row * SIDE + column];
                if depth > EMPTY {
                    line = [line[0] + 1.0, line[1] + depth];
                }
                let above = self.totals[row * (SIDE + 1) + column + 1];
                self.totals[(row + 1) * (SIDE + 1) + column + 1] = [above[0] + line[0], above[1] + line[1]];
            }
        }
    }

    /// Place in the map and depth.
    #[inline]
    fn locate(&self, p: Vec3) -> ([f32; 2], f32) {
        const MIDDLE: f32 = (SIDE - 1) as f32 / 2.0;
        ([p.dot(self.axes[0]) + MIDDLE, p.dot(self.axes[1]) + MIDDLE], p.dot(self.axes[2]))
    }

    /// 1 where nothing stands between a point of the surface and the light, 0 in the full shadow.
    #[inline]
    pub fn visible(&self, p: Vec3) -> f32 {
        const LAST: f32 = (SIDE - 1) as f32;
        let ([x, y], depth) = self.locate(p);
        if !(x >= 0.0 && y >= 0.0 && x < LAST && y < LAST) {
            return 1.0;
        }
        let (column, row) = (x as i32, y as i32);
        let (right, down) = (x - column as f32, y - row as f32);
        let corner = row as usize * SIDE + column as usize;
        let Some(square) = self.nearest.get(corner..corner + SIDE + 2) else { return 1.0 };
        let lit = |at: usize| 1.0 - (square[at] - depth - 0.75).clamp(0.0, 1.0);
        let above = lit(0) + (lit(1) - lit(0)) * right;
        let below = lit(SIDE) + (lit(SIDE + 1) - lit(SIDE)) * right;
        above + (below - above) * down
    }

    /// The same for a point that lies behind everything, as on the floor, with a shadow that grows softer with
    /// the distance of what casts it (percentage closer soft shadows; Fernando 2005).
    pub fn visible_from_behind(&self, p: Vec3) -> f32 {
        let ([x, y], depth) = self.locate(p);
        let mut radius = 12.0;
        // What stands in the way fixes how far to look for it; twice is enough.
        for _ in 0..2 {
            let [count, depths] = self.sum_around(x, y, radius);
            if count < 1e-3 {
                return 1.0;
            }
            radius = (self.spread * (depths / count - depth)).clamp(FLOOR, 0.5 * SIDE as f32);
        }
        // Two boxes of different size: the sum of their edges is softer than either.
        let covered = |radius: f32| self.sum_around(x, y, radius)[0] / (4.0 * radius * radius);
        1.0 - 0.5 * (covered(radius) + covered(0.6 * radius))
    }

    /// The totals over the square of this radius around a place.
    fn sum_around(&self, x: f32, y: f32, radius: f32) -> [f32; 2] {
        let at = |x: f32, y: f32| {
            let limit = |c: f32| (c + 0.5).clamp(0.0, SIDE as f32 - 1e-3);
            let (x, y) = (limit(x), limit(y));
            let (column, row) = (x as usize, y as usize);
            let corner = row * (SIDE + 1) + column;
            let mix = |a: [f32; 2], b: [f32; 2], t: f32| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
            let right = x - column as f32;
            let above = mix(self.totals[corner], self.totals[corner + 1], right);
            let below = mix(self.totals[corner + SIDE + 1], self.totals[corner + SIDE + 2], right);
            mix(above, below, y - row as f32)
        };
        let [a, b] = [at(x - radius, y - radius), at(x + radius, y - radius)];
        let [c, d] = [at(x - radius, y + radius), at(x + radius, y + radius)];
        [0, 1].map(|k| (a[k] + d[k] - b[k] - c[k]).max(0.0))
    }

    /// Where to test a point of the surface: off its own neighbourhood, along the normal.
    pub fn lifted(p: Vec3, normal: Vec3) -> Vec3 {
        p + normal * (2.0 * SQUARE)
    }
}

/// Points of the surface, nowhere farther apart than a square of the maps; about one in each cube of that size.
fn point_cloud(surface: &Surface) -> Vec<Vec3> {
    const CUBES: usize = 256;
    let mut taken = vec![0_u64; CUBES * CUBES * CUBES / 64];
    let mut cloud = Vec::new();
    let mut add = |p: Vec3| {
        // Cubes of 0.8 squares: in the worst direction the points of two neighbours still share a square.
        let [x, y, z] =
            p.to_array().map(|c| (c / (0.8 * SQUARE) + CUBES as f32 / 2.0) as usize & (CUBES - 1));
        let cube = (z * CUBES + y) * CUBES + x;
        if taken[cube / 64] >> (cube % 64) & 1 == 0 {
            taken[cube / 64] |= 1 << (cube % 64);
            cloud.push(p);
        }
    };
    for &triangle in &surface.triangles {
        let [a, b, c] = surface.corners(triangle);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        if longest <= SQUARE * SQUARE {
            add((a + b + c) / 3.0);
            continue;
        }
        let steps = (longest.sqrt() / SQUARE) as usize + 1;
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (s, t) = (i as f32 / steps as f32, j as f32 / steps as f32);
                add(a + (b - a) * s + (c - a) * t);
            }
        }
    }
    cloud
}
