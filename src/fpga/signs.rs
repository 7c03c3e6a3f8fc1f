//! The sign of a sum that two choices read gets a half of carry for each of them.
//!
//! ```text
//!   before   [a28|a28]─►[a28| 0]      s28 ──► choice 28, choice 29
//!   after    [a28|a28]─►[a28|a28]     s28 ──► choice 28, s29 ──► choice 29
//! ```
//!
//! Synthesis makes no more bits of a sum than it needs, and where the other number is wider, two choices read the last
//! one; then none of them goes into the [adder](super::fold). Where the last two halves of a chain are equal, p and g
//! are, and so is every further half: with p = 0 they all give g, with p = 1 they all pass on one carry and invert it.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::nets::{Nets, bit, net};

const PINS: [&str; 4] = ["A", "B", "C", "D"];

/// Gives signs that two LUTs read a half more where the last cell has one to spare; returns how many.
pub fn part_signs(module: &mut Value) -> u64 {
    let nets = Nets::of(module);
    let Some(cells) = module["cells"].as_object_mut() else { return 0 };
    let last = |(name, cell): (&String, &Value)| {
        let is_read = |port: &str| net(cell, port).is_some_and(|out| !nets.readers(out).is_empty());
        let sign = net(cell, "S0")?;
        let (before, _) = nets.drivers.get(&net(cell, "CIN")?)?;
        let spare = cell["type"] == "CCU2C" && !is_read("S1") && !is_read("COUT");
        let equal = content(cells.get(before)?, 1)? == content(cell, 0)? && is_constant(cell, 1);
        let readers: BTreeSet<&str> = nets.readers(sign).iter().map(|(reader, _)| reader.as_str()).collect();
        let choices = readers.iter().all(|name| cells.get(*name).is_some_and(|cell| cell["type"] == "LUT4"));
        let [_, (reader, pin)] = nets.readers(sign) else { return None };
        (spare && equal && choices && readers.len() == 2).then(|| (name.clone(), reader.clone(), pin.clone()))
    };
    let found: Vec<(String, String, String)> = cells.iter().filter_map(last).collect();
    for (free, (name, reader, pin)) in (nets.free()..).zip(&found) {
        let cell = &mut cells[name];
        for port in PINS {
            cell["connections"][format!("{port}1")] = cell["connections"][format!("{port}0")].clone();
        }
        for parameter in ["INIT", "INJECT1_"] {
            cell["parameters"][format!("{parameter}1")] = cell["parameters"][format!("{parameter}0")].clone();
        }
        cell["connections"]["S1"] = json!([free]);
        cells[reader]["connections"][pin] = json!([free]);
    }
    found.len() as u64
}

/// The pins and the table of half a cell.
fn content(cell: &Value, half: usize) -> Option<[&Value; 6]> {
    let [a, b, c, d] = [0, 1, 2, 3].map(|pin| bit(cell, &format!("{}{half}", PINS[pin])));
    let parameters = &cell["parameters"];
    let injects = &parameters[format!("INJECT1_{half}")];
    Some([a?, b?, c?, d?, &parameters[format!("INIT{half}")], injects]).filter(|_| injects == "NO")
}

fn is_constant(cell: &Value, half: usize) -> bool {
    PINS.iter().all(|pin| bit(cell, &format!("{pin}{half}")).is_none_or(Value::is_string))
}
