//! Tools to model irregular shapes: relaxing vertices and turning edges.

use glam::DVec3;
use std::collections::BTreeSet;

/// Moves each vertex that is `free` to the mean of its neighbours, again and again, and then where `place` puts it.
///
/// Vertices are taken in order and each uses the latest positions of the others.
pub(super) fn relax(
    points: &mut [DVec3],
    faces: &[Vec<u32>],
    rounds: usize,
    free: impl Fn(u32) -> bool,
    place: impl Fn(DVec3) -> DVec3,
) {
    let rings = neighbours(points.len(), faces);
    for _ in 0..rounds {
        for (v, ring) in rings.iter().enumerate().filter(|&(v, _)| free(v as u32)) {
            let sum: DVec3 = ring.iter().map(|&n| points[n as usize]).sum();
            points[v] = place(sum / ring.len() as f64);
        }
    }
}

/// The neighbours of each vertex along edges.
pub(super) fn neighbours(vertices: usize, faces: &[Vec<u32>]) -> Vec<BTreeSet<u32>> {
    let mut rings = vec![BTreeSet::new(); vertices];
    for face in faces {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            rings[a as usize].insert(b);
            rings[b as usize].insert(a);
        }
    }
    rings
}

/// Turns the edge between `a` and `b` by one step within the polygon that its two faces form together.
///
/// ```text
///   d ─── a          d ─── a         Both ends lose an edge, their followers gain one. With triangles this
///   │   ╱ │          │ ╲   │         is the usual flip; in two quads the edge turns within a hexagon.
///   │ ╱   │    ->    │   ╲ │
///   b ─── c          b ─── c
/// ```
/// False, and nothing changes, when the two are no edge of two faces or the new edge is there already.
pub(super) fn turn_edge(faces: &mut [Vec<u32>], a: u32, b: u32) -> bool {
    // The corners of the face in which `from` is followed by `to`, beginning after `to`, both included at the end.
    let along = |from: u32, to: u32| {
        faces.iter().enumerate().find_map(|(f, face)| {
            let at = face.iter().position(|&v| v == from)?;
            (face[(at + 1) % face.len()] == to).then(|| {
                let mut corners = face.clone();
                corners.rotate_left((at + 1) % face.len());
                (f, corners)
            })
        })
    };
    let (Some((f, mut left)), Some((g, mut right))) = (along(a, b), along(b, a)) else { return false };
    // left = b, l1, ..., a    right = a, r1, ..., b: the edge a-b becomes l1-r1.
    let (l1, r1) = (left[1], right[1]);
    if faces.iter().any(|face| face.contains(&l1) && face.contains(&r1)) {
        return false;
    }
    left.remove(0);
    left.push(r1);
    right.remove(0);
    right.push(l1);
    faces[f] = left;
    faces[g] = right;
    true
}
