//! The body of a module in the order in which a person reads it: ports, state, then clock by clock what
//! is computed and what is kept.

use std::rc::Rc;

use super::Section;
use super::nets::Nets;
use super::text::{Printer, literal, unwrapped};
use crate::hdl::Word;
use crate::hdl::cell::{Bitwise, Cell, NodeId};
use crate::hdl::live::Live;
use crate::hdl::module::{Direction, MadeOf, Memory, Module, Output};

/// `[59:0] ` and its sign, padded so that names stand below each other.
fn shape(word: Word) -> String {
    let sign = if word.is_signed() && word.width() > 1 { "signed " } else { "" };
    let range = if word.width() > 1 { format!("[{}:0] ", word.width() - 1) } else { String::new() };
    format!("{sign:7}{range:>8}")
}

/// One declaration a line, with its comma and comment.
pub fn ports(module: &Module) -> Vec<String> {
    let mut ports: Vec<(String, String)> = vec![];
    if module.needs_clock() {
        ports.push((format!("input  wire {:15}aclk", ""), "rising edge".into()));
    }
    if module.needs_reset() {
        ports.push((format!("input  wire {:15}aresetn", ""), "synchronous, active low".into()));
    }
    let lane_of = |direction, port| {
        let mut buses = module.buses.iter().filter(move |b| b.direction == direction);
        buses.find(|b| b.lanes.iter().any(|l| l.port == port))
    };
    for (direction, count) in
        [(Direction::Input, module.inputs.len()), (Direction::Output, module.outputs.len())]
    {
        for port in 0..count {
            if let Some(bus) = lane_of(direction, port) {
                if bus.lanes[0].port == port {
                    let keyword = if direction == Direction::Input { "input  wire" } else { "output wire" };
                    let lanes = format!("{} lanes of {} bits", bus.lanes.len(), bus.lanes[0].room);
                    let range = format!("[{}:0] ", bus.width - 1);
                    ports.push((format!("{keyword} {:7}{range:>8}{}", "", bus.name), lanes));
                }
                continue;
            }
            let (keyword, node, name) = match direction {
                Direction::Input => {
                    let id = module.inputs[port];
                    ("input  wire", id, module.node(id).name.clone().unwrap_or_default())
                }
                Direction::Output => {
                    let output = &module.outputs[port];
                    (
                        if is_output_register(module, output) { "output reg " } else { "output wire" },
                        output.node,
                        output.name.clone(),
                    )
                }
            };
            let word = module.node(node).word;
            ports.push((
                format!("{keyword} {}{name}", shape(word)),
                remark(word).trim_start_matches(" // ").into(),
            ));
        }
    }
    let last = ports.len().saturating_sub(1);
    let widest = ports.iter().map(|(p, _)| p.len()).max().unwrap_or(0) + 1;
    let line = |(i, (port, comment)): (usize, &(String, String))| {
        let declared = format!("{port}{}", if i == last { "" } else { "," });
        if comment.is_empty() { declared } else { format!("{declared:widest$} // {comment}") }
    };
    ports.iter().enumerate().map(line).collect()
}

fn in_bus(module: &Module, direction: Direction, port: usize) -> bool {
    module.buses.iter().any(|b| b.direction == direction && b.lanes.iter().any(|l| l.port == port))
}

fn is_output_register(module: &Module, output: &Output) -> bool {
    let node = module.node(output.node);
    node.name.as_deref() == Some(&output.name)
        && matches!(node.cell, Cell::Register { .. } | Cell::MemoryRead { .. })
}

pub fn sections(module: &Module, nets: &Nets, name_of: &dyn Fn(&Rc<Module>) -> String) -> Vec<Section> {
    let body = Body {
        module,
        nets,
        print: Printer { module, nets },
        clocks: clocks(module),
        live: Live::of(module),
    };
    let mut sections = vec![
        Section { banner: "the lanes of the streams".into(), lines: body.lanes() },
        Section { banner: "state".into(), lines: body.state() },
    ];
    let last = body.clocks.iter().copied().max().unwrap_or(0);
    for clock in 0..=last {
        let mut lines = body.wires(clock);
        let kept = body.registers(clock);
        if !lines.is_empty() && !kept.is_empty() {
            lines.push(String::new());
        }
        lines.extend(kept);
        sections.push(Section { banner: format!("---- clock {clock} {}", "-".repeat(60)), lines });
    }
    sections.push(Section { banner: "the modules inside".into(), lines: body.instances(name_of) });
    sections.push(Section { banner: "outputs".into(), lines: body.outputs() });
    sections.push(Section { banner: "bits that nobody needs".into(), lines: body.unused() });
    sections.retain(|s| !s.lines.is_empty());
    sections
}

/// The clock whose section a node is printed in: not before anything it reads.
fn clocks(module: &Module) -> Vec<u32> {
    let mut clocks: Vec<u32> = module.nodes.iter().map(|n| n.time.unwrap_or(0)).collect();
    // Nodes stand after what they read, except behind wires, whose loops registers break; so a few
    // rounds settle everything.
    for _ in 0..module.nodes.len() {
        let mut changed = false;
        for index in 0..module.nodes.len() {
            let inputs = module.nodes[index].cell.combinational_inputs();
            let latest = inputs.iter().map(|i| clocks[i.index()]).max().unwrap_or(0);
            if latest > clocks[index] {
                clocks[index] = latest;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    clocks
}

struct Body<'a> {
    module: &'a Module,
    nets: &'a Nets,
    print: Printer<'a>,
    clocks: Vec<u32>,
    live: Live,
}

/// Registers that are reset or not and merged or not, their conditions, and which they are.
type Alike = ([bool; 2], Vec<Option<NodeId>>, Vec<NodeId>);

impl Body<'_> {
    fn ids(&self) -> impl Iterator<Item = NodeId> {
        (0..self.module.nodes.len() as u32).map(NodeId)
    }

    fn is_port(&self, id: NodeId) -> bool {
        let name = self.nets.name(id);
        self.module.outputs.iter().enumerate().any(|(port, o)| {
            o.node == id && name == Some(&o.name) && !in_bus(self.module, Direction::Output, port)
        })
    }

    fn lanes(&self) -> Vec<String> {
        let mut lines = vec![];
        for bus in self.module.buses.iter().filter(|b| b.direction == Direction::Input) {
            for lane in &bus.lanes {
                let id = self.module.inputs[lane.port];
                let word = self.module.node(id).word;
                let (name, high) = (self.nets.name(id).unwrap_or_default(), lane.low + word.width() - 1);
                lines.push(format!(
                    "wire {}{name} = {}[{high}:{}]; // {word}",
                    shape(word),
                    bus.name,
                    lane.low
                ));
            }
        }
        lines
    }

    /// Declarations of what is used before it is defined: registers, memories, forward wires, and the
    /// outputs of inner modules.
    fn state(&self) -> Vec<String> {
        let mut lines = vec![];
        for id in self.ids() {
            let node = self.module.node(id);
            let keyword = match node.cell {
                Cell::Register { .. } | Cell::MemoryRead { .. } => "reg ",
                Cell::InstanceOutput { .. } => "wire",
                Cell::Wire { .. } => "wire",
                _ => continue,
            };
            if let (Some(name), true) = (self.nets.name(id), self.needed(id))
                && !self.is_port(id)
            {
                lines.push(format!("{keyword} {}{name};{}", shape(node.word), remark(node.word)));
            }
        }
        for (memory, _) in self.live_memories() {
            let (word, last) = (memory.word, memory.depth - 1);
            let style = match memory.made_of {
                MadeOf::Any => "",
                MadeOf::LookupTables => "(* ram_style = \"distributed\" *) ",
                MadeOf::BlockRam => "(* ram_style = \"block\" *) ",
            };
            let apart = if memory.apart { "(* no_rw_check *) " } else { "" };
            lines.push(format!(
                "{style}{apart}reg  {}{} [0:{last}]; // {} words of {word}",
                shape(word),
                memory.name,
                memory.depth
            ));
        }
        lines
    }

    /// The memories that somebody reads, with their indices.
    fn live_memories(&self) -> impl Iterator<Item = (&Memory, usize)> {
        let memories = self.module.memories.iter().zip(0..);
        memories.filter(|(_, index)| self.live.memories[*index])
    }

    /// Somebody reads it, or it leaves the module.
    fn needed(&self, id: NodeId) -> bool {
        self.nets.is_read(id) || matches!(self.module.node(id).cell, Cell::InstanceOutput { .. })
    }

    fn wires(&self, clock: u32) -> Vec<String> {
        let mut lines = vec![];
        for id in self.ids().filter(|id| self.clocks[id.index()] == clock) {
            let node = self.module.node(id);
            let Some(name) = self.nets.name(id).filter(|_| self.needed(id)) else { continue };
            match node.cell {
                Cell::Input
                | Cell::Register { .. }
                | Cell::MemoryRead { .. }
                | Cell::InstanceOutput { .. } => {}
                _ if self.is_port(id) => lines.push(format!("assign {name} = {};", self.print.operation(id))),
                Cell::Wire { .. } => lines.push(format!("assign {name} = {};", self.print.operation(id))),
                _ => {
                    let (shape, operation) = (shape(node.word), self.print.operation(id));
                    lines.push(format!("wire {shape}{name} = {operation};{}", remark(node.word)));
                }
            }
        }
        lines
    }

    /// The registers that take a value of this clock, those steered alike together.
    fn registers(&self, clock: u32) -> Vec<String> {
        let mut groups: Vec<Alike> = vec![];
        for id in self.ids().filter(|&id| self.needed(id)) {
            let Cell::Register { next: Some(next), enable, reset } = self.module.node(id).cell else {
                continue;
            };
            let inputs = [Some(next), enable];
            let taken = match self.module.node(next).time {
                Some(_) => inputs.iter().flatten().map(|i| self.clocks[i.index()]).max().unwrap_or(0),
                None => self.clocks[id.index()],
            };
            if taken == clock {
                let conditions: Vec<_> = self.clauses(next, enable).into_iter().map(|(c, _)| c).collect();
                let kind = [reset.is_some(), self.module.copies.contains(&id)];
                let alike = |g: &&mut Alike| g.0 == kind && g.1 == conditions;
                match groups.iter_mut().find(alike) {
                    Some(group) => group.2.push(id),
                    None => groups.push((kind, conditions, vec![id])),
                }
            }
        }
        let mut lines = vec![];
        for ([resets, kept], conditions, registers) in groups {
            let keep = if kept { "(* keep *) " } else { "" };
            lines.push(format!("{keep}always @(posedge aclk) begin"));
            if resets {
                lines.push("    if (!aresetn) begin".into());
                lines.extend(registers.iter().map(|&id| self.reset(id)));
            }
            let mut open = resets;
            for (index, condition) in conditions.iter().enumerate() {
                let test = condition.map(|c| format!("if ({}) ", unwrapped(&self.print.whole(c))));
                let always = test.is_none() && !open;
                if !always {
                    let otherwise = if open { "end else " } else { "" };
                    lines.push(format!("    {otherwise}{}begin", test.unwrap_or_default()));
                    open = true;
                }
                let indent = if always { "    " } else { "        " };
                lines.extend(registers.iter().map(|&id| format!("{indent}{}", self.take(id, index))));
            }
            if open {
                lines.push("    end".into());
            }
            lines.push("end".into());
        }
        lines.extend(self.memories(clock));
        lines
    }

    /// What a register takes, case by case: the selection that the builder made of its clauses, undone.
    fn clauses(&self, next: NodeId, enable: Option<NodeId>) -> Vec<(Option<NodeId>, NodeId)> {
        let Some(enable) = enable else { return vec![(None, next)] };
        let (mut clauses, mut rest) = (vec![], next);
        if let Cell::Logic { operation: Bitwise::Or, operands } = &self.module.node(enable).cell
            && self.nets.name(enable).is_none()
        {
            for &condition in operands {
                match self.module.node(rest).cell {
                    Cell::Select { condition: c, on_true, on_false }
                        if c == condition && self.nets.name(rest).is_none() =>
                    {
                        clauses.push((Some(c), on_true));
                        rest = on_false;
                    }
                    _ => break,
                }
            }
            if clauses.len() + 1 == operands.len() {
                clauses.push((operands.last().copied(), rest));
                return clauses;
            }
        }
        vec![(Some(enable), next)]
    }

    fn reset(&self, id: NodeId) -> String {
        let node = self.module.node(id);
        let Cell::Register { reset: Some(value), .. } = node.cell else { return String::new() };
        let name = self.nets.name(id).unwrap_or_default();
        format!("        {name} <= {};", literal(value, node.word.width()))
    }

    fn take(&self, id: NodeId, clause: usize) -> String {
        let node = self.module.node(id);
        let Cell::Register { next: Some(next), enable, .. } = node.cell else { return String::new() };
        let name = self.nets.name(id).unwrap_or_default();
        let value = self.clauses(next, enable)[clause].1;
        format!("{name} <= {};", unwrapped(&self.print.sized(value, node.word.width(), 0)))
    }

    fn memories(&self, clock: u32) -> Vec<String> {
        let mut lines = vec![];
        for (memory, index) in self.live_memories() {
            let when = memory.write.as_ref().map_or(0, |w| self.clocks[w.enable.index()]);
            if when != clock {
                continue;
            }
            let name = &memory.name;
            if !memory.contents.is_empty() {
                lines.push("initial begin".into());
                for (address, &word) in memory.contents.iter().enumerate() {
                    lines.push(format!("    {name}[{address}] = {};", literal(word, memory.word.width())));
                }
                lines.push("end".into());
            }
            lines.push("always @(posedge aclk) begin".into());
            if let Some(write) = &memory.write {
                let [enable, data] = [write.enable, write.data].map(|id| self.print.whole(id));
                let address = self.print.index(write.address, memory);
                lines.push(format!("    if ({enable}) {name}[{address}] <= {data};"));
            }
            for id in self.ids().filter(|&id| self.needed(id)) {
                if let Cell::MemoryRead { memory: of, address, enable } = self.module.node(id).cell
                    && of == index
                {
                    let condition =
                        enable.map(|e| format!("if ({}) ", self.print.whole(e))).unwrap_or_default();
                    let read = self.nets.name(id).unwrap_or_default();
                    lines.push(format!(
                        "    {condition}{read} <= {name}[{}];",
                        self.print.index(address, memory)
                    ));
                }
            }
            lines.push("end".into());
        }
        lines
    }

    fn instances(&self, name_of: &dyn Fn(&Rc<Module>) -> String) -> Vec<String> {
        let mut lines = vec![];
        for (index, instance) in self.module.instances.iter().enumerate() {
            let inner = &instance.module;
            let mut pins = vec![];
            if inner.needs_clock() {
                pins.push(".aclk(aclk)".into());
            }
            if inner.needs_reset() {
                pins.push(".aresetn(aresetn)".into());
            }
            for (&port, &outer) in inner.inputs.iter().zip(&instance.inputs) {
                let name = inner.node(port).name.clone().unwrap_or_default();
                pins.push(format!(".{name}({})", self.print.whole(outer)));
            }
            for id in self.ids() {
                if let Cell::InstanceOutput { instance: i, port } = self.module.node(id).cell
                    && i == index
                {
                    let net = self.nets.name(id).unwrap_or_default();
                    pins.push(format!(".{}({net})", inner.outputs[port].name));
                }
            }
            lines.push(format!("{} {} (", name_of(inner), instance.name));
            let last = pins.len().saturating_sub(1);
            let comma = |i| if i == last { "" } else { "," };
            lines.extend(pins.iter().enumerate().map(|(i, pin)| format!("    {pin}{}", comma(i))));
            lines.push(");".into());
        }
        lines
    }

    fn outputs(&self) -> Vec<String> {
        let mut lines = vec![];
        for bus in self.module.buses.iter().filter(|b| b.direction == Direction::Output) {
            let lane = |l: &crate::hdl::Lane| self.print.sized(self.module.outputs[l.port].node, l.room, 0);
            let lanes: Vec<String> = bus.lanes.iter().rev().map(lane).collect();
            lines.push(format!("assign {} = {{{}}};", bus.name, lanes.join(", ")));
        }
        for (port, output) in self.module.outputs.iter().enumerate() {
            let drawn = self.nets.name(output.node) == Some(&output.name);
            if !drawn && !in_bus(self.module, Direction::Output, port) {
                lines.push(format!("assign {} = {};", output.name, self.print.whole(output.node)));
            }
        }
        lines
    }

    /// Verilator's idiom for bits that are left over on purpose.
    fn unused(&self) -> Vec<String> {
        let mut bits = vec![];
        for id in self.ids() {
            let node = self.module.node(id);
            let visible = self.needed(id) || matches!(node.cell, Cell::Input);
            let Some(name) = self.nets.name(id).filter(|_| visible) else { continue };
            for (high, low) in self.nets.unread(self.module, id) {
                bits.push(match (high - low + 1, high) {
                    (width, _) if width == node.word.width() => name.to_string(),
                    (1, _) => format!("{name}[{low}]"),
                    _ => format!("{name}[{high}:{low}]"),
                });
            }
        }
        for bus in self.module.buses.iter().filter(|b| b.direction == Direction::Input) {
            for lane in &bus.lanes {
                let used = lane.low + self.module.node(self.module.inputs[lane.port]).word.width();
                if used < lane.low + lane.room {
                    bits.push(format!("{}[{}:{used}]", bus.name, lane.low + lane.room - 1));
                }
            }
        }
        if bits.is_empty() { vec![] } else { vec![format!("wire unused = &{{1'b0, {}}};", bits.join(", "))] }
    }
}

/// The comment behind a declaration; a single bit needs none.
fn remark(word: Word) -> String {
    if word == Word::bit() { String::new() } else { format!(" // {word}") }
}
