//! What a cut costs: strips, their lengths, and the words that a host sends.
//!
//! ```text
//!   a regular vertex costs 2 words (itself and one outside neighbour), so a column costs 4;
//!   a closed mesh of long strips has as many columns as vertices: 4V words (Hall, section 6.1)
//! ```

use super::Strip;
use super::records::StripRecords;

/// The size of a cut. A word is one position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    pub quads: usize,
    pub strips: usize,
    pub closed: usize,
    pub shortest: usize,
    pub longest: usize,
    /// Words sent in all, guards included; a closed strip sends its first columns again.
    pub words: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
}

impl Statistics {
    /// Of all strips of a mesh and their records.
    pub fn of<P>(vertices: usize, strips: &[Strip], records: &[StripRecords<P>]) -> Self {
        let lengths = strips.iter().map(Strip::len);
        Statistics {
            quads: lengths.clone().sum(),
            strips: strips.len(),
            closed: strips.iter().filter(|s| s.is_closed()).count(),
            shortest: lengths.clone().min().unwrap_or(0),
            longest: lengths.max().unwrap_or(0),
            words: records.iter().map(StripRecords::words).sum(),
            vertices,
        }
    }

    /// Quads a strip.
    pub fn mean_length(&self) -> f64 {
        self.quads as f64 / self.strips.max(1) as f64
    }

    /// Words sent for each vertex of the mesh; the thesis's 4 where all is regular and strips are long.
    pub fn words_per_vertex(&self) -> f64 {
        self.words as f64 / self.vertices.max(1) as f64
    }
}
