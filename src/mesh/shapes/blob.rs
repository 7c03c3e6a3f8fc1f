//! The duck: irregular closed meshes with valences 3 to 9, round and friendly.
//!
//! ```text
//! octahedron or cube, each edge cut in four ─► edges turned ─► relaxed on the sphere ─► pushed to the duck's skin
//!     66 vertices of triangles + 1               valences 3..9       of directions          and fitted to it
//!     98 vertices of quads
//! ```
//!
//! The duck is star-shaped: from a point in its neck every direction meets the skin once. So a mesh that does
//! not fold on the sphere of directions does not cut itself on the duck.

use super::Parts;
use super::sculpt::{fit, gather, nearest, relax, split};
use glam::{DVec3, dvec3};
use std::collections::{BTreeMap, BTreeSet};

/// Where all directions begin: inside every part of the duck.
const NECK: DVec3 = dvec3(0.20, 0.05, 0.0);

/// Centre and radii of the ellipsoids that the duck is made of.
const PARTS: [[DVec3; 2]; 5] = [
    [dvec3(-0.06, -0.36, 0.0), dvec3(0.82, 0.48, 0.56)], // body
    [dvec3(0.34, 0.50, 0.0), dvec3(0.46, 0.45, 0.44)],   // head
    [dvec3(0.22, 0.06, 0.0), dvec3(0.44, 0.42, 0.42)],   // neck
    [dvec3(0.84, 0.44, 0.0), dvec3(0.24, 0.10, 0.20)],   // beak
    [dvec3(-0.84, 0.04, 0.0), dvec3(0.20, 0.22, 0.20)],  // tail
];

/// Where a vertex stays in place: the ends of beak and tail, and the crown.
const TIPS: [DVec3; 3] = [dvec3(0.95, 0.44, 0.0), dvec3(-0.95, 0.15, 0.0), dvec3(0.4, 0.9, 0.0)];

pub(super) fn blob() -> Parts {
    let (mut directions, mut faces) = octahedral_sphere();
    split(&mut directions, &mut faces, dvec3(-0.2, -1.0, 0.3)); // a vertex of valence 3
    for (place, valence) in [
        (dvec3(-1.0, 0.1, 0.0), 9),
        (dvec3(0.4, 0.9, 0.0), 8),
        (dvec3(-0.3, -0.3, 0.6), 8),
        (dvec3(0.9, 0.4, 0.0), 7),
        (dvec3(-0.1, -0.2, -0.6), 9),
    ] {
        gather(&mut faces, nearest(&directions, place - NECK), valence, 4);
    }
    (duck(directions, &faces, 4, 4), faces)
}

pub(super) fn blob_quads() -> Parts {
    let (directions, mut faces) = cubic_sphere();
    for (place, valence) in [
        (dvec3(-0.5, -0.6, 0.4), 6),
        (dvec3(-0.2, -0.5, 0.6), 9),
        (dvec3(-0.1, -0.2, -0.6), 8),
        (dvec3(0.4, 0.9, 0.0), 7),
        (dvec3(0.4, -0.9, -0.1), 8),
        (dvec3(0.7, -0.2, 0.0), 6),
        (dvec3(-1.0, 0.1, 0.0), 6),
    ] {
        gather(&mut faces, nearest(&directions, place - NECK), valence, 3);
    }
    (duck(directions, &faces, 8, 1), faces)
}

/// Control points for the duck from directions all around it: spread by rounds of relaxation, put on the skin,
/// fitted to it by rounds of correction, and centred in the unit box.
fn duck(mut directions: Vec<DVec3>, faces: &[Vec<u32>], relaxed: usize, fitted: usize) -> Vec<DVec3> {
    relax(&mut directions, faces, relaxed, |_| true, DVec3::normalize);
    let tips = TIPS.map(|tip| nearest(&directions, tip - NECK));
    for (v, tip) in tips.into_iter().zip(TIPS) {
        directions[v as usize] = (tip - NECK).normalize();
    }
    relax(&mut directions, faces, relaxed, |v| !tips.contains(&v), DVec3::normalize);
    let mut points: Vec<DVec3> = directions.into_iter().map(skin).collect();
    fit(&mut points, faces, fitted);
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low).max_element());
    points.into_iter().map(|p| (p - centre) * (0.9375 / half)).collect()
}

/// Where a direction from the neck leaves the last part of the duck that it meets.
fn skin(direction: DVec3) -> DVec3 {
    let exit = |[centre, radii]: [DVec3; 2]| {
        // |(neck + t direction - centre) / radii| = 1, the larger t
        let (o, d) = ((NECK - centre) / radii, direction / radii);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let discriminant = b * b - a * c;
        if discriminant < 0.0 { 0.0 } else { (discriminant.sqrt() - b) / a }
    };
    NECK + direction * PARTS.map(exit).into_iter().fold(0.0, f64::max)
}

/// The octahedron |x| + |y| + |z| = 4 cut into triangles at its integer points.
fn octahedral_sphere() -> Parts {
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let sign = [1, 2, 4].map(|bit| if octant & bit == 0 { 1 } else { -1 });
        let mut push = |mut corners: [[i32; 3]; 3]| {
            if sign.iter().product::<i32>() < 0 {
                corners.reverse();
            }
            triangles.push(corners.map(|p| [0, 1, 2].map(|axis| p[axis] * sign[axis])).to_vec());
        };
        for (i, j) in (0..16).map(|n| (n / 4, n % 4)) {
            let (up, down) = (3 - i - j, 2 - i - j);
            if up >= 0 {
                push([[i + 1, j, up], [i, j + 1, up], [i, j, up + 1]]);
            }
            if down >= 0 {
                push([[i + 1, j + 1, down], [i, j + 1, down + 1], [i + 1, j, down + 1]]);
            }
        }
    }
    on_sphere(&triangles)
}

/// The cube max(|x|, |y|, |z|) = 2 cut into unit squares.
fn cubic_sphere() -> Parts {
    let mut quads = Vec::new();
    for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        for (i, j) in (0..16).map(|n| (n / 4 - 2, n % 4 - 2)) {
            let mut quad = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[a, b]| {
                let mut corner = [if upper { 2 } else { -2 }; 3];
                corner[(axis + 1) % 3] = a;
                corner[(axis + 2) % 3] = b;
                corner
            });
            if !upper {
                quad.reverse();
            }
            quads.push(quad.to_vec());
        }
    }
    on_sphere(&quads)
}

/// Numbers the integer points of the polygons and turns them into directions.
fn on_sphere(polygons: &[Vec<[i32; 3]>]) -> Parts {
    let points: BTreeSet<[i32; 3]> = polygons.iter().flatten().copied().collect();
    let number: BTreeMap<[i32; 3], u32> = points.iter().copied().zip(0..).collect();
    let directions = points.iter().map(|p| DVec3::from_array(p.map(f64::from)).normalize()).collect();
    (directions, polygons.iter().map(|polygon| polygon.iter().map(|p| number[p]).collect()).collect())
}
