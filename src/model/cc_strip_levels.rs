//! The levels of a `cc-strip`, as its protocol sees them, and what a walked core knows of their rest.

use super::cc_strip_buffer::COUNTS_LATE;

/// A column on its way into a level.
#[derive(Clone, Copy)]
pub(super) struct Arrival {
    pub(super) first: bool,
    pub(super) last: bool,
}

#[derive(Clone, Copy, Default)]
pub(super) struct Level {
    /// Columns left to send; with two, a vertex column and a face column.
    pub(super) columns: u32,
    pub(super) age: u32,
    pub(super) guarded: bool,
    pub(super) slices: u32,
    /// Clocks from a coordinate to the next, where they take turns.
    pub(super) period: u32,
    pub(super) double: bool,
    /// Clocks of the walk that are left.
    pub(super) walk: u32,
    /// Where rooms are asked for: a column is on its way; one is here and does not count yet.
    pub(super) sends: bool,
    /// There was room for a column a clock ago.
    pub(super) may_send: bool,
    pub(super) comes: Option<Arrival>,
}

/// What is known of the rest of a core: of its levels some clocks late, of the buffer and of what comes in one.
pub(super) struct Rests {
    /// No level had a column to send, a clock ago and before.
    pub(super) levels: [bool; COUNTS_LATE + 1],
    /// The buffer was empty.
    pub(super) buffer: bool,
    /// No word came in.
    pub(super) quiet: bool,
    /// Words came in the clocks before.
    pub(super) came: [bool; 3],
}

impl Rests {
    pub(super) fn all(&self) -> bool {
        self.levels[COUNTS_LATE] && self.buffer && self.quiet
    }

    pub(super) fn clock(&mut self, levels: bool, buffer: bool, came: bool) {
        self.levels.rotate_right(1);
        self.levels[0] = levels;
        self.buffer = buffer;
        self.quiet = !came && !self.came.contains(&true);
        self.came = [came, self.came[0], self.came[1]];
    }
}

impl Level {
    pub(super) fn arrives(&mut self, arrival: Arrival) {
        match (arrival.first, self.age) {
            (true, _) => self.age = 0,
            (_, 0) => (self.age, self.columns) = (1, u32::from(!self.double)),
            _ => (self.age, self.columns) = (2, if self.double { 1 } else { 2 }),
        }
        self.guarded = arrival.last;
    }
}
