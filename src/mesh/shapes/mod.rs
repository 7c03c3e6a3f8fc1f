//! Built-in meshes by name: our own construction, the same bytes everywhere.
//!
//! ```text
//! NAME          a triangle mesh, for Loop's scheme
//! NAME-quads    a mesh of quadrilaterals, for Catmull and Clark's
//! ```
//!
//! Every coordinate is a multiple of 2^-12 in [-1, 1], so `Q2.12` holds all shapes exactly. Rounding to that
//! grid also hides the last bit of `sin` and `cos`, which differs between mathematical libraries.

mod blob;
mod open;
mod polyhedra;
mod sculpt;
mod tori;

use super::Mesh;
use crate::error::{Error, Result};
use glam::DVec3;

/// A built-in mesh.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub name: &'static str,
    /// One line for the list of shapes.
    pub description: &'static str,
    build: fn() -> Parts,
}

impl Shape {
    pub fn mesh(&self) -> Mesh {
        mesh(self.name, (self.build)())
    }
}

/// Points and polygons, before they have a name.
type Parts = (Vec<DVec3>, Vec<Vec<u32>>);

const fn entry(name: &'static str, description: &'static str, build: fn() -> Parts) -> Shape {
    Shape { name, description, build }
}

static SHAPES: &[Shape] = &[
    entry("tetrahedron", "closed, 4 triangles, all valences 3", polyhedra::tetrahedron),
    entry("octahedron", "closed, 8 triangles, all valences 4", polyhedra::octahedron),
    entry("icosahedron", "closed, 20 triangles, all valences 5", polyhedra::icosahedron),
    entry("cube", "closed, 12 triangles, valences 4 and 5", polyhedra::cube),
    entry("torus", "closed, genus 1, 144 triangles, all valences 6 (regular)", tori::torus),
    entry("double-torus", "closed, genus 2, 100 triangles, valences 3, 6 and 9", tori::double_torus),
    entry("blob", "closed, a duck of 130 triangles, valences 3 to 9", blob::blob),
    entry("bipyramid-32", "closed, valences 4 and 32; bipyramid-N for N from 3 to 32", || {
        polyhedra::bipyramid(32)
    }),
    entry("disc", "one boundary, boundary valences 2 to 5", open::disc),
    entry("square", "one boundary with four corners, 32 triangles", open::square),
    entry("annulus", "two boundaries, regular everywhere", open::annulus),
    entry("triangle", "a single triangle", open::triangle),
    entry("cube-quads", "closed, 6 quads, all valences 3", polyhedra::cube_quads),
    entry("torus-quads", "closed, genus 1, 72 quads, all valences 4 (regular)", tori::torus_quads),
    entry("double-torus-quads", "closed, genus 2, 50 quads, valences 3 to 5", tori::double_torus_quads),
    entry("blob-quads", "closed, the duck of 96 quads, valences 3 to 9", blob::blob_quads),
    entry("disc-quads", "one boundary, 15 quads around a vertex of valence 5", open::disc_quads),
    entry("square-quads", "one boundary with four corners, 16 quads", open::square_quads),
];

/// All built-in meshes, in the order in which they are listed.
pub fn shapes() -> &'static [Shape] {
    SHAPES
}

/// The built-in mesh of that name.
///
/// # Errors
/// [`crate::Kind::Usage`] for a name that does not exist, with the one that was probably meant.
pub fn shape(name: &str) -> Result<Mesh> {
    if let Some(shape) = SHAPES.iter().find(|shape| shape.name == name) {
        return Ok(shape.mesh());
    }
    let sides = name.strip_prefix("bipyramid-").and_then(|sides| sides.parse().ok());
    if let Some(sides) = sides.filter(|sides| (3..=32).contains(sides)) {
        return Ok(mesh(name, polyhedra::bipyramid(sides)));
    }
    let nearest = SHAPES.iter().map(|shape| (distance(name, shape.name), shape.name)).min();
    let help = match nearest {
        Some((changes, nearest)) if changes <= 3 => format!("did you mean '{nearest}'?"),
        _ => {
            format!("the shapes are {}", SHAPES.iter().map(|shape| shape.name).collect::<Vec<_>>().join(", "))
        }
    };
    Err(Error::usage(format!("there is no built-in shape '{name}'")).help(help))
}

fn mesh(name: &str, (positions, faces): Parts) -> Mesh {
    let snap = |p: DVec3| (p * 4096.0).round() / 4096.0 + DVec3::ZERO; // no -0
    Mesh::new(name, positions.into_iter().map(snap).collect(), faces)
}

/// How many letters to insert, delete or replace to come from one word to the other (Levenshtein).
fn distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, letter) in from.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for j in 0..to.len() {
            let replaced = diagonal + usize::from(letter != to[j]);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Format;
    use crate::mesh::{Topology, quantise};
    use std::fmt::Write;

    /// `V F genus loops | interior valences | boundary valences`, each valence with its count.
    fn summary(mesh: &Mesh) -> String {
        let topology = Topology::new(mesh).unwrap();
        assert_eq!(topology.component_count(), 1, "{}", mesh.name);
        let (mut interior, mut boundary) = (String::new(), String::new());
        for (valence, count) in topology.valence_histogram() {
            let list = |text: &mut String, count| {
                if count > 0 {
                    write!(text, " {valence}:{count}").unwrap();
                }
            };
            list(&mut interior, count.interior);
            list(&mut boundary, count.boundary);
        }
        let (genus, loops) = (topology.genus(), topology.boundary_loops().len());
        format!("{} {} {genus} {loops} |{interior} |{boundary}", mesh.positions.len(), mesh.faces.len())
    }

    #[test]
    fn every_shape_is_what_the_list_says() {
        let expected = [
            ("tetrahedron", "4 4 0 0 | 3:4 |"),
            ("octahedron", "6 8 0 0 | 4:6 |"),
            ("icosahedron", "12 20 0 0 | 5:12 |"),
            ("cube", "8 12 0 0 | 4:4 5:4 |"),
            ("torus", "72 144 1 0 | 6:72 |"),
            ("double-torus", "48 100 2 0 | 3:4 6:36 9:8 |"),
            ("blob", "67 130 0 0 | 3:1 4:5 5:14 6:38 7:5 8:2 9:2 |"),
            ("bipyramid-32", "34 64 0 0 | 4:32 32:2 |"),
            ("disc", "25 31 0 1 | 6:7 7:1 | 2:3 3:4 4:7 5:3"),
            ("square", "25 32 0 1 | 6:9 | 2:2 3:2 4:12"),
            ("annulus", "36 48 0 2 | 6:12 | 4:24"),
            ("triangle", "3 1 0 1 | | 2:3"),
            ("cube-quads", "8 6 0 0 | 3:8 |"),
            ("torus-quads", "72 72 1 0 | 4:72 |"),
            ("double-torus-quads", "48 50 2 0 | 3:8 4:24 5:16 |"),
            ("blob-quads", "98 96 0 0 | 3:35 4:47 5:11 6:2 7:1 8:1 9:1 |"),
            ("disc-quads", "21 15 0 1 | 3:5 4:5 5:1 | 3:10"),
            ("square-quads", "25 16 0 1 | 4:9 | 2:4 3:12"),
        ];
        let found: Vec<(&str, String)> = shapes().iter().map(|s| (s.name, summary(&s.mesh()))).collect();
        assert_eq!(found, expected.map(|(name, summary)| (name, summary.to_owned())));
    }

    #[test]
    fn names_tell_triangles_from_quads() {
        for shape in shapes() {
            let corners = if shape.name.ends_with("-quads") { 4 } else { 3 };
            assert!(shape.mesh().faces.iter().all(|face| face.len() == corners), "{}", shape.name);
        }
    }

    #[test]
    fn coordinates_are_exact_in_q2_12_and_within_one() {
        let format = Format::new(2, 12).unwrap();
        for shape in shapes() {
            let quantised = quantise(&shape.mesh(), format).unwrap();
            assert!(quantised.rounding.is_exact(), "{}", shape.name);
            assert!(quantised.positions.iter().flatten().all(|q| q.abs() <= 4096), "{}", shape.name);
        }
    }

    #[test]
    fn closed_shapes_are_seen_from_outside() {
        for mesh in shapes().iter().map(Shape::mesh) {
            if Topology::new(&mesh).unwrap().boundary_loops().is_empty() {
                let mesh = mesh.triangulated();
                let corners = |face: &Vec<u32>| [0, 1, 2].map(|i| mesh.positions[face[i] as usize]);
                let volume: f64 = mesh.faces.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
                assert!(volume > 0.1, "{}: {volume}", mesh.name);
            }
        }
    }

    #[test]
    fn the_blobs_do_not_cut_themselves() {
        let meets = |[p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]| {
            let side = |x: DVec3, y: DVec3, z: DVec3, w: DVec3| (y - x).dot((z - x).cross(w - x)) > 0.0;
            side(a, b, c, p) != side(a, b, c, q)
                && side(p, q, a, b) == side(p, q, b, c)
                && side(p, q, b, c) == side(p, q, c, a)
        };
        let triangle = [DVec3::new(-1., -1., 0.), DVec3::new(1., -1., 0.), DVec3::new(0., 1., 0.)];
        assert!(meets([DVec3::NEG_Z, DVec3::Z], triangle) && !meets([DVec3::Z, 2.0 * DVec3::Z], triangle));
        for name in ["blob", "blob-quads"] {
            let mesh = shape(name).unwrap().triangulated();
            let edges = Topology::new(&mesh).unwrap();
            for edge in edges.edges().map(|edge| edge.vertices) {
                for face in mesh.faces.iter().filter(|face| !edge.iter().any(|v| face.contains(v))) {
                    let at = |v: u32| mesh.positions[v as usize];
                    assert!(
                        !meets(edge.map(at), [at(face[0]), at(face[1]), at(face[2])]),
                        "{name} {edge:?} {face:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn blob_quads_has_neighbours_of_valence_three() {
        let topology = Topology::new(&shape("blob-quads").unwrap()).unwrap();
        assert!(topology.edges().any(|edge| edge.vertices.iter().all(|&v| topology.valence(v) == 3)));
    }

    #[test]
    fn the_bytes_are_the_same_on_every_machine() {
        let mut text = String::new();
        for mesh in shapes().iter().map(Shape::mesh) {
            writeln!(text, "{} {:?} {:?}", mesh.name, mesh.positions, mesh.faces).unwrap();
        }
        assert_eq!(&blake3::hash(text.as_bytes()).to_hex()[..16], "3a795dac556a8961");
    }

    #[test]
    fn bipyramids_of_every_valence() {
        for sides in 3..=32 {
            let topology = Topology::new(&shape(&format!("bipyramid-{sides}")).unwrap()).unwrap();
            assert_eq!(topology.valence(0), sides);
        }
        assert!(shape("bipyramid-33").is_err() && shape("bipyramid-2").is_err());
    }

    #[test]
    fn distances_between_words() {
        assert_eq!(
            (distance("blob", "bloob"), distance("bloob", "blob"), distance("tours", "torus")),
            (1, 1, 2)
        );
    }

    #[test]
    fn a_misspelt_name_gets_the_right_one() {
        assert_eq!(shape("tours").unwrap_err().help.as_deref(), Some("did you mean 'torus'?"));
        let error = shape("elephant").unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.help.unwrap().starts_with("the shapes are tetrahedron, octahedron"));
    }
}
