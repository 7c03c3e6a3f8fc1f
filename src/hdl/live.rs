//! Which nodes of a module anything outside of it depends on; the others are not printed and not counted.
//!
//! ```text
//! outputs, inputs of the modules inside ◄── what they read, at once or at a clock edge ◄── ...
//! a memory that such a node reads       ◄── what is written to it
//! ```

use super::cell::{Cell, NodeId};
use super::module::Module;

/// For each node, and for each memory, whether somebody needs it.
pub struct Live {
    pub nodes: Vec<bool>,
    pub memories: Vec<bool>,
}

impl Live {
    pub fn of(module: &Module) -> Live {
        let mut live =
            Live { nodes: vec![false; module.nodes.len()], memories: vec![false; module.memories.len()] };
        let mut open: Vec<NodeId> = module.outputs.iter().map(|o| o.node).collect();
        open.extend(module.instances.iter().flat_map(|i| &i.inputs));
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut live.nodes[id.index()], true) {
                continue;
            }
            let cell = &module.node(id).cell;
            open.extend(cell.combinational_inputs());
            open.extend(cell.clocked_inputs());
            if let Cell::MemoryRead { memory, .. } = cell
                && !std::mem::replace(&mut live.memories[*memory], true)
                && let Some(write) = &module.memories[*memory].write
            {
                open.extend([write.enable, write.address, write.data]);
            }
        }
        live
    }
}
