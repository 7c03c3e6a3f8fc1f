//! Walks around a vertex.

use super::Topology;

/// The half-edges that leave a vertex, counterclockwise, one in each face.
#[derive(Clone, Debug)]
pub struct HalfEdges<'a> {
    topology: &'a Topology,
    first: u32,
    next: Option<u32>,
}

impl<'a> HalfEdges<'a> {
    pub(super) fn new(topology: &'a Topology, first: u32) -> Self {
        HalfEdges { topology, first, next: Some(first) }
    }
}

impl Iterator for HalfEdges<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let current = self.next?;
        let following = self.topology.opposite(self.topology.prev(current));
        self.next = following.filter(|&following| following != self.first);
        Some(current)
    }
}

/// The faces around a vertex, counterclockwise.
#[derive(Clone, Debug)]
pub struct Faces<'a>(pub(super) HalfEdges<'a>);

impl Iterator for Faces<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let half_edge = self.0.next()?;
        Some(self.0.topology.face_of(half_edge))
    }
}

/// The neighbours of a vertex, counterclockwise.
#[derive(Clone, Debug)]
pub struct Ring<'a> {
    half_edges: HalfEdges<'a>,
    /// The last neighbour of an open fan, which no half-edge of the fan points to.
    last: Option<u32>,
    left: usize,
}

impl<'a> Ring<'a> {
    pub(super) fn new(half_edges: HalfEdges<'a>) -> Self {
        let topology = half_edges.topology;
        let left = topology.valence(topology.origin(half_edges.first)) as usize;
        Ring { half_edges, last: None, left }
    }
}

impl Iterator for Ring<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let Some(half_edge) = self.half_edges.next() else {
            let last = self.last.take()?;
            self.left -= 1;
            return Some(last);
        };
        let topology = self.half_edges.topology;
        let incoming = topology.prev(half_edge);
        if topology.opposite(incoming).is_none() {
            self.last = Some(topology.origin(incoming));
        }
        self.left -= 1;
        Some(topology.destination(half_edge))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl ExactSizeIterator for Ring<'_> {}
