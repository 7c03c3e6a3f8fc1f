//! A regular patch: its twelve control points, ghosts included.
//!
//! ```text
//!          P10 -- P11
//!         /  \   /  \
//!       P7 --- P8 --- P9            corners: P4 at (0,0), P5 at (1,0), P8 at (0,1)
//!      /  \  // \\  /  \            P0 (0,-1)  P1 (1,-1)  P2 (2,-1)  P3 (-1,0)  P6 (2,0)
//!    P3 --- P4 === P5 --- P6        P7 (-1,1)  P9 (1,1)   P10 (-1,2) P11 (0,2)
//!      \  /   \  /   \  /
//!       P0 --- P1 --- P2            (drawn with the lattice direction (0,1) leaning to the right)
//! ```
//!
//! A boundary corner of valence 4 gets two ghosts by the parallelogram rule, V + B - I across the boundary
//! edge (V, B) with inner opposite vertex I (Bischoff, Kobbelt, Seidel 2000, Figure 4). With these the
//! interior rules equal the boundary rules exactly, at every level.

use crate::surface::arithmetic::Arithmetic;
use crate::surface::cmesh::{CMesh, Corner};

/// Where the control points that are no corners lie: number, corner, entry of its completed ring.
const PLACES: [(usize, usize, usize); 9] =
    [(7, 0, 1), (3, 0, 2), (0, 0, 3), (1, 0, 4), (2, 1, 2), (6, 1, 3), (9, 1, 4), (11, 2, 2), (10, 2, 3)];

/// Writes the twelve control points of a regular patch, numbered row by row. `m` must be regular.
pub fn control_points<A: Arithmetic>(a: &A, m: &CMesh<A::Point>, points: &mut [A::Point; 12]) {
    debug_assert!(m.regular());
    for (number, corner) in [4, 5, 8].into_iter().zip(&m.corner) {
        points[number].clone_from(&corner.centre);
    }
    for (number, corner, entry) in PLACES {
        points[number] = completed_ring(a, &m.corner[corner], entry);
    }
}

/// Entry `j` of the six neighbours of a regular corner; two ghosts fill the gap of a boundary, so that the
/// ring is [.., c(h-1), ghost, ghost, c(h), ..].
#[inline]
fn completed_ring<A: Arithmetic>(a: &A, corner: &Corner<A::Point>, j: usize) -> A::Point {
    let (v, ring) = (&corner.centre, corner.ring());
    match corner.h() {
        Some(h) if j >= h => match j - h {
            0 => a.ghost(v, &ring[h - 1], &ring[(h + 2) % 4]),
            1 => a.ghost(v, &ring[h], &ring[(h + 1) % 4]),
            _ => ring[j - 2].clone(),
        },
        _ => ring[j].clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::arithmetic::Real;
    use crate::surface::control_mesh::ControlMesh;

    /// A sheet of the triangular lattice: vertex (x, y) for 0 <= x, y < size.
    fn sheet(size: u32) -> ControlMesh {
        let at = |x: u32, y: u32| y * size + x;
        let cells = (0..size - 1).flat_map(|y| (0..size - 1).map(move |x| (x, y)));
        let triangles = cells.flat_map(|(x, y)| {
            [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]]
        });
        let positions = (0..size * size).map(|v| [i64::from(v % size), i64::from(v / size), 0]).collect();
        ControlMesh::new(positions, triangles.collect()).unwrap()
    }

    fn points(mesh: &ControlMesh, face: usize) -> Option<[[f64; 3]; 12]> {
        let mut patch = CMesh::default();
        patch.gather(mesh, face, |v| mesh.positions()[v as usize].map(|x| x as f64));
        patch.regular().then(|| {
            let mut points = [[0.0; 3]; 12];
            control_points(&Real, &patch, &mut points);
            points
        })
    }

    #[test]
    fn control_points_lie_at_their_lattice_places() {
        let lattice = [
            [0, -1],
            [1, -1],
            [2, -1],
            [-1, 0],
            [0, 0],
            [1, 0],
            [2, 0],
            [-1, 1],
            [0, 1],
            [1, 1],
            [-1, 2],
            [0, 2],
        ]; // as numbered above
        let mesh = sheet(6);
        let (mut inner, mut ghosted) = (0, 0);
        for face in (0..mesh.triangles().len()).step_by(2) {
            let Some(points) = points(&mesh, face) else { continue };
            let origin = points[4];
            for (point, [u, v]) in points.iter().zip(lattice) {
                // ghosts of a flat sheet continue the lattice
                assert_eq!(*point, [origin[0] + f64::from(u), origin[1] + f64::from(v), 0.0], "face {face}");
            }
            let reaches_out = points.iter().any(|p| p[..2].iter().any(|x| !(0.0..6.0).contains(x)));
            if reaches_out { ghosted += 1 } else { inner += 1 }
        }
        assert!(inner >= 4 && ghosted >= 8, "{inner} inner and {ghosted} ghosted patches seen");
    }
}
