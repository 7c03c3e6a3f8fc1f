//! The operators of level 1 of the paper's hierarchy: S subdivides a patch, P_m and P_0..P_2 select its parts.
//!
//! ```text
//!             k                    m_k = midpoint of (k, q)     q = k+1
//!            / \                   m_p = midpoint of (p, k)     p = k+2
//!         m_p---m_k                P_k: corners m_k, m_p, v_k (the old corner on top, as corner 2)
//!         / \Pm / \                P_m: corners m_0, m_1, m_2
//!        p---m_q---q
//! ```
//!
//! Source: Bischoff, Kobbelt, Seidel 2000, appendix A.2 and A.3 (which leaves the P maps to the reader).
//! After S, ring entry j of corner k is the new vertex on the edge from k to its old neighbour j, so the
//! midpoint of (k, q) is the last entry of ring k and the first of ring q.

use crate::surface::arithmetic::Arithmetic;
use crate::surface::cmesh::CMesh;

/// S: one subdivision step of the patch `m` into `d`; valences and gaps stay.
pub fn subdivide<A: Arithmetic>(a: &A, m: &CMesh<A::Point>, d: &mut CMesh<A::Point>) {
    for (new, old) in d.corner.iter_mut().zip(&m.corner) {
        let (v, ring, n) = (&old.centre, old.ring(), old.valence());
        let centre = match old.h() {
            None => a.vertex(v, ring),
            Some(h) => a.boundary_vertex(&ring[h - 1], v, &ring[h]),
        };
        new.fill_like(old, centre, |j| match old.h() {
            Some(h) if j == h || j + 1 == h => a.boundary_edge(v, &ring[j]),
            _ => {
                let (after, before) =
                    (if j + 1 == n { 0 } else { j + 1 }, if j == 0 { n - 1 } else { j - 1 });
                a.edge(v, &ring[j], &ring[after], &ring[before])
            }
        });
    }
}

/// The points around the midpoint of edge (k, k+1) of a subdivided patch.
struct Midpoint<'a, P> {
    /// The midpoint itself.
    m: &'a P,
    /// Corner k.
    v: &'a P,
    /// Across the edge, next to corner k and next to corner k+1; none at a boundary edge.
    across: Option<(&'a P, &'a P)>,
}

fn midpoints<P: Clone>(d: &CMesh<P>) -> [Midpoint<'_, P>; 3] {
    std::array::from_fn(|k| {
        let (corner, next) = (&d.corner[k], &d.corner[(k + 1) % 3]);
        let (ring, n) = (corner.ring(), corner.valence());
        let across = (!corner.next_edge_is_boundary()).then(|| (&ring[n - 2], &next.ring()[1]));
        Midpoint { m: &ring[n - 1], v: &corner.centre, across }
    })
}

/// P_m: the middle triangle of the subdivided patch `d`.
pub fn select_middle<P: Clone + Default>(d: &CMesh<P>, out: &mut CMesh<P>) {
    let mid = midpoints(d);
    for k in 0..3 {
        let (at, q, p) = (&mid[k], &mid[(k + 1) % 3], &mid[(k + 2) % 3]);
        match at.across {
            Some((x, y)) => out.corner[k].set(at.m, &[p.m, at.v, x, y, q.v, q.m], None),
            None => out.corner[k].set(at.m, &[p.m, at.v, q.v, q.m], Some(2)),
        }
    }
}

/// P_k: the triangle of the subdivided patch `d` at its corner `k`, with that corner on top (as corner 2).
pub fn select_corner<P: Clone + Default>(d: &CMesh<P>, k: usize, out: &mut CMesh<P>) {
    let mid = midpoints(d);
    let (at, q, p) = (&mid[k], &mid[(k + 1) % 3], &mid[(k + 2) % 3]);
    match at.across {
        Some((x, y)) => out.corner[0].set(at.m, &[at.v, x, y, q.v, q.m, p.m], None),
        None => out.corner[0].set(at.m, &[at.v, q.v, q.m, p.m], Some(1)),
    }
    match p.across {
        Some((x, y)) => out.corner[1].set(p.m, &[at.m, q.m, p.v, x, y, at.v], None),
        None => out.corner[1].set(p.m, &[at.m, q.m, p.v, at.v], Some(3)),
    }
    out.corner[2].copy_from(&d.corner[k]);
}
