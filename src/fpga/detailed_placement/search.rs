//! The search: passes of moves that cost no more than before, each pass with slacks of its own.
//!
//! ```text
//!   6 of 10   an end of a late arc, towards its other end; the later the arc, the more often
//!   2 of 10   any cell, to the middle of its nets
//!   2 of 10   any cell, to a tile near by
//!   1 of 8    a reader of a register with copies reads another one
//!   1 of 64   a late arc's end flies with all its readers into free slots
//! ```
//!
//! Of the cells of a chain, one of 8 goes, and all its chain with it. That may cost something at first.

use super::Refined;
use super::cost::Marks;
use super::design::{Design, Kind, SLOTS};
use super::moves::Swap;
use super::slots::Slot;
use super::timing::Analysis;

const PASSES: u32 = 24;
/// Moves that are tried in a pass, for each cell.
const TRIES: usize = 14;
/// Tiles that a cell may go, along each axis, in the first pass and in later ones.
const FIRST_WIDTH: i32 = 12;
const LAST_WIDTH: i32 = 5;
/// Tiles around the place that a cell or a flock is to go to.
const SPREAD: i32 = 3;
/// The same around the middle of a cell's nets.
const HOME: i32 = 2;
/// What a chain's move may cost in the first passes: what it drives away finds better places of its own later.
const ADVANCE: f32 = 3.0;
const ADVANCING: u32 = PASSES / 2;
/// One of so many moves of chains clears its way.
const CLEARING: usize = 128;
/// Places that are tried for each cell in the way.
const CLEARED: usize = 6;
/// Slots that are looked at for each cell of a flock.
const LANDINGS: usize = 12;

/// Marsaglia's xorshift of 64 bits, with a multiplication behind it.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32
    }

    fn below(&mut self, bound: usize) -> usize {
        ((self.next() * bound as u64) >> 32) as usize
    }

    fn within(&mut self, most: i32) -> i32 {
        self.below(2 * most as usize + 1) as i32 - most
    }

    /// From 0 to 1.
    fn share(&mut self) -> f32 {
        (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    fn of(&mut self, list: &[u32]) -> Option<u32> {
        if list.is_empty() { None } else { Some(list[self.below(list.len())]) }
    }
}

/// What a step does with a cell that only goes with its chain.
#[derive(Clone, Copy, PartialEq)]
enum Chains {
    Stay,
    Swap,
    Clear,
}

pub struct Search {
    pub design: Design,
    marks: Marks,
    dice: Dice,
    /// Arcs from registers with copies: all, and those that are late.
    copied: Vec<u32>,
    copied_late: Vec<u32>,
    late: Vec<u32>,
    width: i32,
    advance: f32,
    /// Used again and again.
    edges: [Vec<i16>; 2],
}

impl Search {
    pub fn new(design: Design) -> Search {
        let has_copies = |arc: &u32| {
            let arc = &design.arcs[*arc as usize];
            design.nets[arc.net as usize].group > 0 && !arc.free
        };
        let copied = (0..design.arcs.len() as u32).filter(has_copies).collect();
        Search {
            marks: Marks::new(&design),
            dice: Dice(0x9e37_79b9_7f4a_7c15),
            copied,
            copied_late: vec![],
            late: vec![],
            width: FIRST_WIDTH,
            advance: 0.0,
            edges: [vec![], vec![]],
            design,
        }
    }

    /// All passes.
    pub fn run(&mut self, target: f32) -> Refined {
        let mut before = None;
        for pass in 0..PASSES {
            self.advance = if pass < ADVANCING { ADVANCE } else { 0.0 };
            let Analysis { longest, late } = self.design.analyse(target);
            before.get_or_insert(longest);
            if late.is_empty() {
                break;
            }
            self.late = late;
            let design = &self.design;
            let copied = |arc: &&u32| design.nets[design.arcs[**arc as usize].net as usize].group > 0;
            self.copied_late = self.late.iter().filter(copied).copied().collect();
            for number in 0..TRIES * self.design.cells.len() {
                self.one(number);
            }
            self.width = (self.width - 1).max(LAST_WIDTH);
        }
        let after = self.design.analyse(target).longest;
        Refined {
            longest_before_ns: before.unwrap_or(after).into(),
            longest_after_ns: after.into(),
            dealt_readers: 0,
        }
    }

    fn one(&mut self, number: usize) {
        if number % 64 == 5 {
            self.fly(number % 128 == 5);
        } else if number.is_multiple_of(8) && !self.copied.is_empty() {
            self.deal();
        } else {
            self.step(match number {
                _ if number % CLEARING == 9 => Chains::Clear,
                _ if number % 8 == 1 => Chains::Swap,
                _ => Chains::Stay,
            });
        }
    }

    /// An end of a late arc, and its other end.
    fn late_ends(&mut self) -> Option<(u32, u32)> {
        // The later the more often.
        let share = self.dice.share();
        let at = (share * share * self.late.len() as f32) as usize;
        let arc = &self.design.arcs[*self.late.get(at)? as usize];
        let ends = (self.design.nets[arc.net as usize].driver, arc.to);
        Some(if self.dice.below(2) == 0 { ends } else { (ends.1, ends.0) })
    }

    fn place_of(&self, cell: u32) -> (i32, i32) {
        let cell = &self.design.cells[cell as usize];
        (cell.x.into(), cell.y.into())
    }

    /// Some way from one cell to another.
    fn towards(&mut self, from: u32, to: u32) -> (i32, i32) {
        let ((x, y), (to_x, to_y)) = (self.place_of(from), self.place_of(to));
        let share = self.dice.share();
        let part = |from: i32, to: i32| ((to - from) as f32 * share) as i32;
        (part(x, to_x), part(y, to_y))
    }

    /// From a cell to where the wires to it would be the shortest: the middle of the edges of its nets.
    fn home(&mut self, cell: u32) -> (i32, i32) {
        let (x, y) = self.place_of(cell);
        let mut edges = std::mem::take(&mut self.edges);
        edges.iter_mut().for_each(Vec::clear);
        for pin in &self.design.cells[cell as usize].pins {
            if let Some(edges_of) = self.design.edges(pin.net, cell) {
                edges.iter_mut().zip(edges_of).for_each(|(edges, of)| edges.extend(of));
            }
        }
        let mut middle = |along: usize, here: i32| {
            let edges = &mut edges[along];
            edges.sort_unstable();
            edges.get(edges.len() / 2).map_or(0, |&middle| i32::from(middle) - here)
        };
        let home = (middle(0, x), middle(1, y));
        self.edges = edges;
        home
    }

    fn step(&mut self, chains: Chains) -> Option<()> {
        let late = self.dice.below(10) < 6;
        let (cell, (dx, dy), spread) = match late.then(|| self.late_ends()).flatten() {
            Some((cell, other)) => (cell, self.towards(cell, other), SPREAD),
            None => {
                let cell = self.dice.below(self.design.cells.len()) as u32;
                match self.dice.below(2) == 0 {
                    true => (cell, self.home(cell), HOME),
                    false => (cell, (0, 0), self.width),
                }
            }
        };
        let content = &self.design.cells[cell as usize];
        if !content.kind.in_tile() {
            return None;
        }
        let (x, y) = (i32::from(content.x) + dx, i32::from(content.y) + dy);
        let to = self.design.slots.tile(x + self.dice.within(spread), y + self.dice.within(spread))?;
        if self.design.is_fixed(cell) {
            let from = self.design.slots.tile_of(&self.design.cells[cell as usize])?;
            if chains != Chains::Stay && from != to {
                self.move_chain(from, to, chains == Chains::Clear);
            }
            return None;
        }
        let slot = Slot { tile: to, at: self.dice.below(SLOTS) };
        let (swap, more) = self.design.step(cell, slot, &mut self.marks)?;
        if more > 0.0 {
            self.design.undo(swap);
        }
        None
    }

    /// A chain goes to the tiles from another one on. What it drives away goes where the chain was, or, where it is
    /// to `clear` its way, to places of its own.
    fn move_chain(&mut self, from: usize, to: usize, clear: bool) -> Option<()> {
        let spans = self.design.spans(from, to)?;
        let mut more = self.design.move_spans(spans, &mut self.marks);
        let mut done: Vec<Swap> = vec![];
        let away = if clear && more > 0.0 { self.design.driven_away(spans) } else { vec![] };
        let ((from_x, from_y), (to_x, to_y)) =
            (self.design.slots.place_of(spans.from), self.design.slots.place_of(spans.to));
        let back = (i32::from(to_x - from_x), i32::from(to_y - from_y));
        for cell in away {
            for number in 0..CLEARED {
                let (dx, dy) = if number % 2 == 0 { self.home(cell) } else { back };
                let (x, y) = self.place_of(cell);
                let (near_x, near_y) = (self.dice.within(SPREAD), self.dice.within(SPREAD));
                let at = self.dice.below(SLOTS);
                let Some(tile) = self.design.slots.tile(x + dx + near_x, y + dy + near_y) else { continue };
                let Some((swap, costs)) = self.design.step(cell, Slot { tile, at }, &mut self.marks) else {
                    continue;
                };
                if costs < 0.0 {
                    done.push(swap);
                    more += costs;
                    break;
                }
                self.design.undo(swap);
            }
        }
        if more > self.advance {
            done.into_iter().rev().for_each(|swap| self.design.undo(swap));
            self.design.swap_spans(spans);
        }
        None
    }

    fn deal(&mut self) -> Option<()> {
        let late = self.dice.below(2) == 0 && !self.copied_late.is_empty();
        let arc = self.dice.of(if late { &self.copied_late } else { &self.copied })?;
        let group = self.design.nets[self.design.arcs[arc as usize].net as usize].group;
        let to = self.dice.of(&self.design.groups[group as usize])?;
        self.design.deal(arc, to);
        None
    }

    fn fly(&mut self, wide: bool) -> Option<()> {
        let (cell, other) = self.late_ends()?;
        let flock = self.design.flock(cell, other, wide);
        let (dx, dy) = self.towards(cell, other);
        if flock.len() < 2 || (dx, dy) == (0, 0) {
            return None;
        }
        let mut done: Vec<Swap> = vec![];
        let mut more = 0.0;
        for &cell in &flock {
            if self.design.is_fixed(cell) {
                continue;
            }
            let (x, y) = self.place_of(cell);
            for _ in 0..LANDINGS {
                let (near_x, near_y) = (self.dice.within(SPREAD), self.dice.within(SPREAD));
                let at = self.dice.below(SLOTS);
                let Some(tile) = self.design.slots.tile(x + dx + near_x, y + dy + near_y) else { continue };
                if !self.is_free(cell, Slot { tile, at }) {
                    continue;
                }
                if let Some((swap, costs)) = self.design.step(cell, Slot { tile, at }, &mut self.marks) {
                    done.push(swap);
                    more += costs;
                    break;
                }
            }
        }
        if more >= 0.0 {
            done.into_iter().rev().for_each(|swap| self.design.undo(swap));
        }
        None
    }

    /// Whether a cell, with what goes with it, could stand in a slot beside what is there.
    fn is_free(&self, cell: u32, slot: Slot) -> bool {
        let content = &self.design.cells[cell as usize];
        let slots = &self.design.slots;
        let empty = |list: &[u32]| list[slot.index()] == super::design::NONE;
        (content.kind != Kind::Register && !content.paired || empty(&slots.registers))
            && (content.kind != Kind::Lut && !content.paired || empty(&slots.luts))
    }
}
