//! Small placed designs, made by hand.

use serde_json::{Map, Value, json};

use super::design::Design;
use super::{read, refine, same};

/// A design of cells on one clock.
#[derive(Default)]
struct Placed {
    cells: Map<String, Value>,
}

const CLOCK: u64 = 1;

impl Placed {
    fn cell(&mut self, name: &str, kind: &str, place: &str, settings: Value, ports: &[(&str, u64)]) {
        let out = |port: &str| {
            matches!(port, "F" | "Q" | "FCO" | "P7") || port.starts_with("WDO") || port.starts_with("WADO")
        };
        let directions: Map<String, Value> = ports
            .iter()
            .map(|(port, _)| (port.to_string(), json!(if out(port) { "output" } else { "input" })))
            .collect();
        let wires: Map<String, Value> =
            ports.iter().map(|(port, net)| (port.to_string(), json!([net]))).collect();
        let content = json!({
            "type": kind,
            "parameters": settings,
            "attributes": { "NEXTPNR_BEL": place },
            "port_directions": directions,
            "connections": wires,
        });
        self.cells.insert(name.into(), content);
    }

    fn register(&mut self, name: &str, place: &str, ports: &[(&str, u64)]) {
        let ports = [ports, &[("CLK", CLOCK)]].concat();
        let settings = json!({ "REGSET": "RESET", "CLKMUX": "CLK", "LSRMUX": "LSR", "CEMUX": "CE" });
        self.cell(name, "TRELLIS_FF", place, settings, &ports);
    }

    fn lut(&mut self, name: &str, place: &str, ports: &[(&str, u64)]) {
        self.cell(name, "TRELLIS_COMB", place, json!({ "INITVAL": "1010101010101010" }), ports);
    }

    fn carry(&mut self, name: &str, place: &str, ports: &[(&str, u64)]) {
        self.cell(name, "TRELLIS_COMB", place, json!({ "MODE": "CCU2" }), ports);
    }

    fn value(&self) -> Value {
        json!({ "modules": { "top": {
            "cells": self.cells,
            "netnames": { "clock": { "bits": [CLOCK], "attributes": { "ECP5_IS_GLOBAL": "1" } } },
        } } })
    }

    fn read(&self) -> Result<Design, String> {
        read::design(&self.value())
    }

    fn refined(&self) -> (Design, super::Refined) {
        let (text, refined) = refine(&serde_json::to_vec(&self.value()).unwrap(), 1.5).unwrap();
        (read::design(&serde_json::from_slice(&text).unwrap()).unwrap(), refined)
    }
}

fn distance(design: &Design, a: &str, b: &str) -> i32 {
    let place =
        |name: &str| design.cells.iter().find(|cell| cell.name == name).map(|cell| (cell.x, cell.y)).unwrap();
    let ((x, y), (u, v)) = (place(a), place(b));
    i32::from((x - u).abs() + (y - v).abs())
}

/// Two registers with a LUT between them, in opposite corners.
fn far_apart() -> Placed {
    let mut placed = Placed::default();
    placed.register("a", "X2/Y2/SLICEA.FF0", &[("M", 9), ("Q", 2)]);
    placed.lut("g", "X60/Y50/SLICEC.K1", &[("A", 2), ("F", 3)]);
    placed.register("b", "X60/Y50/SLICEC.FF1", &[("DI", 3), ("Q", 9)]);
    // A logic row in between, so that there is one.
    (3..50).for_each(|y| placed.lut(&format!("other{y}"), &format!("X30/Y{y}/SLICEA.K0"), &[("A", 9)]));
    placed
}

#[test]
fn what_is_far_apart_comes_together_and_a_register_keeps_its_lut() {
    let placed = far_apart();
    let (design, refined) = placed.refined();
    assert!(refined.longest_before_ns > 5.0 && refined.longest_after_ns < 3.0, "{refined:?}");
    assert!(distance(&design, "a", "g") < 12 && distance(&design, "g", "b") == 0);
    same::proved(&placed.read().unwrap(), &design).unwrap();
}

#[test]
fn the_same_placement_comes_to_the_same_bytes() {
    let text = serde_json::to_vec(&far_apart().value()).unwrap();
    assert_eq!(refine(&text, 1.5).unwrap().0, refine(&text, 1.5).unwrap().0);
}

#[test]
fn what_is_no_placed_design_is_refused() {
    for text in [&b"no"[..], b"{}", br#"{"modules": {"top": {"cells": {"a": {"type": "TRELLIS_FF"}}}}}"#] {
        assert_eq!(refine(text, 1.5).unwrap_err().exit_status(), 5);
    }
}

#[test]
fn a_register_beside_its_lut_is_refused() {
    let mut placed = far_apart();
    placed.cells["b"]["attributes"]["NEXTPNR_BEL"] = json!("X60/Y50/SLICEC.FF0");
    assert!(placed.read().unwrap_err().contains("b is not beside g"));
}

#[test]
fn two_enables_in_a_slice_and_two_resets_in_a_tile_are_refused() {
    for (second, port, fits) in
        [("SLICEA.FF1", "CE", false), ("SLICEB.FF0", "CE", true), ("SLICED.FF1", "LSR", false)]
    {
        let mut placed = Placed::default();
        placed.register("a", "X2/Y2/SLICEA.FF0", &[("M", 2), ("Q", 3), (port, 4)]);
        placed.register("b", &format!("X2/Y2/{second}"), &[("M", 3), ("Q", 2), (port, 5)]);
        assert_eq!(placed.read().is_ok(), fits, "{second} {port}");
    }
}

#[test]
fn a_lut_beside_half_a_slice_of_carry_is_refused() {
    for (slot, fits) in [("SLICEA.K1", false), ("SLICEB.K0", true)] {
        let mut placed = Placed::default();
        placed.carry("sum", "X2/Y2/SLICEA.K0", &[("A", 2), ("F", 3)]);
        placed.lut("g", &format!("X2/Y2/{slot}"), &[("A", 3), ("F", 2)]);
        assert_eq!(placed.read().is_ok(), fits);
    }
}

/// A chain of so many bits from a tile on, each with a register; its nets are numbered from `nets` on.
fn add_chain(placed: &mut Placed, name: &str, (x, y): (u64, u64), bits: u64, nets: u64) {
    for bit in 0..bits {
        let place = |what: &str| {
            let slice = char::from(b'A' + (bit % 8 / 2) as u8);
            format!("X{}/Y{y}/SLICE{slice}.{what}{}", x + bit / 8, bit % 2)
        };
        let mut ports = vec![("A", 2), ("F", nets + bit), ("FCO", nets + 101 + bit)];
        if bit > 0 {
            ports.push(("FCI", nets + 100 + bit));
        }
        placed.carry(&format!("{name}{bit}"), &place("K"), &ports);
        let ports = [("DI", nets + bit), ("Q", nets + 200 + bit)];
        placed.register(&format!("{name}_total{bit}"), &place("FF"), &ports);
    }
}

#[test]
fn a_lower_half_of_a_slice_makes_a_carry_later_and_an_upper_one_does_not() {
    let reach = |bits| {
        let mut placed = far_apart();
        add_chain(&mut placed, "sum", (50, 40), bits, 1000);
        placed.read().unwrap().reach()
    };
    // Two bits are a slice.
    for bits in 20..30 {
        assert!((reach(bits + 2) - reach(bits) - 0.056).abs() < 1e-4);
    }
}

#[test]
fn a_path_goes_on_through_a_multiplier_without_registers() {
    let reach = |clock: &str| {
        let mut placed = far_apart();
        let ports = [("A3", 2), ("P7", 4)];
        let settings = json!({ "REG_INPUTA_CLK": "NONE", "REG_OUTPUT_CLK": clock });
        placed.cell("product", "MULT18X18D", "X49/Y10/MULT18_0", settings, &ports);
        placed.register("c", "X50/Y10/SLICEA.FF0", &[("M", 4)]);
        placed.read().unwrap().reach()
    };
    assert!((1.0..1.5).contains(&reach("CLK0")) && reach("NONE") > 4.0);
}

#[test]
fn no_path_is_asked_to_be_shorter_than_the_longest_can_be() {
    let mut placed = far_apart();
    add_chain(&mut placed, "sum", (50, 40), 50, 1000);
    let text = serde_json::to_vec(&placed.value()).unwrap();
    let reach = placed.read().unwrap().reach();
    let of = |target| refine(&text, target).unwrap().0;
    assert!(reach > 2.5 && of(0.1) == of(reach) && of(reach) != of(reach + 0.4));
}

#[test]
fn a_chain_changes_places_with_the_whole_chain_that_is_there() {
    let mut placed = far_apart();
    add_chain(&mut placed, "long", (40, 40), 20, 1000);
    add_chain(&mut placed, "short", (50, 42), 9, 2000);
    let mut design = placed.read().unwrap();
    let tile = |design: &Design, x, y| design.slots.tile(x, y).unwrap();
    // Its second tile is named, all three are meant.
    let spans = design.spans(tile(&design, 41, 40), tile(&design, 51, 42)).unwrap();
    design.swap_spans(spans);
    design.check().unwrap();
    let place = |name: &str| {
        let cell = design.cells.iter().find(|cell| cell.name == name).unwrap();
        (cell.x, cell.y)
    };
    assert_eq!((place("long0"), place("long19")), ((50, 42), (52, 42)));
    assert_eq!((place("short0"), place("short8")), ((40, 40), (41, 40)));
    // Neither with itself, nor where another chain would be cut.
    let design = placed.read().unwrap();
    assert!(design.spans(tile(&design, 41, 40), tile(&design, 42, 40)).is_none());
    assert!(design.spans(tile(&design, 50, 42), tile(&design, 39, 40)).is_none());
}

#[test]
fn the_router_is_not_said_by_the_placement() {
    let mut value = far_apart().value();
    value["modules"]["top"]["settings"] = json!({ "router": "router1", "seed": "1" });
    let (text, _) = refine(&serde_json::to_vec(&value).unwrap(), 1.5).unwrap();
    let refined: Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(refined["modules"]["top"]["settings"], json!({ "seed": "1" }));
}

#[test]
fn a_chain_moves_as_one() {
    let mut placed = far_apart();
    // Ten bits: a tile and a quarter, far from the register that it adds to.
    add_chain(&mut placed, "sum", (58, 40), 10, 1000);
    let (design, refined) = placed.refined();
    assert!(refined.longest_after_ns + 0.5 < refined.longest_before_ns, "{refined:?}");
    assert!(distance(&design, "sum0", "sum9") == 1 && distance(&design, "sum0", "sum7") == 0);
    design.check().unwrap();
    // A part of it alone would be noticed.
    placed.cells["sum9"]["attributes"]["NEXTPNR_BEL"] = json!("X70/Y40/SLICEA.K1");
    placed.cells["sum_total9"]["attributes"]["NEXTPNR_BEL"] = json!("X70/Y40/SLICEA.FF1");
    assert!(placed.read().unwrap_err().contains("sum9 is not beside sum8"));
}

/// A register and a copy, each with a reader beside the other one.
fn crossed() -> Placed {
    let mut placed = far_apart();
    for (name, place, out) in [("q", "X2/Y20/SLICEA.FF0", 400), ("q_copy", "X60/Y20/SLICEA.FF0", 401)] {
        placed.register(name, place, &[("M", 9), ("Q", out)]);
    }
    placed.register("left", "X3/Y20/SLICEA.FF0", &[("M", 401), ("Q", 410)]);
    placed.register("right", "X61/Y20/SLICEA.FF0", &[("M", 400), ("Q", 411)]);
    placed
}

#[test]
fn readers_are_dealt_to_the_copies_beside_them() {
    let placed = crossed();
    let before = placed.read().unwrap();
    let (after, refined) = placed.refined();
    assert!(refined.dealt_readers > 0 && refined.longest_after_ns < 3.0, "{refined:?}");
    same::proved(&before, &after).unwrap();
}

#[test]
fn a_reader_of_something_else_is_not_the_same_circuit() {
    let before = crossed();
    for (cell, port, net, same) in [("left", "M", 400, true), ("left", "M", 9, false), ("g", "A", 9, false)] {
        let mut after = crossed();
        after.cells[cell]["connections"][port] = json!([net]);
        let proved = same::proved(&before.read().unwrap(), &after.read().unwrap());
        assert_eq!(proved.is_ok(), same, "{cell} {net}");
    }
    // With another start the copy is none.
    let mut other = crossed();
    other.cells["q_copy"]["parameters"]["REGSET"] = json!("SET");
    let mut after = crossed();
    after.cells["q_copy"]["parameters"]["REGSET"] = json!("SET");
    after.cells["left"]["connections"]["M"] = json!([400]);
    assert!(same::proved(&other.read().unwrap(), &after.read().unwrap()).is_err());
}

#[test]
fn a_ram_keeps_what_writes_it_in_its_tile() {
    let mut placed = far_apart();
    for at in 0..4u64 {
        let slice = if at < 2 { "A" } else { "B" };
        let place = format!("X58/Y30/SLICE{slice}.K{}", at % 2);
        let ports = [("WD", 500 + at), ("WRE", 2), ("A", 2), ("F", 510 + at)];
        placed.cell(&format!("ram{at}"), "TRELLIS_COMB", &place, json!({ "MODE": "DPRAM" }), &ports);
    }
    let ports = [("A0", 9), ("WDO0", 500), ("WDO1", 501), ("WDO2", 502), ("WDO3", 503)];
    placed.cell("write", "TRELLIS_RAMW", "X58/Y30/SLICEC.RAMW", json!({}), &ports);
    let (design, _) = placed.refined();
    assert!((0..4).all(|at| distance(&design, "write", &format!("ram{at}")) == 0));
    // And nothing else may take the slice of that.
    placed.lut("intruder", "X58/Y30/SLICEC.K0", &[("A", 2), ("F", 600)]);
    assert!(placed.read().unwrap_err().contains("(58, 30)"));
}
