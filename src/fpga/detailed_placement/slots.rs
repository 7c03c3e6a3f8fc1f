//! Which cell is in which slot, and how full the device is where.

use super::design::{Cell, Design, Kind, NONE, SLOTS};

/// Tiles along the side of a block, of which the load is counted too.
const BLOCK: usize = 6;

/// A slot of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    pub tile: usize,
    pub at: usize,
}

impl Slot {
    pub fn index(self) -> usize {
        self.tile * SLOTS + self.at
    }
}

/// All tiles of a rectangle; a row without logic, as those of block RAMs, has none.
#[derive(Clone, Debug, Default)]
pub struct Slots {
    pub width: usize,
    left: i32,
    top: i32,
    has_logic: Vec<bool>,
    pub luts: Vec<u32>,
    pub registers: Vec<u32>,
    pub ram_writes: Vec<u32>,
    loads: Vec<i32>,
    blocks_a_row: usize,
}

impl Slots {
    /// Those between the cells.
    ///
    /// # Errors
    /// Two cells in one slot.
    pub fn of(cells: &[Cell]) -> Result<Slots, String> {
        let placed: Vec<(usize, &Cell)> =
            cells.iter().enumerate().filter(|(_, cell)| cell.kind.in_tile()).collect();
        let range = |along: &dyn Fn(&Cell) -> i16| {
            let all = || placed.iter().map(|(_, cell)| i32::from(along(cell)));
            (all().min().unwrap_or(0), all().max().unwrap_or(-1))
        };
        let ((left, right), (top, bottom)) = (range(&|cell| cell.x), range(&|cell| cell.y));
        let (width, height) = ((right - left + 1) as usize, (bottom - top + 1) as usize);
        let mut rows = vec![false; height];
        placed.iter().for_each(|(_, cell)| rows[(i32::from(cell.y) - top) as usize] = true);
        let blocks_a_row = width / BLOCK + 1;
        let mut slots = Slots {
            width,
            left,
            top,
            has_logic: (0..width * height).map(|tile| rows[tile / width]).collect(),
            luts: vec![NONE; width * height * SLOTS],
            registers: vec![NONE; width * height * SLOTS],
            ram_writes: vec![NONE; width * height],
            loads: vec![0; blocks_a_row * (height / BLOCK + 1)],
            blocks_a_row,
        };
        for (number, cell) in placed {
            let tile = slots.tile(cell.x.into(), cell.y.into()).ok_or("a cell beside all rows")?;
            let slot = Slot { tile, at: cell.slot.into() }.index();
            let place = match cell.kind {
                Kind::Register => &mut slots.registers[slot],
                Kind::RamWrite => &mut slots.ram_writes[tile],
                _ => &mut slots.luts[slot],
            };
            if *place != NONE {
                return Err(format!("two cells in one slot, one is {}", cell.name));
            }
            *place = number as u32;
            let block = slots.block(tile);
            slots.loads[block] += i32::from(cell.load);
        }
        Ok(slots)
    }

    pub fn tiles(&self) -> usize {
        self.has_logic.len()
    }

    /// The tile there, where there is logic.
    pub fn tile(&self, x: i32, y: i32) -> Option<usize> {
        let (column, row) = (usize::try_from(x - self.left).ok()?, usize::try_from(y - self.top).ok()?);
        let tile = row * self.width + column;
        (column < self.width && tile < self.tiles() && self.has_logic[tile]).then_some(tile)
    }

    pub fn tile_of(&self, cell: &Cell) -> Option<usize> {
        self.tile(cell.x.into(), cell.y.into())
    }

    pub fn place_of(&self, tile: usize) -> (i16, i16) {
        ((tile % self.width) as i16 + self.left as i16, (tile / self.width) as i16 + self.top as i16)
    }

    pub fn block(&self, tile: usize) -> usize {
        (tile / self.width / BLOCK) * self.blocks_a_row + (tile % self.width) / BLOCK
    }

    /// Wires of a block, for each of its tiles.
    pub fn load_of_block(&self, block: usize) -> f32 {
        self.loads[block] as f32 / (BLOCK * BLOCK) as f32
    }
}

impl Design {
    /// Whatever is in a tile.
    pub fn in_tile(&self, tile: usize) -> impl Iterator<Item = u32> + '_ {
        let slots = &self.slots;
        let range = tile * SLOTS..(tile + 1) * SLOTS;
        let both = slots.luts[range.clone()].iter().chain(&slots.registers[range]);
        both.chain([&slots.ram_writes[tile]]).copied().filter(|&cell| cell != NONE)
    }

    /// Swaps what is in two slots: the LUTs, the registers or both.
    pub fn swap(&mut self, a: Slot, b: Slot, luts: bool, registers: bool) {
        let (i, j) = (a.index(), b.index());
        if luts {
            self.slots.luts.swap(i, j);
            self.settle(self.slots.luts[i], b.tile, a);
            self.settle(self.slots.luts[j], a.tile, b);
        }
        if registers {
            self.slots.registers.swap(i, j);
            self.settle(self.slots.registers[i], b.tile, a);
            self.settle(self.slots.registers[j], a.tile, b);
        }
    }

    /// Swaps all that is in two tiles.
    pub fn swap_tiles(&mut self, a: usize, b: usize) {
        (0..SLOTS).for_each(|at| self.swap(Slot { tile: a, at }, Slot { tile: b, at }, true, true));
        self.slots.ram_writes.swap(a, b);
        let at = 4;
        self.settle(self.slots.ram_writes[a], b, Slot { tile: a, at });
        self.settle(self.slots.ram_writes[b], a, Slot { tile: b, at });
    }

    /// A cell has come to a slot from a tile.
    fn settle(&mut self, cell: u32, from: usize, slot: Slot) {
        if cell == NONE {
            return;
        }
        let (before, here) = (self.slots.block(from), self.slots.block(slot.tile));
        let cell = &mut self.cells[cell as usize];
        self.slots.loads[before] -= i32::from(cell.load);
        self.slots.loads[here] += i32::from(cell.load);
        (cell.x, cell.y) = self.slots.place_of(slot.tile);
        cell.slot = slot.at as u8;
    }
}
