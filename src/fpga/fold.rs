//! A choice behind an adder goes into the adder's own cell of carry.
//!
//! ```text
//!   before   a + b ──► LUT  load ? n : sum ──► register          two LUTs a bit
//!   after    load ? n : a + b ──► register                       one
//! ```
//!
//! Half a cell of carry of the ECP5 makes p of four inputs and g of two of them; its sum is p ^ carry, and it passes on
//! the carry where p is 1, else g. With p = load ? n : a ^ b, and g = load ? 0 : a, no carry arises from the start of
//! the chain to its end while `load` is 1, so that the sum is n; while it is 0, all is as before. What a chain
//! carries out while `load` is 1 changes; so it may only go to a register whose readers choose, a clock later,
//! by `load` of the clock before.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use super::nets::{Nets, bit, net, open, table};

const INPUTS: [&str; 4] = ["A", "B", "C", "D"];

/// The net by which is chosen, and its value when the other number is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Choice {
    net: u64,
    when: bool,
}

/// Half a cell of carry: its cell, 0 or 1.
type Half = (String, usize);

/// What a net is: another one, so many clocks later.
type Delayed = (u64, u32);

/// What is to be done with a chain.
#[derive(Clone, Debug)]
struct Plan {
    choice: Choice,
    /// The halves from the start on, with the LUT of the choice where the sum is read.
    halves: Vec<(Half, Option<String>)>,
    /// Nets of the registers that take the sums behind them.
    carried: Vec<u64>,
}

/// Folds the choices of a module; returns how many LUTs that saves.
pub fn fold_choices(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object() else { return 0 };
    let fold = Fold { cells, nets };
    let mut plans: Vec<Plan> = fold.chains().iter().filter_map(|chain| fold.plan(chain)).collect();
    // A choice between two sums goes into one of them.
    let mut taken = BTreeSet::new();
    plans.retain(|plan| {
        let luts: Vec<&String> = plan.halves.iter().filter_map(|(_, lut)| lut.as_ref()).collect();
        let free = luts.iter().all(|lut| !taken.contains(*lut));
        if free {
            taken.extend(luts.into_iter().cloned());
        }
        free
    });
    // A chain that cannot be folded may be what another one relies on.
    loop {
        let folded: BTreeMap<&Half, Choice> =
            plans.iter().flat_map(|plan| plan.halves.iter().map(|(half, _)| (half, plan.choice))).collect();
        let fits: Vec<bool> = plans.iter().map(|plan| fold.is_ignored(plan, &folded)).collect();
        if fits.iter().all(|fits| *fits) {
            break;
        }
        let mut fits = fits.into_iter();
        plans.retain(|_| fits.next() == Some(true));
    }
    let edits: Vec<_> = plans.iter().flat_map(|plan| fold.edits(plan)).collect();
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let mut saved = BTreeSet::new();
    for edit in edits {
        edit.apply(cells);
        saved.extend(edit.sum.map(|(lut, _)| lut));
    }
    cells.retain(|name, _| !saved.contains(name));
    saved.len() as u64
}

/// LUTs in front of an adder that nothing else reads go into its halves where these have pins for what they read, as for
/// `(load ? n : a) + (load ? 0 : b)`; returns how many LUTs that saves.
pub fn absorb_operands(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object() else { return 0 };
    let fold = Fold { cells, nets };
    let carries = cells.iter().filter(|(_, cell)| cell["type"] == "CCU2C");
    let halves = carries.flat_map(|(name, _)| [(name.clone(), 0), (name.clone(), 1)]);
    let edits: Vec<(Edit, Vec<String>)> = halves.filter_map(|half| fold.absorbed(&half)).collect();
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let mut absorbed = BTreeSet::new();
    for (edit, luts) in edits {
        edit.apply(cells);
        absorbed.extend(luts);
    }
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let before = cells.len();
    let read = |cell: &Value| net(cell, "Z").is_some_and(|out| !nets.readers(out).is_empty());
    cells.retain(|name, cell| !absorbed.contains(name) || read(cell));
    (before - cells.len()) as u64
}

/// Chains that begin with a constant and with a half whose carry is a function of two nets, as where a carry enters from a
/// register, need no constant; returns how many.
pub fn seal_chains(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object() else { return 0 };
    let fold = Fold { cells, nets };
    let carries = cells.iter().filter(|(_, cell)| cell["type"] == "CCU2C");
    let edits: Vec<Edit> = carries.filter_map(|(name, cell)| fold.sealed(name, cell)).collect();
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    for edit in &edits {
        edit.apply(cells);
        cells[&edit.half.0]["connections"]["CIN"] = open();
    }
    edits.len() as u64
}

/// A half as it is to be.
struct Edit {
    half: Half,
    pins: [Value; 4],
    table: u16,
    /// The LUT that it replaces, and the net that it drives in its place.
    sum: Option<(String, Value)>,
}

impl Edit {
    fn apply(&self, cells: &mut Map<String, Value>) {
        let (name, half) = &self.half;
        let cell = &mut cells[name];
        for (input, pin) in INPUTS.iter().zip(&self.pins) {
            cell["connections"][format!("{input}{half}")] = pin.clone();
        }
        cell["parameters"][format!("INIT{half}")] = json!(format!("{:016b}", self.table));
        if let Some((_, out)) = &self.sum {
            cell["connections"][format!("S{half}")] = out.clone();
        }
    }
}

struct Fold<'a> {
    cells: &'a Map<String, Value>,
    nets: Nets,
}

impl Fold<'_> {
    /// The chains that begin with no carry, as halves.
    fn chains(&self) -> Vec<Vec<Half>> {
        let carries = self.cells.iter().filter(|(_, cell)| cell["type"] == "CCU2C");
        let heads = carries.filter(|(_, cell)| bit(cell, "CIN").is_some_and(|carry| carry == "0"));
        let chain = |(name, _): (&String, &Value)| {
            let mut names = vec![name.clone()];
            loop {
                let cell = &self.cells[&names[names.len() - 1]];
                let plain = (0..2).all(|half| cell["parameters"][format!("INJECT1_{half}")] == "NO");
                let next = net(cell, "COUT").map(|carry| self.nets.readers(carry));
                match next {
                    _ if !plain => return None,
                    None | Some([]) => break,
                    Some([(next, port)]) if port == "CIN" => names.push(next.clone()),
                    Some(_) => return None,
                }
            }
            Some(names.into_iter().flat_map(|name| [(name.clone(), 0), (name, 1)]).collect())
        };
        heads.filter_map(chain).collect()
    }

    fn sum(&self, (name, half): &Half) -> Option<u64> {
        net(&self.cells[name], &format!("S{half}"))
    }

    /// The LUT that alone reads the sum of a half.
    fn lut(&self, half: &Half) -> Option<(&str, u64)> {
        let sum = self.sum(half)?;
        match self.nets.readers(sum) {
            [(name, _)] if self.cells.get(name).is_some_and(|cell| cell["type"] == "LUT4") => {
                Some((name, sum))
            }
            _ => None,
        }
    }

    fn is_read(&self, half: &Half) -> bool {
        self.sum(half).is_some_and(|sum| !self.nets.readers(sum).is_empty())
    }

    /// Whether the sum of a half goes to registers alone that are reset while the choice is made, as where a low bit of
    /// what is chosen is 0: these do not look at it then.
    fn is_cleared(&self, half: &Half, choice: Choice) -> bool {
        let Some(sum) = self.sum(half) else { return false };
        let reset = if choice.when { "LSR" } else { "INV" };
        self.nets.readers(sum).iter().all(|(name, port)| {
            self.cells.get(name).is_some_and(|cell| {
                cell["type"] == "TRELLIS_FF"
                    && port == "DI"
                    && net(cell, "LSR") == Some(choice.net)
                    && cell["parameters"]["LSRMUX"] == reset
            })
        })
    }

    fn plan(&self, chain: &[Half]) -> Option<Plan> {
        let first = chain.iter().find_map(|half| self.lut(half))?;
        let choices = Function::of_lut(&self.cells[first.0])?.choices(first.1);
        choices.into_iter().find_map(|choice| self.plan_for(chain, choice))
    }

    fn plan_for(&self, chain: &[Half], choice: Choice) -> Option<Plan> {
        let chooses = |half: &Half| {
            let (lut, sum) = self.lut(half)?;
            let function = Function::of_lut(&self.cells[lut])?;
            function.choices(sum).contains(&choice).then(|| lut.to_string())
        };
        let luts: Vec<Option<String>> = chain.iter().map(chooses).collect();
        let count = luts.iter().rposition(Option::is_some)? + 1;
        let halves: Vec<_> = chain.iter().cloned().zip(luts).take(count).collect();
        let fits = |(half, lut): &(Half, Option<String>)| {
            (lut.is_some() || !self.is_read(half) || self.is_cleared(half, choice))
                && self.edit(half, lut.as_deref(), choice).is_some()
        };
        if !halves.iter().all(fits) {
            return None;
        }
        let mut carried = vec![];
        for half in chain[count..].iter().filter(|half| self.is_read(half)) {
            for (name, port) in self.nets.readers(self.sum(half)?) {
                let register = self.cells.get(name).filter(|cell| port == "DI" && is_plain(cell))?;
                carried.push(net(register, "Q")?);
            }
        }
        Some(Plan { choice, halves, carried })
    }

    /// Whether nobody looks at what the chain carries out while the choice is made.
    fn is_ignored(&self, plan: &Plan, folded: &BTreeMap<&Half, Choice>) -> bool {
        let (net, clocks) = self.origin(plan.choice.net);
        let later = (net, clocks + 1);
        let readers = plan.carried.iter().flat_map(|&carry| self.nets.readers(carry));
        readers.map(|(name, port)| half_of(name, port)).all(|half| {
            half.and_then(|half| folded.get(&half))
                .is_some_and(|choice| choice.when == plan.choice.when && self.origin(choice.net) == later)
        })
    }

    /// Back through plain registers.
    fn origin(&self, mut net_here: u64) -> Delayed {
        let mut clocks = 0;
        // A ring of registers has no origin; after so many no other choice is as late.
        while clocks < 64 {
            let driver = self.nets.drivers.get(&net_here).and_then(|(name, _)| self.cells.get(name));
            let Some(before) = driver.filter(|cell| is_plain(cell)).and_then(|cell| net(cell, "DI")) else {
                break;
            };
            (net_here, clocks) = (before, clocks + 1);
        }
        (net_here, clocks)
    }

    fn edits(&self, plan: &Plan) -> Vec<Edit> {
        let edit = |(half, lut): &(Half, Option<String>)| self.edit(half, lut.as_deref(), plan.choice);
        plan.halves.iter().filter_map(edit).collect()
    }

    /// The half with LUTs before it in it, and which: all that fit, else one that does.
    fn absorbed(&self, half: &Half) -> Option<(Edit, Vec<String>)> {
        let cell = &self.cells[&half.0];
        let own = Function::of_half(cell, half.1)?;
        let lut = |net: &u64| {
            let (name, _) = self.nets.drivers.get(net)?;
            let lut = self.cells.get(name).filter(|cell| cell["type"] == "LUT4")?;
            let function = Function::of_lut(lut)?;
            // An inverter costs its readers no pin, however many there are, and a gate one.
            let alone = self.nets.readers(*net).len() == 1;
            (alone || function.nets.len() <= 2).then(|| (*net, name.clone(), function))
        };
        let luts: Vec<(u64, String, Function)> = own.nets.iter().filter_map(lut).collect();
        let groups = [luts.as_slice()].into_iter().chain(luts.chunks(1)).filter(|group| !group.is_empty());
        groups.into_iter().find_map(|group| {
            let inside = |net: &u64| group.iter().find(|(out, ..)| out == net);
            let mut nets: Vec<u64> = own.nets.iter().copied().filter(|net| inside(net).is_none()).collect();
            nets.extend(group.iter().flat_map(|(.., function)| function.nets.iter().copied()));
            nets.sort_unstable();
            nets.dedup();
            let within = |value: &dyn Fn(u64) -> bool, net: u64| match inside(&net) {
                Some((.., function)) => function.at(value),
                None => value(net),
            };
            let passes = |value: &dyn Fn(u64) -> bool| own.at(&|net| within(value, net));
            let generates = |value: &dyn Fn(u64) -> bool| carried(cell, half.1, &|net| within(value, net));
            let (pins, table) = fit(&nets, &passes, &generates)?;
            let pins = pins.map(|pin| pin.map_or(json!(["1"]), |net| json!([net])));
            let names = group.iter().map(|(_, name, _)| name.clone()).collect();
            Some((Edit { half: half.clone(), pins, table, sum: None }, names))
        })
    }

    /// The first half where it does not ask what comes in.
    fn sealed(&self, name: &str, cell: &Value) -> Option<Edit> {
        let enters = bit(cell, "CIN")?.as_str().filter(|constant| ["0", "1"].contains(constant))? == "1";
        let half: Half = (name.to_string(), 0);
        if cell["parameters"]["INJECT1_0"] != "NO" || self.is_read(&half) {
            return None;
        }
        let own = Function::of_half(cell, 0)?;
        let leaves =
            |value: &dyn Fn(u64) -> bool| if own.at(value) { enters } else { carried(cell, 0, value) };
        let (pins, table) = fit(&own.nets, &|_| false, &leaves)?;
        let pins = pins.map(|pin| pin.map_or(json!(["1"]), |net| json!([net])));
        Some(Edit { half, pins, table, sum: None })
    }

    /// The half with the choice in it.
    fn edit(&self, half: &Half, lut: Option<&str>, choice: Choice) -> Option<Edit> {
        let (name, which) = half;
        let cell = &self.cells[name];
        let own = Function::of_half(cell, *which)?;
        let taken = match lut {
            Some(lut) => {
                let sum = self.sum(half)?;
                let chosen =
                    |net| if net == choice.net { Some(choice.when) } else { (net == sum).then_some(false) };
                Some(Function::of_lut(&self.cells[lut])?.fixed(chosen))
            }
            None => None,
        };
        let mut nets = own.nets.clone();
        nets.push(choice.net);
        nets.extend(taken.iter().flat_map(|taken| taken.nets.clone()));
        nets.sort_unstable();
        nets.dedup();
        let chosen = |value: &dyn Fn(u64) -> bool| value(choice.net) == choice.when;
        let passes = |value: &dyn Fn(u64) -> bool| match &taken {
            Some(taken) if chosen(value) => taken.at(value),
            None if chosen(value) => false,
            _ => own.at(value),
        };
        // The table's first four entries are also what is carried, of the first two pins.
        let generates = |value: &dyn Fn(u64) -> bool| !chosen(value) && carried(cell, *which, value);
        let (pins, table) = fit(&nets, &passes, &generates)?;
        let pins = pins.map(|pin| pin.map_or(json!(["1"]), |net| json!([net])));
        let sum = lut.map(|lut| (lut.to_string(), self.cells[lut]["connections"]["Z"].clone()));
        let sum = sum.map(|(lut, out)| (lut, if out.is_null() { open() } else { out }));
        Some(Edit { half: half.clone(), pins, table, sum })
    }
}

/// Finds pins for the nets, and the table; unused pins are 1.
fn fit(nets: &[u64], passes: &Truth, generates: &Truth) -> Option<([Option<u64>; 4], u16)> {
    if nets.len() > 4 {
        return None;
    }
    for order in orders() {
        let pins: [Option<u64>; 4] = order.map(|place| nets.get(place).copied());
        let mut entries = [None; 16];
        let mut set = |index: usize, value: bool| *entries[index].get_or_insert(value) == value;
        let fits = (0..1usize << nets.len()).all(|assignment| {
            let value = |net: u64| {
                nets.iter().position(|other| *other == net).is_some_and(|place| assignment >> place & 1 == 1)
            };
            let pin = |index: usize| usize::from(pins[index].is_none_or(value));
            let low = pin(0) | pin(1) << 1;
            let passes = passes(&value);
            set(low | pin(2) << 2 | pin(3) << 3, passes) && (passes || set(low, generates(&value)))
        });
        if fits {
            let table =
                entries.iter().enumerate().map(|(index, entry)| u16::from(*entry == Some(true)) << index);
            return Some((pins, table.sum()));
        }
    }
    None
}

/// All orders of four places.
fn orders() -> impl Iterator<Item = [usize; 4]> {
    (0..256usize)
        .map(|code| [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6])
        .filter(|order| (0..4).all(|place| order.contains(&place)))
}

/// What is true for the values of nets.
type Truth<'a> = dyn Fn(&dyn Fn(u64) -> bool) -> bool + 'a;

/// A function of some nets: its table has the first net at the lowest place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Function {
    pub nets: Vec<u64>,
    pub table: u64,
}

impl Function {
    /// The table of a LUT or of half a cell of carry over those of its pins that are no constants.
    fn of(cell: &Value, pins: [String; 4], table: u16) -> Option<Function> {
        let pins = [bit(cell, &pins[0])?, bit(cell, &pins[1])?, bit(cell, &pins[2])?, bit(cell, &pins[3])?];
        let mut nets: Vec<u64> = pins.iter().filter_map(|pin| pin.as_u64()).collect();
        nets.sort_unstable();
        nets.dedup();
        let at = |value: &dyn Fn(u64) -> bool| {
            let high = |pin: &Value| pin.as_u64().map_or(pin == "1", value);
            let index: usize = pins.iter().enumerate().map(|(i, pin)| usize::from(high(pin)) << i).sum();
            table >> index & 1 == 1
        };
        Some(Function::tabled(nets, &at))
    }

    pub fn of_lut(cell: &Value) -> Option<Function> {
        Function::of(cell, INPUTS.map(String::from), table(cell, "INIT")?)
    }

    fn of_half(cell: &Value, half: usize) -> Option<Function> {
        let pins = INPUTS.map(|input| format!("{input}{half}"));
        Function::of(cell, pins, table(cell, &format!("INIT{half}"))?)
    }

    fn tabled(nets: Vec<u64>, at: &Truth) -> Function {
        let mut function = Function { nets, table: 0 };
        for assignment in 0..1u64 << function.nets.len() {
            let nets = &function.nets;
            let value = |net: u64| {
                nets.iter().position(|other| *other == net).is_some_and(|place| assignment >> place & 1 == 1)
            };
            if at(&value) {
                function.table |= 1 << assignment;
            }
        }
        function
    }

    fn at(&self, value: &dyn Fn(u64) -> bool) -> bool {
        let index: u32 =
            self.nets.iter().enumerate().map(|(place, net)| u32::from(value(*net)) << place).sum();
        self.table >> index & 1 == 1
    }

    /// The function of the other nets where these have such values.
    pub fn fixed(&self, known: impl Fn(u64) -> Option<bool>) -> Function {
        let nets = self.nets.iter().copied().filter(|net| known(*net).is_none()).collect();
        Function::tabled(nets, &|value| self.at(&|net| known(net).unwrap_or_else(|| value(net))))
    }

    /// The choices that it is between the sum and something else.
    fn choices(&self, sum: u64) -> Vec<Choice> {
        let mut found = vec![];
        for &net in self.nets.iter().filter(|net| **net != sum) {
            for when in [true, false] {
                let at = |chosen: bool, high: bool| {
                    self.fixed(|n| if n == net { Some(chosen) } else { (n == sum).then_some(high) })
                };
                let all = |function: Function, high: bool| {
                    let entries = 1u64 << function.nets.len();
                    function.table == if high { (1u64 << entries) - 1 } else { 0 }
                };
                let other = at(when, false) == at(when, true);
                if other && all(at(!when, false), false) && all(at(!when, true), true) {
                    found.push(Choice { net, when });
                }
            }
        }
        found
    }
}

/// What half a cell carries where it does not pass the carry on.
fn carried(cell: &Value, half: usize, value: &dyn Fn(u64) -> bool) -> bool {
    let high = |input: &str| match bit(cell, &format!("{input}{half}")) {
        Some(pin) => pin.as_u64().map_or(pin == "1", value),
        None => false,
    };
    let index = usize::from(high("A")) | usize::from(high("B")) << 1;
    table(cell, &format!("INIT{half}")).is_some_and(|table| table >> index & 1 == 1)
}

/// A register that takes its input at every edge.
fn is_plain(cell: &Value) -> bool {
    let constant = |port: &str, value: &str| bit(cell, port).is_none_or(|pin| pin == value);
    let enabled = cell["parameters"]["CEMUX"] == "1" || constant("CE", "1");
    cell["type"] == "TRELLIS_FF" && enabled && constant("LSR", "0")
}

/// The half whose input a pin is.
fn half_of(name: &str, port: &str) -> Option<Half> {
    let (input, half) = port.split_at_checked(1)?;
    (INPUTS.contains(&input) && (half == "0" || half == "1"))
        .then(|| (name.to_string(), usize::from(half == "1")))
}

#[cfg(test)]
mod tests;
