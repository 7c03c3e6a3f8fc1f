//! Figure 18: reflection lines on the same mesh, coarse, coarse with interpolated normals, and fine.
//!
//! ```text
//!   level 3, one normal a triangle     the lines are broken
//!   level 3, normals interpolated      continuous, with corners
//!   level 7, one normal a triangle     smooth: what high levels buy
//! ```
//!
//! The number beside each picture is the largest angle by which the normal jumps across an edge.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Files, csv, row};
use crate::cores::loop_fd::RegisterForm;
use crate::error::Result;
use crate::explore::loop_fd::Stage;
use crate::explore::meshes::Subject;
use crate::explore::point::{Design, MeshName, Origin, Precision, Scheme};
use crate::fixed::Rounding;
use crate::mesh::{self, Mesh};
use crate::report::picture::{self, Colouring, Finish, Normals, Options, Scene};
use crate::report::plot::row_of_pictures;
use crate::surface::fine_grid::FineGrid;

const CASES: [(u32, bool, &str); 3] =
    [(3, false, "level 3"), (3, true, "level 3, interpolated normals"), (7, false, "level 7")];

const SIZE: [usize; 2] = [800, 640];

pub fn files(mesh: &Mesh) -> Result<Files> {
    let mut rows =
        vec![row(["picture", "level", "normals", "triangles", "largest jump of the normal (degrees)"])];
    let (mut files, mut pictures) = (Files::new(), vec![]);
    for (index, (level, interpolated, title)) in CASES.into_iter().enumerate() {
        let (positions, triangles) = fine(mesh, level)?;
        let scene = Scene {
            positions: &positions,
            triangles: &triangles,
            normals: if interpolated { Normals::Smooth } else { Normals::Flat },
            colouring: Colouring::Plain,
            control: None,
        };
        let options = Options {
            width: SIZE[0],
            height: SIZE[1],
            finish: Finish::ReflectionLines,
            ..Options::default()
        };
        let png = picture::render(&scene, &options)?.png();
        let jump = if interpolated { 0.0 } else { largest_jump(&positions, &triangles) };
        let name = format!("figure-18-{}.png", ["a", "b", "c"][index]);
        let normals = if interpolated { "interpolated" } else { "one a triangle" };
        let (level, count, jump) = (level.to_string(), triangles.len().to_string(), format!("{jump:.3}"));
        rows.push(row([&name, &level, normals, &count, &jump]));
        pictures.push((title, png.clone()));
        files.push((name, png));
    }
    let title = format!("Reflection lines, {}", mesh.name);
    files.insert(0, ("figure-18.svg".into(), row_of_pictures(&title, &pictures, SIZE)?.into_bytes()));
    files.push(("figure-18.csv".into(), csv(&rows)));
    Ok(files)
}

/// The fine mesh as the exact core puts it out, in the units of the mesh.
fn fine(mesh: &Mesh, level: u32) -> Result<(Vec<DVec3>, Vec<[u32; 3]>)> {
    let coordinates = mesh::widest_format(mesh, 24)?;
    let name =
        MeshName { name: mesh.name.clone(), source: Origin::Shape(mesh.name.clone()), hash: String::new() };
    let subject = Subject { name, mesh: mesh.clone() };
    let stage = Stage::new(&subject, coordinates, level)?;
    let positions = stage.positions(&Design {
        scheme: Scheme::Loop,
        coordinates,
        level,
        precision: Precision::Exact,
        table: Design::usual_table(Scheme::Loop, coordinates),
        rounding: Rounding::HalfUp,
        registers: RegisterForm::Minimal20,
    })?;
    let unit = coordinates.lsb();
    let positions = positions.iter().map(|p| DVec3::from_array(p.map(|x| x as f64 * unit))).collect();
    Ok((positions, FineGrid::new(&stage.control, level)?.triangles().collect()))
}

/// The largest angle between the normals of two triangles with a common edge, in degrees.
fn largest_jump(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut open: BTreeMap<[u32; 2], DVec3> = BTreeMap::new();
    let mut largest = 0.0f64;
    for triangle in triangles {
        let own = normal(triangle);
        for side in 0..3 {
            let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
            match open.remove(&[b, a]) {
                Some(other) => {
                    // The sine is exact for small angles, where the cosine is not.
                    let angle = own.cross(other).length().atan2(own.dot(other));
                    largest = largest.max(angle.to_degrees());
                }
                None => drop(open.insert([a, b], own)),
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normals_of_a_cube_jump_by_a_right_angle() {
        let cube = mesh::shape("cube").unwrap();
        let jump = largest_jump(&cube.positions, &cube.triangles().unwrap());
        assert!((jump - 90.0).abs() < 1e-9, "{jump}");
    }

    #[test]
    fn finer_meshes_jump_less() {
        // Where the curvature is resolved, an angle halves with each level.
        let torus = mesh::shape("torus").unwrap();
        let jump = |level| {
            let (positions, triangles) = fine(&torus, level).unwrap();
            largest_jump(&positions, &triangles)
        };
        let [coarse, fine] = [jump(2), jump(4)];
        assert!(fine < coarse / 3.0 && fine > 0.0, "{coarse} {fine}");
    }
}
