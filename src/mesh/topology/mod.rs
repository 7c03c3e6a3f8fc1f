//! Who is next to whom: the half-edge structure of a manifold mesh, with or without boundary.
//!
//! Every corner of every face owns the half-edge that leaves it along the face. Half-edges are numbered face
//! by face, so `next` and `prev` are arithmetic and only the opposites are stored.
//!
//! ```text
//!            z                 around v, counterclockwise seen from outside:
//!          ╱ ▲ ╲                 h = v→a  lies in face (v a z)
//!        ╱   │   ╲               prev(h) = z→v, its opposite is v→z: the next one
//!      ╱  f  │  g  ╲           ring(v) = a, z, b ...
//!     ▼ h    │      ╲          on a boundary the first half-edge has no opposite,
//!    a ◄──── v ────► b         so the ring runs from one boundary neighbour to the other
//! ```
//!
//! Vertices, faces, edges and half-edges are `u32`; edges are numbered by their first half-edge.

mod build;
mod count;
mod fan;

pub use count::ValenceCount;
pub use fan::{Faces, HalfEdges, Ring};

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::ops::{Range, RangeInclusive};

/// Marks "no half-edge"; `Mesh::check` keeps real numbers below.
const NONE: u32 = u32::MAX;

/// The adjacency of an oriented manifold polygon mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Half-edge h of face f: `first[f] <= h < first[f + 1]`.
    first: Vec<u32>,
    origin: Vec<u32>,
    face_of: Vec<u32>,
    opposite: Vec<u32>,
    edge_of: Vec<u32>,
    /// The first half-edge of each edge.
    edges: Vec<u32>,
    /// The half-edge that each vertex begins its fan with.
    outgoing: Vec<u32>,
    valence: Vec<u32>,
}

/// An edge, seen along its first half-edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub id: u32,
    /// The first half-edge, from `vertices[0]` to `vertices[1]` along `faces.0`.
    pub half_edge: u32,
    pub vertices: [u32; 2],
    /// The face to the left, and the one to the right unless this is the boundary.
    pub faces: (u32, Option<u32>),
}

impl Topology {
    /// Finds the adjacency of a mesh.
    ///
    /// # Errors
    /// Refuses, with the element, its file and line, and a remedy: whatever [`Mesh::check`] refuses; an edge
    /// of more than two faces; two faces that run along an edge in the same direction (orientation), and a face
    /// that is there twice; a vertex that joins two fans of faces; a vertex that no face uses (readers have
    /// removed those already).
    pub fn new(mesh: &Mesh) -> Result<Self> {
        build::topology(mesh)
    }

    pub fn vertex_count(&self) -> u32 {
        self.outgoing.len() as u32
    }

    pub fn face_count(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    pub fn edge_count(&self) -> u32 {
        self.edges.len() as u32
    }

    pub fn half_edge_count(&self) -> u32 {
        self.origin.len() as u32
    }

    /// The half-edges of a face in order; the i-th leaves the i-th corner.
    pub fn half_edges(&self, face: u32) -> Range<u32> {
        self.first[face as usize]..self.first[face as usize + 1]
    }

    /// The corners of a face, counterclockwise.
    pub fn corners(&self, face: u32) -> &[u32] {
        let Range { start, end } = self.half_edges(face);
        &self.origin[start as usize..end as usize]
    }

    /// The half-edge that follows along the face.
    pub fn next(&self, half_edge: u32) -> u32 {
        let Range { start, end } = self.half_edges(self.face_of(half_edge));
        if half_edge + 1 == end { start } else { half_edge + 1 }
    }

    /// The half-edge before along the face.
    pub fn prev(&self, half_edge: u32) -> u32 {
        let Range { start, end } = self.half_edges(self.face_of(half_edge));
        if half_edge == start { end - 1 } else { half_edge - 1 }
    }

    pub fn origin(&self, half_edge: u32) -> u32 {
        self.origin[half_edge as usize]
    }

    pub fn destination(&self, half_edge: u32) -> u32 {
        self.origin(self.next(half_edge))
    }

    pub fn face_of(&self, half_edge: u32) -> u32 {
        self.face_of[half_edge as usize]
    }

    /// The same edge in the other direction, along the other face; nothing on the boundary.
    pub fn opposite(&self, half_edge: u32) -> Option<u32> {
        Some(self.opposite[half_edge as usize]).filter(|&opposite| opposite != NONE)
    }

    pub fn edge_of(&self, half_edge: u32) -> u32 {
        self.edge_of[half_edge as usize]
    }

    pub fn edge(&self, id: u32) -> Edge {
        let half_edge = self.edges[id as usize];
        let right = self.opposite(half_edge).map(|opposite| self.face_of(opposite));
        Edge {
            id,
            half_edge,
            vertices: [self.origin(half_edge), self.destination(half_edge)],
            faces: (self.face_of(half_edge), right),
        }
    }

    pub fn edges(&self) -> impl ExactSizeIterator<Item = Edge> {
        (0..self.edge_count()).map(|id| self.edge(id))
    }

    /// The face across each edge of a face, in the order of its half-edges.
    pub fn face_neighbours(&self, face: u32) -> impl ExactSizeIterator<Item = Option<u32>> {
        self.half_edges(face).map(|half_edge| Some(self.face_of(self.opposite(half_edge)?)))
    }

    /// The number of edges at a vertex.
    pub fn valence(&self, vertex: u32) -> u32 {
        self.valence[vertex as usize]
    }

    pub fn is_boundary(&self, vertex: u32) -> bool {
        self.opposite(self.outgoing[vertex as usize]).is_none()
    }

    /// The half-edge from which the fan of a vertex begins; on the boundary, the first of the open fan.
    pub fn outgoing(&self, vertex: u32) -> u32 {
        self.outgoing[vertex as usize]
    }

    /// The half-edges that leave a vertex, counterclockwise: one in each face around it.
    pub fn half_edges_around(&self, vertex: u32) -> HalfEdges<'_> {
        self.half_edges_from(self.outgoing(vertex))
    }

    /// The same from a given half-edge on. On the boundary it ends at the boundary, and the half-edges
    /// clockwise of the given one are left out.
    pub fn half_edges_from(&self, half_edge: u32) -> HalfEdges<'_> {
        HalfEdges::new(self, half_edge)
    }

    /// The faces around a vertex, counterclockwise.
    pub fn faces_around(&self, vertex: u32) -> Faces<'_> {
        Faces(self.half_edges_around(vertex))
    }

    /// The neighbours of a vertex, counterclockwise seen from outside: `valence` of them. A closed ring for an
    /// interior vertex; on the boundary from one boundary neighbour to the other.
    pub fn ring(&self, vertex: u32) -> Ring<'_> {
        Ring::new(self.half_edges_around(vertex))
    }

    /// Checks that every vertex has a valence that a scheme handles.
    ///
    /// # Errors
    /// Names the first vertex outside `interior` or, on a boundary, outside `boundary`. `mesh` is the one
    /// that this adjacency was made of.
    pub fn check_valences(
        &self,
        mesh: &Mesh,
        interior: RangeInclusive<u32>,
        boundary: RangeInclusive<u32>,
    ) -> Result<()> {
        for v in 0..self.vertex_count() {
            let (allowed, kind) =
                if self.is_boundary(v) { (&boundary, "boundary") } else { (&interior, "interior") };
            if !allowed.contains(&self.valence(v)) {
                let what = format!(
                    "{kind} vertex {} has {} edges, and {} to {} are handled",
                    mesh.vertex_number(v),
                    self.valence(v),
                    allowed.start(),
                    allowed.end()
                );
                return Err(Error::input(what)
                    .at(mesh.vertex_place(v))
                    .help("split or collapse edges around the vertex in a modeller"));
            }
        }
        Ok(())
    }
}
