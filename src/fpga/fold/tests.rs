//! Small netlists folded, and run for many inputs before and after.

use super::super::signs::part_signs;
use super::*;

/// Inputs of the module are bits 2 to 19, its outputs 100 on; 3 bits of a, b and n, and the choice.
const CHOICE: u64 = 2;
const A: u64 = 4;
const B: u64 = 8;
const N: u64 = 12;

fn lut(inputs: [Value; 4], out: u64, table: impl Fn(usize) -> bool) -> Value {
    let table: u32 = (0..16).map(|index| u32::from(table(index)) << index).sum();
    let [a, b, c, d] = inputs;
    json!({
        "type": "LUT4",
        "parameters": { "INIT": format!("{table:016b}") },
        "port_directions": { "A": "input", "B": "input", "C": "input", "D": "input", "Z": "output" },
        "connections": { "A": [a], "B": [b], "C": [c], "D": [d], "Z": [out] },
    })
}

/// A cell of an adder, as Yosys makes it: D is 1, C inverts B.
fn adder(carry_in: Value, a: [Value; 2], b: [Value; 2], sums: [u64; 2], carry_out: u64) -> Value {
    let mut cell = json!({
        "type": "CCU2C",
        "parameters": { "INJECT1_0": "NO", "INJECT1_1": "NO" },
        "port_directions": { "CIN": "input", "COUT": "output", "S0": "output", "S1": "output" },
        "connections": { "CIN": [carry_in], "COUT": [carry_out] },
    });
    for half in 0..2 {
        cell["parameters"][format!("INIT{half}")] = json!(format!("{:016b}", 0x96AA));
        cell["connections"][format!("S{half}")] = json!([sums[half]]);
        let pins = [a[half].clone(), b[half].clone(), json!("0"), json!("1")];
        for (name, pin) in INPUTS.iter().zip(pins) {
            cell["connections"][format!("{name}{half}")] = json!([pin]);
            cell["port_directions"][format!("{name}{half}")] = json!("input");
        }
    }
    cell
}

fn module(cells: Vec<(&str, Value)>, outputs: &[u64]) -> Value {
    let inputs: Vec<u64> = (2..20).collect();
    json!({
        "ports": {
            "i": { "direction": "input", "bits": inputs },
            "y": { "direction": "output", "bits": outputs },
        },
        "cells": cells.into_iter().map(|(name, cell)| (name.to_string(), cell)).collect::<Map<_, _>>(),
    })
}

/// What the module puts out for these inputs.
fn outputs(module: &Value, inputs: u32) -> Vec<Option<bool>> {
    let mut bits: BTreeMap<u64, bool> = (2..20).map(|bit| (bit, inputs >> (bit - 2) & 1 == 1)).collect();
    let mut carries: BTreeMap<u64, bool> = BTreeMap::new();
    // Settled after as many rounds as there are cells.
    for _ in module["cells"].as_object().unwrap() {
        let registers = |cell: &Value| cell["type"] == "TRELLIS_FF";
        for (_, cell) in module["cells"].as_object().unwrap().iter().filter(|(_, cell)| !registers(cell)) {
            let value = |bits: &BTreeMap<u64, bool>, port: &str| match bit(cell, port) {
                Some(Value::String(constant)) => constant == "1",
                Some(net) => net.as_u64().and_then(|net| bits.get(&net).copied()).unwrap_or(false),
                None => false,
            };
            let index = |bits: &BTreeMap<u64, bool>, half: &str| -> usize {
                let pin = |(place, name): (usize, &&str)| {
                    usize::from(value(bits, &format!("{name}{half}"))) << place
                };
                INPUTS.iter().enumerate().map(pin).sum()
            };
            if cell["type"] == "LUT4" {
                let high = table(cell, "INIT").unwrap() >> index(&bits, "") & 1 == 1;
                bits.insert(net(cell, "Z").unwrap(), high);
                continue;
            }
            let mut carry = match net(cell, "CIN") {
                Some(net) => carries.get(&net).copied().unwrap_or(false),
                None => value(&bits, "CIN"),
            };
            for half in ["0", "1"] {
                let (table, index) = (table(cell, &format!("INIT{half}")).unwrap(), index(&bits, half));
                let (passes, generates) = (table >> index & 1 == 1, table >> (index & 3) & 1 == 1);
                if let Some(sum) = net(cell, &format!("S{half}")) {
                    bits.insert(sum, passes ^ carry);
                }
                carry = if passes { carry } else { generates };
            }
            if let Some(out) = net(cell, "COUT") {
                carries.insert(out, carry);
            }
        }
    }
    let ports = module["ports"]["y"]["bits"].as_array().unwrap();
    ports.iter().map(|bit| bits.get(&bit.as_u64().unwrap()).copied()).collect()
}

fn same(before: &Value, after: &Value) {
    let mut seen = BTreeSet::new();
    for inputs in (0..1 << 14).step_by(3) {
        assert_eq!(outputs(before, inputs), outputs(after, inputs), "{inputs:b}");
        seen.insert(outputs(before, inputs));
    }
    assert!(seen.len() >= 4);
}

/// choice ? n : a + b, of 3 bits.
fn chosen(more_outputs: &[u64]) -> Value {
    let net = |first: u64, bit: u64| json!(first + bit);
    let sums = [50, 51, 52, 53];
    let two = |first: u64, bit: u64| [net(first, bit), net(first, bit + 1)];
    let choice = |bit: u64| {
        let inputs = [json!(CHOICE), net(N, bit), json!(sums[bit as usize]), json!("0")];
        lut(inputs, 100 + bit, |index| if index & 1 == 1 { index & 2 != 0 } else { index & 4 != 0 })
    };
    let high = adder(json!(60), [net(A, 2), json!("0")], [net(B, 2), json!("0")], [sums[2], sums[3]], 61);
    let outputs = [&[100, 101, 102], more_outputs].concat();
    module(
        vec![
            ("low", adder(json!("0"), two(A, 0), two(B, 0), [sums[0], sums[1]], 60)),
            ("high", high),
            ("choice0", choice(0)),
            ("choice1", choice(1)),
            ("choice2", choice(2)),
        ],
        &outputs,
    )
}

#[test]
fn a_choice_behind_an_adder_goes_into_it() {
    let (before, mut after) = (chosen(&[]), chosen(&[]));
    assert_eq!(fold_choices(&mut after), 3);
    assert_eq!(after["cells"].as_object().unwrap().len(), 2);
    same(&before, &after);
}

#[test]
fn a_sum_or_a_carry_that_others_read_stays() {
    // Sum bit 1; the carry out of the highest bit.
    for read in [51, 53] {
        let mut module = chosen(&[read]);
        assert_eq!(fold_choices(&mut module), 0, "net {read}");
        assert_eq!(module, chosen(&[read]));
    }
}

/// (choice ? n : a) + (choice ? 0 : b), of 2 bits; others may read one of the operands.
fn operands(more_outputs: &[u64]) -> Value {
    let first = |bit: u64| {
        let inputs = [json!(CHOICE), json!(N + bit), json!(A + bit), json!("0")];
        lut(inputs, 30 + bit, |index| if index & 1 == 1 { index & 2 != 0 } else { index & 4 != 0 })
    };
    let second = |bit: u64| {
        let inputs = [json!(CHOICE), json!(B + bit), json!("0"), json!("0")];
        lut(inputs, 40 + bit, |index| index & 3 == 2)
    };
    let sum = adder(json!("0"), [json!(30), json!(31)], [json!(40), json!(41)], [100, 101], 60);
    let cells = vec![("s", sum), ("a0", first(0)), ("a1", first(1)), ("b0", second(0)), ("b1", second(1))];
    module(cells, &[&[100, 101], more_outputs].concat())
}

#[test]
fn operands_in_front_of_an_adder_go_into_it() {
    let (before, mut after) = (operands(&[]), operands(&[]));
    assert_eq!(absorb_operands(&mut after), 4);
    same(&before, &after);
    // A gate that others read stays, though the adder no longer needs it.
    let (before, mut after) = (operands(&[40]), operands(&[40]));
    assert_eq!(absorb_operands(&mut after), 3);
    same(&before, &after);
}

/// The same, where the lowest bit of n is 0: a register that takes the sum there is reset by the choice.
fn cleared(reset: &str) -> Value {
    let mut module = chosen(&[]);
    module["ports"]["y"]["bits"] = json!([101, 102]);
    let cells = module["cells"].as_object_mut().unwrap();
    cells.remove("choice0");
    let register = json!({
        "type": "TRELLIS_FF",
        "parameters": { "LSRMUX": reset },
        "port_directions": { "DI": "input", "LSR": "input", "Q": "output" },
        "connections": { "DI": [50], "LSR": [CHOICE], "Q": [100] },
    });
    cells.insert("lowest".into(), register);
    module
}

#[test]
fn a_sum_that_goes_to_a_register_that_the_choice_resets_does_not_hinder() {
    let (before, mut after) = (cleared("LSR"), cleared("LSR"));
    assert_eq!(fold_choices(&mut after), 2);
    same(&before, &after);
    // A register that is reset while no choice is made looks at it when one is.
    let mut other = cleared("INV");
    assert_eq!(fold_choices(&mut other), 0);
}

/// choice ? n : a + b, of 4 bits and numbers of 2 bits with a sign: both highest bits of the sum are its sign.
fn signed(sign: u64) -> Value {
    let mut module = chosen(&[103]);
    let cells = module["cells"].as_object_mut().unwrap();
    let inputs = [json!(CHOICE), json!(N + 3), json!(52), json!("0")];
    let table = |index: usize| if index & 1 == 1 { index & 2 != 0 } else { index & 4 != 0 };
    cells.insert("choice3".into(), lut(inputs, 103, table));
    cells["high"]["connections"]["A0"] = json!([A + sign]);
    cells["high"]["connections"]["B0"] = json!([B + sign]);
    cells["high"]["connections"]["S1"] = open();
    cells["high"]["connections"]["COUT"] = open();
    module
}

#[test]
fn a_sign_that_two_choices_read_does_not_hinder() {
    let (before, mut after) = (signed(1), signed(1));
    assert_eq!(fold_choices(&mut after), 0);
    assert_eq!(part_signs(&mut after), 1);
    same(&before, &after);
    assert_eq!(fold_choices(&mut after), 4);
    same(&before, &after);
    // Numbers of 3 bits: their sum's third bit is no sign.
    let mut other = signed(2);
    assert_eq!(part_signs(&mut other), 0);
    assert_eq!(other, signed(2));
}
