//! The cells a design is made of. This page is the specification: printer, simulator and prover all
//! follow it and decide nothing else.
//!
//! Every node has one cell and one [`Word`](super::Word). `value(x)` is the integer that node x carries.

use std::panic::Location;

use super::Word;

/// The index of a node in its module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

impl NodeId {
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// `± value(of) * 2^shift`, one line of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Term {
    pub negate: bool,
    pub shift: u32,
    pub of: NodeId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Bitwise {
    And,
    Or,
    Xor,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A port of the module.
    Input,
    /// A wire that was named before what drives it was built.
    Wire {
        driver: Option<NodeId>,
    },
    Constant(i128),
    /// `constant + sum of terms`; in a modular word, modulo 2^width. Never overflows otherwise: the
    /// word's range was derived from the terms.
    Sum {
        terms: Vec<Term>,
        constant: i128,
    },
    /// `value(left) * value(right)`; never overflows.
    Product {
        left: NodeId,
        right: NodeId,
    },
    /// `floor(value(of) / 2^amount)`. With `exact`, the dropped bits are to be proved zero.
    ShiftRight {
        of: NodeId,
        amount: u32,
        exact: bool,
    },
    /// The low bits of `of`, read in this node's word; an identity where the word is as wide or wider.
    Wrap {
        of: NodeId,
    },
    /// `value(of)`, with the obligation to prove that it lies in this node's range whenever `when` is 1.
    /// In hardware it is the same wiring as `Wrap`.
    Claim {
        of: NodeId,
        when: Option<NodeId>,
    },
    /// `condition ? on_true : on_false`.
    Select {
        condition: NodeId,
        on_true: NodeId,
        on_false: NodeId,
    },
    /// 1 where the relation holds between the numbers (not the bit patterns).
    Compare {
        relation: Relation,
        left: NodeId,
        right: NodeId,
    },
    /// Bit by bit, over unsigned words of one width.
    Logic {
        operation: Bitwise,
        operands: Vec<NodeId>,
    },
    /// Every bit inverted, of an unsigned word.
    Not {
        of: NodeId,
    },
    /// Bits `low .. low + width` of `of`, unsigned.
    Slice {
        of: NodeId,
        low: u32,
    },
    /// Bit strings side by side, the first one highest.
    Concat {
        parts: Vec<NodeId>,
    },
    /// Takes `value(next)` at a rising clock edge where `enable` is 1 (always, without one); takes
    /// `reset`, where it has one, at an edge where the reset is active, which wins over `enable`.
    Register {
        next: Option<NodeId>,
        enable: Option<NodeId>,
        reset: Option<i128>,
    },
    /// The word at `address` before the edge, taken at a rising clock edge where `enable` is 1. A word
    /// written at the same edge is not seen.
    MemoryRead {
        memory: usize,
        address: NodeId,
        enable: Option<NodeId>,
    },
    /// An output port of a module inside this one.
    InstanceOutput {
        instance: usize,
        port: usize,
    },
}

/// One node of the graph.
#[derive(Clone, Debug)]
pub struct Node {
    pub cell: Cell,
    pub word: Word,
    /// The name from the mathematics, where the author gave one.
    pub name: Option<String>,
    /// Clocks after the module's inputs of time 0; nothing for constants, which are of all times.
    pub time: Option<u32>,
    /// The Rust source line that built it.
    pub place: &'static Location<'static>,
}

impl Cell {
    /// What this cell needs to know within the clock; registers and memories answer from their state.
    pub fn combinational_inputs(&self) -> Vec<NodeId> {
        match self {
            Cell::Input | Cell::Constant(_) | Cell::Register { .. } | Cell::MemoryRead { .. } => vec![],
            Cell::InstanceOutput { .. } => vec![],
            Cell::Wire { driver } => driver.iter().copied().collect(),
            Cell::Sum { terms, .. } => terms.iter().map(|t| t.of).collect(),
            Cell::ShiftRight { of, .. } | Cell::Wrap { of } | Cell::Not { of } | Cell::Slice { of, .. } => {
                vec![*of]
            }
            Cell::Claim { of, when } => std::iter::once(*of).chain(*when).collect(),
            Cell::Select { condition, on_true, on_false } => vec![*condition, *on_true, *on_false],
            Cell::Compare { left, right, .. } | Cell::Product { left, right } => vec![*left, *right],
            Cell::Logic { operands, .. } => operands.clone(),
            Cell::Concat { parts } => parts.clone(),
        }
    }

    /// What the cell is a mere view of: some of its bits, or all of them read otherwise.
    pub fn wiring(&self) -> Option<NodeId> {
        match self {
            Cell::Slice { of, .. } | Cell::ShiftRight { of, .. } | Cell::Wrap { of } => Some(*of),
            _ => None,
        }
    }

    /// What this cell reads at the clock edge.
    pub fn clocked_inputs(&self) -> Vec<NodeId> {
        match self {
            Cell::Register { next, enable, .. } => next.iter().chain(enable).copied().collect(),
            Cell::MemoryRead { address, enable, .. } => std::iter::once(*address).chain(*enable).collect(),
            _ => vec![],
        }
    }

    /// Calls `change` on every node this cell refers to.
    pub fn visit_mut(&mut self, mut change: impl FnMut(&mut NodeId)) {
        match self {
            Cell::Input | Cell::Constant(_) | Cell::InstanceOutput { .. } => {}
            Cell::Wire { driver } => driver.iter_mut().for_each(change),
            Cell::Sum { terms, .. } => terms.iter_mut().for_each(|t| change(&mut t.of)),
            Cell::ShiftRight { of, .. } | Cell::Wrap { of } | Cell::Not { of } | Cell::Slice { of, .. } => {
                change(of)
            }
            Cell::Claim { of, when } => {
                change(of);
                when.iter_mut().for_each(change);
            }
            Cell::Select { condition, on_true, on_false } => {
                [condition, on_true, on_false].into_iter().for_each(change)
            }
            Cell::Compare { left, right, .. } | Cell::Product { left, right } => {
                [left, right].into_iter().for_each(change)
            }
            Cell::Logic { operands, .. } => operands.iter_mut().for_each(change),
            Cell::Concat { parts } => parts.iter_mut().for_each(change),
            Cell::Register { next, enable, .. } => next.iter_mut().chain(enable).for_each(change),
            Cell::MemoryRead { address, enable, .. } => {
                change(address);
                enable.iter_mut().for_each(change);
            }
        }
    }
}
