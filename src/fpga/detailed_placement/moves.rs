//! One step: a LUT, a register or both of a pair change places with what is in another slot.
//!
//! A register takes the reset of the tile that it comes to, and the enable of the slice, where those are
//! [copies](super::copies) of its own.

use super::cost::Marks;
use super::design::{Control, Design, Kind, NONE, Port, SLOTS};
use super::slots::Slot;

/// What was swapped, and what reads another copy since.
#[derive(Clone, Debug)]
pub struct Swap {
    a: Slot,
    b: Slot,
    luts: bool,
    registers: bool,
    /// Arcs with the nets that they were of.
    adopted: Vec<(u32, u32)>,
}

impl Design {
    /// Whether what is in a slot may go with a swap of the LUTs, the registers or both.
    fn may_swap(&self, slot: Slot, luts: bool, registers: bool) -> bool {
        let (lut, register) = (self.slots.luts[slot.index()], self.slots.registers[slot.index()]);
        let of = |cell: u32| self.cells.get(cell as usize);
        let lut_may = !luts || of(lut).is_none_or(|lut| lut.kind == Kind::Lut && (!lut.paired || registers));
        let behind_lut = of(lut).is_some_and(|lut| lut.kind == Kind::Lut);
        let register_may =
            !registers || of(register).is_none_or(|register| !register.paired || (luts && behind_lut));
        lut_may && register_may
    }

    /// Whether a cell stays where it is, or goes only with its tile.
    pub fn is_fixed(&self, cell: u32) -> bool {
        let content = &self.cells[cell as usize];
        match content.kind {
            Kind::Lut => false,
            Kind::Register => content.paired && self.behind(cell) != Some(Kind::Lut),
            _ => true,
        }
    }

    /// What a register is behind, in its slot.
    pub fn behind(&self, register: u32) -> Option<Kind> {
        let cell = &self.cells[register as usize];
        let slot = Slot { tile: self.slots.tile_of(cell)?, at: cell.slot.into() };
        self.cells.get(self.slots.luts[slot.index()] as usize).map(|lut| lut.kind)
    }

    /// Moves a cell, with what must go with it, to a slot, and what is there back; what that costs. Nothing where it
    /// cannot be.
    pub fn step(&mut self, cell: u32, to: Slot, marks: &mut Marks) -> Option<(Swap, f32)> {
        let content = &self.cells[cell as usize];
        let from = Slot { tile: self.slots.tile_of(content)?, at: content.slot.into() };
        let mut luts = content.paired || content.kind == Kind::Lut;
        let mut registers = content.paired || content.kind == Kind::Register;
        if from == to || !self.may_swap(from, luts, registers) {
            return None;
        }
        if !self.may_swap(to, luts, registers) {
            (luts, registers) = (true, true);
            if !self.may_swap(from, true, true) || !self.may_swap(to, true, true) {
                return None;
            }
        }
        let mut moved = [NONE; 4];
        let mut count = 0;
        for (wanted, list) in [(luts, &self.slots.luts), (registers, &self.slots.registers)] {
            for slot in [from, to] {
                if wanted && list[slot.index()] != NONE {
                    moved[count] = list[slot.index()];
                    count += 1;
                }
            }
        }
        let moved = &moved[..count];
        let mut swap = Swap { a: from, b: to, luts, registers, adopted: vec![] };
        let adopting = if registers { self.adopt(&mut swap) } else { 0.0 };
        let cost = |design: &Design, marks: &mut Marks| {
            design.around(moved, marks) + design.fullness(from.tile, to.tile)
        };
        let before = cost(self, marks);
        self.swap(from, to, luts, registers);
        if self.is_legal(from.tile) && self.is_legal(to.tile) {
            let after = cost(self, marks);
            return Some((swap, adopting + after - before));
        }
        self.undo(swap);
        None
    }

    /// Lets the registers of a swap read what those read that they come to; what that costs.
    fn adopt(&mut self, swap: &mut Swap) -> f32 {
        let mut costs = 0.0;
        for (from, to) in [(swap.a, swap.b), (swap.b, swap.a)] {
            let cell = self.slots.registers[from.index()];
            if cell == NONE {
                continue;
            }
            // What goes away counts no more.
            let control = |design: &Design, at: usize| {
                let other = design.slots.registers[to.tile * SLOTS + at];
                let stays = other != NONE && at != to.at && other != cell;
                stays.then(|| design.cells[other as usize].control)
            };
            let own = self.cells[cell as usize].control;
            let of_tile = (0..SLOTS).find_map(|at| control(self, at));
            let of_slice = control(self, to.at ^ 1);
            let reset = of_tile.map(|Control { reset, .. }| (Port::Lsr, own.reset, reset));
            let enable = of_slice.map(|Control { enable, .. }| (Port::Ce, own.enable, enable));
            for (port, own, theirs) in [reset, enable].into_iter().flatten() {
                let differ = own != theirs && own != NONE && theirs != NONE;
                if !(differ && self.are_copies(own, theirs) && self.takes(theirs, 1)) {
                    continue;
                }
                let pin = self.cells[cell as usize].pins.iter().find(|pin| pin.port == port);
                let Some(arc) = pin.map(|pin| pin.arc) else { continue };
                let cost = |design: &Design| design.wires(own) + design.wires(theirs) + design.lateness(arc);
                costs -= cost(self);
                self.redirect(arc, theirs);
                costs += cost(self);
                swap.adopted.push((arc, own));
            }
        }
        costs
    }

    pub fn undo(&mut self, Swap { a, b, luts, registers, adopted }: Swap) {
        self.swap(a, b, luts, registers);
        adopted.into_iter().rev().for_each(|(arc, net)| self.redirect(arc, net));
    }
}
