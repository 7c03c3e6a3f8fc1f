//! The algorithm as published, in floating point: what fixed point is compared with.
//!
//! ```text
//!   control mesh --> hierarchy --> 15 differences = matrix * 12 points --> 23 registers, 4 adds a vertex
//!                    every operation rounded to the number at hand: f32, or half precision
//!
//!   deviation of a patch = max over (1, 0), (1/2, 1/2), (0, 1) of |vertex - exact| / |exact|
//! ```
//!
//! "Exact" is the polynomial of the same twelve points, so that only the forward differences are judged.
//! Source: Bischoff, Kobbelt, Seidel 2000, sections 3.3 and 5.3, Figure 17.

mod half;
mod rules;

pub use half::Half;

use super::loop_fd::LoopFd;
use super::loop_fd::reduced::columns_of_any;
use crate::error::Result;
use crate::surface::basis;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::forward::{ORDERS, row};
use crate::surface::hierarchy::{PatchKind, walk};
use crate::surface::packets::patches;
use crate::surface::table::Table;
use rules::Rounded;

/// A floating-point number whose operations round to its own precision.
pub trait Float: Copy + Default {
    const ZERO: Self;
    fn rounded(x: f64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn wide(self) -> f64;
}

impl Float for f32 {
    const ZERO: Self = 0.0;

    fn rounded(x: f64) -> Self {
        x as f32
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn minus(self, other: Self) -> Self {
        self - other
    }
    fn times(self, other: Self) -> Self {
        self * other
    }
    fn wide(self) -> f64 {
        self.into()
    }
}

/// How far vertices are from exact ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The largest distance over the distance of the exact vertex from the origin; infinite where the
    /// numbers have overflown. Vertices at the origin are left out.
    pub relative: f64,
    /// The largest distance, in units of the control coordinates.
    pub absolute: f64,
}

impl Deviation {
    fn add(&mut self, vertex: [f64; 3], exact: [f64; 3]) {
        let norm = |p: [f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let distance = norm([0, 1, 2].map(|x| vertex[x] - exact[x]));
        let distance = if distance.is_nan() { f64::INFINITY } else { distance };
        self.absolute = self.absolute.max(distance);
        if norm(exact) > 0.0 {
            self.relative = self.relative.max(distance / norm(exact));
        }
    }
}

/// The places that the paper looks at: (1, 0), (1/2, 1/2) and (0, 1).
fn places(level: u32) -> [[usize; 2]; 3] {
    let n = 1usize << level;
    [[n, 0], [n - n / 2, n / 2], [0, n]]
}

/// The whole algorithm in floating point, hierarchy included, at a level; `unit` is what a unit of the
/// control coordinates is worth, which matters for the range of half precision.
pub fn deviation<F: Float>(mesh: &ControlMesh, level: u32, unit: f64) -> Deviation {
    let mut worst = Deviation::default();
    let point = |v: u32| mesh.positions()[v as usize].map(|x| F::rounded(x as f64 * unit));
    walk(&Rounded::<F>::new(), mesh, level, point, |patch| {
        if patch.kind != PatchKind::Regular {
            return;
        }
        let columns = [0, 1, 2].map(|x| columns(patch.level, &patch.points.each_ref().map(|p| p[x])));
        for [i, j] in places(patch.level) {
            let mask = basis::mask(patch.level, i as u32, j as u32);
            let exact = |x: usize| {
                let terms = mask.iter().zip(&patch.points).map(|(&m, p)| m as f64 * p[x].wide());
                terms.sum::<f64>() / basis::denominator(patch.level) as f64
            };
            let vertex = [0, 1, 2].map(|x| columns[x][i][j].wide() / unit);
            worst.add(vertex, [0, 1, 2].map(|x| exact(x) / unit));
        }
    });
    worst
}

/// The same of a fixed-point core, whose vertices are rounded at last to its output.
///
/// # Errors
/// Coordinates that are wider than the core's, a level above its maximum.
pub fn deviation_of_core(mesh: &ControlMesh, level: u32, core: &LoopFd, table: &Table) -> Result<Deviation> {
    let mut worst = Deviation::default();
    let mut walker = columns_of_any(core);
    let output = (-f64::from(core.extra_fraction())).exp2();
    let finest = f64::from(4 * core.max_level()).exp2() * 12.0;
    patches(mesh, level, core.max_level(), table, |patch| {
        if patch.kind != PatchKind::Regular {
            return;
        }
        walker.start(patch.level, &patch.points);
        let n = 1usize << patch.level;
        for i in 0..=n {
            let mut column = vec![[0; 3]; n + 1 - i];
            walker.next(&mut column);
            for [_, j] in places(patch.level).into_iter().filter(|place| place[0] == i) {
                let mask = basis::mask(patch.level, i as u32, j as u32);
                let exact = |x: usize| {
                    let terms = mask.iter().zip(&patch.points).map(|(&m, p)| i128::from(m) * p[x]);
                    terms.sum::<i128>() as f64 / finest
                };
                worst.add(column[j].map(|y| y as f64 * output), [0, 1, 2].map(exact));
            }
        }
    })?;
    Ok(worst)
}

/// One axis of a patch by the published scheme: all columns.
fn columns<F: Float>(level: u32, points: &[F; 12]) -> Vec<Vec<F>> {
    let n = 1usize << level;
    let denominator = basis::denominator(level) as f64;
    // The matrix is made once for each level, so its entries are rounded and not computed.
    let mut outer = [[F::ZERO; 5]; 5];
    for (k, l) in ORDERS {
        let weights = row(k, l, level).map(|w| F::rounded(w as f64 / denominator));
        let terms = weights.iter().zip(points).map(|(&w, &p)| w.times(p));
        outer[k][l] = terms.fold(F::ZERO, F::plus);
    }
    let mut columns = Vec::with_capacity(n + 1);
    for i in 0..=n {
        let mut inner = outer[0];
        let mut column = Vec::with_capacity(n + 1 - i);
        for _ in 0..=n - i {
            column.push(inner[0]);
            for l in 0..4 {
                inner[l] = inner[l].plus(inner[l + 1]);
            }
        }
        columns.push(column);
        for k in 0..4 {
            for l in 0..=3 - k {
                outer[k][l] = outer[k][l].plus(outer[k + 1][l]);
            }
        }
    }
    columns
}
