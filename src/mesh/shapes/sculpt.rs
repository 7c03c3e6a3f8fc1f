//! Tools to model irregular shapes: relaxing vertices and turning edges.

use glam::DVec3;
use std::collections::BTreeSet;

/// Evens out the faces: moves each vertex that is `free` to the mean of the centres of its faces, weighted by
/// their areas, again and again, and each time on to where `place` puts that point.
///
/// Vertices are taken in order and each uses the latest positions of the others. Large faces pull harder, so
/// they shrink; the plain mean of the neighbours would let a closed surface slide off to one side.
pub(super) fn relax(
    points: &mut [DVec3],
    faces: &[Vec<u32>],
    rounds: usize,
    free: impl Fn(u32) -> bool,
    place: impl Fn(DVec3) -> DVec3,
) {
    let mut around = vec![Vec::new(); points.len()];
    for face in faces {
        face.iter().for_each(|&v| around[v as usize].push(face));
    }
    for _ in 0..rounds {
        for (v, around) in around.iter().enumerate().filter(|&(v, _)| free(v as u32)) {
            let weighted = around.iter().map(|face| {
                let corner = |i: usize| points[face[i % face.len()] as usize];
                let centre = (0..face.len()).map(corner).sum::<DVec3>() / face.len() as f64;
                let area = (corner(2) - corner(0)).cross(corner(3) - corner(1)).length();
                (centre * area, area)
            });
            let (sum, area) = weighted.fold((DVec3::ZERO, 0.0), |s, w| (s.0 + w.0, s.1 + w.1));
            points[v] = place(sum / area);
        }
    }
}

/// Pushes control points outwards until the surface that they control comes close to where they were.
///
/// A limit point of either scheme lies about half-way between its control point and the mean of the
/// neighbours (on regular meshes exactly half-way for Loop).
pub(super) fn fit(points: &mut [DVec3], faces: &[Vec<u32>], rounds: usize) {
    let (rings, target) = (neighbours(points.len(), faces), points.to_vec());
    for _ in 0..rounds {
        let limit = |(&p, ring): (&DVec3, &BTreeSet<u32>)| {
            let sum: DVec3 = ring.iter().map(|&v| points[v as usize]).sum();
            0.5 * (p + sum / ring.len() as f64)
        };
        let limits: Vec<DVec3> = points.iter().zip(&rings).map(limit).collect();
        for ((p, target), limit) in points.iter_mut().zip(&target).zip(limits) {
            *p += 0.7 * (target - limit);
        }
    }
}

/// The neighbours of each vertex along edges.
fn neighbours(vertices: usize, faces: &[Vec<u32>]) -> Vec<BTreeSet<u32>> {
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

/// The point furthest in a direction; the first of several.
pub(super) fn nearest(points: &[DVec3], direction: DVec3) -> u32 {
    let mut best = 0;
    for v in 0..points.len() {
        if points[v].dot(direction) > points[best].dot(direction) {
            best = v;
        }
    }
    best as u32
}

/// Puts a vertex into the triangle that lies furthest in a direction: three faces more, one less.
pub(super) fn split(points: &mut Vec<DVec3>, faces: &mut Vec<Vec<u32>>, direction: DVec3) {
    let centre =
        |face: &Vec<u32>| face.iter().map(|&v| points[v as usize]).sum::<DVec3>() / face.len() as f64;
    let centres: Vec<DVec3> = faces.iter().map(centre).collect();
    let face = nearest(&centres, direction) as usize;
    let v = points.len() as u32;
    points.push(centres[face]);
    let corners = faces.swap_remove(face);
    faces.extend((0..corners.len()).map(|i| vec![corners[i], corners[(i + 1) % corners.len()], v]));
}

/// Turns edges of the faces around `hub` towards it until it has `valence` edges, or no edge can be turned
/// without another vertex falling below `least` edges.
pub(super) fn gather(faces: &mut [Vec<u32>], hub: u32, valence: usize, least: usize) {
    loop {
        let vertices = faces.iter().flatten().max().map_or(0, |&last| last as usize + 1);
        let rings = neighbours(vertices, faces);
        let count = |v: u32| rings[v as usize].len();
        if count(hub) >= valence {
            return;
        }
        // a -> b -> hub in a face around it, and b -> a -> x across: a-b becomes hub-x.
        let mut best: Option<(usize, u32, u32)> = None;
        for (face, at) in faces.iter().filter_map(|face| Some((face, face.iter().position(|&v| v == hub)?))) {
            let before = |steps| face[(at + face.len() - steps) % face.len()];
            let (a, b) = (before(2), before(1));
            let Some(x) = faces.iter().find_map(|face| follower(face, b, a)) else { continue };
            let may = count(a).min(count(b)) > least;
            let gain = (count(a) + count(b)).saturating_sub(count(x));
            if may && !rings[hub as usize].contains(&x) && best.is_none_or(|(most, ..)| gain > most) {
                best = Some((gain, a, b));
            }
        }
        if !best.is_some_and(|(_, a, b)| turn_edge(faces, a, b)) {
            return;
        }
    }
}

/// The corner that comes after `from`, `to` in a face, if it has this side.
fn follower(face: &[u32], from: u32, to: u32) -> Option<u32> {
    let at = face.iter().position(|&v| v == from)?;
    (face[(at + 1) % face.len()] == to).then(|| face[(at + 2) % face.len()])
}

/// Turns the edge between `a` and `b` by one step within the polygon that its two faces form together.
///
/// ```text
///   r1 ── a          r1 ── a         Both ends lose an edge, their followers gain one. With triangles this
///   │   ╱ │          │ ╲   │         is the usual flip; in two quads the edge turns within a hexagon.
///   │ ╱   │    ->    │   ╲ │
///   b ─── l1         b ─── l1
/// ```
/// False, and nothing changes, when the two are no edge of two faces or a face has both ends of the new edge.
fn turn_edge(faces: &mut [Vec<u32>], a: u32, b: u32) -> bool {
    let side = |from, to| faces.iter().position(|face| follower(face, from, to).is_some());
    let (Some(left), Some(right)) = (side(a, b), side(b, a)) else { return false };
    let ends = (follower(&faces[left], a, b), follower(&faces[right], b, a));
    let (Some(l1), Some(r1)) = ends else { return false };
    if faces.iter().any(|face| face.contains(&l1) && face.contains(&r1)) {
        return false;
    }
    let mut replace = |face: usize, old: u32, new: u32, after: u32| {
        let corners = &mut faces[face];
        corners.retain(|&v| v != old);
        let at = corners.iter().position(|&v| v == after).map_or(0, |at| at + 1);
        corners.insert(at, new);
    };
    replace(left, b, r1, a);
    replace(right, a, l1, b);
    true
}
