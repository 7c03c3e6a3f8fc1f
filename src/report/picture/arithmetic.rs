//! The few functions that a picture needs, from `+ - * /` and square roots only.
//!
//! Those five are rounded the same way on every machine (IEEE 754); the C library's `pow`, `sin` and
//! `atan2` are not. A picture must have the same bytes everywhere, so it uses nothing else.

/// `x^n` by repeated squaring.
pub fn power(x: f32, n: u32) -> f32 {
    let (mut result, mut square, mut rest) = (1.0, x, n);
    while rest > 0 {
        if rest & 1 == 1 {
            result *= square;
        }
        square *= square;
        rest >>= 1;
    }
    result
}

/// The `n`-th root of a number in 0..=1, by Newton's method from above.
pub fn root(x: f64, n: i32) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut y = 1.0;
    loop {
        let power = (1..n).fold(1.0, |p, _| p * y);
        let next = y - (y - x / power) / f64::from(n);
        // From above the steps decrease until rounding takes over.
        if next >= y {
            return y;
        }
        y = next;
    }
}

/// 0 below `from`, 1 above `to`, and the cubic `3t^2 - 2t^3` between; `from` may be the larger one.
pub fn smooth_step(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The angle of the vector (x, y) in turns, in -0.5..=0.5; the error is below 2e-6 turns.
pub fn turns(y: f32, x: f32) -> f32 {
    let (low, high) = if y.abs() < x.abs() { (y.abs(), x.abs()) } else { (x.abs(), y.abs()) };
    let a = if high > 0.0 { low / high } else { 0.0 };
    let s = a * a;
    // Minimax polynomial for arctan on 0..=1.
    let series = [-0.011_721_2, 0.052_653_32, -0.116_432_87, 0.193_543_46, -0.332_623_47, 0.999_977_26];
    let arctan = a * series.iter().fold(0.0, |sum, c| sum * s + c);
    let eighth = arctan * (0.5 / std::f32::consts::PI);
    let quarter = if y.abs() < x.abs() { eighth } else { 0.25 - eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_roots_undo_each_other() {
        assert_eq!(power(1.5, 5), 7.59375);
        for x in [1e-6, 0.01, 0.3, 1.0] {
            for n in [3, 5] {
                let back = (0..n).fold(1.0, |p, _| p * root(x, n));
                assert!((back - x).abs() < 1e-12, "{x} {n}");
            }
        }
    }

    #[test]
    fn turns_follow_the_circle() {
        for step in 0..1000 {
            let angle = (step as f64 / 1000.0 - 0.4995) * std::f64::consts::TAU;
            let turn = turns(angle.sin() as f32, angle.cos() as f32);
            assert!((f64::from(turn) - angle / std::f64::consts::TAU).abs() < 3e-6, "{step}");
        }
    }
}
