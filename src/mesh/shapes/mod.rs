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
    entry("cube", "closed, 12 triangles, valences 4 and 6", polyhedra::cube),
    entry("torus", "closed, genus 1, 144 triangles, all valences 6 (regular)", tori::torus),
    entry("double-torus", "closed, genus 2, a bar with two holes", tori::double_torus),
    entry("blob", "closed, a duck of 130 triangles, valences 3 to 9", blob::blob),
    entry("bipyramid-32", "closed, valences 4 and 32; bipyramid-N for N from 3 to 32", || polyhedra::bipyramid(32)),
    entry("disc", "one boundary, boundary valences 2 to 5", open::disc),
    entry("square", "one boundary with four corners, 32 triangles", open::square),
    entry("annulus", "two boundaries, regular everywhere", open::annulus),
    entry("triangle", "a single triangle", open::triangle),
    entry("cube-quads", "closed, 6 quads, all valences 3", polyhedra::cube_quads),
    entry("torus-quads", "closed, genus 1, 72 quads, all valences 4 (regular)", tori::torus_quads),
    entry("double-torus-quads", "closed, genus 2, 50 quads, valences 3 to 5", tori::double_torus_quads),
    entry("blob-quads", "closed, valences 3 to 9, neighbours of valence 3", blob::blob_quads),
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
        _ => format!("the shapes are {}", SHAPES.iter().map(|shape| shape.name).collect::<Vec<_>>().join(", ")),
    };
    Err(Error::usage(format!("there is no built-in shape '{name}'")).help(help))
}

fn mesh(name: &str, (positions, faces): Parts) -> Mesh {
    Mesh::new(name, positions.into_iter().map(|p| (p * 4096.0).round() / 4096.0).collect(), faces)
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
