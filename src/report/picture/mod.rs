//! Shaded pictures of fine meshes, in software: no graphics card, no library, the same bytes everywhere.
//!
//! ```text
//!  Scene ─► surface ─► visibility ─► studio          light at every vertex (area lamps, shadows)
//!              │            └──────► floor           the shadow on the paper
//!              └► camera ─► raster ─► shade ─► lines ─► colour ─► Image ─► PNG
//!                           eight samples a pixel, in bands of rows, a band a thread
//! ```
//!
//! ```
//! use glam::DVec3;
//! use subdiv_rtl::report::picture::{self, Colouring, Normals, Options, Scene};
//! let positions = [[1, 1, 1], [-1, 1, -1], [-1, -1, 1], [1, -1, -1]].map(|p| DVec3::from(p.map(f64::from)));
//! let triangles = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
//! let scene = Scene {
//!     positions: &positions,
//!     triangles: &triangles,
//!     normals: Normals::Flat,
//!     colouring: Colouring::Plain,
//!     control: None,
//! };
//! let image = picture::render(&scene, &Options { width: 64, height: 48, ..Options::default() }).unwrap();
//! assert_eq!(image.pixels.len(), 64 * 48);
//! assert_eq!(image.png()[1..4], *b"PNG");
//! ```

mod arithmetic;
mod camera;
mod colour;
mod floor;
mod groups;
mod legend;
mod lettering;
mod lines;
mod raster;
mod scene;
mod shade;
mod stripes;
mod studio;
mod surface;
#[cfg(test)]
mod tests;
mod visibility;

pub use scene::{Axis, Colouring, Finish, Normals, Options, Patch, Scene, Wire};

use crate::error::Result;
use crate::parallel;
use camera::{Camera, Margins};
use colour::{Encoder, oklab};
use floor::Floor;
use glam::{Vec2, Vec3};
use legend::Legend;
use lines::{Ink, Line};
use raster::{Band, Corner, UNIT};
use shade::Shader;
use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};
use studio::{Bounce, Light, Studio};
use surface::{Placement, Surface};

/// Rows that are drawn together: few enough that their samples stay in the cache.
const BAND: usize = 16;

/// Red, green and blue in sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// The picture as a PNG file of 8 bits a channel.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(self.pixels.as_flattened())?;
            writer.finish()
        });
        // The only errors are those of the writer, and memory takes all bytes; the sizes fit by construction.
        written.expect("a picture is written to memory");
        bytes
    }
}

/// Draws the scene.
///
/// # Errors
/// `Input` when the scene cannot be drawn (nothing in it, an index too large, a coordinate that is no number),
/// `Usage` when there is no picture of this size.
pub fn render(scene: &Scene, options: &Options) -> Result<Image> {
    options.check()?;
    scene.check()?;
    let threads = options.threads.unwrap_or_else(parallel::available);
    let (width, height) = (options.width as f32, options.height as f32);

    let placement = Placement::new(scene, options.up);
    let surface = Surface::new(scene, &placement);
    let control: Vec<Vec3> =
        scene.control.iter().flat_map(|wire| wire.positions).map(|p| placement.point(*p)).collect();

    let edge = 0.07 * height;
    let margins = Margins([edge, edge + width * legend::share(scene), edge, 1.4 * edge]);
    let shown = surface.positions.iter().chain(&control).copied();
    let camera = Camera::new(shown, width, height, &margins);

    let Lighting { studio, floor, outside, inside } = Lighting::new(&surface, &camera, threads);
    let corners: Vec<Corner> = surface
        .positions
        .iter()
        .map(|p| {
            let (place, near) = camera.project(*p);
            Corner::new(place, near)
        })
        .collect();
    let bands = Bands::new(&surface.triangles, &corners, options.height);
    let legend = Legend::new(scene, width, height);
    let overlays = overlays(scene, &legend, &control, &placement, &camera, height);
    let strips = match scene.colouring {
        Colouring::Strips(strips) => groups::colours(scene.triangles, strips),
        _ => BTreeMap::new(),
    };
    let shader = Shader {
        strips: &strips,
        scene,
        finish: options.finish,
        surface: &surface,
        corners: &corners,
        camera: &camera,
        studio: &studio,
        outside: &outside,
        inside: &inside,
    };
    let encoder = Encoder::new();

    let rows = parallel::map_with(
        threads,
        bands.count(),
        || Band::new(options.width),
        |band, index| {
            let rows = index * BAND..options.height.min((index + 1) * BAND);
            band.clear(rows.clone());
            for &triangle in bands.triangles(index) {
                let corners = surface.triangles[triangle as usize].map(|corner| corners[corner as usize]);
                band.draw(triangle, corners, surface.closed);
            }
            let mut pixels = Vec::with_capacity(options.width * rows.len());
            for (at, samples) in band.triangles.iter().enumerate() {
                let (column, row) = (at % options.width, rows.start + at / options.width);
                let place = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
                let backdrop = || floor.seen(&camera, place, width, height);
                pixels.push(legend.over(shader.pixel(column, row, samples, backdrop), place));
            }
            for (lines, ink) in &overlays {
                lines::draw(&mut pixels, band, lines, ink);
            }
            let bytes = pixels.iter().enumerate().map(|(at, light)| {
                encoder.pixel(*light, at % options.width, rows.start + at / options.width)
            });
            bytes.collect::<Vec<_>>()
        },
    );
    Ok(Image { width: options.width, height: options.height, pixels: rows.concat() })
}

/// All light on the surface and on the floor.
struct Lighting {
    studio: Studio,
    floor: Floor,
    /// For each vertex; the inside only where it can be seen.
    outside: Vec<Light>,
    inside: Vec<Light>,
}

impl Lighting {
    fn new(surface: &Surface, camera: &Camera, threads: usize) -> Self {
        let studio = Studio::new(camera);
        let lights: Vec<(Vec3, f32)> = studio.rays.iter().map(|ray| (ray.toward, ray.spread)).collect();
        let maps = visibility::depth_maps(surface, &lights, threads);
        let lowest = surface.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
        // A little below, so that a flat plate casts a shadow too.
        let floor = Floor::new(lowest - 0.015, &studio.rays, &maps, threads);
        let brightness = |p: Vec3| floor.lit(p).y;
        let bounce = Bounce { level: floor.level, brightness: &brightness };
        let gather = |side: f32| studio.gather(&maps, surface, side, &bounce, threads);
        let outside = gather(1.0);
        let inside = if surface.closed { Vec::new() } else { gather(-1.0) };
        Lighting { studio, floor, outside, inside }
    }
}

/// Borders of patches, the control mesh with its vertices, and the text of the legend, in this order.
fn overlays(
    scene: &Scene,
    legend: &Legend,
    control: &[Vec3],
    placement: &Placement,
    camera: &Camera,
    height: f32,
) -> Vec<(Vec<Line>, Ink)> {
    let pixel = height / 960.0;
    let mut overlays = Vec::new();
    let borders: Vec<[u32; 2]> = match scene.colouring {
        Colouring::Patches(patches) => first(groups::borders(scene.triangles, patches)),
        Colouring::Strips(strips) => first(groups::borders(scene.triangles, strips)),
        Colouring::Plain | Colouring::Values { .. } => vec![],
    };
    if !borders.is_empty() {
        let place = |index: u32| camera.project(placement.point(scene.positions[index as usize]));
        let borders = borders.into_iter();
        let lines = borders.map(|edge| Line { ends: edge.map(place), radius: 0.55 * pixel }).collect();
        overlays.push((lines, Ink { colour: oklab(0.32, -0.01, -0.04), front: 0.55, behind: 0.0 }));
    }
    if let Some(wire) = &scene.control {
        let place = |index: u32| camera.project(control[index as usize]);
        let mut lines: Vec<Line> =
            wire.edges.iter().map(|edge| Line { ends: edge.map(place), radius: 0.8 * pixel }).collect();
        let ends: BTreeSet<u32> = wire.edges.iter().flatten().copied().collect();
        lines.extend(ends.into_iter().map(|end| Line { ends: [place(end); 2], radius: 3.0 * pixel }));
        overlays.push((lines, Ink { colour: oklab(0.52, 0.15, 0.09), front: 0.9, behind: 0.24 }));
    }
    overlays.push((legend.text.clone(), Ink { colour: oklab(0.36, 0.0, -0.02), front: 1.0, behind: 1.0 }));
    overlays
}

fn first<A, B>(pairs: Vec<(A, B)>) -> Vec<A> {
    pairs.into_iter().map(|(a, _)| a).collect()
}

/// The triangles that touch each band, in the order of the scene.
struct Bands {
    /// Where the list of each band starts, and where the last one ends.
    starts: Vec<usize>,
    lists: Vec<u32>,
}

impl Bands {
    fn new(triangles: &[[u32; 3]], corners: &[Corner], height: usize) -> Self {
        let count = height.div_ceil(BAND);
        let touched = |triangle: &[u32; 3]| -> Range<usize> {
            let rows = triangle.map(|corner| corners[corner as usize].y.div_euclid(UNIT * BAND as i32));
            let low = rows[0].min(rows[1]).min(rows[2]).max(0);
            let high = rows[0].max(rows[1]).max(rows[2]).min(count as i32 - 1);
            if low <= high { low as usize..high as usize + 1 } else { 0..0 }
        };
        let mut starts = vec![0; count + 1];
        for triangle in triangles {
            touched(triangle).for_each(|band| starts[band + 1] += 1);
        }
        for band in 0..count {
            starts[band + 1] += starts[band];
        }
        let mut next = starts.clone();
        let mut lists = vec![0; starts[count]];
        for (number, triangle) in triangles.iter().enumerate() {
            for band in touched(triangle) {
                lists[next[band]] = number as u32;
                next[band] += 1;
            }
        }
        Bands { starts, lists }
    }

    fn count(&self) -> usize {
        self.starts.len() - 1
    }

    fn triangles(&self, band: usize) -> &[u32] {
        &self.lists[self.starts[band]..self.starts[band + 1]]
    }
}
