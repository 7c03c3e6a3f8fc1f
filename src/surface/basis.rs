//! The exact masks of the samples of a regular patch, straight from the quartic box spline.
//!
//! ```text
//!   p(i/n, j/n) = sum of mask[m] P_m / (12 n^4),    n = 2^level
//!
//!   With integer barycentric coordinates a = n-i-j, i, j every basis function is one of three forms,
//!   homogeneous of degree 4 with non-negative integer coefficients (x: weight of the nearest corner,
//!   y, z: of the other two):
//!
//!   corner    P4 P5 P8           6x^4 + 24x^3(y+z) + 24x^2(y^2+z^2) + 60x^2 yz + 8x(y^3+z^3) + 36xyz(y+z)
//!                                + y^4 + z^4 + 6yz(y^2+z^2) + 12y^2z^2
//!   across    P1 P7 P9           y^4 + z^4 + 6yz(y^2+z^2) + 12y^2z^2 + x(2(y^3+z^3) + 6yz(y+z))
//!   outer     P0 P3 P2 P6 P10 P11    x^4 + 2x^3 y      (y: the corner on the side that it leans to)
//! ```
//!
//! Source: the twelve box-spline functions of Stam 1998, "Evaluation of Loop subdivision surfaces",
//! appendix, sorted by symmetry. Nothing here goes through differences, so that a mask can serve as the
//! independent side of a proof. All weights are >= 0 and sum to 12 n^4: samples are convex combinations.

/// Weights of a corner's own control point; `x` belongs to that corner.
fn corner(x: i64, y: i64, z: i64) -> i64 {
    let (sum, product) = (y + z, y * z);
    let squares = sum * sum - 2 * product;
    let cubes = sum * (squares - product);
    x * (x * (x * (6 * x + 24 * sum) + 24 * squares + 60 * product) + 8 * cubes + 36 * product * sum)
        + quartic(squares, product)
}

/// Weights of the control point across the edge (y, z), opposite to the corner `x`.
fn across(x: i64, y: i64, z: i64) -> i64 {
    let (sum, product) = (y + z, y * z);
    let squares = sum * sum - 2 * product;
    let cubes = sum * (squares - product);
    quartic(squares, product) + x * (2 * cubes + 6 * product * sum)
}

/// y^4 + z^4 + 6yz(y^2 + z^2) + 12y^2z^2 from y^2 + z^2 and yz.
fn quartic(squares: i64, product: i64) -> i64 {
    squares * squares - 2 * product * product + 6 * product * squares + 12 * product * product
}

/// Weights of an outer control point next to corner `x`, leaning to corner `y`.
fn outer(x: i64, y: i64) -> i64 {
    x * x * x * (x + 2 * y)
}

/// The weights of P0..P11 in p(i/n, j/n) over [`denominator`]`(level)`, for n = 2^level, level <= 10,
/// i + j <= n.
pub fn mask(level: u32, i: u32, j: u32) -> [i64; 12] {
    let [n, u, v] = [1i64 << level, i.into(), j.into()];
    let w = n - u - v;
    [
        outer(w, u),
        across(v, w, u),
        outer(u, w),
        outer(w, v),
        corner(w, u, v),
        corner(u, v, w),
        outer(u, v),
        across(u, v, w),
        corner(v, w, u),
        across(w, u, v),
        outer(v, w),
        outer(v, u),
    ]
}

/// 12 * 16^level.
pub fn denominator(level: u32) -> i64 {
    12 << (4 * level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_convex() {
        for level in 0..=5 {
            let n = 1 << level;
            for i in 0..=n {
                for j in 0..=n - i {
                    let mask = mask(level, i, j);
                    assert!(mask.iter().all(|&w| w >= 0));
                    assert_eq!(mask.iter().sum::<i64>(), denominator(level), "p({i}, {j}) of {n}");
                }
            }
        }
        assert_eq!(mask(10, 300, 400).iter().sum::<i64>(), denominator(10));
    }

    #[test]
    fn corners_are_limit_positions() {
        assert_eq!(mask(0, 0, 0), [1, 1, 0, 1, 6, 1, 0, 1, 1, 0, 0, 0]);
        assert_eq!(mask(0, 1, 0), [0, 1, 1, 0, 1, 6, 1, 0, 1, 1, 0, 0]);
        assert_eq!(mask(0, 0, 1), [0, 0, 0, 0, 1, 1, 0, 1, 6, 1, 1, 1]);
    }
}
