//! The published algorithm on counted vectors: what an operation costs is what the run has counted.
//!
//! ```text
//!   operation = one addition of vectors, or one multiplication of a vector by a number
//!   start-up: its constants are shifts and adds (46 for stage 1, 33 for stage 2), and a shift is a wire
//! ```
//!
//! Generic over the number, so that the same run in single precision shows what rounding does to it.
//! Source: Bischoff, Kobbelt, Seidel 2000, appendix A, with 20 registers; start-up as in
//! [`crate::surface::forward`].

use std::cell::Cell;
use std::ops::{Add, Mul, Sub};

use crate::surface::arithmetic::Arithmetic;
use crate::surface::loop_masks::{limit_weight, vertex_weight};

/// `f64`, and whatever else a patch is to be computed in.
pub trait Number:
    Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Into<f64>
{
    fn of(number: f64) -> Self;
}

impl Number for f64 {
    fn of(number: f64) -> Self {
        number
    }
}

pub type Vector<T> = [T; 3];

/// Computes with vectors and counts what it does.
#[derive(Debug, Default)]
pub struct Counter {
    operations: Cell<u64>,
}

impl Counter {
    pub fn operations(&self) -> u64 {
        self.operations.get()
    }

    fn count(&self) {
        self.operations.set(self.operations.get() + 1);
    }

    pub fn plus<T: Number>(&self, a: Vector<T>, b: Vector<T>) -> Vector<T> {
        self.count();
        [0, 1, 2].map(|x| a[x] + b[x])
    }

    pub fn minus<T: Number>(&self, a: Vector<T>, b: Vector<T>) -> Vector<T> {
        self.count();
        [0, 1, 2].map(|x| a[x] - b[x])
    }

    pub fn times<T: Number>(&self, factor: f64, a: Vector<T>) -> Vector<T> {
        self.count();
        a.map(|x| T::of(factor) * x)
    }

    /// Times a power of two: a wire.
    fn shifted<T: Number>(&self, power: f64, a: Vector<T>) -> Vector<T> {
        a.map(|x| T::of(power) * x)
    }

    fn sum<T: Number>(&self, points: &[Vector<T>]) -> Vector<T> {
        let mut points = points.iter().copied();
        let first = points.next().unwrap_or_default();
        points.fold(first, |sum, point| self.plus(sum, point))
    }

    /// The start-up: N00 N10 N20 N30, N01 N11 N21 N31, N02 N12, N03 N13 over 12 * 16^level, by 79 additions.
    pub fn start_up<T: Number>(&self, level: u32, p: &[Vector<T>; 12]) -> Outer<T> {
        let two = |a| self.shifted(2.0, a);
        let second = |a: usize, b: usize, c: usize| self.minus(self.plus(p[a], p[c]), two(p[b]));
        let (r_m, r_0, r_0p, r_1) = (second(0, 1, 2), second(3, 4, 5), second(4, 5, 6), second(7, 8, 9));
        let (s_m, s_0, s_0p, s_1) = (second(3, 7, 10), second(0, 4, 8), second(4, 8, 11), second(1, 5, 9));
        let c30 = self.plus(self.minus(r_m, two(r_0)), r_1);
        let c03 = self.plus(self.minus(s_m, two(s_0)), s_1);
        let (c21, c12) = (self.minus(r_1, r_0), self.minus(s_1, s_0));
        let g = self.minus(self.minus(self.plus(r_0, r_0p), r_m), r_1);
        let h = self.minus(self.minus(self.plus(s_0, s_0p), s_m), s_1);
        let (p10, p87, p53) = (self.minus(p[1], p[0]), self.minus(p[8], p[7]), self.minus(p[5], p[3]));
        let (p71, p80) = (self.minus(p[7], p[1]), self.minus(p[8], p[0]));
        let c11 = self.plus(self.minus(r_0, p10), p87);
        let c10 = self.plus(self.plus(p10, p87), two(p53));
        let c01 = self.plus(self.plus(p71, p53), two(p80));
        let six = self.plus(self.shifted(4.0, p[4]), two(p[4]));
        let c00 = self.plus(self.sum(&[p[0], p[1], p[3], p[5], p[7], p[8]]), six);

        let [a, b, c, d] = [1, 2, 3, 4].map(|power| f64::from(level * power).exp2());
        let at = |power: f64, x| self.shifted(power, x);
        let six = |x| self.plus(at(4.0, x), at(2.0, x));
        let twelve = |x| self.plus(at(8.0, x), at(4.0, x));
        let n10 = |c1, c2, c3, g| {
            self.plus(self.plus(self.plus(at(2.0 * c, c1), six(at(b, c2))), at(2.0 * a, c3)), g)
        };
        let n20 = |c2, c3, g| {
            let fourteen = self.minus(at(16.0, g), at(2.0, g));
            self.plus(twelve(self.plus(at(b, c2), at(a, c3))), fourteen)
        };
        let n30 = |c3, g| twelve(self.plus(at(a, c3), self.plus(at(2.0, g), g)));
        let n21 = |c21, g| twelve(self.plus(at(a, c21), g));
        let mixed = self.plus(at(b, c11), at(a, self.plus(c21, c12)));
        let n11 = self.plus(six(mixed), at(2.0, self.plus(g, h)));
        Outer {
            row0: [at(d, c00), n10(c10, r_0, c30, g), n20(r_0, c30, g), n30(c30, g)],
            row1: [n10(c01, s_0, c03, h), n11, n21(c21, g), twelve(g)],
            row2: [n20(s_0, c03, h), n21(c12, h)],
            row3: [n30(c03, h), twelve(h)],
        }
    }

    /// i -> i+1: 9 additions.
    pub fn step<T: Number>(&self, o: &mut Outer<T>) {
        for k in 0..3 {
            o.row0[k] = self.plus(o.row0[k], o.row0[k + 1]);
        }
        o.row0[3] = self.plus(o.row0[3], self.shifted(2.0, o.row1[3]));
        for k in 0..3 {
            o.row1[k] = self.plus(o.row1[k], o.row1[k + 1]);
        }
        o.row2[0] = self.plus(o.row2[0], o.row2[1]);
        o.row3[0] = self.plus(o.row3[0], o.row3[1]);
    }

    /// j -> j+1 of a column: 4 additions.
    pub fn step_column<T: Number>(&self, l: &mut [Vector<T>; 4], fourth: Vector<T>) {
        for k in 0..3 {
            l[k] = self.plus(l[k], l[k + 1]);
        }
        l[3] = self.plus(l[3], self.shifted(2.0, fourth));
    }
}

/// The outer registers, row l from order (0, l) on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outer<T> {
    pub row0: [Vector<T>; 4],
    pub row1: [Vector<T>; 4],
    pub row2: [Vector<T>; 2],
    pub row3: [Vector<T>; 2],
}

impl<T: Number> Outer<T> {
    /// The differences of the column at hand along v.
    pub fn column(&self) -> [Vector<T>; 4] {
        [self.row0[0], self.row1[0], self.row2[0], self.row3[0]]
    }

    /// All registers times a number: from N to D.
    pub fn scaled(self, factor: f64) -> Self {
        fn rows<T: Number, const N: usize>(row: [Vector<T>; N], factor: f64) -> [Vector<T>; N] {
            row.map(|vector| vector.map(|x| T::of(factor) * x))
        }
        Outer {
            row0: rows(self.row0, factor),
            row1: rows(self.row1, factor),
            row2: rows(self.row2, factor),
            row3: rows(self.row3, factor),
        }
    }
}

/// The rules as published: V by n + 2 operations, E by 5.
impl Arithmetic for Counter {
    type Point = Vector<f64>;

    fn edge(&self, a: &Self::Point, b: &Self::Point, c: &Self::Point, d: &Self::Point) -> Self::Point {
        let ends = self.times(3.0, self.plus(*a, *b));
        self.times(0.125, self.plus(self.plus(ends, *c), *d))
    }

    fn boundary_edge(&self, a: &Self::Point, b: &Self::Point) -> Self::Point {
        self.times(0.5, self.plus(*a, *b))
    }

    fn vertex(&self, v: &Self::Point, ring: &[Self::Point]) -> Self::Point {
        let (n, weight) = (ring.len() as f64, vertex_weight(ring.len()));
        self.plus(self.times(1.0 - n * weight, *v), self.times(weight, self.sum(ring)))
    }

    fn boundary_vertex(&self, a: &Self::Point, v: &Self::Point, b: &Self::Point) -> Self::Point {
        self.times(0.125, self.plus(self.plus(*a, self.times(6.0, *v)), *b))
    }

    fn limit12(&self, v: &Self::Point, ring: &[Self::Point]) -> Self::Point {
        let (n, weight) = (ring.len() as f64, limit_weight(ring.len()));
        // The factor 12 belongs to the masks.
        self.plus(self.times(12.0 * (1.0 - n * weight), *v), self.times(12.0 * weight, self.sum(ring)))
    }

    fn boundary_limit12(&self, a: &Self::Point, v: &Self::Point, b: &Self::Point) -> Self::Point {
        self.times(2.0, self.plus(self.plus(*a, self.times(4.0, *v)), *b))
    }

    fn ghost(&self, v: &Self::Point, b: &Self::Point, i: &Self::Point) -> Self::Point {
        self.minus(self.plus(*v, *b), *i)
    }
}
