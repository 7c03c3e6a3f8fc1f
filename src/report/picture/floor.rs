//! The floor and the backdrop are one seamless sheet of paper; the scene casts its shadow on it.

use super::{arithmetic::smooth_step, camera::Camera, colour::oklab, studio::Ray, visibility::DepthMap};
use crate::parallel;
use glam::{Vec2, Vec3};

/// Points along the side of the lattice on which the light is gathered, and half its width in radii.
const SIDE: usize = 112;
const HALF: f32 = 3.0;

pub struct Floor {
    pub level: f32,
    /// What remains of the light at each point of the lattice, row by row.
    lit: Vec<Vec3>,
}

impl Floor {
    pub fn new(level: f32, rays: &[Ray], maps: &[DepthMap], threads: usize) -> Self {
        let above = rays.iter().zip(maps).filter(|(ray, _)| ray.toward.y > 0.0);
        let all: Vec3 = above.clone().map(|(ray, _)| ray.strength * ray.toward.y).sum();
        let rows = parallel::map(threads, SIDE, |row| {
            let point = |column: usize| {
                let place = |k: usize| (k as f32 / (SIDE - 1) as f32 * 2.0 - 1.0) * HALF;
                let p = Vec3::new(place(column), level, place(row));
                let light: Vec3 = above
                    .clone()
                    .map(|(ray, map)| ray.strength * (ray.toward.y * map.visible_from_behind(p)))
                    .sum();
                let fade = smooth_step(0.6 * HALF, 0.98 * HALF, Vec2::new(p.x, p.z).length());
                (light / all).lerp(Vec3::ONE, fade)
            };
            (0..SIDE).map(point).collect::<Vec<_>>()
        });
        Floor { level, lit: rows.concat() }
    }

    /// What remains of the light under (or over) a point, 0 to 1 in each colour.
    pub fn lit(&self, p: Vec3) -> Vec3 {
        let place = |c: f32| (c / HALF + 1.0) * 0.5 * (SIDE - 1) as f32;
        let (x, z) = (place(p.x), place(p.z));
        let last = (SIDE - 1) as f32;
        if !(x >= 0.0 && z >= 0.0 && x < last && z < last) {
            return Vec3::ONE;
        }
        let (column, row) = (x as usize, z as usize);
        let at = |c: usize, r: usize| self.lit[r * SIDE + c];
        let (right, down) = (x - column as f32, z - row as f32);
        let near = at(column, row).lerp(at(column + 1, row), right);
        let far = at(column, row + 1).lerp(at(column + 1, row + 1), right);
        near.lerp(far, down)
    }

    /// The paper at a place in the picture, in linear light.
    pub fn seen(&self, camera: &Camera, place: Vec2, width: f32, height: f32) -> Vec3 {
        let ray = camera.ray(place);
        let steps = (self.level - camera.eye.y) / ray.y;
        let shadow = if ray.y < 0.0 { self.lit(camera.eye + ray * steps) } else { Vec3::ONE };
        // A pool of light behind the scene that falls off to the corners, and a lighter top.
        let centre = Vec2::new(place.x / width - 0.5, (place.y / height - 0.46) * height / width);
        let pool = 1.0 - smooth_step(0.05, 0.78, centre.length());
        let top = oklab(0.875, -0.003, -0.010);
        let bottom = oklab(0.835, -0.001, -0.004);
        let paper = top.lerp(bottom, smooth_step(0.0, height, place.y));
        let glow = oklab(0.965, 0.0, 0.003);
        paper.lerp(glow, 0.85 * pool) * shadow
    }
}
