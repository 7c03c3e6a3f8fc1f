//! What every mesh must satisfy before its adjacency can be asked for, and the removal of unused vertices.
//!
//! ```text
//! at least one face · finite coordinates · every index in range · 3 or more corners · no corner twice
//! ```

use super::Mesh;
use crate::error::{Error, Result};

/// More corners than this are refused: the adjacency counts corners in 32 bits and keeps one value for "none".
const MOST_CORNERS: usize = u32::MAX as usize - 1;

impl Mesh {
    /// Checks the mesh by itself, face by face; how the faces fit together is up to [`super::Topology`].
    ///
    /// # Errors
    /// The first violation in the order of the picture above, with its place and a remedy.
    pub fn check(&self) -> Result<()> {
        if self.faces.is_empty() {
            return Err(Error::input("the mesh has no faces")
                .at(self.place())
                .help("points, lines and curves make no surface: export the model as polygons"));
        }
        let corners: usize = self.faces.iter().map(Vec::len).sum();
        if corners > MOST_CORNERS || self.positions.len() > MOST_CORNERS {
            return Err(Error::input(format!("the mesh has {corners} face corners"))
                .at(self.place())
                .help(format!("up to {MOST_CORNERS} are handled: split the mesh")));
        }
        if let Some(v) = self.positions.iter().position(|p| !p.is_finite()) {
            let v = v as u32; // fits: the number of positions was checked above
            return Err(Error::input(format!(
                "vertex {} has a coordinate that is infinite or not a number",
                self.vertex_number(v)
            ))
            .at(self.vertex_place(v))
            .help("repair the vertex in the program that made the mesh"));
        }
        let mut sorted = Vec::new();
        (0..self.faces.len()).try_for_each(|f| self.check_face(f, &mut sorted))
    }

    /// `sorted` is scratch space, kept by the caller so that a million faces do not allocate a million times.
    fn check_face(&self, f: usize, sorted: &mut Vec<u32>) -> Result<()> {
        let face = &self.faces[f];
        if face.len() < 3 {
            return Err(Error::input(format!("a face has only {} corners", face.len()))
                .at(self.face_place(f))
                .help("a face needs three corners at least: remove it, or close the polygon"));
        }
        if let Some(&index) = face.iter().find(|&&index| index as usize >= self.positions.len()) {
            let first = u64::from(self.vertex_number(0));
            let count = self.positions.len();
            return Err(Error::input(format!(
                "a face uses vertex {}, but there are {count} vertices, counted from {first}",
                u64::from(index) + first
            ))
            .at(self.face_place(f))
            .help("correct the number, or add the missing vertices"));
        }
        sorted.clear();
        sorted.extend_from_slice(face);
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            None => Ok(()),
            Some(pair) => {
                Err(Error::input(format!("a face has vertex {} twice", self.vertex_number(pair[0])))
                    .at(self.face_place(f))
                    .help("the face is degenerate: remove it, or give it distinct corners"))
            }
        }
    }

    /// The same mesh without vertices that no face uses; the others keep their order.
    ///
    /// Such vertices do not touch the surface, and files have them often (several objects in one file, points
    /// of curves), so the readers drop them and leave a note. Requires [`Mesh::check`] to have passed.
    pub fn without_unused_vertices(mut self) -> Mesh {
        let mut used = vec![false; self.positions.len()];
        for &v in self.faces.iter().flatten() {
            used[v as usize] = true;
        }
        let unused = used.iter().filter(|used| !**used).count();
        if unused == 0 {
            return self;
        }
        let mut new_index = vec![0; used.len()];
        let mut next = 0;
        for (new, used) in new_index.iter_mut().zip(&used) {
            *new = next;
            next += u32::from(*used);
        }
        for v in self.faces.iter_mut().flatten() {
            *v = new_index[*v as usize];
        }
        retain(&mut self.positions, &used);
        if let Some(source) = &mut self.source {
            retain(&mut source.vertex_numbers, &used);
            retain(&mut source.vertex_lines, &used);
        }
        let vertices =
            if unused == 1 { "vertex that no face uses was" } else { "vertices that no face uses were" };
        self.notes.push(format!("{unused} {vertices} left out"));
        self
    }
}

/// Keeps the entries marked in `used`; an empty list (nothing known) stays empty.
fn retain<T>(list: &mut Vec<T>, used: &[bool]) {
    let mut used = used.iter();
    list.retain(|_| *used.next().unwrap_or(&true));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Source;
    use glam::DVec3;

    fn mesh(faces: &[&[u32]]) -> Mesh {
        let positions = (0..5).map(|i| DVec3::new(i.into(), 0.0, 0.0)).collect();
        let mut mesh = Mesh::new("m", positions, faces.iter().map(|f| f.to_vec()).collect());
        mesh.source = Some(Source {
            vertex_numbers: vec![1, 2, 3, 4, 5],
            vertex_lines: vec![11, 12, 13, 14, 15],
            face_lines: (21..).take(faces.len()).collect(),
            ..Source::new("m.obj")
        });
        mesh
    }

    fn refusal(mesh: Mesh) -> (String, String) {
        let error = mesh.check().unwrap_err();
        assert!(error.help.is_some(), "{error}");
        (error.what, error.place.unwrap())
    }

    #[test]
    fn each_violation_is_named_with_its_line() {
        assert_eq!(refusal(mesh(&[])), ("the mesh has no faces".into(), "m.obj".into()));
        let (what, place) = refusal(mesh(&[&[0, 1, 2], &[0, 1]]));
        assert_eq!((what.as_str(), place.as_str()), ("a face has only 2 corners", "m.obj:22"));
        let (what, place) = refusal(mesh(&[&[0, 1, 5]]));
        assert!(
            what.contains("vertex 6, but there are 5 vertices, counted from 1") && place == "m.obj:21",
            "{what}"
        );
        let (what, place) = refusal(mesh(&[&[3, 1, 2, 3]]));
        assert_eq!((what.as_str(), place.as_str()), ("a face has vertex 4 twice", "m.obj:21"));
        let mut infinite = mesh(&[&[0, 1, 2]]);
        infinite.positions[3].y = f64::INFINITY;
        assert_eq!(refusal(infinite).1, "m.obj:14");
    }

    #[test]
    fn unused_vertices_go_and_the_others_keep_order_and_lines() {
        let mesh = mesh(&[&[4, 1, 2]]).without_unused_vertices();
        assert_eq!(mesh.faces, [[2, 0, 1]]);
        assert_eq!(mesh.positions.iter().map(|p| p.x).collect::<Vec<_>>(), [1.0, 2.0, 4.0]);
        assert_eq!(mesh.source.as_ref().unwrap().vertex_lines, [12, 13, 15]);
        assert_eq!(mesh.vertex_number(2), 5);
        assert_eq!(mesh.notes, ["2 vertices that no face uses were left out"]);
    }
}
