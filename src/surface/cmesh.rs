//! The control mesh of one patch (`CMesh` of Bischoff, Kobbelt, Seidel 2000, appendix A.1) and its gathering.
//!
//! ```text
//!            2                 corner i (i = 0, 1, 2, counterclockwise): centre, ring counterclockwise,
//!           / \                  ring[0]     = centre of corner i-1
//!          /   \                 ring[n-1]   = centre of corner i+1
//!         0 --- 1              h: none, or the gap of the boundary lies between ring[h-1] and ring[h]
//! ```
//!
//! The triangle itself lies between ring[n-1] and ring[0], so 1 <= h <= n-1. Edge (i, i+1) is a boundary
//! edge exactly if h of corner i is n-1, equivalently if h of corner i+1 is 1. Vertices that belong to
//! several rings are stored in each; nothing is special about valence 3, where rings share more entries.

use crate::surface::control_mesh::ControlMesh;
use crate::surface::table::MAX_VALENCE;

/// One corner: its vertex and the ring around it.
#[derive(Clone, Debug)]
pub struct Corner<P> {
    pub centre: P,
    entries: [P; MAX_VALENCE],
    n: usize,
    h: Option<usize>,
}

impl<P: Clone + Default> Default for Corner<P> {
    fn default() -> Self {
        Corner { centre: P::default(), entries: std::array::from_fn(|_| P::default()), n: 0, h: None }
    }
}

impl<P: Clone> Corner<P> {
    /// The ring, counterclockwise; as many points as the valence.
    #[inline]
    pub fn ring(&self) -> &[P] {
        &self.entries[..self.n]
    }

    #[inline]
    pub fn valence(&self) -> usize {
        self.n
    }

    /// None for an interior corner, else the gap of the boundary lies between ring entries h-1 and h.
    #[inline]
    pub fn h(&self) -> Option<usize> {
        self.h
    }

    /// Interior of valence 6 or boundary of valence 4.
    #[inline]
    pub fn regular(&self) -> bool {
        self.n == if self.h.is_some() { 4 } else { 6 }
    }

    /// Whether the edge to the next corner is a boundary edge.
    #[inline]
    pub fn next_edge_is_boundary(&self) -> bool {
        self.h == Some(self.n - 1)
    }

    /// Replaces the corner; `ring` has at most 32 points.
    #[inline]
    pub fn set(&mut self, centre: &P, ring: &[&P], h: Option<usize>) {
        self.centre = centre.clone();
        for (entry, &point) in self.entries.iter_mut().zip(ring) {
            *entry = point.clone();
        }
        (self.n, self.h) = (ring.len(), h);
    }

    /// Makes this corner a copy of another; entries beyond the valence are left alone.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        self.centre = other.centre.clone();
        self.entries[..other.n].clone_from_slice(other.ring());
        (self.n, self.h) = (other.n, other.h);
    }

    /// The same valence and gap as `other`, with points computed from its ring by index.
    #[inline]
    pub(crate) fn fill_like(&mut self, other: &Self, centre: P, mut entry: impl FnMut(usize) -> P) {
        self.centre = centre;
        (self.n, self.h) = (other.n, other.h);
        for (j, slot) in self.entries[..other.n].iter_mut().enumerate() {
            *slot = entry(j);
        }
    }
}

/// The control mesh of one patch.
#[derive(Clone, Debug)]
pub struct CMesh<P> {
    pub corner: [Corner<P>; 3],
}

impl<P: Clone + Default> Default for CMesh<P> {
    fn default() -> Self {
        CMesh { corner: std::array::from_fn(|_| Corner::default()) }
    }
}

impl<P: Clone> CMesh<P> {
    pub fn regular(&self) -> bool {
        self.corner.iter().all(Corner::regular)
    }

    /// Collects the patch of triangle `face`, one point a vertex from `point`.
    pub fn gather(&mut self, mesh: &ControlMesh, face: usize, point: impl Fn(u32) -> P) {
        let triangle = mesh.triangles()[face];
        for (i, corner) in self.corner.iter_mut().enumerate() {
            let around = mesh.ring(triangle[i]);
            let before = triangle[(i + 2) % 3];
            let n = around.valence();
            // Both ends of an edge know each other, so the corner before is in the ring.
            let start = around.neighbours.iter().position(|&v| v == before).unwrap_or(0);
            corner.centre = point(triangle[i]);
            for (j, entry) in corner.entries[..n].iter_mut().enumerate() {
                *entry = point(around.neighbours[(start + j) % n]);
            }
            // The open ring has its gap before entry 0, which rotation moves to n - start.
            corner.h = around.boundary.then_some(n - start);
            corner.n = n;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The patch of `face` with vertex numbers as points.
    fn gathered(triangles: &[[u32; 3]], vertices: usize, face: usize) -> CMesh<u32> {
        let mesh = ControlMesh::new(vec![[0; 3]; vertices], triangles.to_vec()).unwrap();
        let mut patch = CMesh::default();
        patch.gather(&mesh, face, |v| v);
        patch
    }

    #[test]
    fn rings_start_at_the_corner_before_and_end_at_the_corner_after() {
        let patch = gathered(&[[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], 4, 0);
        for i in 0..3 {
            let corner = &patch.corner[i];
            assert_eq!(corner.ring()[0], patch.corner[(i + 2) % 3].centre);
            assert_eq!(corner.ring()[2], patch.corner[(i + 1) % 3].centre);
            assert_eq!((corner.ring()[1], corner.h()), (3, None));
        }
    }

    #[test]
    fn the_gap_of_the_boundary_is_found_from_every_corner() {
        // two triangles with the common edge 0-2: edges 0-1 and 1-2 of the first are boundary edges
        let patch = gathered(&[[0, 1, 2], [0, 2, 3]], 4, 0);
        assert_eq!(patch.corner[0].ring(), [2, 3, 1]);
        assert_eq!(patch.corner.each_ref().map(|c| c.h()), [Some(2), Some(1), Some(1)]);
        assert_eq!(patch.corner.each_ref().map(|c| c.next_edge_is_boundary()), [true, true, false]);
        assert_eq!(patch.corner[2].ring(), [1, 3, 0].map(|v| v), "corner 2: 1, gap, 3, 0");
    }
}
