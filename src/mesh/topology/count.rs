//! The mesh as a whole: boundary loops, components, Euler characteristic, genus, valences.
//!
//! ```text
//! V - E + F = sum over components of (2 - 2 genus - boundary loops)
//! ```

use super::Topology;
use std::collections::BTreeMap;

/// How many vertices have a valence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ValenceCount {
    pub interior: u32,
    pub boundary: u32,
}

impl Topology {
    /// The boundary, one loop of vertices each, as the half-edges of the faces run (the surface to the left).
    /// Loops and their beginnings are ordered by half-edge.
    pub fn boundary_loops(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.half_edge_count() as usize];
        let mut loops = Vec::new();
        for start in 0..self.half_edge_count() {
            let mut border = Vec::new();
            let mut h = start;
            while self.opposite(h).is_none() && !seen[h as usize] {
                seen[h as usize] = true;
                border.push(self.origin(h));
                // On a boundary vertex the open fan begins at the half-edge that leaves along the boundary.
                h = self.outgoing(self.destination(h));
            }
            if !border.is_empty() {
                loops.push(border);
            }
        }
        loops
    }

    /// The component of each face; components are numbered by their first face.
    pub fn components(&self) -> Vec<u32> {
        const UNSEEN: u32 = u32::MAX;
        let mut component = vec![UNSEEN; self.face_count() as usize];
        let mut count = 0;
        let mut open = Vec::new();
        for face in 0..self.face_count() {
            if component[face as usize] != UNSEEN {
                continue;
            }
            component[face as usize] = count;
            open.push(face);
            while let Some(face) = open.pop() {
                for neighbour in self.face_neighbours(face).flatten() {
                    if component[neighbour as usize] == UNSEEN {
                        component[neighbour as usize] = count;
                        open.push(neighbour);
                    }
                }
            }
            count += 1;
        }
        component
    }

    pub fn component_count(&self) -> u32 {
        self.components().iter().max().map_or(0, |last| last + 1)
    }

    /// V - E + F.
    pub fn euler_characteristic(&self) -> i64 {
        i64::from(self.vertex_count()) - i64::from(self.edge_count()) + i64::from(self.face_count())
    }

    /// The number of handles, over all components.
    pub fn genus(&self) -> u32 {
        let loops = self.boundary_loops().len() as i64;
        let twice = 2 * i64::from(self.component_count()) - self.euler_characteristic() - loops;
        (twice / 2) as u32 // an oriented surface: even and never negative
    }

    pub fn valence_histogram(&self) -> BTreeMap<u32, ValenceCount> {
        let mut histogram = BTreeMap::<u32, ValenceCount>::new();
        for v in 0..self.vertex_count() {
            let count = histogram.entry(self.valence(v)).or_default();
            *(if self.is_boundary(v) { &mut count.boundary } else { &mut count.interior }) += 1;
        }
        histogram
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use glam::DVec3;

    fn topology(vertices: usize, faces: &[&[u32]]) -> Topology {
        let faces = faces.iter().map(|face| face.to_vec()).collect();
        Topology::new(&Mesh::new("m", vec![DVec3::ZERO; vertices], faces)).unwrap()
    }

    /// ```text
    /// 6 ─ 7 ─ 8
    /// │ 2 │ 3 │
    /// 3 ─ 4 ─ 5
    /// │ 0 │ 1 │
    /// 0 ─ 1 ─ 2
    /// ```
    fn four_quads() -> Topology {
        topology(9, &[&[0, 1, 4, 3], &[1, 2, 5, 4], &[3, 4, 7, 6], &[4, 5, 8, 7]])
    }

    #[test]
    fn rings_run_counterclockwise_open_ones_from_boundary_to_boundary() {
        let t = four_quads();
        let mut ring: Vec<u32> = t.ring(4).collect();
        let one = ring.iter().position(|&v| v == 1).unwrap();
        ring.rotate_left(one);
        assert_eq!(ring, [1, 5, 7, 3]);
        assert_eq!(t.ring(1).collect::<Vec<_>>(), [2, 4, 0]);
        assert_eq!(t.ring(0).collect::<Vec<_>>(), [1, 3]);
        assert_eq!((t.ring(1).len(), t.valence(1), t.is_boundary(1), t.is_boundary(4)), (3, 3, true, false));
        assert_eq!(t.faces_around(1).collect::<Vec<_>>(), [1, 0]);
    }

    #[test]
    fn a_ring_can_begin_at_any_face() {
        let t = four_quads();
        let h = t.half_edges(3).find(|&h| t.origin(h) == 4).unwrap();
        let ring: Vec<u32> = t.half_edges_from(h).map(|h| t.destination(h)).collect();
        assert_eq!(ring, [5, 7, 3, 1]);
    }

    #[test]
    fn edges_know_their_faces() {
        let t = four_quads();
        assert_eq!(t.edge_count(), 12);
        let inner = t.edges().find(|edge| edge.vertices == [1, 4]).unwrap();
        assert_eq!(inner.faces, (0, Some(1)));
        assert_eq!(t.edge_of(t.opposite(inner.half_edge).unwrap()), inner.id);
        assert_eq!(t.edges().filter(|edge| edge.faces.1.is_none()).count(), 8);
        assert_eq!(t.face_neighbours(0).collect::<Vec<_>>(), [None, Some(1), Some(2), None]);
    }

    #[test]
    fn the_boundary_runs_once_around_with_the_surface_to_the_left() {
        assert_eq!(four_quads().boundary_loops(), [[0, 1, 2, 5, 8, 7, 6, 3]]);
    }

    #[test]
    fn components_and_genus_of_a_disc_and_a_sphere() {
        let t = topology(7, &[&[0, 1, 2], &[3, 4, 5], &[3, 5, 6], &[3, 6, 4], &[4, 6, 5]]);
        assert_eq!(t.components(), [0, 1, 1, 1, 1]);
        assert_eq!((t.component_count(), t.euler_characteristic(), t.genus()), (2, 3, 0));
    }

    #[test]
    fn a_torus_of_nine_quads_has_one_handle() {
        let v = |x: u32, y: u32| 3 * (y % 3) + x % 3;
        let quads: Vec<[u32; 4]> = (0..9)
            .map(|i| (i % 3, i / 3))
            .map(|(x, y)| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
            .collect();
        let quads: Vec<&[u32]> = quads.iter().map(|quad| &quad[..]).collect();
        let t = topology(9, &quads);
        assert_eq!((t.euler_characteristic(), t.genus(), t.boundary_loops().len()), (0, 1, 0));
        let expected = BTreeMap::from([(4, ValenceCount { interior: 9, boundary: 0 })]);
        assert_eq!(t.valence_histogram(), expected);
    }

    #[test]
    fn valences_out_of_range_are_refused_with_the_vertex() {
        let faces = vec![vec![0, 1, 2], vec![2, 1, 0]];
        let pillow = Mesh::new("pillow", vec![DVec3::ZERO; 3], faces);
        let t = Topology::new(&pillow).unwrap();
        let error = t.check_valences(&pillow, 3..=32, 2..=32).unwrap_err();
        assert_eq!(error.what, "interior vertex 0 has 2 edges, and 3 to 32 are handled");
        assert_eq!(error.place.as_deref(), Some("pillow, vertex 0"));
        assert!(t.check_valences(&pillow, 2..=32, 2..=32).is_ok());
    }
}
