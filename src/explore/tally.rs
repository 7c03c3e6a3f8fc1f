//! The error and the cracks of a whole mesh, counted as the vertices come.
//!
//! ```text
//!   limit = whole + rest (output units, 0 <= rest < 1)          error = (y - whole) - rest
//!   largest: over every vertex of every patch     rms: over one position a vertex, the first that came
//!   crack: a vertex that came out at two places; its size is the largest distance in any coordinate
//! ```
//!
//! The positions of the oracle are split once and shared by all points; an error is then one subtraction of
//! small numbers, exact to 2^-53 unit and the rounding of `rest`.

/// The true positions of the vertices of a fine mesh, in units of the output.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    whole: Vec<[i64; 3]>,
    rest: Vec<[f64; 3]>,
    /// How far an error may be off, in the same units.
    pub uncertainty: f64,
}

impl Truth {
    /// From positions over `unit`, as an oracle has them; `uncertainty` is the oracle's own.
    pub fn new(positions: impl Iterator<Item = [i128; 3]>, unit: i128, uncertainty: f64) -> Truth {
        let mut truth = Truth { uncertainty: uncertainty + (-50f64).exp2(), ..Truth::default() };
        for position in positions {
            truth.whole.push(position.map(|x| x.div_euclid(unit) as i64));
            truth.rest.push(position.map(|x| x.rem_euclid(unit) as f64 / unit as f64));
        }
        truth
    }

    pub fn vertices(&self) -> usize {
        self.whole.len()
    }
}

/// What has come so far.
#[derive(Clone, Debug)]
pub struct Tally<'a> {
    truth: &'a Truth,
    /// The lowest and the highest coordinates of each vertex; low above high where nothing came.
    low: Vec<[i64; 3]>,
    high: Vec<[i64; 3]>,
    largest: f64,
    squares: f64,
}

/// Errors of all vertices in output units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    pub max: f64,
    pub rms: f64,
}

/// Vertices at more than one place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Cracks {
    pub count: u64,
    /// The largest distance of a coordinate between two patches, in output units.
    pub largest: u64,
}

impl<'a> Tally<'a> {
    pub fn new(truth: &'a Truth) -> Self {
        let count = truth.vertices();
        let (low, high) = (vec![[i64::MAX; 3]; count], vec![[i64::MIN; 3]; count]);
        Tally { truth, low, high, largest: 0.0, squares: 0.0 }
    }

    /// A vertex of the fine mesh, by its number.
    #[inline]
    pub fn put(&mut self, vertex: usize, position: [i64; 3]) {
        let (whole, rest) = (&self.truth.whole[vertex], &self.truth.rest[vertex]);
        let (low, high) = (&mut self.low[vertex], &mut self.high[vertex]);
        let first = low[0] > high[0];
        for axis in 0..3 {
            let y = position[axis];
            // A wild output saturates: a fault shows as a huge error and not as a panic.
            let error = (y.saturating_sub(whole[axis]) as f64 - rest[axis]).abs();
            self.largest = self.largest.max(error);
            if first {
                self.squares += error * error;
            }
            low[axis] = low[axis].min(y);
            high[axis] = high[axis].max(y);
        }
    }

    pub fn errors(&self) -> Errors {
        let coordinates = (3 * self.low.len()).max(1) as f64;
        Errors { max: self.largest, rms: (self.squares / coordinates).sqrt() }
    }

    pub fn cracks(&self) -> Cracks {
        let mut cracks = Cracks::default();
        for (low, high) in self.low.iter().zip(&self.high).filter(|(low, high)| low[0] <= high[0]) {
            let size = (0..3).map(|axis| high[axis].abs_diff(low[axis])).max().unwrap_or(0);
            cracks.count += u64::from(size > 0);
            cracks.largest = cracks.largest.max(size);
        }
        cracks
    }

    /// Vertices that did not come.
    pub fn missing(&self) -> usize {
        self.low.iter().zip(&self.high).filter(|(low, high)| low[0] > high[0]).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_and_cracks_of_three_vertices() {
        // positions over 4: 0.5, -0.25 and 3
        let truth = Truth::new([[2, 0, 0], [-1, 0, 0], [12, 0, 0]].map(|p: [i128; 3]| p).into_iter(), 4, 0.0);
        let mut tally = Tally::new(&truth);
        tally.put(0, [1, 0, 0]);
        tally.put(1, [0, 0, 0]);
        assert_eq!(tally.missing(), 1);
        tally.put(1, [0, 0, 0]);
        tally.put(2, [3, 0, 0]);
        assert_eq!((tally.cracks(), tally.missing()), (Cracks::default(), 0));
        let errors = tally.errors();
        assert_eq!(errors.max, 0.5);
        assert!((errors.rms - ((0.25 + 0.0625) / 9.0f64).sqrt()).abs() < 1e-15);
        // Another patch says something else: a crack, which counts once and for the largest error only.
        tally.put(2, [3, -2, 0]);
        tally.put(2, [3, 1, 0]);
        assert_eq!(tally.cracks(), Cracks { count: 1, largest: 3 });
        assert_eq!((tally.errors().max, tally.errors().rms), (2.0, errors.rms));
    }

    #[test]
    fn a_wild_output_is_a_huge_error() {
        let truth = Truth::new([[0; 3]].into_iter(), 1, 0.0);
        let mut tally = Tally::new(&truth);
        tally.put(0, [i64::MAX, i64::MIN, 0]);
        assert!(tally.errors().max > 1e18 && tally.cracks().count == 0);
    }
}
