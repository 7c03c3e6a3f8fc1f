//! Building a module: every operation adds one node to the graph and checks it at once.
//!
//! The first mistake is kept, with the source line that made it, and `finish` returns it; so the code
//! between reads like the formula and not like error handling.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::panic::Location;
use std::rc::Rc;

use super::cell::{Cell, Node, NodeId};
use super::form::StaticForm;
use super::module::{Bus, Direction, Instance, Lane, Memory, Module, Output};
use super::{Signal, Word};
use crate::error::{Error, Result};
use crate::fixed::Range;

/// A module under construction; a handle that is cheap to clone.
#[derive(Clone)]
pub struct Builder(pub(super) Rc<RefCell<State>>);

pub(super) struct State {
    pub module: Module,
    /// What each register takes, the first clause whose condition holds.
    pub clauses: BTreeMap<NodeId, Vec<(Option<NodeId>, NodeId)>>,
    pub forms: Vec<Option<Rc<StaticForm>>>,
    /// The same signal one clock later, where somebody needed it.
    pub delays: BTreeMap<NodeId, NodeId>,
    pub error: Option<Error>,
    pub strict: bool,
}

impl Builder {
    pub fn new(name: &str) -> Self {
        let module = Module {
            name: name.into(),
            purpose: vec![],
            parameters: vec![],
            separate: false,
            nodes: vec![],
            inputs: vec![],
            outputs: vec![],
            buses: vec![],
            memories: vec![],
            copies: Default::default(),
            instances: vec![],
        };
        Builder(Rc::new(RefCell::new(State {
            module,
            clauses: BTreeMap::new(),
            forms: vec![],
            delays: BTreeMap::new(),
            error: None,
            strict: false,
        })))
    }

    /// Signals of different times in one operation become an error instead of getting delays.
    pub fn strict_latency(&self) {
        self.0.borrow_mut().strict = true;
    }

    /// One line of what the module is for.
    pub fn purpose(&self, line: impl Into<String>) {
        self.0.borrow_mut().module.purpose.push(line.into());
    }

    /// A parameter that was fixed when the module was generated.
    pub fn parameter(&self, name: &str, value: impl ToString) {
        self.0.borrow_mut().module.parameters.push((name.into(), value.to_string()));
    }

    /// Asks synthesis to leave each instance a module of its own: registers that do the same in several instances
    /// stay apart, and each drives only cells nearby.
    pub fn separate(&self) {
        self.0.borrow_mut().module.separate = true;
    }

    #[track_caller]
    pub fn input(&self, name: impl Into<String>, word: Word) -> Signal {
        self.input_at(name, word, 0)
    }

    /// An input that arrives `time` clocks after those of time 0.
    #[track_caller]
    pub fn input_at(&self, name: impl Into<String>, word: Word, time: u32) -> Signal {
        let signal = self.add(Cell::Input, word, Some(time));
        self.rename(&signal, name.into());
        self.0.borrow_mut().module.inputs.push(signal.id);
        signal
    }

    #[track_caller]
    pub fn output(&self, name: impl Into<String>, value: impl Into<super::Expr>) {
        let signal = self.signal(value);
        let name = name.into();
        let mut state = self.0.borrow_mut();
        let node = &mut state.module.nodes[signal.id.index()];
        if node.name.is_none() && !matches!(node.cell, Cell::Constant(_)) {
            node.name = Some(name.clone());
        }
        state.module.outputs.push(Output { name, node: signal.id });
    }

    /// Inputs that the outside sees as one port `name`, each in a lane of `room` bits, the first lowest.
    #[track_caller]
    pub fn input_bus(&self, name: &str, room: u32, lanes: &[(&str, Word)]) -> Vec<Signal> {
        let start = self.0.borrow().module.inputs.len();
        let signals = lanes.iter().map(|(lane, word)| self.input(format!("{name}_{lane}"), *word)).collect();
        self.add_bus(name, Direction::Input, room, start, lanes.len());
        signals
    }

    /// Outputs that the outside sees as one port `name`, each in a lane of `room` bits, the first lowest.
    #[track_caller]
    pub fn output_bus(&self, name: &str, room: u32, lanes: &[(&str, &Signal)]) {
        let start = self.0.borrow().module.outputs.len();
        lanes.iter().for_each(|(lane, signal)| self.output(format!("{name}_{lane}"), *signal));
        self.add_bus(name, Direction::Output, room, start, lanes.len());
    }

    fn add_bus(&self, name: &str, direction: Direction, room: u32, start: usize, count: usize) {
        let lanes = (0..count).map(|i| Lane { port: start + i, low: room * i as u32, room }).collect();
        let bus = Bus { name: name.into(), direction, width: room * count as u32, lanes };
        self.0.borrow_mut().module.buses.push(bus);
    }

    #[track_caller]
    pub fn constant(&self, value: i128, word: Word) -> Signal {
        if !word.range.contains(Range::point(value)) {
            self.fail(|_| {
                Error::usage(format!("the constant {value} does not fit its word {word}"))
                    .help("give the constant a word whose range holds it")
            });
        }
        self.add(Cell::Constant(value), word, None)
    }

    /// One bit, 0 or 1.
    #[track_caller]
    pub fn bit(&self, value: bool) -> Signal {
        self.constant(value.into(), Word::bit())
    }

    /// A wire that is used before what drives it exists; [`Builder::drive`] closes the loop.
    #[track_caller]
    pub fn forward(&self, name: impl Into<String>, word: Word) -> Signal {
        let signal = self.add(Cell::Wire { driver: None }, word, Some(0));
        self.rename(&signal, name.into());
        signal
    }

    #[track_caller]
    pub fn drive(&self, wire: &Signal, value: impl Into<super::Expr>) {
        let value = self.signal(value);
        let (from, to) = (value.word(), wire.word());
        if from.width() != to.width() || from.is_signed() != to.is_signed() {
            self.fail(|m| {
                let (wire, value) = (m.describe(wire.id), m.describe(value.id));
                Error::usage(format!("{wire} is {to}, but {value} that drives it is {from}"))
                    .help("declare the wire with the word of what drives it")
            });
        }
        let mut state = self.0.borrow_mut();
        if let Cell::Wire { driver } = &mut state.module.nodes[wire.id.index()].cell {
            *driver = Some(value.id);
        }
    }

    /// An instance of a finished module without bus ports; inputs by name. Inputs that come at different times are delayed
    /// to the latest, and the outputs count from there.
    #[track_caller]
    pub fn instance(&self, name: &str, module: &Rc<Module>, inputs: &[(&str, &Signal)]) -> Placed {
        if let Some(bus) = module.buses.first() {
            self.fail(|_| {
                Error::usage(format!(
                    "instance {name} of {}, which has the bus port {}",
                    module.name, bus.name
                ))
                .help("give an inner module its ports one by one; buses are for the top")
            });
        }
        let mut base = 0;
        let mut found = Vec::new();
        for &id in &module.inputs {
            let port = module.node(id);
            let port_name = port.name.clone().unwrap_or_default();
            let given = inputs.iter().find(|(n, _)| *n == port_name).map(|(_, s)| (*s).clone());
            let Some(signal) = given else {
                self.fail(|_| {
                    Error::usage(format!("instance {name} of {}: input {port_name} is missing", module.name))
                        .help("connect every input of the module")
                });
                continue;
            };
            let (have, want) = (signal.word(), port.word);
            if have.width() != want.width()
                || have.is_signed() != want.is_signed()
                || have.modular != want.modular
            {
                self.fail(|m| {
                    Error::usage(format!(
                        "{} is {have}, but {name}.{port_name} takes {want}",
                        m.describe(signal.id)
                    ))
                    .help("convert it with wrap or claim, or declare the port with this word")
                });
            }
            base = base.max(signal.time().unwrap_or(0).saturating_sub(port.time.unwrap_or(0)));
            found.push((signal, port.time.unwrap_or(0)));
        }
        if let Some((unknown, _)) = inputs.iter().find(|(n, _)| module.input(n).is_none()) {
            self.fail(|_| Error::usage(format!("{} has no input {unknown}", module.name)));
        }
        let inputs = found.iter().map(|(s, t)| self.at_time(s, base + t).id).collect();
        let mut state = self.0.borrow_mut();
        state.module.instances.push(Instance { name: name.into(), module: module.clone(), inputs });
        let index = state.module.instances.len() - 1;
        drop(state);
        let outputs = module.outputs.iter().enumerate().map(|(port, output)| {
            let node = module.node(output.node);
            let time = node.time.map(|t| t + base);
            let signal = self.add(Cell::InstanceOutput { instance: index, port }, node.word, time);
            self.rename(&signal, format!("{name}_{}", output.name));
            (output.name.clone(), signal)
        });
        Placed { name: name.into(), outputs: outputs.collect(), builder: self.clone() }
    }

    /// Ends the construction: the module, or the first mistake.
    pub fn finish(self) -> Result<Rc<Module>> {
        self.resolve_registers();
        let mut state = self.0.borrow_mut();
        if let Some(error) = state.error.take() {
            return Err(error);
        }
        for (index, node) in state.module.nodes.iter().enumerate() {
            let undriven = match &node.cell {
                Cell::Wire { driver: None } => "is never driven",
                Cell::Register { next: None, .. } => "is never given a value",
                _ => continue,
            };
            let id = NodeId(index as u32);
            return Err(Error::usage(format!("{} {undriven}", state.module.describe(id)))
                .at(state.module.place(id))
                .help("drive it, or remove it"));
        }
        super::names::allocate(&mut state.module);
        Ok(Rc::new(state.module.clone()))
    }

    // ---- for the other files of the language -------------------------------------------------------

    #[track_caller]
    pub(super) fn add(&self, cell: Cell, word: Word, time: Option<u32>) -> Signal {
        self.add_with_form(cell, word, time, None)
    }

    #[track_caller]
    pub(super) fn add_with_form(
        &self,
        cell: Cell,
        word: Word,
        time: Option<u32>,
        form: Option<Rc<StaticForm>>,
    ) -> Signal {
        let node = Node { cell, word, name: None, time, place: Location::caller() };
        if word.width() > Range::WIDEST {
            self.fail(|_| {
                Error::usage(format!(
                    "a word of {} bits ({word}) is wider than {}",
                    word.width(),
                    Range::WIDEST
                ))
                .help("choose a narrower coordinate format or a lower maximum level")
            });
        }
        let mut state = self.0.borrow_mut();
        state.module.nodes.push(node);
        state.forms.push(form);
        let id = NodeId(state.module.nodes.len() as u32 - 1);
        drop(state);
        Signal { builder: self.clone(), id }
    }

    pub(super) fn node<T>(&self, id: NodeId, read: impl FnOnce(&Node) -> T) -> T {
        read(self.0.borrow().module.node(id))
    }

    pub(super) fn rename(&self, signal: &Signal, name: String) {
        self.0.borrow_mut().module.nodes[signal.id.index()].name = Some(name);
    }

    pub(super) fn add_memory(&self, memory: Memory) -> usize {
        let mut state = self.0.borrow_mut();
        state.module.memories.push(memory);
        state.module.memories.len() - 1
    }

    /// Keeps the first mistake.
    #[track_caller]
    pub(super) fn fail(&self, error: impl FnOnce(&Module) -> Error) {
        self.fail_at(Location::caller(), error);
    }

    /// Keeps the first mistake, made on another line than the one that found it.
    pub(super) fn fail_at(&self, place: &Location, error: impl FnOnce(&Module) -> Error) {
        if self.0.borrow().error.is_some() {
            return;
        }
        // The message reads the module, and asks signals for their words: nothing may be locked for writing.
        let error = error(&self.0.borrow().module).at(format!("{}:{}", place.file(), place.line()));
        self.0.borrow_mut().error = Some(error);
    }
}

/// The outputs of an instance.
pub struct Placed {
    name: String,
    outputs: Vec<(String, Signal)>,
    builder: Builder,
}

impl Placed {
    #[track_caller]
    pub fn out(&self, name: &str) -> Signal {
        match self.outputs.iter().find(|(n, _)| n == name) {
            Some((_, signal)) => signal.clone(),
            None => {
                self.builder.fail(|_| Error::usage(format!("{} has no output {name}", self.name)));
                self.builder.bit(false)
            }
        }
    }
}
