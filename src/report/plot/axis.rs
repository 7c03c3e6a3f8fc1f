//! An axis: from numbers to places on the paper, with ticks at round numbers.
//!
//! ```text
//!   linear        1, 2 or 5 times a power of ten apart
//!   logarithmic   at powers of ten; over less than three of them also at 2 and 5 times
//! ```

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Numbers that are not positive do not show.
    Logarithmic,
}

/// Numbers from `low` to `high` along places from `first` to `last`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    first: f64,
    last: f64,
}

impl Axis {
    /// An axis that holds all numbers, with a little room at both ends.
    pub fn around(numbers: impl Iterator<Item = f64>, scale: Scale, [first, last]: [f64; 2]) -> Axis {
        let shown = numbers.filter(|x| x.is_finite() && (scale == Scale::Linear || *x > 0.0));
        let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = match (scale, low <= high) {
            (Scale::Linear, false) => (0.0, 1.0),
            (Scale::Logarithmic, false) => (1.0, 10.0),
            (Scale::Linear, true) => {
                let room = if low < high { (high - low) * 0.05 } else { low.abs().max(1.0) * 0.5 };
                // An axis that begins near zero begins at zero.
                let begin = if low >= 0.0 && low <= 0.3 * high { 0.0 } else { low - room };
                (begin, high + room)
            }
            (Scale::Logarithmic, true) => {
                let room = (high / low).powf(0.06).max(1.25);
                (low / room, high * room)
            }
        };
        Axis { scale, low, high, first, last }
    }

    /// The place of a number; nothing for what does not show.
    pub fn place(&self, x: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear => (x - self.low) / (self.high - self.low),
            Scale::Logarithmic if x > 0.0 => (x / self.low).ln() / (self.high / self.low).ln(),
            Scale::Logarithmic => return None,
        };
        share.is_finite().then_some(self.first + share * (self.last - self.first))
    }

    /// Round numbers within the axis.
    pub fn ticks(&self) -> Vec<f64> {
        let within = |x: &f64| (self.low..=self.high).contains(x);
        match self.scale {
            Scale::Linear => {
                let rough = (self.high - self.low) / 6.0;
                let power = 10f64.powi(rough.log10().floor() as i32);
                let step =
                    [1.0, 2.0, 5.0, 10.0].into_iter().find(|s| s * power >= rough).unwrap_or(10.0) * power;
                let from = (self.low / step).ceil() as i64;
                (from..from + 20).map(|n| n as f64 * step).filter(within).collect()
            }
            Scale::Logarithmic => {
                let (from, to) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
                let every = ((to - from) / 8 + 1) as usize;
                let factors: &[f64] = if self.high / self.low < 1000.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
                let powers = (from..=to).filter(|power| power.rem_euclid(every as i32) == 0);
                let ticks = powers.flat_map(|power| factors.iter().map(move |f| f * 10f64.powi(power)));
                ticks.filter(within).collect()
            }
        }
    }
}

/// A tick's number, as short as it can be.
pub(super) fn label(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if !(1e-3..1e7).contains(&size) {
        format!("{x:.0e}")
    } else if size >= 1.0 && (x - x.round()).abs() < 1e-9 {
        let digits = format!("{x:.0}");
        if digits.len() > 4 { crate::report::table::thousands(x as u64) } else { digits }
    } else {
        let text = format!("{x:.4}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let axis = Axis::around([0.0, 97.0].into_iter(), Scale::Linear, [0.0, 100.0]);
        assert_eq!(axis.ticks(), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        let axis = Axis::around([0.5, 30.0].into_iter(), Scale::Logarithmic, [0.0, 100.0]);
        assert_eq!(axis.ticks(), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        let axis = Axis::around([1e-7, 1e4].into_iter(), Scale::Logarithmic, [0.0, 100.0]);
        assert!(axis.ticks().len() <= 9 && axis.ticks().len() >= 5, "{:?}", axis.ticks());
    }

    #[test]
    fn places_run_from_end_to_end() {
        let axis = Axis::around([1.0, 100.0].into_iter(), Scale::Logarithmic, [200.0, 0.0]);
        let middle = axis.place(10.0).unwrap();
        assert!((middle - 100.0).abs() < 1e-9, "{middle}");
        assert_eq!(axis.place(0.0), None);
        // One number alone still has a place.
        let axis = Axis::around([7.0].into_iter(), Scale::Linear, [0.0, 10.0]);
        assert!(axis.place(7.0).is_some_and(|x| x > 0.0 && x < 10.0));
    }

    #[test]
    fn labels_are_short() {
        let labels = [0.0, 0.5, 2.0, 1234.0, 20000.0, 1e7, 1e-7, 0.0625].map(label);
        assert_eq!(labels, ["0", "0.5", "2", "1234", "20 000", "1e7", "1e-7", "0.0625"]);
    }
}
