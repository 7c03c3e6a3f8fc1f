//! The rules of subdivision over any kind of number: what the patch hierarchy does not decide.
//!
//! ```text
//!   hierarchy<A: Arithmetic>  --- exact integers (the hardware's host)      see `exact`
//!                             --- f64                                       here
//!                             --- rationals (tests)
//! ```
//!
//! A point one subdivision step deeper may be scaled: exact integers at depth k are scaled by 16^k.

use crate::surface::loop_masks::{limit_weight, vertex_weight};

/// The rules of Bischoff, Kobbelt, Seidel 2000, Figures 2 and 8 (their L, E, B2, B3 and the projections).
pub trait Arithmetic {
    /// A point of the surface, or one of its coordinates.
    type Point: Clone + Default;

    /// New vertex of an interior edge (a, b) with opposite vertices c, d: (3 (a+b) + c + d)/8.
    fn edge(&self, a: &Self::Point, b: &Self::Point, c: &Self::Point, d: &Self::Point) -> Self::Point;
    /// New vertex of a boundary edge: (a + b)/2.
    fn boundary_edge(&self, a: &Self::Point, b: &Self::Point) -> Self::Point;
    /// Interior vertex, one step deeper: v + w_n (sum of the ring - n v).
    fn vertex(&self, v: &Self::Point, ring: &[Self::Point]) -> Self::Point;
    /// Boundary vertex between its boundary neighbours, one step deeper: (a + 6v + b)/8.
    fn boundary_vertex(&self, a: &Self::Point, v: &Self::Point, b: &Self::Point) -> Self::Point;
    /// Twelve times the limit position of an interior vertex: 12 (v + g_n (sum of the ring - n v)).
    fn limit12(&self, v: &Self::Point, ring: &[Self::Point]) -> Self::Point;
    /// Twelve times the limit position of a boundary vertex: 2 (a + 4v + b).
    fn boundary_limit12(&self, a: &Self::Point, v: &Self::Point, b: &Self::Point) -> Self::Point;
    /// The parallelogram rule: the ghost v + b - i across the boundary edge (v, b) with opposite vertex i.
    fn ghost(&self, v: &Self::Point, b: &Self::Point, i: &Self::Point) -> Self::Point;
}

/// Floating point, unscaled at every depth. Neighbouring patches may differ in the last bits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Real;

impl Real {
    fn towards_ring(v: &[f64; 3], ring: &[[f64; 3]], weight: f64) -> [f64; 3] {
        std::array::from_fn(|x| v[x] + weight * ring.iter().map(|c| c[x] - v[x]).sum::<f64>())
    }
}

impl Arithmetic for Real {
    type Point = [f64; 3];

    fn edge(&self, a: &[f64; 3], b: &[f64; 3], c: &[f64; 3], d: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|x| (3.0 * (a[x] + b[x]) + c[x] + d[x]) / 8.0)
    }

    fn boundary_edge(&self, a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|x| (a[x] + b[x]) / 2.0)
    }

    fn vertex(&self, v: &[f64; 3], ring: &[[f64; 3]]) -> [f64; 3] {
        Self::towards_ring(v, ring, vertex_weight(ring.len()))
    }

    fn boundary_vertex(&self, a: &[f64; 3], v: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|x| (a[x] + 6.0 * v[x] + b[x]) / 8.0)
    }

    fn limit12(&self, v: &[f64; 3], ring: &[[f64; 3]]) -> [f64; 3] {
        Self::towards_ring(v, ring, limit_weight(ring.len())).map(|x| 12.0 * x)
    }

    fn boundary_limit12(&self, a: &[f64; 3], v: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|x| 2.0 * (a[x] + 4.0 * v[x] + b[x]))
    }

    fn ghost(&self, v: &[f64; 3], b: &[f64; 3], i: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|x| v[x] + b[x] - i[x])
    }
}
