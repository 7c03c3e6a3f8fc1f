//! Closed surfaces with handles.

use super::Parts;
use super::polyhedra::cut;
use glam::{DVec3, dvec3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Vertices around the hole, and around the tube.
const AROUND: u32 = 12;
const TUBE: u32 = 6;

fn torus_points() -> Vec<DVec3> {
    let turn = |i: u32, n: u32| (f64::from(i) * TAU / f64::from(n)).sin_cos();
    let point = |i: u32| {
        let ((sin, cos), (tube_sin, tube_cos)) = (turn(i / TUBE, AROUND), turn(i % TUBE, TUBE));
        let radius = 0.6875 + 0.3125 * tube_cos;
        dvec3(radius * cos, 0.3125 * tube_sin, -radius * sin)
    };
    (0..AROUND * TUBE).map(point).collect()
}

fn torus_grid() -> impl Iterator<Item = [u32; 4]> {
    let v = |i: u32, j: u32| i % AROUND * TUBE + j % TUBE;
    let quad = move |(i, j)| [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
    (0..AROUND * TUBE).map(move |k| quad((k / TUBE, k % TUBE)))
}

pub(super) fn torus_quads() -> Parts {
    (torus_points(), torus_grid().map(Vec::from).collect())
}

/// All diagonals in one direction, so that each vertex has six neighbours.
pub(super) fn torus() -> Parts {
    cut(torus_quads())
}

/// The surface of a bar of unit cubes with two cubes left out:
///
/// ```text
/// ■ ■ ■ ■ ■
/// ■ □ ■ □ ■
/// ■ ■ ■ ■ ■
/// ```
pub(super) fn double_torus_quads() -> Parts {
    let filled = |[x, y, z]: [i32; 3]| {
        (0..5).contains(&x) && (0..3).contains(&y) && z == 0 && !(y == 1 && (x == 1 || x == 3))
    };
    // For each axis the four corners of a cube's upper side, counterclockwise from outside.
    const SIDE: [[i32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let mut quads = Vec::new();
    for cube in (0..15).map(|i| [i % 5, i / 5, 0]).filter(|&cube| filled(cube)) {
        for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let mut beside = cube;
            beside[axis] += if upper { 1 } else { -1 };
            if filled(beside) {
                continue;
            }
            let mut quad = SIDE.map(|[a, b]| {
                let mut corner = cube;
                corner[axis] += i32::from(upper);
                corner[(axis + 1) % 3] += a;
                corner[(axis + 2) % 3] += b;
                corner
            });
            if !upper {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    let corners: BTreeSet<[i32; 3]> = quads.iter().flatten().copied().collect();
    let number: BTreeMap<[i32; 3], u32> = corners.iter().copied().zip(0..).collect();
    let point = |&[x, y, z]: &[i32; 3]| dvec3(x.into(), y.into(), z.into()) - dvec3(2.5, 1.5, 0.5);
    let points = corners.iter().map(|corner| point(corner) * 0.375).collect();
    (points, quads.iter().map(|quad| quad.iter().map(|corner| number[corner]).collect()).collect())
}

pub(super) fn double_torus() -> Parts {
    cut(double_torus_quads())
}
