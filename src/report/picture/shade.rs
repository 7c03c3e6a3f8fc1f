//! The colour of one sample, and of a pixel from its eight samples.

use super::{
    arithmetic::smooth_step,
    camera::Camera,
    colour::{self, oklab},
    raster::{self, Corner, NOTHING, SAMPLES},
    scene::{Colouring, Finish, Normals, Scene},
    stripes,
    studio::{Light, Studio, fresnel},
    surface::Surface,
};
use glam::Vec3;
use std::collections::BTreeMap;

pub struct Shader<'a> {
    pub scene: &'a Scene<'a>,
    pub finish: Finish,
    pub surface: &'a Surface,
    pub corners: &'a [Corner],
    pub camera: &'a Camera,
    pub studio: &'a Studio,
    /// For each vertex what reaches its outside, and its inside where that can be seen.
    pub outside: &'a [Light],
    pub inside: &'a [Light],
    /// The colour of each strip, where strips are shown.
    pub strips: &'a BTreeMap<u32, usize>,
}

/// The surface at one sample.
struct Spot {
    normal: Vec3,
    to_eye: Vec3,
    light: Light,
    colour: Vec3,
    /// The triangle where each has a normal of its own; else 0.
    facet: u32,
}

impl Shader<'_> {
    /// The mean of the samples in linear light; those that show nothing have the colour of the backdrop.
    pub fn pixel(
        &self,
        column: usize,
        row: usize,
        triangles: &[u32; SAMPLES],
        backdrop: impl Fn() -> Vec3,
    ) -> Vec3 {
        let covered = triangles.iter().filter(|triangle| **triangle != NOTHING).count();
        let mut sum = Vec3::ZERO;
        if covered < SAMPLES {
            sum += backdrop() * (SAMPLES - covered) as f32;
        }
        if covered == 0 {
            return sum / SAMPLES as f32;
        }
        let spots: [Option<Spot>; SAMPLES] = std::array::from_fn(|s| {
            (triangles[s] != NOTHING).then(|| self.spot(triangles[s], column, row, s))
        });
        sum += match self.finish {
            Finish::Studio => spots.iter().flatten().map(|spot| self.porcelain(spot)).sum::<Vec3>(),
            Finish::ReflectionLines => self.mirror(&spots),
        };
        sum / SAMPLES as f32
    }

    fn spot(&self, number: u32, column: usize, row: usize, sample: usize) -> Spot {
        let triangle = self.surface.triangles[number as usize];
        let corners = triangle.map(|corner| self.corners[corner as usize]);
        let weights = weights(corners, column, row, sample);
        let blend = |of: [Vec3; 3]| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];

        let front = raster::doubled_area(corners) > 0;
        let (side, lights) = if front { (1.0, self.outside) } else { (-1.0, self.inside) };
        let lights = triangle.map(|corner| lights[corner as usize]);
        let position = blend(self.surface.corners(triangle));
        let to_eye = (self.camera.eye - position).normalize();
        let mut normal = blend(triangle.map(|corner| self.surface.normals[corner as usize])) * side;
        // A normal between those of the corners may turn away at the outline; it is bent back into view.
        let facing = normal.dot(to_eye);
        if facing < 0.02 {
            normal += to_eye * (0.02 - facing);
        }
        Spot {
            normal: normal.normalize(),
            to_eye,
            light: Light {
                diffuse: blend(lights.map(|light| light.diffuse)),
                open: (0..3).map(|k| lights[k].open * weights[k]).sum(),
            },
            colour: self.body(number, triangle, weights, front),
            facet: if matches!(self.scene.normals, Normals::Flat) { number } else { 0 },
        }
    }

    /// The colour of the body itself.
    fn body(&self, number: u32, triangle: [u32; 3], weights: [f32; 3], front: bool) -> Vec3 {
        let inside = oklab(0.66, 0.085, 0.075);
        match self.scene.colouring {
            Colouring::Plain if front => oklab(0.775, -0.020, -0.045),
            Colouring::Plain => inside,
            Colouring::Values { .. } => {
                let value = |k: usize| self.surface.values[triangle[k] as usize] * weights[k];
                colour::heat(value(0) + value(1) + value(2))
            }
            Colouring::Patches(patches) => {
                let patch = patches[number as usize / self.surface.parts];
                let outside = colour::patch(patch.depth, patch.number);
                if front { outside } else { outside.lerp(inside, 0.5) }
            }
            Colouring::Strips(strips) => {
                let strip = strips[number as usize / self.surface.parts];
                let outside = colour::strip(self.strips.get(&strip).copied().unwrap_or(0));
                if front { outside } else { outside.lerp(inside, 0.5) }
            }
        }
    }

    fn porcelain(&self, spot: &Spot) -> Vec3 {
        // A heat map is read against its legend, so it gets flatter light and less gloss.
        let (contrast, gloss) = match self.scene.colouring {
            Colouring::Plain => (1.0, 1.0),
            Colouring::Values { .. } => (0.5, 0.12),
            Colouring::Patches(_) | Colouring::Strips(_) => (0.85, 0.6),
        };
        let diffuse = Vec3::splat(0.86).lerp(spot.light.diffuse, contrast);
        let cosine = spot.normal.dot(spot.to_eye);
        let mirrored = self.studio.mirrored(mirror(spot));
        let open = spot.light.open * spot.light.open;
        tone(spot.colour * diffuse + mirrored * (fresnel(cosine) * gloss * open))
    }

    /// The sum over the samples of a dark mirror under lines of light.
    fn mirror(&self, spots: &[Option<Spot>; SAMPLES]) -> Vec3 {
        let meetings = spots
            .each_ref()
            .map(|spot| spot.as_ref().map(|spot| (spot.facet, stripes::meet(mirror(spot), self.camera))));
        let mut sum = Vec3::ZERO;
        for (spot, meeting) in spots.iter().zip(&meetings) {
            let (Some(spot), Some((_, meeting))) = (spot, meeting) else { continue };
            let same = meetings.iter().flatten().filter(|(facet, _)| *facet == spot.facet);
            let width = stripes::footprint(meeting.phase, same.map(|(_, other)| other.phase));
            let lit = stripes::light(meeting.phase, width) * meeting.within;
            let cosine = spot.normal.dot(spot.to_eye);
            let open = 0.25 + 0.75 * spot.light.open;
            let lacquer = spot.colour * oklab(0.42, -0.012, -0.045);
            let body = lacquer * spot.light.diffuse * 0.9
                + self.studio.mirrored(mirror(spot)) * (0.5 * fresnel(cosine) * open);
            let line = Vec3::new(1.0, 0.975, 0.93) * (0.78 + 0.22 * smooth_step(0.0, 0.9, cosine)) * open;
            sum += tone(body * (1.0 - 0.55 * lit) + line * lit);
        }
        sum
    }
}

/// The direction that is seen mirrored.
fn mirror(spot: &Spot) -> Vec3 {
    spot.normal * (2.0 * spot.normal.dot(spot.to_eye)) - spot.to_eye
}

/// Shares of the three corners at a sample, with the perspective taken out.
fn weights(corners: [Corner; 3], column: usize, row: usize, sample: usize) -> [f32; 3] {
    let [x, y] = raster::PLACES[sample];
    let here = Corner { x: column as i32 * raster::UNIT + x, y: row as i32 * raster::UNIT + y, near: 0.0 };
    let mut weights = [0.0; 3];
    for k in 0..3 {
        let mut with_sample = corners;
        with_sample[k] = here;
        weights[k] = raster::doubled_area(with_sample) as f32 * corners[k].near;
    }
    let sum = weights[0] + weights[1] + weights[2];
    weights.map(|weight| weight / sum)
}

/// Straight up to 0.65, then bending towards 1, so that lamps keep their soft edges.
fn tone(light: Vec3) -> Vec3 {
    let bend = |x: f32| {
        let over = (x - 0.65) / 0.35;
        if over <= 0.0 { x } else { 0.65 + 0.35 * over / (1.0 + over) }
    };
    Vec3::from(light.to_array().map(bend))
}
