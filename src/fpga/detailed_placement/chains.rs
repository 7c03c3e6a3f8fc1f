//! Tiles change places with all they hold: the only way for chains of carry and for RAMs.

use super::cost::Marks;
use super::design::{Design, Kind, NONE, SLOTS};

/// Tiles in a row, and as many others.
#[derive(Clone, Copy, Debug)]
pub struct Spans {
    pub from: usize,
    pub to: usize,
    tiles: usize,
}

impl Spans {
    fn pairs(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.tiles).map(move |at| (self.from + at, self.to + at))
    }
}

impl Design {
    /// Whether a chain goes on from a tile into the next.
    fn goes_on(&self, tile: usize) -> bool {
        self.cells.get(self.slots.luts[tile * SLOTS + SLOTS - 1] as usize).is_some_and(|cell| cell.chains_on)
    }

    fn holds_wide(&self, tile: usize) -> bool {
        let luts = &self.slots.luts[tile * SLOTS..(tile + 1) * SLOTS];
        luts.iter().any(|&lut| lut != NONE && self.cells[lut as usize].kind == Kind::Wide)
    }

    /// The tiles of a tile's chain, or only that tile.
    fn chain(&self, within: usize) -> (usize, usize) {
        let (mut first, mut last) = (within, within);
        while first % self.slots.width > 0 && self.goes_on(first - 1) {
            first -= 1;
        }
        while self.goes_on(last) {
            last += 1;
        }
        (first, last)
    }

    fn cuts(&self, first: usize, tiles: usize) -> bool {
        (!first.is_multiple_of(self.slots.width) && self.goes_on(first - 1))
            || self.goes_on(first + tiles - 1)
    }

    /// The tiles of the chain in a tile, and as many others, from `to` on or from where the chain begins that is there;
    /// nothing where they cannot be swapped.
    pub fn spans(&self, within: usize, to: usize) -> Option<Spans> {
        let (from, last) = self.chain(within);
        let (to, last_there) = self.chain(to);
        let spans = Spans { from, to, tiles: 1 + (last - from).max(last_there - to) };
        let beyond = |first: usize| first % self.slots.width + spans.tiles > self.slots.width;
        if from.abs_diff(to) < spans.tiles || beyond(from) || beyond(to) {
            return None;
        }
        let cuts = self.cuts(from, spans.tiles) || self.cuts(to, spans.tiles);
        let wide = spans.pairs().any(|(a, b)| self.holds_wide(a) || self.holds_wide(b));
        (!cuts && !wide).then_some(spans)
    }

    pub fn swap_spans(&mut self, spans: Spans) {
        spans.pairs().for_each(|(a, b)| self.swap_tiles(a, b));
    }

    /// Swaps them; what that costs.
    pub fn move_spans(&mut self, spans: Spans, marks: &mut Marks) -> f32 {
        let moved: Vec<u32> =
            spans.pairs().flat_map(|(a, b)| self.in_tile(a).chain(self.in_tile(b))).collect();
        let cost = |design: &Design, marks: &mut Marks| {
            design.around(&moved, marks) + design.fullness(spans.from, spans.to)
        };
        let before = cost(self, marks);
        self.swap_spans(spans);
        cost(self, marks) - before
    }

    /// What may go its own way of what a swap has put where the chain was.
    pub fn driven_away(&self, spans: Spans) -> Vec<u32> {
        let cells = spans.pairs().flat_map(|(tile, _)| self.in_tile(tile));
        cells.filter(|&cell| !self.is_fixed(cell)).collect()
    }
}
