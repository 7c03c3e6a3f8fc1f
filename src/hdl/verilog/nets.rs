//! Which nodes of a module become nets of their own, under which names, and which of their bits are read.
//!
//! Slices, shifts, wraps and claims are wiring: where they have no name they are printed as part selects
//! of what they read. An unnamed operation that is read once, whole, is printed inside its reader. All
//! else is a net.

use std::collections::BTreeMap;

use crate::hdl::cell::{Cell, NodeId};
use crate::hdl::live::Live;
use crate::hdl::module::{Direction, Memory, Module};
use crate::hdl::names::Allocator;

/// Bits `low .. low + width` of a net, read as a number.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    pub base: NodeId,
    pub low: u32,
    pub width: u32,
    pub signed: bool,
}

pub struct Nets {
    names: BTreeMap<NodeId, String>,
    /// Bit i is set where somebody reads bit i of the net.
    read: BTreeMap<NodeId, u128>,
}

impl Nets {
    pub fn new(module: &Module) -> Nets {
        let mut nets = Nets { names: BTreeMap::new(), read: BTreeMap::new() };
        let mut demands = Demands::new(module);
        demands.gather();
        let mut scope = Allocator::default();
        for port in ["aclk", "aresetn"] {
            scope.allocate(port);
        }
        module.buses.iter().for_each(|b| drop(scope.allocate(&b.name)));
        module.outputs.iter().for_each(|o| drop(scope.allocate(&o.name)));
        module.memories.iter().for_each(|m| drop(scope.allocate(&m.name)));
        module.instances.iter().for_each(|i| drop(scope.allocate(&i.name)));
        for (index, node) in module.nodes.iter().enumerate() {
            if let Some(name) = &node.name {
                scope.allocate(name);
                // A constant is a literal wherever it is read.
                if !matches!(node.cell, Cell::Constant(_)) {
                    nets.names.insert(NodeId(index as u32), name.clone());
                }
            }
        }
        for (index, node) in module.nodes.iter().enumerate() {
            let id = NodeId(index as u32);
            if node.name.is_none() && demands.needs_net(id) {
                let wanted = match &demands.reader[index] {
                    Some(reader) => format!("{reader}_{}", kind(&node.cell)),
                    None => format!("{}_{}", module.name, kind(&node.cell)),
                };
                nets.names.insert(id, scope.allocate(&wanted));
            }
        }
        for (reader, id, low, width) in std::mem::take(&mut demands.reads) {
            // Wiring without a name reads nothing itself; whoever reads through it does.
            let transparent = |id: NodeId| !nets.names.contains_key(&id) && is_wiring(&module.node(id).cell);
            if reader.is_some_and(transparent) {
                continue;
            }
            if let Some(span) = nets.span(module, id) {
                let width = width.min(span.width.saturating_sub(low));
                let mask = if width >= 128 { u128::MAX } else { (1 << width) - 1 };
                *nets.read.entry(span.base).or_default() |= mask << (span.low + low);
            }
        }
        nets
    }

    pub fn name(&self, id: NodeId) -> Option<&str> {
        self.names.get(&id).map(String::as_str)
    }

    pub fn is_read(&self, id: NodeId) -> bool {
        self.read.contains_key(&id)
    }

    /// The bits of the net that nobody reads, as (high, low) pairs.
    pub fn unread(&self, module: &Module, id: NodeId) -> Vec<(u32, u32)> {
        let (width, read) = (module.node(id).word.width(), self.read.get(&id).copied().unwrap_or(0));
        let mut gaps: Vec<(u32, u32)> = vec![];
        for bit in (0..width).filter(|bit| read >> bit & 1 == 0) {
            match gaps.last_mut() {
                Some((high, _)) if *high + 1 == bit => *high = bit,
                _ => gaps.push((bit, bit)),
            }
        }
        gaps
    }

    /// The number that a node always carries: a constant, seen through wiring that has no name.
    pub fn constant(&self, module: &Module, id: NodeId) -> Option<i128> {
        if self.names.contains_key(&id) {
            return None;
        }
        let node = module.node(id);
        match &node.cell {
            Cell::Constant(value) => Some(*value),
            Cell::ShiftRight { of, amount, .. } => {
                let word = module.node(*of).word;
                match self.constant(module, *of) {
                    Some(value) => Some(value >> amount),
                    // Without a sign nothing is left behind the highest bit.
                    None => (*amount >= word.width() && !word.is_signed()).then_some(0),
                }
            }
            Cell::Slice { of, low } => Some(node.word.range.wrap(self.constant(module, *of)? >> low)),
            Cell::Wrap { of } | Cell::Claim { of, .. } => {
                Some(node.word.range.wrap(self.constant(module, *of)?))
            }
            _ => None,
        }
    }

    /// The node as a part of a net; nothing for a constant, an inlined operation or a widening.
    pub fn span(&self, module: &Module, id: NodeId) -> Option<Span> {
        let node = module.node(id);
        let (width, signed) = (node.word.width(), node.word.is_signed());
        if self.names.contains_key(&id) {
            return Some(Span { base: id, low: 0, width, signed });
        }
        let (of, low) = match &node.cell {
            Cell::Slice { of, low } => (*of, *low),
            Cell::ShiftRight { of, amount, .. } => (*of, *amount),
            Cell::Wrap { of } | Cell::Claim { of, .. } => (*of, 0),
            Cell::Wire { driver: Some(driver) } => (*driver, 0),
            _ => return None,
        };
        if self.constant(module, id).is_some() {
            return None;
        }
        let inner = self.span(module, of)?;
        // Shifting everything out leaves the sign.
        let low = low.min(inner.width - 1);
        (low + width <= inner.width).then_some(Span { base: inner.base, low: inner.low + low, width, signed })
    }
}

fn is_wiring(cell: &Cell) -> bool {
    matches!(cell, Cell::Slice { .. } | Cell::ShiftRight { .. } | Cell::Wrap { .. } | Cell::Claim { .. })
}

/// How the name of an unnamed operation ends.
fn kind(cell: &Cell) -> &'static str {
    match cell {
        Cell::Sum { .. } => "sum",
        Cell::Product { .. } => "product",
        Cell::Select { .. } => "choice",
        Cell::Compare { .. } => "compared",
        Cell::Concat { .. } => "joined",
        Cell::Not { .. } => "inverted",
        Cell::Logic { .. } => "condition",
        _ => "bits",
    }
}

/// Who reads what of each node.
struct Demands<'a> {
    module: &'a Module,
    /// (reader, node, low, width): a read of these bits; ports and instances have no node.
    reads: Vec<(Option<NodeId>, NodeId, u32, u32)>,
    /// The cell whose reads are being gathered.
    current: Option<NodeId>,
    count: Vec<u32>,
    /// Somebody reads less than all of it, or more than its width.
    partial: Vec<bool>,
    /// The name of the first named node that reads it.
    reader: Vec<Option<String>>,
}

impl<'a> Demands<'a> {
    fn new(module: &'a Module) -> Self {
        let n = module.nodes.len();
        Demands {
            module,
            reads: vec![],
            current: None,
            count: vec![0; n],
            partial: vec![false; n],
            reader: vec![None; n],
        }
    }

    fn gather(&mut self) {
        let module = self.module;
        let live = Live::of(module);
        for (index, node) in module.nodes.iter().enumerate().rev() {
            if live.nodes[index] {
                self.current = Some(NodeId(index as u32));
                self.gather_cell(NodeId(index as u32), &node.cell, node.word.width());
            }
        }
        self.current = None;
        for output in &module.outputs {
            self.read_whole(output.node, None);
        }
        for bus in module.buses.iter().filter(|b| b.direction == Direction::Output) {
            for lane in &bus.lanes {
                // Sign extension over the lane reads the top bit as a part select.
                self.partial[module.outputs[lane.port].node.index()] = true;
            }
        }
        for instance in &module.instances {
            for &input in &instance.inputs {
                self.read_whole(input, Some(&instance.name));
            }
        }
        for (memory, _) in module.memories.iter().zip(&live.memories).filter(|(_, live)| **live) {
            if let Some(write) = &memory.write {
                for id in [write.enable, write.data] {
                    self.read_whole(id, Some(&memory.name));
                }
                self.read_index(write.address, memory, Some(&memory.name));
            }
        }
    }

    fn gather_cell(&mut self, id: NodeId, cell: &Cell, width: u32) {
        let name = self.module.node(id).name.clone().or_else(|| self.reader[id.index()].clone());
        let name = name.as_deref();
        match cell {
            Cell::Sum { terms, .. } => {
                for term in terms.iter().filter(|term| term.shift < width) {
                    let own = self.module.node(term.of).word.width();
                    self.read(term.of, 0, own.min(width - term.shift), term.shift > 0 || own != width, name);
                }
            }
            Cell::ShiftRight { of, amount, .. } => self.read(*of, *amount, width, true, name),
            Cell::Slice { of, low } => self.read(*of, *low, width, true, name),
            Cell::Wrap { of } | Cell::Claim { of, .. } => {
                let own = self.module.node(*of).word.width();
                // Whoever reads through a wrap that has no name reads what it wraps.
                let through = self.module.node(id).name.is_none()
                    && (self.partial[id.index()] || self.count[id.index()] > 1);
                self.read(*of, 0, width.min(own), own != width || through, name);
            }
            Cell::Select { condition, on_true, on_false } => {
                self.read_whole(*condition, name);
                for of in [on_true, on_false] {
                    let own = self.module.node(*of).word.width();
                    self.read(*of, 0, own.min(width), own != width, name);
                }
            }
            Cell::Compare { left, right, .. } => {
                let widths = [left, right].map(|id| self.module.node(*id).word);
                let mixed =
                    widths[0].width() != widths[1].width() || widths[0].is_signed() != widths[1].is_signed();
                for of in [left, right] {
                    self.read(*of, 0, self.module.node(*of).word.width(), mixed, name);
                }
            }
            // The operands are extended to the width of the product, or cut: times zero, only one bit is left.
            Cell::Product { left, right } => {
                for &of in [left, right] {
                    self.read(of, 0, self.module.node(of).word.width().min(width), true, name);
                }
            }
            Cell::Logic { operands, .. } => operands.iter().for_each(|&o| self.read_whole(o, name)),
            Cell::Concat { parts } => parts.iter().for_each(|&p| self.read_whole(p, name)),
            Cell::Not { of } => self.read_whole(*of, name),
            Cell::Wire { driver } => driver.iter().for_each(|&d| self.read_whole(d, name)),
            Cell::Register { next, enable, .. } => {
                if let Some(next) = next {
                    let own = self.module.node(*next).word.width();
                    self.read(*next, 0, own.min(width), own != width, name);
                }
                enable.iter().for_each(|&e| self.read_whole(e, name));
            }
            Cell::MemoryRead { memory, address, enable } => {
                self.read_index(*address, &self.module.memories[*memory], name);
                enable.iter().for_each(|&e| self.read_whole(e, name));
            }
            Cell::Input | Cell::Constant(_) | Cell::InstanceOutput { .. } => {}
        }
    }

    fn read_whole(&mut self, id: NodeId, reader: Option<&str>) {
        self.read(id, 0, self.module.node(id).word.width(), false, reader);
    }

    /// An index is extended to the bits that the last word needs.
    fn read_index(&mut self, id: NodeId, memory: &Memory, reader: Option<&str>) {
        let own = self.module.node(id).word.width();
        self.read(id, 0, own, own != memory.index_width(), reader);
    }

    fn read(&mut self, id: NodeId, low: u32, width: u32, partial: bool, reader: Option<&str>) {
        self.reads.push((self.current, id, low, width));
        self.count[id.index()] += 1;
        self.partial[id.index()] |= partial;
        let slot = &mut self.reader[id.index()];
        if slot.is_none() {
            *slot = reader.map(String::from);
        }
    }

    fn needs_net(&self, id: NodeId) -> bool {
        let (count, partial) = (self.count[id.index()], self.partial[id.index()]);
        let node = self.module.node(id);
        match &node.cell {
            _ if count == 0 => false,
            Cell::Constant(_) | Cell::Slice { .. } | Cell::ShiftRight { .. } => false,
            // A wrap to a wider word is an extension, which cannot be a part select.
            Cell::Wrap { of } | Cell::Claim { of, .. } => {
                node.word.width() > self.module.node(*of).word.width()
            }
            _ => count > 1 || partial,
        }
    }
}
