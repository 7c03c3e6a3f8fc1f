//! The placed design that nextpnr writes: its cells have an attribute with their place.
//!
//! ```text
//!   "NEXTPNR_BEL": "X41/Y36/SLICEB.K0"        K: the LUT, FF: the register, RAMW: what writes the RAM beside it
//! ```

use std::collections::{BTreeMap, HashMap};

use serde_json::{Map, Value};

use super::delays::through;
use super::design::{Arc, Cell, Control, Design, Kind, NONE, Net, Pin, Port};
use super::slots::Slots;
use crate::fpga::nets::net;

/// The attribute of the place.
pub const PLACE: &str = "NEXTPNR_BEL";

/// The one module.
pub fn module(placed: &Value) -> Result<&Value, String> {
    let modules = placed["modules"].as_object().ok_or("it has no modules")?;
    modules.values().next().ok_or_else(|| "it has no module".into())
}

/// Reads it.
///
/// # Errors
/// What is missing or does not fit together.
pub fn design(placed: &Value) -> Result<Design, String> {
    let module = module(placed)?;
    let cells = module["cells"].as_object().ok_or("it has no cells")?;
    let mut reader = Reader { ignored: ignored(module), ..Reader::default() };
    for (name, cell) in cells {
        reader.cell(name, cell)?;
    }
    let Reader { mut design, bits, .. } = reader;
    finish_arcs(&mut design);
    pair(&mut design);
    loads(&mut design);
    design.slots = Slots::of(&design.cells)?;
    design.order = order(&design);
    group(&mut design, cells, &bits);
    design.check()?;
    Ok(design)
}

/// Nets whose wires take nothing that could be placed: global ones and constants.
fn ignored(module: &Value) -> Vec<u64> {
    let nets = module["netnames"].as_object().into_iter().flatten();
    let ignored = nets
        .filter(|(name, net)| !net["attributes"]["ECP5_IS_GLOBAL"].is_null() || name.starts_with("$PACKER_"));
    let mut bits: Vec<u64> = ignored.filter_map(|(_, net)| net["bits"][0].as_u64()).collect();
    bits.sort_unstable();
    bits
}

/// A setting of a cell; nextpnr pads those that are numbers.
fn setting<'a>(cell: &'a Value, name: &str) -> &'a str {
    cell["parameters"][name].as_str().unwrap_or_default().trim()
}

#[derive(Default)]
struct Reader {
    design: Design,
    ignored: Vec<u64>,
    bits: HashMap<u64, u32>,
    ports: HashMap<String, Port>,
}

impl Reader {
    fn net(&mut self, bit: u64) -> u32 {
        let (nets, ignored) = (&mut self.design.nets, &self.ignored);
        *self.bits.entry(bit).or_insert_with(|| {
            let ignored = ignored.binary_search(&bit).is_ok();
            nets.push(Net {
                driver: NONE,
                port: Port::Q,
                arcs: vec![],
                ignored,
                bit,
                from_array: false,
                group: 0,
            });
            nets.len() as u32 - 1
        })
    }

    fn port(&mut self, name: &str) -> Port {
        if let Some(port) = self.ports.get(name) {
            return *port;
        }
        let named = Port::NAMED.iter().find(|(_, known)| *known == name).map(|(port, _)| *port);
        let port = named.unwrap_or_else(|| {
            self.design.ports.push(name.to_string());
            Port::Other(self.design.ports.len() as u16 - 1)
        });
        self.ports.insert(name.to_string(), port);
        port
    }

    fn cell(&mut self, name: &str, content: &Value) -> Result<(), String> {
        let kind = kind(content);
        let (x, y, slot) = place(content)
            .or_else(|| (!kind.in_tile()).then_some((0, 0, 0)))
            .ok_or_else(|| format!("{name} has no place"))?;
        let number = self.design.cells.len() as u32;
        let mut pins = vec![];
        for (port, _) in content["connections"].as_object().into_iter().flatten() {
            let Some(bit) = net(content, port) else { continue };
            let (net, drives) = (self.net(bit), content["port_directions"][port] == "output");
            let register =
                port.strip_prefix("DO").and_then(|port| port.get(..1)).map(|half| format!("REGMODE_{half}"));
            let port = self.port(port);
            let arc = if drives { NONE } else { self.design.arcs.len() as u32 };
            let of = &mut self.design.nets[net as usize];
            match drives {
                true => {
                    (of.driver, of.port) = (number, port);
                    of.from_array = register.is_some_and(|register| setting(content, &register) == "NOREG");
                }
                false => {
                    of.arcs.push(arc);
                    let budget = f32::INFINITY;
                    self.design.arcs.push(Arc { net, to: number, port, free: false, budget });
                }
            }
            pins.push(Pin { port, net, arc });
        }
        let on = |port: Port| pins.iter().find(|pin| pin.port == port).map_or(NONE, |pin| pin.net);
        let control = match kind {
            Kind::Register => Control {
                clock: on(Port::Clk),
                reset: on(Port::Lsr),
                enable: on(Port::Ce),
                clock_inverted: setting(content, "CLKMUX") == "INV",
                reset_inverted: setting(content, "LSRMUX") == "INV",
                enable_setting: match setting(content, "CEMUX") {
                    "INV" => 1,
                    "0" => 2,
                    "1" => 3,
                    _ => 0,
                },
            },
            _ => Control::default(),
        };
        let (name, paired, chains_on, load) = (name.to_string(), false, false, 0);
        self.design.cells.push(Cell { name, kind, x, y, slot, pins, control, paired, chains_on, load });
        Ok(())
    }
}

/// The settings that say which clock each register of a multiplier has.
const MULTIPLIER_CLOCKS: [&str; 4] =
    ["REG_INPUTA_CLK", "REG_INPUTB_CLK", "REG_PIPELINE_CLK", "REG_OUTPUT_CLK"];

fn kind(cell: &Value) -> Kind {
    match cell["type"].as_str().unwrap_or_default() {
        "TRELLIS_FF" => Kind::Register,
        "TRELLIS_RAMW" => Kind::RamWrite,
        "TRELLIS_COMB" => match setting(cell, "MODE") {
            "CCU2" => Kind::Carry,
            "DPRAM" => Kind::Ram,
            "RAMW_BLOCK" => Kind::RamBlock,
            _ if net(cell, "OFX").is_some() || net(cell, "M").is_some() => Kind::Wide,
            _ => Kind::Lut,
        },
        "DP16KD" | "PDPW16KD" => Kind::BlockRam,
        "MULT18X18D" if MULTIPLIER_CLOCKS.iter().all(|clock| matches!(setting(cell, clock), "" | "NONE")) => {
            Kind::Multiplier
        }
        _ => Kind::Other,
    }
}

/// Where it is: column, row, and the slot in the tile.
fn place(cell: &Value) -> Option<(i16, i16, u8)> {
    let mut words = cell["attributes"][PLACE].as_str()?.split('/');
    let mut along = |axis: char| words.next()?.strip_prefix(axis)?.parse().ok();
    let (x, y) = (along('X')?, along('Y')?);
    let Some(slice) = words.next()?.strip_prefix("SLICE") else { return Some((x, y, 0)) };
    let first = 2 * "ABCD".find(slice.chars().next()?)? as u8;
    Some((x, y, if slice.ends_with('1') { first + 1 } else { first }))
}

fn finish_arcs(design: &mut Design) {
    for net in design.nets.iter_mut().filter(|net| net.driver == NONE) {
        net.ignored = true;
    }
    for arc in &mut design.arcs {
        let net = &design.nets[arc.net as usize];
        let within = matches!(arc.port, Port::Fci | Port::Di | Port::Fxa | Port::Fxb | Port::F1);
        let by_ram = design.cells.get(net.driver as usize).is_some_and(|cell| cell.kind == Kind::RamWrite);
        arc.free = net.ignored || within || by_ram;
    }
}

/// Registers with their LUTs, and the ends of the tiles in a chain.
fn pair(design: &mut Design) {
    for arc in &design.arcs {
        let from = design.nets[arc.net as usize].driver as usize;
        let to = arc.to as usize;
        match arc.port {
            Port::Di if from < design.cells.len() => {
                [from, to].iter().for_each(|&cell| design.cells[cell].paired = true);
            }
            Port::Fci if from < design.cells.len() => {
                design.cells[from].chains_on |= design.cells[from].x != design.cells[to].x;
            }
            _ => {}
        }
    }
}

fn loads(design: &mut Design) {
    for number in 0..design.cells.len() {
        let Design { cells, nets, arcs, .. } = &*design;
        let cell = &cells[number];
        if !cell.kind.in_tile() {
            continue;
        }
        let shared = |port| matches!(port, Port::Ce | Port::Lsr | Port::Wre);
        let loads = cell.pins.iter().filter(|pin| match pin.drives() {
            true => nets[pin.net as usize].arcs.iter().any(|&arc| !arcs[arc as usize].free),
            false => !arcs[pin.arc as usize].free && !shared(pin.port),
        });
        design.cells[number].load = loads.count() as u8;
    }
}

/// Each net behind those that it depends on; those of registers before all others, as readers may come to read another
/// one of them.
fn order(design: &Design) -> Vec<u32> {
    let mut seen = vec![false; design.nets.len()];
    let mut order = vec![];
    let of_register = |&net: &usize| {
        let cell = design.cells.get(design.nets[net].driver as usize);
        cell.is_some_and(|cell| cell.kind == Kind::Register)
    };
    let all = 0..design.nets.len();
    for first in all.clone().filter(of_register).chain(all) {
        let mut stack = vec![(first as u32, 0)];
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        while let Some((net, pin)) = stack.pop() {
            let Net { driver, port, ignored, .. } = design.nets[net as usize];
            let cell = design.cells.get(driver as usize).filter(|_| !ignored);
            let before = cell.and_then(|cell| {
                let pins = cell.pins.iter().enumerate().skip(pin);
                let mut before = pins.filter(|(_, pin)| {
                    !pin.drives() && through(cell, pin.port, port).is_some() && !seen[pin.net as usize]
                });
                before.next().map(|(at, pin)| (at, pin.net))
            });
            match before {
                Some((at, before)) => {
                    seen[before as usize] = true;
                    stack.extend([(net, at + 1), (before, 0)]);
                }
                None => order.push(net),
            }
        }
    }
    order
}

/// Registers that have the same input, control and settings.
fn group(design: &mut Design, cells: &Map<String, Value>, bits: &HashMap<u64, u32>) {
    type Key = (u64, Control, Vec<(String, String)>);
    let mut equal: BTreeMap<Key, Vec<u32>> = BTreeMap::new();
    for (number, content) in cells.values().enumerate() {
        let cell = &design.cells[number];
        let input = net(content, "DI").or(net(content, "M"));
        let (Kind::Register, Some(input), Some(out)) = (cell.kind, input, net(content, "Q")) else {
            continue;
        };
        // By which way the input comes in does not matter.
        let settings = content["parameters"].as_object().into_iter().flatten();
        let settings = settings.filter(|(name, _)| *name != "SD");
        let mut settings: Vec<(String, String)> =
            settings.map(|(name, value)| (name.clone(), value.to_string())).collect();
        settings.sort();
        equal.entry((input, cell.control, settings)).or_default().push(bits[&out]);
    }
    design.groups = vec![vec![]];
    for nets in equal.into_values().filter(|nets| nets.len() > 1) {
        nets.iter().for_each(|&net| design.nets[net as usize].group = design.groups.len() as u32);
        design.groups.push(nets);
    }
}
