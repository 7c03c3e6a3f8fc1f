//! The places back into the design that nextpnr wrote.

use serde_json::{Value, json};

use super::design::{Cell, Design, Kind, Port};
use super::read::PLACE;

/// Places, and other nets at the ports whose readers read another copy; how many those are.
pub fn into(placed: &mut Value, design: &Design, before: &Design) -> u64 {
    let mut dealt = 0;
    let Some(module) = placed["modules"].as_object_mut().and_then(|modules| modules.values_mut().next())
    else {
        return dealt;
    };
    // What it says of the router would count more than what we say when it is read.
    if let Some(settings) = module.get_mut("settings").and_then(Value::as_object_mut) {
        settings.remove("router");
    }
    let Some(cells) = module["cells"].as_object_mut() else { return dealt };
    for (number, (_, content)) in cells.iter_mut().enumerate() {
        let (cell, was) = (&design.cells[number], &before.cells[number]);
        if cell.kind.in_tile() {
            content["attributes"][PLACE] = json!(place(cell));
        }
        for (pin, was) in cell.pins.iter().zip(&was.pins).filter(|(pin, was)| pin.net != was.net) {
            content["connections"][name(design, was.port)] = json!([design.nets[pin.net as usize].bit]);
            dealt += 1;
        }
    }
    dealt
}

/// As nextpnr calls it.
fn place(cell: &Cell) -> String {
    let slice = char::from(b'A' + cell.slot / 2);
    let what = match cell.kind {
        Kind::RamWrite => "RAMW".to_string(),
        Kind::Register => format!("FF{}", cell.slot % 2),
        _ => format!("K{}", cell.slot % 2),
    };
    format!("X{}/Y{}/SLICE{slice}.{what}", cell.x, cell.y)
}

fn name(design: &Design, port: Port) -> &str {
    match port {
        Port::Other(number) => &design.ports[number as usize],
        known => Port::NAMED.iter().find(|(port, _)| *port == known).map_or("", |(_, name)| name),
    }
}
