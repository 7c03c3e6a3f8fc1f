//! Registers that many cells read are copied, so that none has far to go to all of its readers.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::nets::{Nets, Pin, net};

/// Readers that a register may have: two chains of 15 bits. Fewer cost registers, more cost routing.
pub const MOST_READERS: usize = 32;

/// Readers that a RAM made of lookup tables stands for, which takes the place of six of them.
const READERS_OF_A_RAM: usize = 4;

/// Copies the registers of a module until none has more readers; returns how many copies that takes.
///
/// The readers are shared out in the order of their names: what stands side by side there does so on the device. The
/// registers behind one adder stay together, as two enables do not fit into one slice.
pub fn copy_registers(module: &mut Value) -> u64 {
    let mut copies = 0;
    // Copies are new readers of what stands before them.
    loop {
        let nets = Nets::of(module);
        let mut free = nets.free();
        let Some(cells) = module["cells"].as_object_mut() else { return copies };
        let registers: Vec<(String, u64)> = cells
            .iter()
            .filter(|(_, cell)| cell["type"] == "TRELLIS_FF")
            .filter_map(|(name, cell)| Some((name.clone(), net(cell, "Q")?)))
            .filter(|(_, out)| weight(cells, cells_of(nets.readers(*out))) > MOST_READERS)
            .collect();
        if registers.is_empty() {
            return copies;
        }
        for (name, out) in registers {
            for (nth, group) in groups(cells, &nets, nets.readers(out)).iter().enumerate().skip(1) {
                let mut copy = cells[&name].clone();
                copy["connections"]["Q"] = json!([free]);
                cells.insert(free_name(cells, &name, nth), copy);
                for (reader, port) in group {
                    redirect(&mut cells[reader]["connections"][port], out, free);
                }
                free += 1;
                copies += 1;
            }
        }
    }
}

/// Copies registers of a module whose readers are in another one, which is placed there once: a port for each copy.
/// Returns how many copies that takes.
pub fn copy_across(modules: &mut Map<String, Value>) -> u64 {
    let mut places: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (outer, module) in modules.iter() {
        for (cell, content) in module["cells"].as_object().into_iter().flatten() {
            let kind = content["type"].as_str().unwrap_or_default();
            if modules.get(kind).is_some_and(|inner| inner["attributes"]["blackbox"].is_null()) {
                places.entry(kind.into()).or_default().push((outer.clone(), cell.clone()));
            }
        }
    }
    let once = places.into_iter().filter_map(|(inner, places)| match places.as_slice() {
        [(outer, cell)] => Some((inner, outer.clone(), cell.clone())),
        _ => None,
    });
    once.map(|(inner, outer, cell)| copy_into(modules, &inner, &outer, &cell)).sum()
}

fn copy_into(modules: &mut Map<String, Value>, inner: &str, outer: &str, cell: &str) -> u64 {
    let (within, around) = (Nets::of(&modules[inner]), Nets::of(&modules[outer]));
    let (mut free_within, mut free_around) = (within.free(), around.free());
    let Some(cells) = modules[inner]["cells"].as_object() else { return 0 };
    let ports: Vec<(String, u64, String)> = modules[inner]["ports"]
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(_, port)| port["direction"] == "input")
        .filter_map(|(name, port)| {
            let [bit] = port["bits"].as_array()?.as_slice() else { return None };
            let (register, _) = around.drivers.get(&net(&modules[outer]["cells"][cell], name)?)?;
            let is_register = modules[outer]["cells"][register]["type"] == "TRELLIS_FF";
            Some((name.clone(), bit.as_u64()?, register.clone())).filter(|_| is_register)
        })
        .filter(|(_, bit, _)| weight(cells, cells_of(within.readers(*bit))) > MOST_READERS)
        .collect();
    let mut copies = 0;
    for (port, bit, register) in ports {
        let Some(cells) = modules[inner]["cells"].as_object() else { continue };
        let groups = groups(cells, &within, within.readers(bit));
        for (nth, group) in groups.iter().enumerate().skip(1) {
            let copy = format!("{port}_copy{nth}");
            let module = &mut modules[inner];
            module["ports"][&copy] = json!({ "direction": "input", "bits": [free_within] });
            for (reader, pin) in group {
                redirect(&mut module["cells"][reader]["connections"][pin], bit, free_within);
            }
            let Some(cells) = modules[outer]["cells"].as_object_mut() else { continue };
            cells[cell]["port_directions"][&copy] = json!("input");
            cells[cell]["connections"][&copy] = json!([free_around]);
            let mut another = cells[&register].clone();
            another["connections"]["Q"] = json!([free_around]);
            cells.insert(free_name(cells, &register, nth), another);
            (free_within, free_around) = (free_within + 1, free_around + 1);
            copies += 1;
        }
    }
    copies
}

/// The readers in groups of as many as a register may have.
fn groups<'a>(cells: &Map<String, Value>, nets: &Nets, readers: &'a [Pin]) -> Vec<Vec<&'a Pin>> {
    let mut units: BTreeMap<String, Vec<&Pin>> = BTreeMap::new();
    for pin in cells_of(readers) {
        units.entry(chain(cells, nets, &pin.0)).or_default().push(pin);
    }
    let units: Vec<&[&Pin]> = units.values().flat_map(|unit| unit.chunks(MOST_READERS)).collect();
    let mut groups: Vec<Vec<&Pin>> = vec![];
    let weight = |pins: &[&Pin]| weight(cells, pins.iter().copied());
    for unit in units {
        match groups.last_mut().filter(|group| weight(group) + weight(unit) <= MOST_READERS) {
            Some(group) => group.extend(unit),
            None => groups.push(unit.to_vec()),
        }
    }
    groups
}

/// How many readers pins stand for.
fn weight<'a>(cells: &Map<String, Value>, pins: impl Iterator<Item = &'a Pin>) -> usize {
    let is_ram = |name: &str| cells.get(name).is_some_and(|cell| cell["type"] == "TRELLIS_DPR16X4");
    pins.map(|(name, _)| if is_ram(name) { READERS_OF_A_RAM } else { 1 }).sum()
}

/// The first cell of the chain of carry that a cell belongs to, or that a register takes its bit from; else the cell.
fn chain(cells: &Map<String, Value>, nets: &Nets, name: &str) -> String {
    let carry = |name: &String| cells.get(name).is_some_and(|cell| cell["type"] == "CCU2C");
    let before = |name: &str, port: &str| {
        let (driver, _) = nets.drivers.get(&net(cells.get(name)?, port)?)?;
        Some(driver.clone()).filter(carry)
    };
    let mut first = before(name, "DI").unwrap_or_else(|| name.to_string());
    while let Some(lower) = before(&first, "CIN") {
        first = lower;
    }
    first
}

/// The readers without ports of the module, which stay with the first one.
fn cells_of(readers: &[Pin]) -> impl Iterator<Item = &Pin> {
    readers.iter().filter(|(cell, _)| !cell.is_empty())
}

fn free_name(cells: &Map<String, Value>, name: &str, nth: usize) -> String {
    let mut free = format!("{name}_copy{nth}");
    while cells.contains_key(&free) {
        free.push('_');
    }
    free
}

fn redirect(bits: &mut Value, from: u64, to: u64) {
    for bit in bits.as_array_mut().into_iter().flatten().filter(|bit| bit.as_u64() == Some(from)) {
        *bit = json!(to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reset_from_outside_has_a_register_for_every_few_of_its_readers() {
        let register = |reset: Value, input: u64, out: u64| {
            json!({
                "type": "TRELLIS_FF",
                "port_directions": { "LSR": "input", "DI": "input", "Q": "output" },
                "connections": { "LSR": [reset], "DI": [input], "Q": [out] },
            })
        };
        let inner: Map<String, Value> =
            (0..70).map(|n| (format!("reader{n:02}"), register(json!(2), 1, 10 + n))).collect();
        let outer = json!({
            "held": register(json!("0"), 2, 3),
            "core": {
                "type": "core",
                "port_directions": { "aresetn": "input" },
                "connections": { "aresetn": [3] },
            },
        });
        let mut modules = Map::new();
        let ports = json!({ "aresetn": { "direction": "input", "bits": [2] } });
        modules.insert("core".into(), json!({ "ports": ports, "cells": inner }));
        modules.insert("top".into(), json!({ "ports": {}, "cells": outer }));
        assert_eq!(copy_across(&mut modules), 2);
        let (within, around) = (Nets::of(&modules["core"]), Nets::of(&modules["top"]));
        let mut readers = 0;
        for (name, port) in modules["core"]["ports"].as_object().unwrap() {
            let bit = port["bits"][0].as_u64().unwrap();
            assert!(within.readers(bit).len() <= MOST_READERS, "{name}");
            readers += within.readers(bit).len();
            let (register, _) = &around.drivers[&net(&modules["top"]["cells"]["core"], name).unwrap()];
            assert_eq!(net(&modules["top"]["cells"][register], "DI"), Some(2), "{name}");
        }
        assert_eq!(readers, 70);
        assert_eq!(copy_across(&mut modules), 0);
    }

    fn module(readers: u64) -> Value {
        let register = |input: u64, out: u64| {
            json!({
                "type": "TRELLIS_FF",
                "port_directions": { "DI": "input", "Q": "output" },
                "connections": { "DI": [input], "Q": [out] },
            })
        };
        let mut cells = Map::new();
        cells.insert("before".into(), register(2, 3));
        cells.insert("source".into(), register(3, 4));
        (0..readers).for_each(|n| drop(cells.insert(format!("reader{n:04}"), register(4, 10 + n))));
        json!({ "ports": { "y": { "direction": "output", "bits": [4] } }, "cells": cells })
    }

    #[test]
    fn no_register_has_more_readers_than_it_may_and_all_read_the_same() {
        for readers in [32, 33, 700] {
            let mut copied = module(readers);
            let copies = copy_registers(&mut copied);
            let nets = Nets::of(&copied);
            assert_eq!(copies > 0, readers > 32);
            for (bit, readers) in &nets.readers {
                assert!(*bit == 2 || cells_of(readers).count() <= MOST_READERS, "{bit}");
            }
            // Back to the input, each in three steps.
            for n in 0..readers {
                let mut name = format!("reader{n:04}");
                let mut steps = 0;
                while let Some(input) = net(&copied["cells"][&name], "DI") {
                    let Some((driver, _)) = nets.drivers.get(&input) else { break };
                    (name, steps) = (driver.clone(), steps + 1);
                }
                assert_eq!(steps, 2);
            }
            assert_eq!(copied["ports"], module(readers)["ports"]);
        }
    }

    #[test]
    fn an_address_has_a_register_for_every_few_rams() {
        let mut rams = module(9);
        for (_, cell) in rams["cells"].as_object_mut().unwrap().iter_mut().filter(|(n, _)| n.starts_with('r'))
        {
            cell["type"] = json!("TRELLIS_DPR16X4");
        }
        assert_eq!(copy_registers(&mut rams), 1);
        let nets = Nets::of(&rams);
        assert!(nets.readers.values().all(|readers| readers.len() <= 8 + 1));
    }

    #[test]
    fn registers_behind_one_adder_have_one_enable() {
        let mut cells = Map::new();
        let carry = json!({
            "type": "CCU2C",
            "port_directions": { "CIN": "input", "COUT": "output", "S0": "output", "S1": "output" },
        });
        let register = |input: u64, enable: u64, out: u64| {
            json!({
                "type": "TRELLIS_FF",
                "port_directions": { "DI": "input", "CE": "input", "Q": "output" },
                "connections": { "DI": [input], "CE": [enable], "Q": [out] },
            })
        };
        cells.insert("enable".into(), register(2, 3, 4));
        for chain in 0..3u64 {
            for place in 0..10u64 {
                let of = |place: u64| 100 + 1000 * chain + 10 * place;
                let mut cell = carry.clone();
                let below = if place == 0 { json!("0") } else { json!(of(place - 1)) };
                cell["connections"] = json!({ "CIN": [below], "COUT": [of(place)], "S0": [of(place) + 1], "S1": [of(place) + 2] });
                cells.insert(format!("carry{chain}_{}", 9 - place), cell);
                for half in 1..3 {
                    // Their names tell nothing of the chains.
                    let name = format!("register{place}_{half}_{chain}");
                    cells.insert(name, register(of(place) + half, 4, of(place) + half + 5000));
                }
            }
        }
        let mut module = json!({ "ports": {}, "cells": cells });
        assert_eq!(copy_registers(&mut module), 2);
        let enable = |chain: u64, place: u64, half: u64| {
            net(&module["cells"][&format!("register{place}_{half}_{chain}")], "CE")
        };
        for chain in 0..3 {
            assert!((0..10).all(|place| enable(chain, place, 1) == enable(chain, 0, 2)));
            assert!((0..10).all(|place| enable(chain, place, 2) == enable(chain, 0, 2)));
        }
        assert_ne!(enable(0, 0, 1), enable(1, 0, 1));
    }
}
