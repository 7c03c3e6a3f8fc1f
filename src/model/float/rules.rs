//! The rules of subdivision with every operation rounded; weights are rounded constants.

use std::marker::PhantomData;

use super::Float;
use crate::surface::arithmetic::Arithmetic;
use crate::surface::loop_masks::{limit_weight, vertex_weight};

/// Plain numbers of one kind at every depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounded<F>(PhantomData<F>);

impl<F> Rounded<F> {
    pub fn new() -> Self {
        Rounded(PhantomData)
    }
}

/// The sum of weight * coordinate, axis by axis, in this order.
fn combine<F: Float, const N: usize>(terms: [(f64, &[F; 3]); N]) -> [F; 3] {
    std::array::from_fn(|x| {
        let terms = terms.iter().map(|(w, p)| if *w == 1.0 { p[x] } else { F::rounded(*w).times(p[x]) });
        terms.fold(F::ZERO, F::plus)
    })
}

/// v + weight * (sum of the ring - n v).
fn towards_ring<F: Float>(v: &[F; 3], ring: &[[F; 3]], weight: f64) -> [F; 3] {
    std::array::from_fn(|x| {
        let spread = ring.iter().fold(F::ZERO, |sum, c| sum.plus(c[x].minus(v[x])));
        v[x].plus(F::rounded(weight).times(spread))
    })
}

impl<F: Float> Arithmetic for Rounded<F> {
    type Point = [F; 3];

    fn edge(&self, a: &[F; 3], b: &[F; 3], c: &[F; 3], d: &[F; 3]) -> [F; 3] {
        combine([(0.375, a), (0.375, b), (0.125, c), (0.125, d)])
    }

    fn boundary_edge(&self, a: &[F; 3], b: &[F; 3]) -> [F; 3] {
        combine([(0.5, a), (0.5, b)])
    }

    fn vertex(&self, v: &[F; 3], ring: &[[F; 3]]) -> [F; 3] {
        towards_ring(v, ring, vertex_weight(ring.len()))
    }

    fn boundary_vertex(&self, a: &[F; 3], v: &[F; 3], b: &[F; 3]) -> [F; 3] {
        combine([(0.125, a), (0.75, v), (0.125, b)])
    }

    fn limit12(&self, v: &[F; 3], ring: &[[F; 3]]) -> [F; 3] {
        towards_ring(v, ring, limit_weight(ring.len())).map(|x| F::rounded(12.0).times(x))
    }

    fn boundary_limit12(&self, a: &[F; 3], v: &[F; 3], b: &[F; 3]) -> [F; 3] {
        combine([(2.0, a), (8.0, v), (2.0, b)])
    }

    fn ghost(&self, v: &[F; 3], b: &[F; 3], i: &[F; 3]) -> [F; 3] {
        std::array::from_fn(|x| v[x].plus(b[x]).minus(i[x]))
    }
}
