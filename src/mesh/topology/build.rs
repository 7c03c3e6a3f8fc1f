//! From faces to half-edges, and everything that can be wrong on the way.
//!
//! ```text
//! sort the half-edges by (smaller vertex, larger vertex):
//!   a pair in opposite directions      an inner edge
//!   a single one                       a boundary edge
//!   a pair in the same direction       refused: orientation, or a repeated face
//!   three or more                      refused: no manifold
//! then walk around each vertex: the walk must meet all its faces, or two fans touch there.
//! ```

use super::{NONE, Topology};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

pub(super) fn topology(mesh: &Mesh) -> Result<Topology> {
    mesh.check()?; // indices are in range, and all counts fit 32 bits
    let mut first = Vec::with_capacity(mesh.faces.len() + 1);
    let corners = mesh.faces.iter().map(Vec::len).sum();
    let (mut origin, mut face_of) = (Vec::with_capacity(corners), Vec::with_capacity(corners));
    for (f, face) in mesh.faces.iter().enumerate() {
        first.push(origin.len() as u32);
        origin.extend_from_slice(face);
        face_of.resize(origin.len(), f as u32);
    }
    first.push(origin.len() as u32);
    let mut topology = Topology {
        first,
        origin,
        face_of,
        opposite: vec![NONE; corners],
        edge_of: vec![NONE; corners],
        edges: Vec::with_capacity(corners / 2 + 1),
        outgoing: vec![NONE; mesh.positions.len()],
        valence: vec![0; mesh.positions.len()],
    };
    topology.pair(mesh)?;
    topology.number_edges();
    topology.close_fans(mesh)?;
    Ok(topology)
}

impl Topology {
    /// Finds the opposite of each half-edge.
    fn pair(&mut self, mesh: &Mesh) -> Result<()> {
        let key = |h: u32| {
            let (a, b) = (self.origin(h), self.destination(h));
            (a.min(b), a.max(b), h)
        };
        let mut sorted: Vec<_> = (0..self.half_edge_count()).map(key).collect();
        sorted.sort_unstable();
        for same_edge in sorted.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            match *same_edge {
                [_] => {}
                [(.., h), (.., g)] if self.origin[h as usize] != self.origin[g as usize] => {
                    self.opposite[h as usize] = g;
                    self.opposite[g as usize] = h;
                }
                [(.., h), (.., g)] => return Err(self.same_direction(mesh, h, g)),
                _ => {
                    let faces: Vec<u32> = same_edge.iter().map(|&(.., h)| self.face_of(h)).collect();
                    return Err(too_many_faces(mesh, [same_edge[0].0, same_edge[0].1], &faces));
                }
            }
        }
        Ok(())
    }

    fn number_edges(&mut self) {
        for h in 0..self.half_edge_count() {
            let opposite = self.opposite[h as usize];
            if opposite > h {
                self.edge_of[h as usize] = self.edge_count();
                self.edges.push(h);
            } else {
                self.edge_of[h as usize] = self.edge_of[opposite as usize];
            }
        }
    }

    /// Chooses where each fan begins, and checks that a vertex has one fan only.
    fn close_fans(&mut self, mesh: &Mesh) -> Result<()> {
        let mut faces = vec![0u32; mesh.positions.len()];
        for h in 0..self.half_edge_count() {
            let v = self.origin(h) as usize;
            faces[v] += 1;
            // An open fan begins at the half-edge with nothing clockwise of it.
            if self.outgoing[v] == NONE || self.opposite(h).is_none() {
                self.outgoing[v] = h;
            }
        }
        for v in 0..self.vertex_count() {
            let h = self.outgoing[v as usize];
            if h == NONE {
                return Err(Error::input(format!("no face uses vertex {}", mesh.vertex_number(v)))
                    .at(mesh.vertex_place(v))
                    .help("remove the vertex (Mesh::without_unused_vertices does it)"));
            }
            if self.half_edges_from(h).count() != faces[v as usize] as usize {
                return Err(several_fans(mesh, v));
            }
            self.valence[v as usize] = faces[v as usize] + u32::from(self.opposite(h).is_none());
        }
        Ok(())
    }

    fn same_direction(&self, mesh: &Mesh, h: u32, g: u32) -> Error {
        let (older, newer) = (self.face_of(h), self.face_of(g));
        let sorted = |face: u32| {
            let mut corners = self.corners(face).to_vec();
            corners.sort_unstable();
            corners
        };
        if sorted(older) == sorted(newer) {
            let what = format!("a face repeats the one at {}", mesh.face_place(older as usize));
            return Error::input(what)
                .at(mesh.face_place(newer as usize))
                .help("remove one of the two faces");
        }
        Error::input(format!(
            "two neighbouring faces have opposite orientations: both run from vertex {} to vertex {}",
            mesh.vertex_number(self.origin(h)),
            mesh.vertex_number(self.destination(h)),
        ))
        .at(format!("{} and {}", mesh.face_place(older as usize), mesh.face_place(newer as usize)))
        .help("order the corners of every face counterclockwise as seen from outside (in a modeller: unify normals)")
    }
}

fn too_many_faces(mesh: &Mesh, vertices: [u32; 2], faces: &[u32]) -> Error {
    let [a, b] = vertices.map(|v| mesh.vertex_number(v));
    // Three places show the trouble; a hundred would hide it.
    let places: Vec<String> = faces.iter().take(3).map(|&f| mesh.face_place(f as usize)).collect();
    let more = if faces.len() > 3 { " ..." } else { "" };
    Error::input(format!("the edge between vertices {a} and {b} belongs to {} faces", faces.len()))
        .at(format!("{}{more}", places.join(" and ")))
        .help("an edge has two faces at most: remove inner faces, or give each sheet its own vertices")
}

fn several_fans(mesh: &Mesh, v: u32) -> Error {
    Error::input(format!("separate fans of faces touch in vertex {} alone", mesh.vertex_number(v)))
        .at(mesh.vertex_place(v))
        .help("give each fan its own copy of the vertex, or join the fans by an edge")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Source;
    use glam::DVec3;

    fn mesh(vertices: usize, faces: &[&[u32]]) -> Mesh {
        let positions = (0..vertices).map(|i| DVec3::new(i as f64, (i * i) as f64, 0.0)).collect();
        let mut mesh = Mesh::new("m", positions, faces.iter().map(|f| f.to_vec()).collect());
        mesh.source = Some(Source {
            vertex_numbers: (1..=vertices as u32).collect(),
            vertex_lines: (101..).take(vertices).collect(),
            face_lines: (201..).take(faces.len()).collect(),
            ..Source::new("m.obj")
        });
        mesh
    }

    fn refusal(vertices: usize, faces: &[&[u32]]) -> (String, String) {
        let error = topology(&mesh(vertices, faces)).unwrap_err();
        assert!(error.help.is_some(), "{error}");
        (error.what, error.place.unwrap())
    }

    #[test]
    fn three_faces_at_an_edge() {
        let (what, place) = refusal(5, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]);
        assert_eq!(what, "the edge between vertices 1 and 2 belongs to 3 faces");
        assert_eq!(place, "m.obj:201 and m.obj:202 and m.obj:203");
    }

    #[test]
    fn opposite_orientations() {
        let (what, place) = refusal(4, &[&[0, 1, 2], &[0, 1, 3]]);
        assert!(what.contains("both run from vertex 1 to vertex 2"), "{what}");
        assert_eq!(place, "m.obj:201 and m.obj:202");
    }

    #[test]
    fn a_face_twice() {
        let (what, place) = refusal(3, &[&[0, 1, 2], &[1, 2, 0]]);
        assert_eq!((what.as_str(), place.as_str()), ("a face repeats the one at m.obj:201", "m.obj:202"));
    }

    #[test]
    fn two_fans_at_a_vertex_open_or_closed() {
        let (what, place) = refusal(5, &[&[0, 1, 2], &[0, 3, 4]]);
        assert_eq!(
            (what.as_str(), place.as_str()),
            ("separate fans of faces touch in vertex 1 alone", "m.obj:101")
        );
        let closed: &[&[u32]] = &[&[0, 1, 2], &[0, 2, 3], &[0, 3, 1], &[1, 3, 2]];
        let mut two = closed.to_vec();
        two.extend([&[0, 4, 5][..], &[0, 5, 6], &[0, 6, 4], &[4, 6, 5]]);
        assert!(topology(&mesh(4, closed)).is_ok());
        assert_eq!(refusal(7, &two).1, "m.obj:101");
    }

    #[test]
    fn a_vertex_of_no_face() {
        assert_eq!(refusal(4, &[&[0, 1, 3]]), ("no face uses vertex 3".into(), "m.obj:103".into()));
    }

    #[test]
    fn a_hub_of_many_faces_is_no_trap() {
        // Sorting keeps this linear; comparing all edges of a vertex with each other would take hours.
        let n = 200_000;
        let faces: Vec<[u32; 3]> = (1..n).map(|i| [0, i, i + 1]).collect();
        let faces: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
        let topology = topology(&mesh(n as usize + 1, &faces)).unwrap();
        assert_eq!((topology.valence(0), topology.ring(0).last()), (n, Some(n)));
    }
}
