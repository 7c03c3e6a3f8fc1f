//! Every fault that a design can have, in the order of its cells.

use super::{Change, Fault, Target};
use crate::hdl::cell::{Bitwise, Cell, NodeId, Relation};
use crate::hdl::flat::{Flat, FlatNode};
use crate::hdl::simulate::Integers;

/// All faults of a design, in an order that depends on the design alone.
pub fn all(flat: &Flat) -> Vec<Fault> {
    let (zeros, constants, demands) = (zeros(flat), constants(flat), demands(flat));
    let list = List { flat, zeros, constants, demands, readers: readers(flat) };
    let mut faults = vec![];
    let live = live(flat);
    for id in (0..flat.nodes.len() as u32).map(NodeId).filter(|id| live[id.index()]) {
        for change in list.changes(id) {
            let (signal, place) = (list.signal(id), flat.node(id).place);
            faults.push(Fault { target: Target::Node(id), change, signal, place });
        }
    }
    for (index, memory) in flat.memories.iter().enumerate() {
        if let Some(write) = &memory.write {
            let place = flat.node(write.data).place;
            for always in [true, false] {
                let (target, signal) = (Target::Write(index), format!("{} (write)", memory.name));
                faults.push(Fault { target, change: Change::Enable(always), signal, place });
            }
        }
    }
    faults
}

struct List<'a> {
    flat: &'a Flat,
    zeros: Vec<u32>,
    constants: Vec<Option<i128>>,
    demands: Vec<u32>,
    readers: Vec<Vec<NodeId>>,
}

impl List<'_> {
    fn changes(&self, id: NodeId) -> Vec<Change> {
        let node = self.flat.node(id);
        let mut changes = vec![];
        if self.constants[id.index()].is_some() {
            return changes;
        }
        match &node.cell {
            Cell::Sum { terms, constant } => {
                let mut lowest: Vec<u32> =
                    terms.iter().map(|t| self.zeros[t.of.index()].saturating_add(t.shift)).collect();
                lowest.extend((*constant != 0).then(|| constant.trailing_zeros()));
                lowest.sort_unstable();
                if let Some(&second) = lowest.get(1) {
                    // A carry arises above the lowest bit that two operands have.
                    let width = node.word.width().min(self.demands[id.index()]);
                    changes.extend((second.saturating_add(1)..width).map(Change::Carry));
                }
                for (index, term) in terms.iter().enumerate() {
                    changes.push(Change::TermShift(index, term.shift + 1));
                    if term.shift > 0 {
                        changes.push(Change::TermShift(index, term.shift - 1));
                    }
                    changes.push(Change::TermSign(index));
                }
            }
            Cell::ShiftRight { of, amount, .. } => {
                if *amount + 1 < self.flat.node(*of).word.width() {
                    changes.push(Change::ShiftRight(amount + 1));
                }
                if *amount > 0 {
                    changes.push(Change::ShiftRight(amount - 1));
                }
            }
            Cell::Slice { of, low } => {
                if low + 1 + node.word.width() <= self.flat.node(*of).word.width() {
                    changes.push(Change::ShiftRight(low + 1));
                }
                if *low > 0 {
                    changes.push(Change::ShiftRight(low - 1));
                }
            }
            Cell::Select { .. } => changes.push(Change::Exchange),
            Cell::Compare { relation, .. } => {
                if matches!(relation, Relation::Less | Relation::LessOrEqual) {
                    changes.push(Change::Exchange);
                }
                changes.push(Change::Gate);
            }
            Cell::Concat { parts } => {
                let differ = |&first: &usize| parts[first] != parts[first + 1];
                changes.extend((0..parts.len().saturating_sub(1)).filter(differ).map(Change::Parts));
            }
            Cell::Logic { operands, .. } if operands.len() > 1 => {
                changes.push(Change::Gate);
            }
            Cell::Not { .. } => changes.push(Change::Gate),
            Cell::Register { enable, reset, .. } => {
                changes.extend(enable.iter().flat_map(|_| [true, false]).map(Change::Enable));
                changes.extend(reset.map(|value| Change::Reset(node.word.range.wrap(!value))));
            }
            Cell::MemoryRead { enable, .. } => {
                changes.extend(enable.iter().flat_map(|_| [true, false]).map(Change::Enable));
            }
            _ => {}
        }
        let wiring = matches!(
            node.cell,
            Cell::Input | Cell::Wire { .. } | Cell::Constant(_) | Cell::Wrap { .. } | Cell::Claim { .. }
        );
        if node.word.width() == 1 && !wiring {
            changes.extend([false, true].map(Change::Stuck));
        }
        changes
    }

    /// The name of the node, or of the nearest one behind it that has one.
    fn signal(&self, id: NodeId) -> String {
        let mut seen = vec![false; self.flat.nodes.len()];
        let mut open = std::collections::VecDeque::from([id]);
        while let Some(next) = open.pop_front() {
            if let Some(path) = &self.flat.nodes[next.index()].path {
                return if next == id { path.clone() } else { format!("{path} (on the way to it)") };
            }
            for &reader in &self.readers[next.index()] {
                if !std::mem::replace(&mut seen[reader.index()], true) {
                    open.push_back(reader);
                }
            }
        }
        self.flat.describe(id)
    }
}

/// For each node how many of its lowest bits are read by anybody.
fn demands(flat: &Flat) -> Vec<u32> {
    let mut demands = vec![0; flat.nodes.len()];
    let mut demand = |of: NodeId, bits: u32| {
        let width = flat.node(of).word.width();
        demands[of.index()] = demands[of.index()].max(bits.min(width));
    };
    for flat_node in &flat.nodes {
        let width = flat_node.node.word.width();
        match &flat_node.node.cell {
            Cell::Wrap { of } | Cell::Claim { of, .. } => demand(*of, width),
            Cell::Slice { of, low } => demand(*of, low + width),
            Cell::Sum { terms, .. } => terms.iter().for_each(|t| demand(t.of, width.saturating_sub(t.shift))),
            Cell::Register { next: Some(next), enable, .. } => {
                demand(*next, width);
                enable.iter().for_each(|&e| demand(e, 1));
            }
            cell => {
                let reads = cell.combinational_inputs().into_iter().chain(cell.clocked_inputs());
                reads.for_each(|of| demand(of, u32::MAX));
            }
        }
    }
    let writes = flat.memories.iter().filter_map(|m| m.write.as_ref());
    writes.for_each(|w| [w.enable, w.address, w.data].into_iter().for_each(|of| demand(of, u32::MAX)));
    flat.outputs.iter().for_each(|(_, id)| demand(*id, u32::MAX));
    demands
}

/// What a cell always carries, where constants alone decide it.
fn constants(flat: &Flat) -> Vec<Option<i128>> {
    let mut known: Vec<Option<i128>> = vec![None; flat.nodes.len()];
    let constant = |node: &FlatNode| match node.node.cell {
        Cell::Constant(value) => Some(value),
        _ => None,
    };
    flat.nodes.iter().zip(&mut known).for_each(|(node, value)| *value = constant(node));
    for &id in &flat.order {
        let at = |id: &NodeId| known[id.index()];
        let cell = &flat.node(id).cell;
        let decisive = match cell {
            Cell::Select { on_true, on_false, .. } if at(on_true) == at(on_false) => at(on_true),
            Cell::Logic { operation: Bitwise::And, operands } => {
                operands.iter().map(at).find(|value| *value == Some(0)).flatten()
            }
            Cell::Claim { .. } => None,
            _ if cell.combinational_inputs().iter().all(|id| at(id).is_some()) => {
                Some(Integers::evaluate_with(flat, id, |id| at(&id).unwrap_or(0)))
            }
            _ => None,
        };
        known[id.index()] = decisive;
    }
    known
}

fn readers(flat: &Flat) -> Vec<Vec<NodeId>> {
    let mut readers = vec![vec![]; flat.nodes.len()];
    for (index, flat_node) in flat.nodes.iter().enumerate() {
        let cell = &flat_node.node.cell;
        for read in cell.combinational_inputs().into_iter().chain(cell.clocked_inputs()) {
            readers[read.index()].push(NodeId(index as u32));
        }
    }
    readers
}

/// The nodes that an output depends on.
fn live(flat: &Flat) -> Vec<bool> {
    let mut live = vec![false; flat.nodes.len()];
    let mut open: Vec<NodeId> = flat.outputs.iter().map(|(_, id)| *id).collect();
    while let Some(id) = open.pop() {
        if std::mem::replace(&mut live[id.index()], true) {
            continue;
        }
        let cell = &flat.node(id).cell;
        match cell {
            // The condition of a claim is no hardware.
            Cell::Claim { of, .. } => open.push(*of),
            _ => open.extend(cell.combinational_inputs()),
        }
        open.extend(cell.clocked_inputs());
        if let Cell::MemoryRead { memory, .. } = cell
            && let Some(write) = &flat.memories[*memory].write
        {
            open.extend([write.enable, write.address, write.data]);
        }
    }
    live
}

/// For each node the number of its lowest bits that are always 0, whatever the inputs: the greatest
/// solution over all cells and registers.
fn zeros(flat: &Flat) -> Vec<u32> {
    const ALL: u32 = 128;
    let of_constant = |value: i128| if value == 0 { ALL } else { value.trailing_zeros() };
    let mut zeros = vec![ALL; flat.nodes.len()];
    loop {
        let mut changed = false;
        for (index, flat_node) in flat.nodes.iter().enumerate() {
            let at = |id: &NodeId| zeros[id.index()];
            let low = match &flat_node.node.cell {
                Cell::Constant(value) => of_constant(*value),
                Cell::Sum { terms, constant } => {
                    let terms = terms.iter().map(|t| at(&t.of).saturating_add(t.shift));
                    terms.chain([of_constant(*constant)]).min().unwrap_or(ALL)
                }
                Cell::Wrap { of } | Cell::Claim { of, .. } | Cell::Wire { driver: Some(of) } => at(of),
                Cell::Select { on_true, on_false, .. } => at(on_true).min(at(on_false)),
                Cell::Register { next: Some(next), reset, .. } => {
                    at(next).min(reset.map_or(ALL, of_constant))
                }
                _ => 0,
            };
            changed |= low < zeros[index];
            zeros[index] = zeros[index].min(low);
        }
        if !changed {
            return zeros;
        }
    }
}
