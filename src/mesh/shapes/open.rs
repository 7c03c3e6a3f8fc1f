//! Surfaces with boundary.

use super::Parts;
use super::polyhedra::cut;
use super::sculpt::relax;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

pub(super) fn triangle() -> Parts {
    (vec![dvec3(-0.75, -0.5, 0.0), dvec3(0.75, -0.5, 0.25), dvec3(0.0, 0.75, -0.25)], vec![vec![0, 1, 2]])
}

/// A wavy grid of 4 x 4 squares; valence 2 at the corners, 3 along the sides, 4 inside.
pub(super) fn square_quads() -> Parts {
    let at = |i: u32| f64::from(i) / 2.0 - 1.0;
    let point = |(x, y): (f64, f64)| dvec3(x, y, 0.25 * x * y * (1.0 - 0.5 * y) + 0.15 * x * x) * 0.9;
    let points = (0..25).map(|i| point((at(i % 5), at(i / 5)))).collect();
    let quads = (0..16).map(|i| i % 4 + i / 4 * 5).map(|v| vec![v, v + 1, v + 6, v + 5]);
    (points, quads.collect())
}

/// All diagonals in one direction: corners of valence 2 and 3, regular elsewhere.
pub(super) fn square() -> Parts {
    cut(square_quads())
}

/// A band around a cone: two loops of 12 boundary vertices of valence 4, between them a loop of valence 6.
pub(super) fn annulus() -> Parts {
    let point = |i: u32| {
        let ((sin, cos), row) = ((f64::from(i % 12) * TAU / 12.0).sin_cos(), f64::from(i / 12));
        let radius = 0.9375 - 0.25 * row;
        dvec3(radius * cos, radius * sin, 0.3125 * row - 0.25)
    };
    let quad = |i: u32| {
        let (row, next) = (i / 12 * 12, (i + 1) % 12);
        vec![i, row + next, row + next + 12, i + 12]
    };
    cut(((0..36).map(point).collect(), (0..24).map(quad).collect()))
}

/// Seven sectors of triangles in two rings around a hub, and three triangles more on the boundary: a vertex
/// of valence 2 at their tips, and of valence 4 and 5 beside.
///
/// ```text
/// 15 ─ 16 ─ 17     outer ring 8..22
///   ╲ ╱ ╲ ╱
///    1 ─── 2       inner ring 1..8
///     ╲   ╱
///       0          hub
/// ```
pub(super) fn disc() -> Parts {
    const SECTORS: u32 = 7;
    let inner = |i: u32| 1 + i % SECTORS;
    let outer = |i: u32| 1 + SECTORS + i % (2 * SECTORS);
    let mut faces = Vec::new();
    for s in 0..SECTORS {
        let [a, m, b] = [outer(2 * s), outer(2 * s + 1), outer(2 * s + 2)];
        faces.push(vec![0, inner(s), inner(s + 1)]);
        faces.push(vec![inner(s), a, m]);
        faces.push(vec![inner(s), m, inner(s + 1)]);
        faces.push(vec![inner(s + 1), m, b]);
    }
    // The boundary in order, with the tips of the three additional triangles put in.
    let mut boundary = Vec::new();
    let mut tip = outer(0) + 2 * SECTORS;
    for i in 0..2 * SECTORS {
        boundary.push(outer(i));
        if [1, 6, 11].contains(&i) {
            faces.push(vec![outer(i + 1), outer(i), tip]);
            boundary.push(tip);
            tip += 1;
        }
    }
    let mut points = vec![DVec3::ZERO; tip as usize];
    for (i, &v) in boundary.iter().enumerate() {
        let (sin, cos) = (i as f64 * TAU / boundary.len() as f64).sin_cos();
        points[v as usize] = dvec3(cos, sin, 0.0);
    }
    (0..SECTORS).for_each(|s| points[inner(s) as usize] = 0.5 * points[outer(2 * s) as usize]);
    relax(&mut points, &faces, 10, |v| v <= SECTORS, |p| p);
    (points.into_iter().map(dome).collect(), faces)
}

/// Five quads around a hub, ten more around them; every boundary vertex is regular (valence 3).
pub(super) fn disc_quads() -> Parts {
    let on_circle = |i: u32, n: u32, radius: f64| {
        let (sin, cos) = (f64::from(i) * TAU / f64::from(n)).sin_cos();
        dvec3(cos, sin, 0.0) * radius
    };
    let mut points = vec![DVec3::ZERO];
    points.extend((0..10).map(|i| on_circle(i, 10, 0.5625)));
    points.extend((0..10).map(|i| on_circle(i, 10, 1.0)));
    let inner = |i: u32| 1 + i % 10;
    let mut faces: Vec<Vec<u32>> =
        (0..5).map(|s| vec![0, inner(2 * s), inner(2 * s + 1), inner(2 * s + 2)]).collect();
    faces.extend((0..10).map(|i| vec![inner(i), inner(i) + 10, inner(i + 1) + 10, inner(i + 1)]));
    (points.into_iter().map(dome).collect(), faces)
}

/// Lifts the flat disc to a dome with a slope.
fn dome(p: DVec3) -> DVec3 {
    dvec3(p.x, p.y, 0.3 * (1.0 - p.x * p.x - p.y * p.y) + 0.15 * p.x * p.y) * 0.9375
}
