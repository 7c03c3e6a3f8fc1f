//! The full ring of every vertex: neighbours and diagonals, counterclockwise, with what a boundary lacks.
//!
//! ```text
//!   Ghosts                               Repeated                   Rim
//!     g(A)── g ──g(B)   g = 2V - I         A ── V ── B                no ghosts: the ring has a gap
//!      │     │     │                       │    │    │
//!   ───A──── V ────B─── boundary        ───A─── V ───B───          ───A──── V ────B───
//!      │     │     │                       │    │    │                │     │     │
//!            I                                  I                           I
//! ```
//!
//! * `Ghosts`: a boundary vertex with one inner edge (three edges) gets the ghost 2V - I. The interior rules
//!   then reproduce the boundary rules, and the new ghosts are again 2V' - I', exactly and at every level:
//!   F + Fo = A + B, so E = (A + B)/2, V' = (A + 6V + B)/8, and the limit is (A + 4V + B)/6.
//!   A corner, with two edges, gets 2V - A, 2V - B and, beyond both, D + 4V - 2A - 2B: it stays where it is
//!   and its boundary edges are splines that end there ([`Corners::Sharp`]).
//! * `Repeated`: the ghost is V itself, and a corner is repeated three times (Hall, section 4.3), for every
//!   number of edges. The surface is another one: it shrinks away from the boundary row.
//! * `Rim`: no ghosts. The records of the strips say where the gap is, and the strip engine needs the boundary
//!   rules (`Corners::Smooth`, every number of edges from two on).
//!
//! Why ghosts cannot do more: they would make the half ring of a boundary vertex with n edges a part of a closed
//! ring whose step commutes with it, so the eigenvalues and Jordan blocks of the half ring's step would be among
//! those of the closed ring's. But the half ring has a block of the eigenvalue 1/4 for even n (the corner with
//! (A + 6V + B)/8 included) and of 1/2 for n = 5, 9, ..., and a closed ring has none of either. That leaves n = 3
//! and n = 7, whose inner eigenvalues only a valence of 12 has (cos(2 pi k/d) = cos(pi j/6)).

use crate::error::{Error, Result};
use crate::surface::catmull_clark::masks::Corners;
use crate::surface::catmull_clark::quad_mesh::{QuadMesh, width};

/// What completes the ring of a boundary vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Reflected ghosts: no boundary case in hardware; two (sharp corner) or three edges only.
    Ghosts,
    /// Repeated vertices: no boundary case in hardware; a surface that lies inside of its boundary row.
    Repeated,
    /// Gaps, which the strip engine fills by the boundary rules.
    Rim,
}

impl Boundary {
    /// The rule of corners that global refinement must take to come to the same surface.
    pub fn corners(self) -> Corners {
        match self {
            Boundary::Ghosts => Corners::Sharp,
            Boundary::Repeated | Boundary::Rim => Corners::Smooth,
        }
    }
}

/// A neighbour, and the diagonal of the face between it and the next neighbour counterclockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spoke {
    pub neighbour: u32,
    /// None: the gap of the boundary lies here.
    pub diagonal: Option<u32>,
}

/// The rings of all vertices over the positions of vertices and ghosts.
#[derive(Clone, Debug)]
pub struct Rings {
    positions: Vec<[i64; 3]>,
    spokes: Vec<Spoke>,
    /// Where the ring of each vertex starts in `spokes`; one entry more than there are vertices.
    start: Vec<u32>,
}

impl Rings {
    /// # Errors
    /// `Ghosts`: names a boundary vertex with more than three edges, and what to do.
    pub fn new(mesh: &QuadMesh, boundary: Boundary) -> Result<Self> {
        let mut rings = Rings { positions: mesh.positions().to_vec(), spokes: Vec::new(), start: Vec::new() };
        let ghosts = rings.add_ghosts(mesh, boundary)?;
        for v in 0..mesh.vertex_count() as u32 {
            rings.start.push(rings.spokes.len() as u32);
            rings.push_ring(mesh, v, &ghosts);
        }
        rings.start.push(rings.spokes.len() as u32);
        Ok(rings)
    }

    /// Positions by number: the vertices of the mesh, then the ghosts.
    pub fn positions(&self) -> &[[i64; 3]] {
        &self.positions
    }

    /// The bits that the coordinates of vertices and ghosts need in two's complement.
    pub fn width(&self) -> u32 {
        width(&self.positions)
    }

    /// The ring of a vertex of the mesh, counterclockwise.
    pub fn ring(&self, vertex: u32) -> &[Spoke] {
        let v = vertex as usize;
        &self.spokes[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// The largest number of edges at a vertex, ghosts counted.
    pub fn largest_valence(&self) -> usize {
        self.start.windows(2).map(|w| (w[1] - w[0]) as usize).max().unwrap_or(0)
    }

    /// Makes the ghosts of each boundary vertex: [first, last, beyond], where `first` lies across the boundary
    /// edge that begins the open ring and `last` across the one that ends it.
    fn add_ghosts(&mut self, mesh: &QuadMesh, boundary: Boundary) -> Result<Vec<Option<[u32; 3]>>> {
        let topology = mesh.topology();
        let mut ghosts = vec![None; mesh.vertex_count()];
        if boundary == Boundary::Rim {
            return Ok(ghosts);
        }
        for v in (0..topology.vertex_count()).filter(|&v| topology.is_boundary(v)) {
            let p = mesh.positions()[v as usize];
            let ring: Vec<[i64; 3]> = topology.ring(v).map(|a| mesh.positions()[a as usize]).collect();
            let first = self.positions.len() as u32;
            let combine = |terms: &[(i64, [i64; 3])]| {
                std::array::from_fn(|x| terms.iter().map(|(weight, q)| weight * q[x]).sum())
            };
            let made: Vec<[i64; 3]> = match (boundary, ring.as_slice()) {
                (Boundary::Ghosts, &[a, b]) => {
                    let opposite = topology.next(topology.next(topology.outgoing(v)));
                    let d = mesh.positions()[topology.origin(opposite) as usize];
                    let across = [combine(&[(2, p), (-1, b)]), combine(&[(2, p), (-1, a)])];
                    vec![across[0], across[1], combine(&[(4, p), (1, d), (-2, a), (-2, b)])]
                }
                (Boundary::Ghosts, &[_, inner, _]) => vec![combine(&[(2, p), (-1, inner)])],
                (Boundary::Ghosts, _) => return Err(no_ghost(v, topology.valence(v))),
                (_, &[_, _]) => vec![p; 3],
                _ => vec![p],
            };
            ghosts[v as usize] =
                Some(if made.len() == 1 { [first; 3] } else { [first, first + 1, first + 2] });
            self.positions.extend(made);
        }
        Ok(ghosts)
    }

    fn push_ring(&mut self, mesh: &QuadMesh, v: u32, ghosts: &[Option<[u32; 3]>]) {
        let topology = mesh.topology();
        for h in topology.half_edges_around(v) {
            let diagonal = Some(topology.destination(topology.next(h)));
            self.spokes.push(Spoke { neighbour: topology.destination(h), diagonal });
        }
        if !topology.is_boundary(v) {
            return;
        }
        let last = topology.ring(v).last().expect("a vertex has two neighbours at least");
        let ghost = |v: u32| ghosts[v as usize];
        let Some(own) = ghost(v) else {
            self.spokes.push(Spoke { neighbour: last, diagonal: None });
            return;
        };
        // v is the first in the ring of its last neighbour, and the last in that of its first.
        let first = topology.destination(topology.outgoing(v));
        let [beyond_last, beyond_first] = [ghost(last).map(|g| g[0]), ghost(first).map(|g| g[1])];
        self.spokes.push(Spoke { neighbour: last, diagonal: beyond_last });
        if own[0] != own[1] {
            self.spokes.push(Spoke { neighbour: own[1], diagonal: Some(own[2]) });
        }
        self.spokes.push(Spoke { neighbour: own[0], diagonal: beyond_first });
    }
}

pub(super) fn no_ghost(v: u32, edges: u32) -> Error {
    Error::input(format!("boundary vertex {v} has {edges} edges, and no ghost makes up for its other half"))
        .help("boundary vertices with two or three edges can have ghosts: use an engine with rims, or repeat the boundary vertices")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of 2 x 1 quads.
    fn sheet() -> QuadMesh {
        let positions = vec![[0, 0, 0], [8, 0, 0], [16, 0, 0], [0, 8, 0], [8, 9, 1], [16, 8, 0]];
        QuadMesh::new(positions, vec![[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap()
    }

    #[test]
    fn ghosts_are_reflections() {
        let rings = Rings::new(&sheet(), Boundary::Ghosts).unwrap();
        let at = |spoke: &Spoke| {
            let of = |v: u32| rings.positions()[v as usize];
            [of(spoke.neighbour), of(spoke.diagonal.unwrap())]
        };
        let regular: Vec<_> = rings.ring(1).iter().map(at).collect();
        let expected = [
            [[16, 0, 0], [16, 8, 0]],
            [[8, 9, 1], [0, 8, 0]],
            [[0, 0, 0], [0, -8, 0]],    // beyond the corner 0: 2V - its other neighbour
            [[8, -9, -1], [16, -8, 0]], // 2V - I
        ];
        assert_eq!(regular, expected);
        let corner: Vec<_> = rings.ring(0).iter().map(at).collect();
        let beyond = [8 - 2 * 8, 9 - 2 * 8, 1];
        let expected = [
            [[8, 0, 0], [8, 9, 1]],
            [[0, 8, 0], [-8, 8, 0]],
            [[-8, 0, 0], beyond],
            [[0, -8, 0], [8, -9, -1]],
        ];
        // the ghost of 3 across the edge 3-0 reflects its other neighbour, 4
        assert_eq!(corner[0], expected[0]);
        assert_eq!(corner[1], [[0, 8, 0], [-8, 7, -1]]);
        assert_eq!(corner[2..], expected[2..]);
    }

    #[test]
    fn every_closed_ring_of_faces_is_seen_alike_from_its_corners() {
        for boundary in [Boundary::Ghosts, Boundary::Repeated] {
            let mesh = sheet();
            let rings = Rings::new(&mesh, boundary).unwrap();
            for v in 0..6 {
                let ring = rings.ring(v);
                for (i, spoke) in ring.iter().enumerate() {
                    let (a, x, b) =
                        (spoke.neighbour, spoke.diagonal.unwrap(), ring[(i + 1) % ring.len()].neighbour);
                    if a < 6 {
                        // the face (v, a, x, b) from a: neighbours x then v, diagonal b
                        let seen = rings.ring(a).iter().find(|s| s.neighbour == x);
                        assert_eq!(seen.unwrap().diagonal, Some(b), "{boundary:?} {v} {a}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_rim_has_one_gap() {
        let rings = Rings::new(&sheet(), Boundary::Rim).unwrap();
        let gaps = |v: u32| rings.ring(v).iter().filter(|s| s.diagonal.is_none()).count();
        assert!((0..6).all(|v| gaps(v) == 1));
        assert_eq!((rings.ring(0).len(), rings.ring(1).len()), (2, 3));
    }

    #[test]
    fn four_edges_at_the_boundary_have_no_ghosts() {
        let quads = vec![[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7]];
        let mesh = QuadMesh::new(vec![[0; 3]; 8], quads).unwrap();
        let error = Rings::new(&mesh, Boundary::Ghosts).unwrap_err();
        assert!(error.what.starts_with("boundary vertex 0 has 4 edges"), "{error}");
        assert_eq!(Rings::new(&mesh, Boundary::Repeated).unwrap().ring(0).len(), 5);
    }
}
