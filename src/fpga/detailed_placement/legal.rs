//! What may stand in a tile together.

use super::design::{Design, Kind, NONE, SLOTS};

/// The slice, of two slots, that a RAM is written by.
const WRITES: usize = 2;

impl Design {
    /// All registers of a tile have one clock and one reset, those of a slice one enable; both halves of a slice are
    /// carry or neither is; a RAM takes slices A and B, what it is written by slice C, and its enable the reset, which
    /// then cannot be inverted.
    pub fn is_legal(&self, tile: usize) -> bool {
        let writes = self.slots.ram_writes[tile] != NONE;
        let kind = |at: usize| {
            let cell = self.slots.luts[tile * SLOTS + at];
            (cell != NONE).then(|| self.cells[cell as usize].kind)
        };
        let control = |at: usize| {
            let cell = self.slots.registers[tile * SLOTS + at];
            (cell != NONE).then(|| self.cells[cell as usize].control)
        };
        let mut common = None;
        let mut ram = false;
        for slice in 0..SLOTS / 2 {
            let kinds = [kind(2 * slice), kind(2 * slice + 1)];
            for kind in kinds.into_iter().flatten() {
                if (writes && slice == WRITES && kind != Kind::RamBlock)
                    || (kind == Kind::Ram && slice >= WRITES)
                {
                    return false;
                }
                ram |= kind == Kind::Ram;
            }
            if let [Some(low), Some(high)] = kinds
                && (low == Kind::Carry) != (high == Kind::Carry)
            {
                return false;
            }
            let controls = [control(2 * slice), control(2 * slice + 1)];
            for control in controls.into_iter().flatten() {
                if *common.get_or_insert(control.of_tile()) != control.of_tile() {
                    return false;
                }
            }
            if let [Some(low), Some(high)] = controls
                && low.of_slice() != high.of_slice()
            {
                return false;
            }
        }
        !(ram && common.is_some_and(|(.., reset_inverted)| reset_inverted))
    }

    /// Every tile is legal, a register is in the slot of its LUT, and a chain goes on in the next tile.
    ///
    /// # Errors
    /// The first cell or tile that is not so.
    pub fn check(&self) -> Result<(), String> {
        for tile in 0..self.slots.tiles() {
            if !self.is_legal(tile) {
                let (x, y) = self.slots.place_of(tile);
                return Err(format!("what stands in tile ({x}, {y}) does not fit together"));
            }
        }
        for arc in &self.arcs {
            let Some(from) = self.cells.get(self.nets[arc.net as usize].driver as usize) else { continue };
            let to = &self.cells[arc.to as usize];
            let place = (to.x - from.x, to.y - from.y, i16::from(to.slot) - i16::from(from.slot));
            let fits = match arc.port {
                super::design::Port::Di => place == (0, 0, 0),
                super::design::Port::Fci => place == (0, 0, 1) || place == (1, 0, 1 - SLOTS as i16),
                _ if from.kind == Kind::RamWrite => place.0 == 0 && place.1 == 0,
                _ => true,
            };
            if !fits {
                return Err(format!("{} is not beside {}", to.name, from.name));
            }
        }
        Ok(())
    }
}
