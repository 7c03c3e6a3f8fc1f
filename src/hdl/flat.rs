//! The hierarchy laid out as one list of cells in an order in which they can be evaluated.

use std::rc::Rc;

use super::cell::{Cell, Node, NodeId};
use super::module::{Memory, Module};
use crate::error::{Error, Result};

/// One node of the flattened design.
#[derive(Clone, Debug)]
pub struct FlatNode {
    pub node: Node,
    /// `engine_x.delta_0`: the instances on the way down, and the name.
    pub path: Option<String>,
}

/// A whole design without hierarchy. Every [`NodeId`] in it counts over `nodes`.
#[derive(Clone, Debug)]
pub struct Flat {
    pub nodes: Vec<FlatNode>,
    /// Combinational cells, each after those it reads.
    pub order: Vec<NodeId>,
    /// Registers and memory reads.
    pub clocked: Vec<NodeId>,
    pub memories: Vec<Memory>,
    pub inputs: Vec<(String, NodeId)>,
    pub outputs: Vec<(String, NodeId)>,
}

impl Flat {
    /// Refuses a combinational loop, naming the signals on it.
    pub fn new(top: &Rc<Module>) -> Result<Flat> {
        let mut flat = Flat {
            nodes: vec![],
            order: vec![],
            clocked: vec![],
            memories: vec![],
            inputs: vec![],
            outputs: vec![],
        };
        flat.place(top, "");
        flat.inputs =
            top.inputs.iter().map(|&id| (top.node(id).name.clone().unwrap_or_default(), id)).collect();
        let outputs: Vec<_> = top.outputs.iter().map(|o| (o.name.clone(), o.node)).collect();
        flat.outputs = outputs.into_iter().map(|(name, id)| (name, flat.root(id))).collect();
        flat.follow_wires();
        flat.sort()?;
        Ok(flat)
    }

    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()].node
    }

    pub fn input(&self, name: &str) -> Option<NodeId> {
        self.inputs.iter().find(|(n, _)| n == name).map(|(_, id)| *id)
    }

    pub fn output(&self, name: &str) -> Option<NodeId> {
        self.outputs.iter().find(|(n, _)| n == name).map(|(_, id)| *id)
    }

    /// The full name of a node, or the source line that built it.
    pub fn describe(&self, id: NodeId) -> String {
        let flat = &self.nodes[id.index()];
        flat.path
            .clone()
            .unwrap_or_else(|| format!("(unnamed, {}:{})", flat.node.place.file(), flat.node.place.line()))
    }

    /// Appends a module and all below it; returns where its nodes begin.
    fn place(&mut self, module: &Rc<Module>, prefix: &str) -> u32 {
        let (base, memories) = (self.nodes.len() as u32, self.memories.len());
        for node in &module.nodes {
            let mut node = node.clone();
            node.cell.visit_mut(|id| id.0 += base);
            if let Cell::MemoryRead { memory, .. } = &mut node.cell {
                *memory += memories;
            }
            let path = node.name.as_ref().map(|name| format!("{prefix}{name}"));
            self.nodes.push(FlatNode { node, path });
        }
        for memory in &module.memories {
            let mut memory = memory.clone();
            memory.name = format!("{prefix}{}", memory.name);
            if let Some(write) = &mut memory.write {
                write.nodes_mut().for_each(|id| id.0 += base);
            }
            self.memories.push(memory);
        }
        for (index, instance) in module.instances.iter().enumerate() {
            let inner = self.place(&instance.module, &format!("{prefix}{}.", instance.name));
            for (&port, &outer) in instance.module.inputs.iter().zip(&instance.inputs) {
                let driver = Some(NodeId(outer.0 + base));
                self.nodes[(port.0 + inner) as usize].node.cell = Cell::Wire { driver };
            }
            for (id, node) in module.nodes.iter().enumerate() {
                if let Cell::InstanceOutput { instance, port } = node.cell
                    && instance == index
                {
                    let driver = NodeId(module.instances[index].module.outputs[port].node.0 + inner);
                    self.nodes[base as usize + id].node.cell = Cell::Wire { driver: Some(driver) };
                }
            }
        }
        base
    }

    /// What drives a node, through any number of wires.
    fn root(&self, mut id: NodeId) -> NodeId {
        // A ring of wires and nothing else cannot end; it is left for `sort` to report.
        for _ in 0..self.nodes.len() {
            match self.node(id).cell {
                Cell::Wire { driver: Some(driver) } => id = driver,
                _ => break,
            }
        }
        id
    }

    fn follow_wires(&mut self) {
        let roots: Vec<NodeId> = (0..self.nodes.len() as u32).map(|id| self.root(NodeId(id))).collect();
        let follow = |id: &mut NodeId| *id = roots[id.index()];
        for flat in &mut self.nodes {
            flat.node.cell.visit_mut(follow);
        }
        for write in self.memories.iter_mut().filter_map(|m| m.write.as_mut()) {
            write.nodes_mut().for_each(follow);
        }
    }

    /// Orders the cells anew, after their connections have changed. Depth first, without recursion: designs
    /// can be deep.
    pub(super) fn sort(&mut self) -> Result<()> {
        self.order.clear();
        self.clocked.clear();
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let mut marks = vec![Mark::New; self.nodes.len()];
        for start in 0..self.nodes.len() as u32 {
            let mut path = vec![(NodeId(start), false)];
            while let Some((id, leaving)) = path.pop() {
                let mark = &mut marks[id.index()];
                if leaving {
                    *mark = Mark::Done;
                    match self.node(id).cell {
                        Cell::Register { .. } | Cell::MemoryRead { .. } => self.clocked.push(id),
                        Cell::Input | Cell::Wire { .. } => {}
                        _ => self.order.push(id),
                    }
                } else if *mark == Mark::New {
                    *mark = Mark::Open;
                    path.push((id, true));
                    path.extend(self.node(id).cell.combinational_inputs().into_iter().map(|i| (i, false)));
                } else if *mark == Mark::Open {
                    let ring: Vec<String> =
                        path.iter().filter(|(_, leaving)| *leaving).map(|(i, _)| self.describe(*i)).collect();
                    let place = self.node(id).place;
                    return Err(Error::usage(format!("a combinational loop through {}", ring.join(", ")))
                        .at(format!("{}:{}", place.file(), place.line()))
                        .help("break it with a register"));
                }
            }
        }
        Ok(())
    }
}
