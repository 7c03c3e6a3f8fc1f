//! The reference of the core `loop-fd`: twelve control points in, the vertices of triangle strips out.
//!
//! ```text
//!   strip i, n = 2^level:   left  p(i,0)   p(i,1)   ...  p(i,n-i-1)    p(i,n-i)
//!                           right p(i+1,0) p(i+1,1) ...  p(i+1,n-i-1)  none, end of strip
//!
//!   p = floor(N00 2^f / (12 * 16^R) + 1/2),   N00 = sum of mask * P over 12 * 16^R
//! ```
//!
//! Two means, which the tests hold against each other bit for bit: [`direct`] evaluates the polynomial with
//! one exact division, [`columns`] runs forward differences in wrapping words. Formats with fewer bits than
//! exact ones lose them in the differences themselves: [`reduced`].
//! Source: Bischoff, Kobbelt, Seidel 2000, section 3.3 (`render_forward_differences`).

pub mod columns;
pub mod direct;
pub mod reduced;
pub mod rounding;

use crate::error::{Error, Result};
use crate::fixed::Precision;
use crate::surface::packets::{MAX_LEVEL, MAX_WIDTH, word_bits};
use crate::surface::word::Word;
use columns::Columns;
use rounding::{ByDivision, ByMultiplication, Rounding};

/// The numbers that a core is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopFd {
    width: u32,
    extra_fraction: i32,
    max_level: u32,
    precision: Precision,
}

/// One beat of the output stream: two vertices of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beat {
    /// p(i, j) in output units.
    pub left: [i64; 3],
    /// p(i+1, j); none in the last beat of a strip.
    pub right: Option<[i64; 3]>,
    /// Last beat of a strip (`tlast`).
    pub strip_end: bool,
    /// First beat of a patch.
    pub patch_start: bool,
    /// Last beat of a patch.
    pub patch_end: bool,
}

impl LoopFd {
    /// A core for coordinates of `width` bits (2..=32) whose outputs have `extra_fraction` more fraction
    /// bits (fewer, if negative) and whose patches have levels up to `max_level` (0..=10).
    ///
    /// # Errors
    /// Numbers outside these ranges, no bit left to round off (f > 4R + 1), outputs of W + f bits outside
    /// 2..=63.
    pub fn new(width: u32, extra_fraction: i32, max_level: u32) -> Result<Self> {
        if !(2..=MAX_WIDTH).contains(&width) || max_level > MAX_LEVEL {
            return Err(Error::usage(format!("a core of {width} bits and maximum level {max_level}"))
                .help(format!("use 2 to {MAX_WIDTH} bits and a maximum level of 0 to {MAX_LEVEL}")));
        }
        let (most, output) = (4 * max_level as i32 + 1, width as i32 + extra_fraction);
        if extra_fraction > most || !(2..=63).contains(&output) {
            return Err(Error::usage(format!("{extra_fraction} extra fraction bits on {width} bits"))
                .help(format!("use at most 4 R + 1 = {most} extra bits, and 2 to 63 output bits in all")));
        }
        Ok(LoopFd { width, extra_fraction, max_level, precision: Precision::Exact })
    }

    /// The same core with other numbers inside.
    ///
    /// # Errors
    /// Differences of order 0 with fewer fraction bits than the output.
    pub fn with_precision(self, precision: Precision) -> Result<Self> {
        if let Some(reduced) = precision.reduced() {
            let (have, want) = (reduced.fractions.of(0), self.extra_fraction);
            if i64::from(have) < i64::from(want) {
                return Err(Error::usage(format!("{have} fraction bits for an output of {want} more bits"))
                    .help("give the differences at least the fraction bits of the output"));
            }
        }
        Ok(LoopFd { precision, ..self })
    }

    /// How the differences are kept.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// W: bits of a control coordinate.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// f: fraction bits of the output beyond those of the input.
    pub fn extra_fraction(&self) -> i32 {
        self.extra_fraction
    }

    /// R: the highest level of a patch.
    pub fn max_level(&self) -> u32 {
        self.max_level
    }

    /// W + f: bits of an output coordinate.
    pub fn output_bits(&self) -> u32 {
        self.width.saturating_add_signed(self.extra_fraction)
    }

    /// B = W + 4R + 4: bits of every register, modulo which the core computes.
    pub fn word_bits(&self) -> u32 {
        word_bits(self.width, self.max_level)
    }

    /// s = 4R + 2 - f: bits that rounding shifts out before the division by 3.
    pub fn rounding_shift(&self) -> u32 {
        (4 * self.max_level + 2).saturating_add_signed(-self.extra_fraction)
    }

    /// Beats of a patch: n(n+1)/2 pairs and n single vertices.
    pub fn beat_count(level: u32) -> usize {
        let n = 1 << level;
        n * (n + 3) / 2
    }

    /// Vertices of a patch, (n+1)(n+2)/2.
    pub fn vertex_count(level: u32) -> usize {
        let n = 1 << level;
        (n + 1) * (n + 2) / 2
    }

    /// All beats of one patch.
    ///
    /// `points`: P0..P11 as integers with 4 (R - level) extra fraction bits, as
    /// [`crate::surface::packets::patches`] delivers them: every sample lies within W bits. (Other points
    /// give meaningless beats, and no panic.)
    ///
    /// # Errors
    /// A level above the core's maximum.
    pub fn beats(&self, level: u32, points: &[[i128; 3]; 12]) -> Result<Vec<Beat>> {
        let mut beats = Vec::with_capacity(Self::beat_count(level.min(MAX_LEVEL)));
        self.for_each_beat(level, points, |beat| beats.push(beat))?;
        Ok(beats)
    }

    /// The same, one beat after the other; keeps two columns.
    ///
    /// # Errors
    /// As [`LoopFd::beats`].
    pub fn for_each_beat(&self, level: u32, points: &[[i128; 3]; 12], sink: impl FnMut(Beat)) -> Result<()> {
        if level > self.max_level {
            return Err(Error::usage(format!("a patch of level {level}"))
                .help(format!("this core was made for levels up to {}", self.max_level)));
        }
        if let Some(mut columns) = reduced::columns(self) {
            columns.start(level, points);
            strips(level, |column| columns.next(column), sink);
        } else if self.word_bits() > i64::BITS {
            beats_of(level, points, ByDivision::new(self), sink);
        } else {
            let narrow = points.map(|p| p.map(i64::narrow));
            match ByMultiplication::new(self) {
                Some(rounding) => beats_of(level, &narrow, rounding, sink),
                None => beats_of(level, &narrow, ByDivision::new(self), sink),
            }
        }
        Ok(())
    }
}

fn beats_of<W: Word, R: Rounding<W>>(level: u32, points: &[[W; 3]; 12], rounding: R, sink: impl FnMut(Beat)) {
    let mut columns = Columns::new(rounding);
    columns.start(level, points);
    strips(level, |column| columns.next(column), sink);
}

/// Cuts the columns of a patch into strips.
fn strips(level: u32, mut next: impl FnMut(&mut [[i64; 3]]), mut sink: impl FnMut(Beat)) {
    let n = 1usize << level;
    let (mut left, mut right) = (vec![[0; 3]; n + 1], vec![[0; 3]; n]);
    next(&mut left);
    for i in 0..n {
        next(&mut right[..n - i]);
        for j in 0..=n - i {
            sink(Beat {
                left: left[j],
                right: (j < n - i).then(|| right[j]),
                strip_end: j == n - i,
                patch_start: i == 0 && j == 0,
                patch_end: i + 1 == n && j == n - i,
            });
        }
        std::mem::swap(&mut left, &mut right);
    }
}
