//! Which bits of each word synthesis keeps: those that are read, not always 0, and no copies of the sign.
//!
//! ```text
//!   s s s s x x x x x 0 0      read: 9 low bits; zeros: 2; all above 8 are copies: kept are 6
//! ```

use crate::hdl::{Bitwise, Cell, Flat, NodeId};

/// The bits of each node.
pub(super) struct Kept {
    /// How many low bits are read.
    pub read: Vec<u32>,
    /// How many low bits are always 0.
    pub zeros: Vec<u32>,
    /// Beyond how many low bits all are copies of the last one.
    pub signed: Vec<u32>,
}

impl Kept {
    pub fn of(flat: &Flat) -> Kept {
        let width = |id: usize| flat.nodes[id].node.word.width();
        let signed = grown(flat, |known, id| signed_of(flat, known, id), (0..flat.nodes.len()).map(width));
        let zeros = grown(flat, |known, id| zeros_of(flat, known, id), flat.nodes.iter().map(|_| 0));
        Kept { read: needed(flat), zeros, signed }
    }

    pub fn bits(&self, id: NodeId) -> u32 {
        self.read[id.index()].min(self.signed[id.index()]).saturating_sub(self.zeros[id.index()])
    }
}

/// What is known of every node, from what is known of those that it reads, until nothing more is learnt. What only a
/// loop keeps up is not found, as synthesis does not find it.
fn grown(flat: &Flat, found: impl Fn(&[u32], NodeId) -> u32, first: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut known: Vec<u32> = first.collect();
    loop {
        let mut changed = false;
        for id in flat.order.iter().chain(&flat.clocked) {
            let found = found(&known, *id).min(flat.node(*id).word.width());
            changed |= found != known[id.index()];
            known[id.index()] = found;
        }
        if !changed {
            return known;
        }
    }
}

/// Low bits of which all others are copies.
fn signed_of(flat: &Flat, signed: &[u32], id: NodeId) -> u32 {
    let of = |id: &NodeId| signed[id.index()];
    match &flat.node(id).cell {
        Cell::Wrap { of: inner } | Cell::Claim { of: inner, .. } | Cell::Wire { driver: Some(inner) } => {
            // Above a number without sign there are zeros.
            of(inner) + u32::from(!flat.node(*inner).word.is_signed())
        }
        Cell::ShiftRight { of: inner, amount: low, .. } | Cell::Slice { of: inner, low } => {
            of(inner).saturating_sub(*low).max(1)
        }
        Cell::Select { on_true, on_false, .. } => of(on_true).max(of(on_false)),
        Cell::Register { next: Some(next), .. } => of(next),
        _ => u32::MAX,
    }
}

/// Low bits that are 0 whatever comes in.
fn zeros_of(flat: &Flat, zeros: &[u32], id: NodeId) -> u32 {
    let of = |id: &NodeId| zeros[id.index()];
    let number = |value: i128| if value == 0 { ALL } else { value.trailing_zeros() };
    match &flat.node(id).cell {
        Cell::Constant(value) => number(*value),
        Cell::Sum { terms, constant } => {
            terms.iter().map(|term| term.shift + of(&term.of)).fold(number(*constant), u32::min)
        }
        Cell::Product { left, right } => of(left) + of(right),
        Cell::ShiftRight { of: inner, amount: low, .. } | Cell::Slice { of: inner, low } => {
            of(inner).saturating_sub(*low)
        }
        Cell::Wrap { of: inner } | Cell::Claim { of: inner, .. } => of(inner),
        Cell::Wire { driver: Some(driver) } => of(driver),
        Cell::Select { on_true, on_false, .. } => of(on_true).min(of(on_false)),
        Cell::Logic { operation: Bitwise::And, operands } => operands.iter().map(of).max().unwrap_or(0),
        Cell::Logic { operands, .. } => operands.iter().map(of).min().unwrap_or(0),
        Cell::Concat { parts } => {
            let mut low = 0;
            for part in parts.iter().rev() {
                low += of(part);
                if of(part) < flat.node(*part).word.width() {
                    break;
                }
            }
            low
        }
        Cell::Register { next: Some(next), reset, .. } => of(next).min(reset.map_or(ALL, number)),
        _ => 0,
    }
}

/// How many low bits of each node are read.
fn needed(flat: &Flat) -> Vec<u32> {
    let mut reads = Reads { flat, needed: vec![0; flat.nodes.len()], open: vec![] };
    for (_, id) in &flat.outputs {
        reads.read(*id, ALL);
    }
    while let Some(id) = reads.open.pop() {
        reads.follow(id);
    }
    reads.needed
}

/// More bits than any word has.
const ALL: u32 = u32::MAX / 2;

struct Reads<'a> {
    flat: &'a Flat,
    needed: Vec<u32>,
    /// Nodes of which more is read than was followed.
    open: Vec<NodeId>,
}

impl Reads<'_> {
    fn read(&mut self, id: NodeId, bits: u32) {
        let bits = bits.min(self.flat.node(id).word.width());
        if bits > self.needed[id.index()] {
            self.needed[id.index()] = bits;
            self.open.push(id);
        }
    }

    /// Reads what a node is made from.
    fn follow(&mut self, id: NodeId) {
        let (flat, bits) = (self.flat, self.needed[id.index()]);
        match &flat.node(id).cell {
            Cell::Input | Cell::Constant(_) | Cell::InstanceOutput { .. } => {}
            Cell::Wire { driver } => driver.iter().for_each(|of| self.read(*of, bits)),
            Cell::Sum { terms, .. } => {
                terms.iter().for_each(|term| self.read(term.of, bits.saturating_sub(term.shift)));
            }
            Cell::Product { left, right } => [left, right].iter().for_each(|of| self.read(**of, bits)),
            Cell::ShiftRight { of, amount: low, .. } | Cell::Slice { of, low } => self.read(*of, bits + low),
            Cell::Wrap { of } | Cell::Claim { of, .. } | Cell::Not { of } => self.read(*of, bits),
            Cell::Select { condition, on_true, on_false } => {
                self.read(*condition, 1);
                [on_true, on_false].iter().for_each(|of| self.read(**of, bits));
            }
            Cell::Compare { left, right, .. } => [left, right].iter().for_each(|of| self.read(**of, ALL)),
            Cell::Logic { operands, .. } => operands.iter().for_each(|of| self.read(*of, bits)),
            Cell::Concat { parts } => {
                let mut low = 0;
                for part in parts.iter().rev() {
                    self.read(*part, bits.saturating_sub(low));
                    low += flat.node(*part).word.width();
                }
            }
            Cell::Register { next, enable, .. } => {
                next.iter().for_each(|of| self.read(*of, bits));
                enable.iter().for_each(|of| self.read(*of, 1));
            }
            Cell::MemoryRead { memory, address, enable } => {
                self.read(*address, ALL);
                enable.iter().for_each(|of| self.read(*of, 1));
                if let Some(write) = &flat.memories[*memory].write {
                    [write.enable, write.address, write.data].iter().for_each(|of| self.read(*of, ALL));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn zeros_come_through_sums_and_registers_and_only_what_is_read_counts() {
        let m = Builder::new("m");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(8)));
        let sum = m.pipe("sum", 4 * &a + 12 * &b);
        m.output("y", m.slice(&sum, 0, 7));
        let flat = Flat::new(&m.finish().unwrap()).unwrap();
        let kept = Kept::of(&flat);
        let register = flat.clocked[0];
        assert_eq!((kept.read[register.index()], kept.zeros[register.index()]), (7, 2));
        assert_eq!(kept.bits(register), 5);
    }

    #[test]
    fn copies_of_the_sign_are_one_bit() {
        let m = Builder::new("m");
        let a = m.input("a", Word::signed(6));
        let wide = m.wrap(&a, Word::signed(14));
        let high = m.pipe("high", m.slice(&wide, 8, 6));
        m.output("y", &high);
        let flat = Flat::new(&m.finish().unwrap()).unwrap();
        assert_eq!(Kept::of(&flat).bits(flat.clocked[0]), 1);
    }
}
