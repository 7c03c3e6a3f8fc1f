//! Registers that many cells read are copied, so that none has far to go to all of its readers.

use serde_json::{Map, Value, json};

use super::nets::{Nets, Pin, net};

/// Readers that a register may have. Fewer cost registers, more cost routing.
pub const MOST_READERS: usize = 24;

/// Copies the registers of a module until none has more readers; returns how many copies that takes.
///
/// The readers are shared out in the order of their names: what stands side by side there does so on the device.
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
            .filter(|(_, out)| cells_of(nets.readers(*out)).count() > MOST_READERS)
            .collect();
        if registers.is_empty() {
            return copies;
        }
        for (name, out) in registers {
            let readers: Vec<&Pin> = cells_of(nets.readers(out)).collect();
            let size = readers.len().div_ceil(readers.len().div_ceil(MOST_READERS));
            for (nth, group) in readers.chunks(size).enumerate().skip(1) {
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
        for readers in [24, 25, 700] {
            let mut copied = module(readers);
            let copies = copy_registers(&mut copied);
            let nets = Nets::of(&copied);
            assert_eq!(copies > 0, readers > 24);
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
}
