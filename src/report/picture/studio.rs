//! The studio: a large key lamp at the upper left, a strip lamp at the right, a rim lamp behind, a bright room.
//!
//! Diffuse light is the sum over some eighty directions of what comes from there, times the cosine, times what
//! is visible; mirrored light is the brightness of the room in the mirrored direction.

use super::{
    arithmetic::{power, smooth_step},
    camera::Camera,
    surface::Surface,
    visibility::DepthMap,
};
use crate::parallel;
use glam::Vec3;

/// Light from one direction.
pub struct Ray {
    pub toward: Vec3,
    /// Brightness times solid angle over pi: what a white surface facing it sends back.
    pub strength: Vec3,
    /// Half the angle (as a tangent) between this direction and its neighbours: it stands for all light between.
    pub spread: f32,
}

/// The lamps stand still relative to the photographer.
pub struct Studio {
    pub rays: Vec<Ray>,
    key: Lamp,
    strip: Lamp,
    rim: Lamp,
}

/// A rectangular lamp, infinitely far away, as mirrors show it.
struct Lamp {
    toward: Vec3,
    across: [Vec3; 2],
    /// Half the width and height over the distance.
    half: [f32; 2],
    brightness: Vec3,
}

/// Light that reaches a point of the surface.
#[derive(Clone, Copy)]
pub struct Light {
    pub diffuse: Vec3,
    /// The part of the room that is not hidden, 0 to 1.
    pub open: f32,
}

const KEY: Vec3 = Vec3::new(1.0, 0.955, 0.89);
const SKY: Vec3 = Vec3::new(0.86, 0.93, 1.0);
const BOUNCE: Vec3 = Vec3::new(1.0, 0.95, 0.89);
const RIM: Vec3 = Vec3::new(0.93, 0.97, 1.0);

impl Studio {
    pub fn new(camera: &Camera) -> Self {
        // The photographer's axes, level with the floor.
        let right = camera.right;
        let front = right.cross(Vec3::Y);
        let direction = |x: f32, y: f32, z: f32| (right * x + Vec3::Y * y + front * z).normalize();
        let key = Lamp::new(direction(-0.62, 0.95, 0.62), [0.42, 0.42], KEY * 7.0);
        let strip = Lamp::new(direction(1.0, 0.42, 0.30), [0.16, 0.75], SKY * 3.2);
        let rim = Lamp::new(direction(0.45, 0.62, -0.95), [0.6, 0.22], RIM * 4.0);

        let mut rays = Vec::new();
        disc(&mut rays, &key, 18, 0.36, KEY * 0.82);
        disc(&mut rays, &strip, 4, 0.35, SKY * 0.16);
        disc(&mut rays, &rim, 4, 0.30, RIM * 0.50);
        for (toward, share) in sphere(56) {
            // The sky is brightest overhead; the floor sends back what falls on it.
            let above = smooth_step(-0.15, 0.15, toward.y);
            let sky = SKY * (0.27 + 0.25 * toward.y.max(0.0));
            let floor = BOUNCE * 0.20;
            rays.push(Ray { toward, strength: floor.lerp(sky, above) * share, spread: 0.27 });
        }
        Studio { rays, key, strip, rim }
    }

    /// What reaches each vertex, on the outside or on the inside.
    pub fn gather(
        &self,
        maps: &[DepthMap],
        surface: &Surface,
        side: f32,
        floor: &Bounce,
        threads: usize,
    ) -> Vec<Light> {
        const CHUNK: usize = 4096;
        let chunks = surface.positions.len().div_ceil(CHUNK);
        let lit = parallel::map(threads, chunks, |chunk| {
            let range = chunk * CHUNK..surface.positions.len().min((chunk + 1) * CHUNK);
            self.light(maps, &surface.positions[range.clone()], &surface.normals[range], side, floor)
        });
        lit.concat()
    }

    fn light(
        &self,
        maps: &[DepthMap],
        points: &[Vec3],
        normals: &[Vec3],
        side: f32,
        floor: &Bounce,
    ) -> Vec<Light> {
        let mut lights = vec![Light { diffuse: Vec3::ZERO, open: 0.0 }; points.len()];
        let lifted: Vec<Vec3> =
            points.iter().zip(normals).map(|(p, n)| DepthMap::lifted(*p, *n * side)).collect();
        let shares: Vec<f32> = points.iter().map(|p| floor.under(*p)).collect();
        let mut weights = vec![0.0; points.len()];
        for (ray, map) in self.rays.iter().zip(maps) {
            for (k, light) in lights.iter_mut().enumerate() {
                let cosine = normals[k].dot(ray.toward) * side;
                if cosine <= 0.0 {
                    continue;
                }
                let mut seen = cosine * map.visible(lifted[k]);
                light.open += seen;
                weights[k] += cosine;
                if ray.toward.y < 0.0 {
                    seen *= shares[k];
                }
                light.diffuse += ray.strength * seen;
            }
        }
        for (light, weight) in lights.iter_mut().zip(weights) {
            light.open /= weight;
        }
        lights
    }

    /// The brightness of the room in a mirrored direction.
    pub fn mirrored(&self, toward: Vec3) -> Vec3 {
        let room = SKY * (0.38 + 0.30 * toward.y);
        let floor = BOUNCE * 0.30;
        let around = floor.lerp(room, smooth_step(-0.25, 0.12, toward.y));
        around + self.key.seen(toward) + self.strip.seen(toward) + self.rim.seen(toward)
    }
}

/// How bright the floor is below a point, where the scene itself shades it.
pub struct Bounce<'a> {
    pub level: f32,
    pub brightness: &'a (dyn Fn(Vec3) -> f32 + Sync),
}

impl Bounce<'_> {
    fn under(&self, p: Vec3) -> f32 {
        let height = p.y - self.level;
        let near = 1.0 - smooth_step(0.0, 0.9, height);
        1.0 + ((self.brightness)(p) - 1.0) * near
    }
}

impl Lamp {
    fn new(toward: Vec3, half: [f32; 2], brightness: Vec3) -> Self {
        let level = Vec3::Y.cross(toward).normalize();
        Lamp { toward, across: [level, toward.cross(level)], half, brightness }
    }

    fn seen(&self, toward: Vec3) -> Vec3 {
        let depth = toward.dot(self.toward);
        if depth <= 0.05 {
            return Vec3::ZERO;
        }
        let inside = |k: usize| {
            let place = (toward.dot(self.across[k]) / depth).abs();
            smooth_step(self.half[k] * 1.45, self.half[k] * 0.75, place)
        };
        self.brightness * (inside(0) * inside(1))
    }
}

/// The golden angle as a rotation: cosine and sine.
const GOLDEN: [f32; 2] = [-0.737_368_9, 0.675_490_3];

/// Directions spread evenly over a disc around a lamp, in Vogel's sunflower order.
fn disc(rays: &mut Vec<Ray>, lamp: &Lamp, count: usize, radius: f32, strength: Vec3) {
    let [mut x, mut y] = [1.0, 0.0];
    for k in 0..count {
        let r = radius * ((k as f32 + 0.5) / count as f32).sqrt();
        let aside = lamp.across[0] * (x * r) + lamp.across[1] * (y * r);
        let spread = radius / (count as f32).sqrt();
        rays.push(Ray {
            toward: (lamp.toward + aside).normalize(),
            strength: strength / count as f32,
            spread,
        });
        [x, y] = [x * GOLDEN[0] - y * GOLDEN[1], x * GOLDEN[1] + y * GOLDEN[0]];
    }
}

/// Directions spread evenly over the sphere, with their share of what a white surface would send back:
/// four over the count, since the cosine averages a quarter over all directions.
fn sphere(count: usize) -> impl Iterator<Item = (Vec3, f32)> {
    let [mut x, mut z] = [1.0, 0.0];
    (0..count).map(move |k| {
        let y = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
        let r = (1.0 - y * y).sqrt();
        let toward = Vec3::new(x * r, y, z * r);
        [x, z] = [x * GOLDEN[0] - z * GOLDEN[1], x * GOLDEN[1] + z * GOLDEN[0]];
        (toward, 4.0 / count as f32)
    })
}

/// Schlick's approximation for a glaze that mirrors four percent head on.
pub fn fresnel(cosine: f32) -> f32 {
    0.04 + 0.96 * power(1.0 - cosine.clamp(0.0, 1.0), 5)
}
