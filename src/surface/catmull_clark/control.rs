//! Any manifold polygon mesh becomes a quad mesh: as it is, or by one step of Catmull and Clark.
//!
//! ```text
//!   all faces quads        the mesh itself, nothing changes
//!   else one step          F = mean of the face       E = (F1 + F2 + A + B)/4
//!                          V' = (sum F + sum A)/d^2 + (d-2) S/d         over all d faces around, of any size
//! ```
//!
//! The step is taken in exact rationals: an n-gon brings the denominator n, a valence d^2, and no common scale
//! is a power of two. Each coordinate of the result is then rounded once, half up, to the coordinate format
//! (with `extra_fraction` more bits on request); how many were rounded and by how much at most is part of
//! the result. The surface that the hardware evaluates is that of the rounded quad mesh.
//!
//! Vertices of the result: the old vertices, one a face edge (in the order of the topology), one a face.

use crate::error::{Error, Result};
use crate::mesh::{Mesh, QuantisedMesh, Topology};
use crate::surface::catmull_clark::masks::Corners;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Boundary, no_ghost};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

/// A quad mesh and how it came to be one.
#[derive(Clone, Debug)]
pub struct Control {
    pub mesh: QuadMesh,
    /// The step that was needed; none where all faces were quads.
    pub step: Option<Step>,
}

/// What one step of subdivision changed beyond the rules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Vertices of the polygon mesh; they keep their numbers.
    pub old_vertices: usize,
    /// Edges of the polygon mesh; their new vertices follow.
    pub old_edges: usize,
    /// Coordinates that had to be rounded.
    pub rounded: usize,
    /// The largest change, at most half a unit of the result.
    pub largest: f64,
}

/// Where a vertex of the quad mesh comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A vertex of the polygon mesh.
    Vertex(u32),
    /// An edge of its topology.
    Edge(u32),
    /// One of its faces.
    Face(u32),
}

/// The quad mesh of a polygon mesh.
///
/// `extra_fraction`: fraction bits of the result beyond those of the input, 0..=16; quads are shifted by it.
///
/// # Errors
/// What [`Topology::new`] refuses; an interior vertex with two edges.
pub fn control(
    mesh: &Mesh,
    quantised: &QuantisedMesh,
    corners: Corners,
    extra_fraction: u32,
) -> Result<Control> {
    if extra_fraction > 16 {
        return Err(Error::usage(format!("{extra_fraction} extra fraction bits"))
            .help("0 to 16 are possible; or choose a wider coordinate format"));
    }
    let topology = Topology::new(mesh)?;
    topology.check_valences(mesh, 3..=u32::MAX, 2..=u32::MAX)?;
    if mesh.faces.iter().all(|face| face.len() == 4) {
        let positions = quantised.positions.iter().map(|p| p.map(|x| x << extra_fraction)).collect();
        return Ok(Control { mesh: QuadMesh::of_mesh(mesh, topology, positions)?, step: None });
    }
    let exact = Polygons { topology: &topology, positions: &quantised.positions, corners }.subdivided();
    let mut step = Step {
        old_vertices: topology.vertex_count() as usize,
        old_edges: topology.edge_count() as usize,
        ..Step::default()
    };
    let positions =
        exact.iter().map(|p| std::array::from_fn(|x| step.round(&p[x], extra_fraction))).collect();
    let mesh = QuadMesh::new(positions, quads(&topology))?;
    Ok(Control { mesh, step: Some(step) })
}

impl Control {
    pub fn origin(&self, vertex: u32) -> Origin {
        let Some(step) = self.step else { return Origin::Vertex(vertex) };
        let (vertices, edges) = (step.old_vertices as u32, step.old_edges as u32);
        if vertex < vertices {
            Origin::Vertex(vertex)
        } else if vertex < vertices + edges {
            Origin::Edge(vertex - vertices)
        } else {
            Origin::Face(vertex - vertices - edges)
        }
    }

    /// Checks that no vertex has more than `largest` edges, the one that completes a boundary vertex counted.
    ///
    /// # Errors
    /// Names the vertex or face of `mesh`, the polygon mesh that this came from, and its place.
    pub fn check_valences(&self, mesh: &Mesh, largest: usize) -> Result<()> {
        let topology = self.mesh.topology();
        let edges = |v: u32| topology.valence(v) + u32::from(topology.is_boundary(v));
        let Some(v) = (0..topology.vertex_count()).find(|&v| edges(v) as usize > largest) else {
            return Ok(());
        };
        let valence = edges(v);
        let (what, place) = match self.origin(v) {
            Origin::Face(f) => (format!("a face has {valence} corners"), mesh.face_place(f as usize)),
            Origin::Vertex(v) => {
                let completed =
                    if topology.is_boundary(v) { ", one beyond the boundary counted" } else { "" };
                let number = mesh.vertex_number(v);
                (format!("vertex {number} has {valence} edges{completed}"), mesh.vertex_place(v))
            }
            // The middle of an edge has four edges itself.
            Origin::Edge(_) => (format!("an edge of {valence} faces"), mesh.place().to_owned()),
        };
        Err(Error::input(format!("{what}, and the largest valence here is {largest}"))
            .at(place)
            .help("generate the core with a larger --max-valence (up to 16), or split the vertex"))
    }

    /// Checks that the boundary can be completed in the way asked for.
    ///
    /// # Errors
    /// Names the first boundary vertex of `mesh` that has no ghosts, and its place.
    pub fn check_boundary(&self, mesh: &Mesh, boundary: Boundary) -> Result<()> {
        let topology = self.mesh.topology();
        let without = |&v: &u32| topology.is_boundary(v) && topology.valence(v) > 3;
        match (0..topology.vertex_count()).find(without) {
            // New boundary vertices have three edges, so it is an old one, with its old number.
            Some(v) if boundary == Boundary::Ghosts => {
                Err(no_ghost(mesh.vertex_number(v), topology.valence(v)).at(mesh.vertex_place(v)))
            }
            _ => Ok(()),
        }
    }
}

impl Step {
    /// x 2^extra_fraction, half up.
    fn round(&mut self, x: &BigRational, extra_fraction: u32) -> i64 {
        let scaled = x * BigRational::from_integer(BigInt::one() << extra_fraction);
        let half = BigRational::new(BigInt::one(), BigInt::from(2));
        let rounded = (&scaled + half).floor();
        let change = (&scaled - &rounded).to_f64().unwrap_or(0.0).abs();
        self.rounded += usize::from(!scaled.is_integer());
        self.largest = self.largest.max(change);
        rounded.to_integer().to_i64().expect("the rules are convex, so the result is as small as the input")
    }
}

type Point = [BigRational; 3];

/// The polygon mesh with its exact arithmetic.
struct Polygons<'a> {
    topology: &'a Topology,
    positions: &'a [[i64; 3]],
    corners: Corners,
}

fn fraction(numerator: i64, denominator: i64) -> BigRational {
    BigRational::new(numerator.into(), denominator.into())
}

/// Sum of weight * point.
fn combine<'a>(terms: impl IntoIterator<Item = (BigRational, &'a Point)>) -> Point {
    let mut sum: Point = std::array::from_fn(|_| BigRational::zero());
    for (weight, point) in terms {
        for (sum, x) in sum.iter_mut().zip(point) {
            *sum += &weight * x;
        }
    }
    sum
}

impl Polygons<'_> {
    /// Positions of the new vertices, edges and faces, in this order.
    fn subdivided(&self) -> Vec<Point> {
        let t = self.topology;
        let old: Vec<Point> =
            self.positions.iter().map(|p| p.map(|x| BigRational::from_integer(x.into()))).collect();
        let face = |f: u32| {
            let corners = t.corners(f);
            let weight = fraction(1, corners.len() as i64);
            combine(corners.iter().map(|&v| (weight.clone(), &old[v as usize])))
        };
        let faces: Vec<Point> = (0..t.face_count()).map(face).collect();
        let edge = |e: crate::mesh::topology::Edge| {
            let ends = e.vertices.map(|v| &old[v as usize]);
            match e.faces {
                (f, Some(g)) => {
                    let of = [ends[0], ends[1], &faces[f as usize], &faces[g as usize]];
                    combine(of.map(|p| (fraction(1, 4), p)))
                }
                _ => combine(ends.map(|p| (fraction(1, 2), p))),
            }
        };
        let edges: Vec<Point> = t.edges().map(edge).collect();
        let vertices = (0..t.vertex_count()).map(|v| self.vertex(v, &old, &faces));
        vertices.chain(edges.iter().cloned()).chain(faces.iter().cloned()).collect()
    }

    fn vertex(&self, v: u32, old: &[Point], faces: &[Point]) -> Point {
        let (t, s) = (self.topology, &old[v as usize]);
        let d = i64::from(t.valence(v));
        if t.is_boundary(v) {
            if d == 2 && self.corners == Corners::Sharp {
                return s.clone();
            }
            let ring: Vec<u32> = t.ring(v).collect();
            let ends = [ring[0], ring[d as usize - 1]].map(|a| (fraction(1, 8), &old[a as usize]));
            return combine(ends.into_iter().chain([(fraction(3, 4), s)]));
        }
        let around = t.faces_around(v).map(|f| &faces[f as usize]);
        let ring = t.ring(v).map(|a| &old[a as usize]);
        let outer = around.chain(ring).map(|p| (fraction(1, d * d), p));
        combine(outer.chain([(fraction(d - 2, d), s)]))
    }
}

/// Corner by corner, from the old vertex around: vertex, edge ahead, face, edge behind.
fn quads(t: &Topology) -> Vec<[u32; 4]> {
    let (edges, faces) = (t.vertex_count(), t.vertex_count() + t.edge_count());
    let quad =
        |h: u32| [t.origin(h), edges + t.edge_of(h), faces + t.face_of(h), edges + t.edge_of(t.prev(h))];
    (0..t.half_edge_count()).map(quad).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Format;
    use crate::mesh::{quantise, shape};

    fn of_shape(name: &str, extra_fraction: u32) -> Control {
        let mesh = shape(name).unwrap();
        let quantised = quantise(&mesh, Format::new(2, 12).unwrap()).unwrap();
        control(&mesh, &quantised, Corners::Smooth, extra_fraction).unwrap()
    }

    #[test]
    fn quads_stay_as_they_are() {
        let cube = of_shape("cube-quads", 0);
        assert_eq!((cube.step, cube.mesh.quads().len()), (None, 6));
        assert_eq!(of_shape("cube-quads", 4).mesh.positions()[0], cube.mesh.positions()[0].map(|x| x * 16));
    }

    #[test]
    fn a_tetrahedron_becomes_twelve_quads_with_the_known_positions() {
        let mesh = Mesh::new(
            "t",
            [[0., 0., 0.], [36., 0., 0.], [0., 36., 0.], [0., 0., 36.]].map(DVec3::from_array).to_vec(),
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.to_vec()).to_vec(),
        );
        let quantised = quantise(&mesh, Format::new(8, 0).unwrap()).unwrap();
        let control = control(&mesh, &quantised, Corners::Smooth, 0).unwrap();
        let p = control.mesh.positions();
        // F of (0 2 1) = (12, 12, 0); E of 0-1 = ((12,12,0) + (12,0,12) + (36,0,0))/4 = (15, 3, 3)
        assert_eq!((p[4 + 6], p[4 + 2]), ([12, 12, 0], [15, 3, 3]));
        // V0 = (sum F + sum A)/9 + V0/3 = ((24, 24, 24) + (36, 36, 36))/9 = 6.67 -> 7
        assert_eq!(p[0], [7, 7, 7]);
        let step = control.step.unwrap();
        assert_eq!((step.rounded, p.len(), control.mesh.quads().len()), (3 + 9 - 3, 14, 12));
        assert!((step.largest - 1.0 / 3.0).abs() < 1e-9);
        assert_eq!(control.mesh.topology().valence(0), 3);
        assert_eq!((control.origin(4), control.origin(10)), (Origin::Edge(0), Origin::Face(0)));
    }

    #[test]
    fn more_fraction_bits_round_less() {
        let (coarse, fine) = (of_shape("blob", 0).step.unwrap(), of_shape("blob", 16).step.unwrap());
        assert!(coarse.largest <= 0.5 && fine.largest <= 0.5 && fine.rounded <= coarse.rounded);
        let (coarse, fine) = (of_shape("blob", 0).mesh, of_shape("blob", 16).mesh);
        for (p, q) in coarse.positions().iter().flatten().zip(fine.positions().iter().flatten()) {
            assert!((p - ((q + (1 << 15)) >> 16)).abs() <= 1);
        }
    }

    #[test]
    fn a_valence_that_is_too_large_names_the_vertex() {
        let mesh = shape("bipyramid-32").unwrap();
        let quantised = quantise(&mesh, Format::new(2, 12).unwrap()).unwrap();
        let control = control(&mesh, &quantised, Corners::Smooth, 0).unwrap();
        let error = control.check_valences(&mesh, 16).unwrap_err();
        assert!(error.what.starts_with("vertex 0 has 32 edges"), "{error}");
        assert!(error.help.unwrap().contains("--max-valence"));
        assert!(control.check_valences(&mesh, 32).is_ok());
    }

    #[test]
    fn a_boundary_vertex_without_ghosts_is_named() {
        let mesh = shape("disc").unwrap();
        let quantised = quantise(&mesh, Format::new(2, 12).unwrap()).unwrap();
        let control = control(&mesh, &quantised, Corners::Smooth, 0).unwrap();
        let error = control.check_boundary(&mesh, Boundary::Ghosts).unwrap_err();
        assert!(error.what.contains("edges") && error.place.unwrap().starts_with("disc, vertex"));
        assert!(control.check_boundary(&mesh, Boundary::Rim).is_ok());
    }

    #[test]
    fn the_edge_that_completes_a_boundary_vertex_counts() {
        let error =
            of_shape("square-quads", 0).check_valences(&shape("square-quads").unwrap(), 3).unwrap_err();
        assert!(error.what.contains("4 edges, one beyond the boundary counted"), "{error}");
    }

    use glam::DVec3;
}
