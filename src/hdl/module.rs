//! A finished module: plain data that passes, printers, simulators and provers walk.

use std::rc::Rc;

use super::cell::{Cell, Node, NodeId};
use super::live::Live;
use crate::fixed::Range;

/// A memory with one synchronous read port for each [`Cell::MemoryRead`] and at most one write port.
#[derive(Clone, Debug)]
pub struct Memory {
    pub name: String,
    pub depth: u32,
    pub word: super::Word,
    /// What it holds before the first clock; a memory that is never written is a ROM.
    pub contents: Vec<i128>,
    pub write: Option<MemoryWrite>,
    pub made_of: MadeOf,
    /// No word is read at the edge at which it is written; a simulator gives such a read an unset word.
    pub apart: bool,
}

/// What synthesis makes a memory of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MadeOf {
    /// As it likes.
    #[default]
    Any,
    LookupTables,
    BlockRam,
}

/// At a rising clock edge where `enable` is 1, `data` goes to `address`.
#[derive(Clone, Debug)]
pub struct MemoryWrite {
    pub enable: NodeId,
    pub address: NodeId,
    pub data: NodeId,
}

impl Memory {
    /// The bits of the address of its last word.
    pub fn index_width(&self) -> u32 {
        Range::new(0, i128::from(self.depth.max(1)) - 1).width()
    }
}

impl MemoryWrite {
    pub fn nodes_mut(&mut self) -> impl Iterator<Item = &mut NodeId> {
        [&mut self.enable, &mut self.address, &mut self.data].into_iter()
    }
}

/// A module inside a module; `inputs` in the order of the inner module's inputs.
#[derive(Clone, Debug)]
pub struct Instance {
    pub name: String,
    pub module: Rc<Module>,
    pub inputs: Vec<NodeId>,
}

/// An output port.
#[derive(Clone, Debug)]
pub struct Output {
    pub name: String,
    pub node: NodeId,
}

/// Several ports that the outside sees as one wide one, such as the lanes of a stream's `tdata`.
#[derive(Clone, Debug)]
pub struct Bus {
    pub name: String,
    pub direction: Direction,
    pub width: u32,
    pub lanes: Vec<Lane>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    Input,
    Output,
}

/// One port within a bus: its index among the module's inputs or outputs, its lowest bit, its room. An
/// output is sign-extended over the room; the spare bits of an input are ignored.
#[derive(Clone, Debug)]
pub struct Lane {
    pub port: usize,
    pub low: u32,
    pub room: u32,
}

/// One module of a design, its parameters fixed.
#[derive(Clone, Debug)]
pub struct Module {
    pub name: String,
    /// What it is for, line by line: the head of the emitted file.
    pub purpose: Vec<String>,
    pub parameters: Vec<(String, String)>,
    /// Whether synthesis is asked to leave it a module, so that its registers are not shared with other instances.
    pub separate: bool,
    pub nodes: Vec<Node>,
    pub inputs: Vec<NodeId>,
    pub outputs: Vec<Output>,
    pub buses: Vec<Bus>,
    pub memories: Vec<Memory>,
    pub instances: Vec<Instance>,
    /// Registers that synthesis is not to merge with others of the same value.
    pub copies: std::collections::BTreeSet<NodeId>,
}

impl Module {
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|&id| self.node(id).name.as_deref() == Some(name))
    }

    pub fn output(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|o| o.name == name)
    }

    /// Clocks from the inputs of time 0 to this output.
    pub fn latency(&self, output: &Output) -> u32 {
        self.node(output.node).time.unwrap_or(0)
    }

    /// Whether anything in it or below it that somebody needs is clocked, and whether anything is reset.
    pub fn needs_clock(&self) -> bool {
        self.needed().any(|n| matches!(n.cell, Cell::Register { .. } | Cell::MemoryRead { .. }))
            || self.instances.iter().any(|i| i.module.needs_clock())
    }
    pub fn needs_reset(&self) -> bool {
        self.needed().any(|n| matches!(n.cell, Cell::Register { reset: Some(_), .. }))
            || self.instances.iter().any(|i| i.module.needs_reset())
    }

    fn needed(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().zip(Live::of(self).nodes).filter_map(|(node, live)| live.then_some(node))
    }

    /// This module and all below it, each once, the inner ones first.
    pub fn hierarchy(self: &Rc<Self>) -> Vec<Rc<Module>> {
        let mut found: Vec<Rc<Module>> = Vec::new();
        for instance in &self.instances {
            for module in instance.module.hierarchy() {
                if !found.iter().any(|m| Rc::ptr_eq(m, &module)) {
                    found.push(module);
                }
            }
        }
        found.push(self.clone());
        found
    }

    /// The source line that built a node, for messages.
    pub fn place(&self, id: NodeId) -> String {
        let place = self.node(id).place;
        format!("{}:{}", place.file(), place.line())
    }

    /// The node's name, or what kind of cell stands on which line.
    pub fn describe(&self, id: NodeId) -> String {
        match &self.node(id).name {
            Some(name) => format!("{}.{name}", self.name),
            None => format!("{}.(unnamed, {})", self.name, self.place(id)),
        }
    }

    pub fn range(&self, id: NodeId) -> Range {
        self.node(id).word.range
    }
}
