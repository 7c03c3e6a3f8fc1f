//! The whole control mesh: integer positions, triangles, and the ring of every vertex.
//!
//! ```text
//!        c2 --- c1              ring of V, counterclockwise: c0, c1, ..., c(n-1)
//!       /  \   /  \             interior: cyclic;  boundary: open, the gap of the boundary lies
//!     c3 --- V --- c0           between c(n-1) and c0, so c0 and c(n-1) are the boundary neighbours
//! ```

use crate::error::{Error, Result};
use crate::surface::table::MAX_VALENCE;

/// Triangles with counterclockwise corners (seen from outside) over integer control points.
///
/// Built by [`ControlMesh::new`], which refuses what is no oriented manifold of valences 3 to 32
/// (2 to 32 at the boundary).
#[derive(Clone, Debug)]
pub struct ControlMesh {
    positions: Vec<[i64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Rings of all vertices, one after the other.
    neighbours: Vec<u32>,
    /// Where the ring of each vertex starts in `neighbours`; one entry more than there are vertices.
    ring_start: Vec<u32>,
    boundary: Vec<bool>,
    /// Undirected edges (low, high), sorted.
    edges: Vec<[u32; 2]>,
    /// Edge of each triangle's sides 0-1, 1-2, 2-0.
    triangle_edges: Vec<[u32; 3]>,
}

/// The ring of one vertex.
#[derive(Clone, Copy, Debug)]
pub struct VertexRing<'a> {
    /// The neighbours, counterclockwise; as many as the valence.
    pub neighbours: &'a [u32],
    /// The vertex lies on the boundary: the gap lies between the last neighbour and the first.
    pub boundary: bool,
}

impl VertexRing<'_> {
    pub fn valence(&self) -> usize {
        self.neighbours.len()
    }

    /// Interior of valence 6 or boundary of valence 4.
    pub fn regular(&self) -> bool {
        self.valence() == if self.boundary { 4 } else { 6 }
    }
}

impl ControlMesh {
    /// # Errors
    /// A corner without position, an edge with more than two triangles or two of the same orientation, a
    /// vertex where two sheets meet, a valence above 32.
    pub fn new(positions: Vec<[i64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        for (f, &[a, b, c]) in triangles.iter().enumerate() {
            if [a, b, c].iter().any(|&v| v as usize >= positions.len()) {
                return Err(Error::input(format!("triangle {f} uses a vertex that does not exist"))
                    .help(format!("vertices are numbered 0 to {}", positions.len() as i64 - 1)));
            }
            if a == b || b == c || c == a {
                return Err(Error::input(format!("triangle {f} ({a}, {b}, {c}) uses a vertex twice"))
                    .help("remove degenerate triangles"));
            }
        }
        let wedges = sorted_wedges(&triangles)?;
        let (edges, triangle_edges) = number_edges(&triangles);
        let mut mesh = ControlMesh {
            neighbours: Vec::with_capacity(wedges.len()),
            ring_start: Vec::with_capacity(positions.len() + 1),
            boundary: Vec::with_capacity(positions.len()),
            positions,
            triangles,
            edges,
            triangle_edges,
        };
        let mut rest = wedges.as_slice();
        for vertex in 0..mesh.positions.len() as u32 {
            let count = rest.iter().take_while(|w| w[0] == vertex).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            mesh.ring_start.push(mesh.neighbours.len() as u32);
            mesh.boundary.push(false);
            if count > 0 {
                mesh.push_ring(vertex, own)?;
            }
        }
        mesh.ring_start.push(mesh.neighbours.len() as u32);
        Ok(mesh)
    }

    /// Walks once around `vertex`. A wedge (V, a, b) says that the triangle V, a, b is counterclockwise.
    fn push_ring(&mut self, vertex: u32, wedges: &[[u32; 3]]) -> Result<()> {
        let starts = |w: &&[u32; 3]| wedges.iter().all(|other| other[2] != w[1]);
        let open = wedges.iter().find(starts);
        let first = open.unwrap_or(&wedges[0])[1];
        let from = self.neighbours.len();
        let mut at = first;
        loop {
            self.neighbours.push(at);
            let Some(wedge) = wedges.iter().find(|w| w[1] == at) else { break };
            at = wedge[2];
            if at == first {
                break;
            }
        }
        let valence = self.neighbours.len() - from;
        let place = format!("vertex {vertex}");
        if valence != wedges.len() + usize::from(open.is_some()) {
            return Err(Error::input("two sheets of the surface meet in one vertex")
                .at(place)
                .help("give each sheet a vertex of its own"));
        }
        if valence > MAX_VALENCE || (open.is_none() && valence < 3) {
            return Err(Error::input(format!("a vertex of valence {valence}"))
                .at(place)
                .help("interior valences 3 to 32 and boundary valences 2 to 32 are supported"));
        }
        if let Some(boundary) = self.boundary.last_mut() {
            *boundary = open.is_some();
        }
        Ok(())
    }

    pub fn positions(&self) -> &[[i64; 3]] {
        &self.positions
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Undirected edges (low, high) in ascending order.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// The edges of triangle `face`: sides 0-1, 1-2, 2-0.
    pub fn triangle_edges(&self, face: usize) -> [u32; 3] {
        self.triangle_edges[face]
    }

    /// The ring of `vertex`; empty when no triangle uses it.
    pub fn ring(&self, vertex: u32) -> VertexRing<'_> {
        let v = vertex as usize;
        let range = self.ring_start[v] as usize..self.ring_start[v + 1] as usize;
        VertexRing { neighbours: &self.neighbours[range], boundary: self.boundary[v] }
    }

    /// The largest interior valence other than 6, if there is one: the vertices that use the [`Table`].
    ///
    /// [`Table`]: crate::surface::table::Table
    pub fn largest_irregular_valence(&self) -> Option<usize> {
        let rings = (0..self.positions.len() as u32).map(|v| self.ring(v));
        rings.filter(|r| !r.boundary && r.valence() > 0 && r.valence() != 6).map(|r| r.valence()).max()
    }

    /// The bits that the coordinates need in two's complement; at least 2.
    pub fn width(&self) -> u32 {
        let bits = |x: &i64| 65 - (x ^ (x >> 63)).leading_zeros();
        self.positions.iter().flatten().map(bits).max().unwrap_or(2).max(2)
    }
}

/// Every triangle seen from each of its corners, (V, a, b), sorted; refuses a directed edge used twice.
fn sorted_wedges(triangles: &[[u32; 3]]) -> Result<Vec<[u32; 3]>> {
    let mut wedges: Vec<[u32; 3]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]).collect();
    wedges.sort_unstable();
    match wedges.windows(2).find(|pair| pair[0][..2] == pair[1][..2]) {
        None => Ok(wedges),
        Some(pair) => Err(Error::input("an edge has two triangles on the same side")
            .at(format!("edge {}-{}", pair[0][0], pair[0][1]))
            .help("orient neighbouring triangles alike and give each edge at most two triangles")),
    }
}

fn number_edges(triangles: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (f, t) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (t[side], t[(side + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], f, side));
        }
    }
    sides.sort_unstable();
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(sides.len());
    let mut triangle_edges = vec![[0; 3]; triangles.len()];
    for (edge, f, side) in sides {
        if edges.last() != Some(&edge) {
            edges.push(edge);
        }
        triangle_edges[f][side] = edges.len() as u32 - 1;
    }
    (edges, triangle_edges)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_has_an_open_ring_that_starts_behind_the_gap() {
        let mesh = ControlMesh::new(vec![[0; 3]; 4], vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let ring = mesh.ring(0);
        assert_eq!((ring.neighbours, ring.boundary), (&[1, 2, 3][..], true));
        assert_eq!(mesh.edges(), [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]);
        assert_eq!(mesh.triangle_edges(1), [1, 4, 2]);
    }

    #[test]
    fn a_tetrahedron_has_closed_rings() {
        let faces = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let mesh = ControlMesh::new(vec![[-5, 3, 0]; 4], faces).unwrap();
        assert_eq!(mesh.ring(0).neighbours, [1, 2, 3]);
        assert!(!mesh.ring(0).boundary);
        assert_eq!((mesh.largest_irregular_valence(), mesh.width()), (Some(3), 4));
    }

    #[test]
    fn what_is_no_manifold_is_refused() {
        let refused = |n: usize, t: &[[u32; 3]]| ControlMesh::new(vec![[0; 3]; n], t.to_vec()).is_err();
        assert!(refused(3, &[[0, 1, 3]]), "missing vertex");
        assert!(refused(3, &[[0, 1, 1]]), "degenerate");
        assert!(refused(4, &[[0, 1, 2], [0, 1, 3]]), "inconsistent orientation");
        assert!(refused(5, &[[0, 1, 2], [0, 3, 4]]), "two sheets in one vertex");
        assert!(refused(3, &[[0, 1, 2], [0, 2, 1]]), "interior valence 2");
        let fan: Vec<_> = (1..33).map(|i| [0, i, i + 1]).collect();
        assert!(refused(34, &fan), "boundary valence 33");
    }

    #[test]
    fn width_counts_the_sign() {
        let width = |x: i64| ControlMesh::new(vec![[x; 3]], vec![]).map(|m| m.width()).unwrap();
        assert_eq!([0, 1, -2, 2, -8, 7, 8].map(width), [2, 2, 2, 3, 4, 4, 5]);
    }
}
