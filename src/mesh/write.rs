//! Writing the fine mesh: OBJ, PLY (ascii) and STL (binary).
//!
//! ```text
//! OBJ, PLY   coordinates as exact decimals:  -409 / 2^12  ->  -0.099853515625
//! STL        float32 by its nature: exact for coordinates of up to 24 bits, rounded beyond, and then said
//! ```

use crate::error::{Error, Result};
use crate::files::write_whole_with;
use crate::fixed::Format;
use std::io::{self, Write};
use std::path::Path;

/// An indexed mesh of polygons with `N` corners each, coordinates in units of 2^-fraction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FineMesh<const N: usize = 3> {
    pub format: Format,
    pub positions: Vec<[i64; 3]>,
    /// Indices into `positions`, counterclockwise seen from outside.
    pub faces: Vec<[u32; N]>,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Coordinates of vertices that the file format could not hold exactly.
    pub rounded: usize,
}

/// Writes the mesh, whole or not at all, in the format of the extension: `.obj`, `.ply` or `.stl`.
///
/// # Errors
/// An unknown extension ([`crate::Kind::Usage`]); a face that uses a vertex beyond the list, more triangles
/// than STL can count, or a file that cannot be written ([`crate::Kind::Input`]).
pub fn write<const N: usize>(path: &Path, mesh: &FineMesh<N>) -> Result<Written> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let fill = match extension.as_str() {
        "obj" => obj,
        "ply" => ply,
        "stl" => stl,
        _ => {
            return Err(Error::usage(format!("no mesh can be written as '{}'", path.display()))
                .help("name it .obj, .ply or .stl"));
        }
    };
    if let Some(&v) = mesh.faces.iter().flatten().find(|&&v| v as usize >= mesh.positions.len()) {
        let what = format!("a face uses vertex {v} of {}", mesh.positions.len());
        return Err(Error::input(what).at(path.display()).help("vertices count from 0"));
    }
    if extension == "stl" && u32::try_from(triangle_count(mesh)).is_err() {
        return Err(Error::input(format!("STL cannot count {} triangles", triangle_count(mesh)))
            .at(path.display())
            .help("write .ply or .obj, or choose a lower level"));
    }
    write_whole_with(path, |file| fill(mesh, file))?;
    let rounded = if extension == "stl" { inexact_in_float32(mesh) } else { 0 };
    Ok(Written { rounded })
}

type Out<'a> = &'a mut dyn Write;

fn obj<const N: usize>(mesh: &FineMesh<N>, out: Out) -> io::Result<()> {
    writeln!(
        out,
        "# {} vertices, {} faces, units of 2^-{}",
        mesh.positions.len(),
        mesh.faces.len(),
        mesh.format.fraction
    )?;
    for &position in &mesh.positions {
        let [x, y, z] = position.map(|q| mesh.format.decimal(q));
        writeln!(out, "v {x} {y} {z}")?;
    }
    mesh.faces.iter().try_for_each(|face| {
        write!(out, "f")?;
        face.iter().try_for_each(|&v| write!(out, " {}", u64::from(v) + 1))?;
        writeln!(out)
    })
}

fn ply<const N: usize>(mesh: &FineMesh<N>, out: Out) -> io::Result<()> {
    writeln!(out, "ply\nformat ascii 1.0\ncomment units of 2^-{}", mesh.format.fraction)?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    writeln!(out, "element face {}\nproperty list uchar uint vertex_indices\nend_header", mesh.faces.len())?;
    for &position in &mesh.positions {
        let [x, y, z] = position.map(|q| mesh.format.decimal(q));
        writeln!(out, "{x} {y} {z}")?;
    }
    mesh.faces.iter().try_for_each(|face| {
        write!(out, "{N}")?;
        face.iter().try_for_each(|v| write!(out, " {v}"))?;
        writeln!(out)
    })
}

/// Polygons are cut into fans, for STL knows triangles only.
fn stl<const N: usize>(mesh: &FineMesh<N>, out: Out) -> io::Result<()> {
    let mut head = [b' '; 80];
    let title = format!("binary STL, {}", mesh.format);
    head[..title.len()].copy_from_slice(title.as_bytes());
    out.write_all(&head)?;
    out.write_all(&(triangle_count(mesh) as u32).to_le_bytes())?;
    for face in &mesh.faces {
        for side in face.windows(2).skip(1) {
            let corners = [face[0], side[0], side[1]].map(|v| mesh.positions[v as usize]);
            let points = corners.map(|corner| corner.map(|q| (q as f64 * mesh.format.lsb()) as f32));
            for number in normal(corners).into_iter().chain(points.into_iter().flatten()) {
                out.write_all(&number.to_le_bytes())?;
            }
            out.write_all(&[0; 2])?;
        }
    }
    Ok(())
}

fn triangle_count<const N: usize>(mesh: &FineMesh<N>) -> usize {
    mesh.faces.len() * N.saturating_sub(2)
}

/// The unit normal of a triangle; zero where the triangle has no area.
fn normal([a, b, c]: [[i64; 3]; 3]) -> [f32; 3] {
    let side = |p: [i64; 3]| glam::DVec3::from_array([0, 1, 2].map(|i| (p[i] - a[i]) as f64));
    side(b).cross(side(c)).normalize_or_zero().as_vec3().to_array()
}

fn inexact_in_float32<const N: usize>(mesh: &FineMesh<N>) -> usize {
    mesh.positions.iter().flatten().filter(|&&q| f64::from(q as f32) != q as f64).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, Topology, read};

    fn pyramid(fraction: u32) -> FineMesh {
        FineMesh {
            format: Format::new(32 - fraction, fraction).unwrap(),
            positions: vec![[-409, 1, 0], [4096, 0, 0], [0, 0x7fff_ffff, 0], [0, 0, -0x8000_0000]],
            faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        }
    }

    fn written<const N: usize>(name: &str, mesh: &FineMesh<N>) -> (Written, Mesh) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        (write(&path, mesh).unwrap(), read(&path).unwrap())
    }

    #[test]
    fn obj_and_ply_come_back_exactly() {
        for name in ["a.obj", "a.ply"] {
            let fine = pyramid(12);
            let (result, mesh) = written(name, &fine);
            assert_eq!(result.rounded, 0);
            let back = mesh.positions.iter().map(|p| p.to_array().map(|x| (x * 4096.0) as i64));
            assert_eq!(back.collect::<Vec<_>>(), fine.positions, "{name}");
            assert_eq!(mesh.triangles().unwrap(), fine.faces, "{name}");
        }
    }

    #[test]
    fn stl_says_what_it_rounded() {
        let (result, mesh) = written("a.stl", &pyramid(12));
        assert_eq!(result.rounded, 1); // 2^31 - 1 has too many bits, 2^31 has one
        assert_eq!(Topology::new(&mesh).unwrap().euler_characteristic(), 2);
        assert_eq!(mesh.positions[0].x, -409.0 / 4096.0);
    }

    #[test]
    fn stl_cuts_quads_and_points_normals_outside() {
        let quad = FineMesh::<4> {
            format: Format::new(4, 0).unwrap(),
            positions: vec![[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]],
            faces: vec![[0, 1, 2, 3]],
        };
        let mut bytes = Vec::new();
        stl(&quad, &mut bytes).unwrap();
        assert_eq!(bytes.len(), 84 + 2 * 50);
        assert_eq!(bytes[84..96], [0u8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63]); // (0, 0, 1)
        assert_eq!(written("q.stl", &quad).1.faces, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn an_unknown_extension_and_a_wrong_index_write_nothing() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(write(&folder.path().join("a.blend"), &pyramid(12)).unwrap_err().exit_status(), 2);
        let mut broken = pyramid(12);
        broken.faces[2][1] = 4;
        assert!(write(&folder.path().join("a.obj"), &broken).unwrap_err().what.contains("vertex 4 of 4"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
