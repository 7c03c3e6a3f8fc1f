//! A mesh while it is being read: points and faces as they come, each with its line.

use crate::error::Result;
use crate::mesh::{Mesh, Source};
use glam::DVec3;

pub(super) struct Draft {
    mesh: Mesh,
    source: Source,
    first_number: u32,
}

impl Draft {
    /// `first_number` is what the file calls its first vertex.
    pub fn new(file: &str, first_number: u32) -> Self {
        Draft {
            mesh: Mesh { name: file.to_owned(), ..Mesh::default() },
            source: Source::new(file),
            first_number,
        }
    }

    pub fn vertices(&self) -> usize {
        self.mesh.positions.len()
    }

    pub fn faces(&self) -> usize {
        self.mesh.faces.len()
    }

    pub fn vertex(&mut self, position: [f64; 3], line: Option<u64>) {
        // An astronomic number saturates here; `Mesh::check` refuses the mesh then.
        let number = u32::try_from(self.vertices()).unwrap_or(u32::MAX);
        self.source.vertex_numbers.push(number.saturating_add(self.first_number));
        self.source.vertex_lines.extend(line.map(saturate));
        self.mesh.positions.push(DVec3::from_array(position));
    }

    pub fn face(&mut self, corners: Vec<u32>, line: Option<u64>) {
        self.source.face_lines.extend(line.map(saturate));
        self.mesh.faces.push(corners);
    }

    pub fn note(&mut self, note: String) {
        self.mesh.notes.push(note);
    }

    /// The checked mesh, without vertices that no face uses.
    pub fn finish(self) -> Result<Mesh> {
        let mesh = Mesh { source: Some(self.source), ..self.mesh };
        mesh.check()?;
        Ok(mesh.without_unused_vertices())
    }
}

fn saturate(line: u64) -> u32 {
    u32::try_from(line).unwrap_or(u32::MAX)
}
