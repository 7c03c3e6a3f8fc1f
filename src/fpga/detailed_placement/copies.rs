//! Registers that always hold the same: who reads which.
//!
//! ```text
//!   q  ──► r1, r2 far from it       q  ──► r1, r3
//!   q' ──► r3 far from it, r4   ─►  q' ──► r2, r4
//! ```
//!
//! Before placement, readers are dealt to the copies of a register by their names.

use super::design::{Design, Kind, NONE, Port, SLOTS};

/// Readers that a copy may have.
const MOST_READERS: usize = 48;

impl Design {
    /// Lets the reader at the end of an arc, and those that must read the same, read another net, if that costs no more.
    pub fn deal(&mut self, arc: u32, to: u32) {
        let from = self.arcs[arc as usize].net;
        let together = self.together(arc);
        if from == to || !self.takes(to, together.len()) {
            return;
        }
        let cost = |design: &Design| {
            let late: f32 = together.iter().map(|&arc| design.lateness(arc)).sum();
            design.wires(from) + design.wires(to) + late
        };
        let before = cost(self);
        together.iter().for_each(|&arc| self.redirect(arc, to));
        if cost(self) > before {
            together.iter().for_each(|&arc| self.redirect(arc, from));
        }
    }

    /// The arcs that read one net as they share a pin of the device: a reset in a tile, an enable in a slice.
    fn together(&self, arc: u32) -> Vec<u32> {
        let content = &self.arcs[arc as usize];
        let cell = &self.cells[content.to as usize];
        let Some(tile) = self.slots.tile_of(cell) else { return vec![arc] };
        let all = tile * SLOTS..(tile + 1) * SLOTS;
        let slice = usize::from(cell.slot / 2 * 2);
        let cells = match (cell.kind, content.port) {
            (Kind::Register, Port::Lsr) => &self.slots.registers[all],
            (Kind::Register, Port::Ce) => &self.slots.registers[all.start + slice..all.start + slice + 2],
            (Kind::Ram, Port::Wre) => &self.slots.luts[all],
            _ => return vec![arc],
        };
        let pins =
            cells.iter().filter(|&&cell| cell != NONE).flat_map(|&cell| &self.cells[cell as usize].pins);
        pins.filter(|pin| pin.port == content.port && pin.net == content.net).map(|pin| pin.arc).collect()
    }

    /// Whether two nets always hold the same.
    pub fn are_copies(&self, a: u32, b: u32) -> bool {
        let group = self.nets[a as usize].group;
        group > 0 && group == self.nets[b as usize].group
    }

    /// Whether a net may have so many readers more.
    pub fn takes(&self, net: u32, more: usize) -> bool {
        self.nets[net as usize].arcs.len() + more <= MOST_READERS
    }

    /// Lets the reader at the end of an arc read another net.
    pub fn redirect(&mut self, arc: u32, to: u32) {
        let from = std::mem::replace(&mut self.arcs[arc as usize].net, to);
        let arcs = &mut self.nets[from as usize].arcs;
        if let Some(at) = arcs.iter().position(|&other| other == arc) {
            arcs.swap_remove(at);
        }
        self.nets[to as usize].arcs.push(arc);
        let port = self.arcs[arc as usize].port;
        let cell = &mut self.cells[self.arcs[arc as usize].to as usize];
        cell.pins.iter_mut().filter(|pin| pin.arc == arc).for_each(|pin| pin.net = to);
        if cell.kind == Kind::Register {
            match port {
                Port::Lsr => cell.control.reset = to,
                Port::Ce => cell.control.enable = to,
                _ => {}
            }
        }
    }
}
