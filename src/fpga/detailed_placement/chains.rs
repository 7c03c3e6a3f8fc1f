//! Tiles change places with all they hold: the only way for chains of carry and for RAMs.

use super::cost::Marks;
use super::design::{Design, Kind, NONE, SLOTS};

impl Design {
    /// Whether a chain goes on from a tile into the next.
    fn goes_on(&self, tile: usize) -> bool {
        self.cells.get(self.slots.luts[tile * SLOTS + SLOTS - 1] as usize).is_some_and(|cell| cell.chains_on)
    }

    fn holds_wide(&self, tile: usize) -> bool {
        let luts = &self.slots.luts[tile * SLOTS..(tile + 1) * SLOTS];
        luts.iter().any(|&lut| lut != NONE && self.cells[lut as usize].kind == Kind::Wide)
    }

    /// Swaps the tiles in a row that a cell's chain takes with as many others, of which `to` is the first, if that costs
    /// no more; whether it did.
    pub fn swap_chain(&mut self, within: usize, to: usize, marks: &mut Marks) -> bool {
        let width = self.slots.width;
        let (mut first, mut last) = (within, within);
        while first % width > 0 && self.goes_on(first - 1) {
            first -= 1;
        }
        while self.goes_on(last) {
            last += 1;
        }
        let tiles = last - first + 1;
        let overlaps = to.abs_diff(first) < tiles;
        let beyond = to % width + tiles > width;
        if overlaps || beyond {
            return false;
        }
        let cuts = (!to.is_multiple_of(width) && self.goes_on(to - 1)) || self.goes_on(to + tiles - 1);
        let pairs = || (0..tiles).map(|at| (first + at, to + at));
        if cuts || pairs().any(|(a, b)| self.holds_wide(a) || self.holds_wide(b)) {
            return false;
        }
        let moved: Vec<u32> = pairs().flat_map(|(a, b)| self.in_tile(a).chain(self.in_tile(b))).collect();
        let cost =
            |design: &Design, marks: &mut Marks| design.around(&moved, marks) + design.fullness(first, to);
        let before = cost(self, marks);
        pairs().for_each(|(a, b)| self.swap_tiles(a, b));
        if cost(self, marks) <= before {
            return true;
        }
        pairs().for_each(|(a, b)| self.swap_tiles(a, b));
        false
    }
}
