//! Indexed meshes: readers and writers, adjacency, built-in shapes.
//!
//! A [`Mesh`] is what a file says: points, and faces that name their corners counterclockwise as seen from
//! outside. Nothing is assumed about how the faces fit together; [`Topology`] finds that out, or refuses.
//!
//! ```text
//!   2 ───── 3
//!   │    ╱  │      positions: 4 points        file ──[read]──► Mesh ──[Topology::new]──► who is next to whom
//!   │  ╱    │      faces: [0 1 3] [0 3 2]                        └──[quantise]──► integers for the hardware
//!   0 ───── 1
//! ```
//!
//! ```
//! use subdiv_rtl::mesh::{Topology, shape};
//! let mesh = shape("octahedron").unwrap();
//! let topology = Topology::new(&mesh).unwrap();
//! assert_eq!((topology.valence(0), topology.euler_characteristic()), (4, 2));
//! ```

mod check;
mod quantise;
pub mod read;
pub mod shapes;
mod source;
pub mod topology;
pub mod write;

pub use quantise::{QuantisedMesh, Rounding, quantise, widest_format};
pub use read::{FileFormat, read, read_from};
pub use shapes::{Shape, shape, shapes};
pub use source::Source;
pub use topology::Topology;
pub use write::{FineMesh, Written, write};

use crate::error::{Error, Result};
use glam::DVec3;

/// Points and polygons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// For messages and titles: the stem of the file name, or the name of the shape.
    pub name: String,
    pub positions: Vec<DVec3>,
    /// Corners of each face as indices into `positions`, counterclockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
    /// Where each vertex and face stands in its file, when it came from one.
    pub source: Option<Source>,
    /// What reading changed or left out, one sentence each, for the user to see.
    pub notes: Vec<String>,
}

impl Mesh {
    pub fn new(name: impl Into<String>, positions: Vec<DVec3>, faces: Vec<Vec<u32>>) -> Self {
        Mesh { name: name.into(), positions, faces, source: None, notes: Vec::new() }
    }

    pub fn is_triangle_mesh(&self) -> bool {
        self.faces.iter().all(|face| face.len() == 3)
    }

    /// The faces of a triangle mesh.
    ///
    /// # Errors
    /// Names the first face that is no triangle: Loop's scheme is defined on triangles only, and how to cut
    /// a polygon is the user's choice, so it is never done unasked.
    pub fn triangles(&self) -> Result<Vec<[u32; 3]>> {
        let triangle = |(f, face): (usize, &Vec<u32>)| {
            face.as_slice().try_into().map_err(|_| {
                Error::input(format!("a face has {} corners, and only triangles will do here", face.len()))
                    .at(self.face_place(f))
                    .help("cut the polygons into triangles (--triangulate does it, each as a fan)")
            })
        };
        self.faces.iter().enumerate().map(triangle).collect()
    }

    /// The same mesh with every polygon cut into the fan of triangles around its first corner.
    ///
    /// `[a b c d e]` becomes `[a b c] [a c d] [a d e]`, in the order of the faces.
    pub fn triangulated(&self) -> Mesh {
        let mut faces = Vec::with_capacity(self.faces.len());
        let mut face_lines = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            let fan = face.windows(2).skip(1).map(|side| vec![face[0], side[0], side[1]]);
            faces.extend(fan);
            if let Some(&line) = self.source.as_ref().and_then(|source| source.face_lines.get(f)) {
                face_lines.resize(faces.len(), line);
            }
        }
        let source = self.source.clone().map(|source| Source { face_lines, ..source });
        Mesh { faces, source, ..self.clone() }
    }

    /// Smallest and largest coordinate of each axis; nothing for a mesh without points.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pentagon() -> Mesh {
        let positions = vec![DVec3::ZERO; 6];
        let mut mesh = Mesh::new("pentagon", positions, vec![vec![5, 1, 2, 3, 4], vec![0, 1, 5]]);
        mesh.source = Some(Source { face_lines: vec![70, 80], ..Source::new("p.obj") });
        mesh
    }

    #[test]
    fn a_polygon_becomes_the_fan_of_its_first_corner() {
        let mesh = pentagon().triangulated();
        assert_eq!(mesh.triangles().unwrap(), [[5, 1, 2], [5, 2, 3], [5, 3, 4], [0, 1, 5]]);
        assert_eq!(mesh.source.unwrap().face_lines, [70, 70, 70, 80]);
    }

    #[test]
    fn a_polygon_is_not_cut_unasked() {
        let error = pentagon().triangles().unwrap_err();
        assert_eq!(error.place.as_deref(), Some("p.obj:70"));
        assert!(error.what.contains("5 corners") && error.help.unwrap().contains("--triangulate"));
    }
}
