//! Where the parts of a mesh stand in their file, so that a message can point there.
//!
//! ```text
//! bunny.obj:412            a text file: file and line
//! bunny.stl, face 17       a binary file: file and number
//! torus, vertex 3          a built-in shape: its name and number
//! ```

use super::Mesh;

/// Lines and numbers of vertices and faces in the file that they were read from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The file as the user named it.
    pub file: String,
    /// The number that the file itself gives to each vertex: OBJ counts from 1, all others from 0.
    pub vertex_numbers: Vec<u32>,
    /// Line of each vertex, from 1; empty for binary files.
    pub vertex_lines: Vec<u32>,
    /// Line of each face, from 1; empty for binary files.
    pub face_lines: Vec<u32>,
}

impl Source {
    pub fn new(file: impl Into<String>) -> Self {
        Source { file: file.into(), ..Source::default() }
    }
}

impl Mesh {
    /// The number of a vertex as its file counts.
    pub fn vertex_number(&self, vertex: u32) -> u32 {
        let numbers = self.source.as_ref().map_or(&[][..], |source| &source.vertex_numbers);
        numbers.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// Where a vertex is defined.
    pub fn vertex_place(&self, vertex: u32) -> String {
        let Some(source) = &self.source else { return format!("{}, vertex {vertex}", self.name) };
        match source.vertex_lines.get(vertex as usize) {
            Some(line) => format!("{}:{line}", source.file),
            None => format!("{}, vertex {}", source.file, self.vertex_number(vertex)),
        }
    }

    /// Where a face is defined.
    pub fn face_place(&self, face: usize) -> String {
        let Some(source) = &self.source else { return format!("{}, face {face}", self.name) };
        match source.face_lines.get(face) {
            Some(line) => format!("{}:{line}", source.file),
            None => format!("{}, face {face}", source.file),
        }
    }

    /// Where the mesh as a whole comes from.
    pub fn place(&self) -> &str {
        self.source.as_ref().map_or(&self.name, |source| &source.file)
    }
}
