//! The scene as the studio sees it: y points up, the middle stands at the origin, the radius is 1, single
//! precision, with a normal at every vertex.
//!
//! Light is gathered at the vertices. Triangles that are too large for that are split on their own plane,
//! all of them into m^2 equal parts, so that no vertex ever lies on the side of a neighbour.

use super::scene::{Axis, Colouring, Normals, Scene};
use glam::{DVec3, Vec3};

pub struct Surface {
    pub positions: Vec<Vec3>,
    /// Unit vectors.
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Heat map values in 0..=1, one for each position, or none at all.
    pub values: Vec<f32>,
    /// Every edge has a triangle on both sides, so that no back is ever seen.
    pub closed: bool,
    /// How many parts each triangle of the scene was split into.
    pub parts: usize,
}

/// From the coordinates of the scene to those of the studio.
pub struct Placement {
    up: Axis,
    centre: DVec3,
    scale: f64,
}

impl Placement {
    pub fn new(scene: &Scene, up: Option<Axis>) -> Self {
        let corners = |points: &[DVec3]| {
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            points.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)))
        };
        let (low, high) = corners(scene.positions);
        let size = high - low;
        // A plate or a ring given in the x-y plane is laid down; everything else stands as it is.
        let flat = size.z < 0.5 * size.x.min(size.y);
        let up = up.unwrap_or(if flat { Axis::Z } else { Axis::Y });
        let centre = low * 0.5 + high * 0.5;
        let radius = scene.positions.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
        Placement { up, centre, scale: if radius > 0.0 { 1.0 / radius } else { 1.0 } }
    }

    /// Turns without mirroring.
    fn turn(&self, v: DVec3) -> DVec3 {
        match self.up {
            Axis::X => DVec3::new(v.z, v.x, v.y),
            Axis::Y => v,
            Axis::Z => DVec3::new(v.y, v.z, v.x),
        }
    }

    pub fn point(&self, p: DVec3) -> Vec3 {
        self.turn((p - self.centre) * self.scale).as_vec3()
    }
}

impl Surface {
    pub fn new(scene: &Scene, placement: &Placement) -> Self {
        let positions = scene.positions.iter().map(|p| placement.point(*p)).collect();
        let normals = match scene.normals {
            Normals::Given(normals) => normals.iter().map(|n| unit(placement.turn(*n))).collect(),
            Normals::Smooth | Normals::Flat => smooth_normals(scene, placement),
        };
        let values = match scene.colouring {
            Colouring::Values { values, range: [low, high], .. } => {
                let width = if high > low { high - low } else { 1.0 };
                values.iter().map(|value| ((value - low) / width).clamp(0.0, 1.0) as f32).collect()
            }
            _ => Vec::new(),
        };
        let triangles = scene.triangles.to_vec();
        let closed = is_closed(&triangles);
        let mut surface = Surface { positions, normals, triangles, values, closed, parts: 1 };
        if matches!(scene.normals, Normals::Flat) {
            surface.flatten();
        }
        let steps = surface.steps();
        if steps > 1 {
            surface.split(steps);
        }
        surface
    }

    pub fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|corner| self.positions[corner as usize])
    }

    /// Gives every triangle corners and a normal of its own.
    fn flatten(&mut self) {
        let mut flat = self.blank();
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            let normal = unit((b - a).cross(c - a).as_dvec3());
            let first = flat.positions.len() as u32;
            flat.positions.extend([a, b, c]);
            flat.normals.extend([normal; 3]);
            if !self.values.is_empty() {
                flat.values.extend(triangle.map(|corner| self.values[corner as usize]));
            }
            flat.triangles.push([first, first + 1, first + 2]);
        }
        *self = flat;
    }

    /// Into how many parts each edge is split, so that light is gathered about every twentieth of the radius,
    /// as far as 100,000 triangles go.
    fn steps(&self) -> usize {
        let longest = self.triangles.iter().map(|&triangle| {
            let [a, b, c] = self.corners(triangle);
            a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
        });
        let wanted = (longest.fold(0.0, f32::max).sqrt() / 0.05) as usize + 1;
        let mut affordable = 1;
        while (affordable + 1) * (affordable + 1) * self.triangles.len() <= 100_000 {
            affordable += 1;
        }
        wanted.min(affordable)
    }

    /// Puts an even lattice of (m + 1)(m + 2)/2 vertices on each triangle.
    fn split(&mut self, m: usize) {
        let mut fine = self.blank();
        fine.parts = self.parts * m * m;
        for &triangle in &self.triangles {
            let first = fine.positions.len() as u32;
            let corners = self.corners(triangle);
            let normals = triangle.map(|corner| self.normals[corner as usize]);
            for i in 0..=m {
                for j in 0..=m - i {
                    // Integer weights that add up to m: both triangles at an edge compute the same point.
                    let weights = [m - i - j, i, j].map(|weight| weight as f32);
                    let blend = |of: [Vec3; 3]| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
                    fine.positions.push(blend(corners) / m as f32);
                    fine.normals.push(unit(blend(normals).as_dvec3()));
                    if !self.values.is_empty() {
                        let value = |k: usize| self.values[triangle[k] as usize] * weights[k];
                        fine.values.push((value(0) + value(1) + value(2)) / m as f32);
                    }
                }
            }
            // Row i of the lattice starts after the m + 1, m, .. points of the rows before.
            let at = |i: usize, j: usize| first + (i * (m + 1) - i * (i.max(1) - 1) / 2 + j) as u32;
            for i in 0..m {
                for j in 0..m - i {
                    fine.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < m {
                        fine.triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
        }
        *self = fine;
    }

    fn blank(&self) -> Self {
        Surface {
            positions: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            values: Vec::new(),
            closed: self.closed,
            parts: self.parts,
        }
    }
}

fn smooth_normals(scene: &Scene, placement: &Placement) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; scene.positions.len()];
    for triangle in scene.triangles {
        let [a, b, c] = triangle.map(|corner| scene.positions[corner as usize] * placement.scale);
        let doubled_area = (b - a).cross(c - a);
        for corner in triangle {
            sums[*corner as usize] += doubled_area;
        }
    }
    sums.into_iter().map(|sum| unit(placement.turn(sum))).collect()
}

/// The unit vector of this direction; up where there is none.
fn unit(v: DVec3) -> Vec3 {
    let length = v.length();
    if length > 0.0 { (v / length).as_vec3() } else { Vec3::Y }
}

/// Whether every edge is used once in each direction. Each directed edge adds or takes away a number that
/// belongs to its two ends; the sum vanishes when all find their opposites (and by chance once in 2^64).
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut sum = 0_u64;
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let number = scatter(u64::from(from.min(to)) << 32 | u64::from(from.max(to)));
            sum = if from < to { sum.wrapping_add(number) } else { sum.wrapping_sub(number) };
        }
    }
    sum == 0
}

/// A fixed bijection of the 64-bit numbers without visible pattern (the finaliser of SplitMix64).
fn scatter(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

    fn tetrahedron_points() -> Vec<DVec3> {
        [[1, 1, 1], [-1, 1, -1], [-1, -1, 1], [1, -1, -1]].map(|p| DVec3::from(p.map(f64::from))).to_vec()
    }

    fn scene<'a>(positions: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Scene<'a> {
        Scene { positions, triangles, normals: Normals::Smooth, colouring: Colouring::Plain, control: None }
    }

    #[test]
    fn closed_means_that_every_edge_has_its_opposite() {
        assert!(is_closed(&TETRAHEDRON));
        assert!(!is_closed(&TETRAHEDRON[..3]));
        assert!(!is_closed(&[[0, 2, 1], [0, 3, 1], [1, 3, 2], [2, 3, 0]]), "one triangle turned over");
    }

    #[test]
    fn splitting_keeps_the_area_and_the_orientation() {
        let points = tetrahedron_points();
        let scene = scene(&points, &TETRAHEDRON);
        let surface = Surface::new(&scene, &Placement::new(&scene, None));
        assert!(surface.triangles.len() > 1000);
        let volume: f32 = surface
            .triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = surface.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        // A regular tetrahedron in a sphere of radius 1 has the volume 8 sqrt(3)/27; outside is positive.
        let outside = if (points[1] - points[0]).cross(points[2] - points[0]).dot(points[0]) > 0.0 {
            1.0
        } else {
            -1.0
        };
        assert!((volume * outside - 8.0 * 3_f32.sqrt() / 27.0).abs() < 1e-4, "{volume}");
    }

    #[test]
    fn a_plate_in_the_plane_is_laid_down() {
        let points = [[0, 0, 0], [4, 0, 0], [0, 3, 0]].map(|p| DVec3::from(p.map(f64::from)));
        let triangles = [[0, 1, 2]];
        let scene = scene(&points, &triangles);
        let surface = Surface::new(&scene, &Placement::new(&scene, None));
        assert!(surface.normals.iter().all(|n| *n == Vec3::Y));
        assert!(surface.positions.iter().all(|p| p.y == 0.0));
    }
}
