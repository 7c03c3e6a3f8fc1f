//! Skewed carry proved equal to the plain form by Yosys, for all inputs and without end: a module and its chunks side by
//! side, brought to one clock, and a bit that says whether they agree.
//!
//! ```text
//!   base        behind a load, from whatever state, they agree for some clocks
//!   induction   where they have agreed for so many clocks, they agree in the next one too
//! ```

use std::fs;
use std::process::Command;
use std::rc::Rc;

use subdiv_rtl::hdl::skew::{LEAD, SkewedPorts, skew};
use subdiv_rtl::hdl::{Builder, Module, Relation, Word, verilog};

/// Bits of the numbers: what holds for all of these does not depend on how many they are.
const WIDTH: u32 = 6;

/// Two differences and a sum behind them, `extra` being a mistake.
fn differences(extra: i128) -> Rc<Module> {
    let word = Word::modular(WIDTH);
    let m = Builder::new("differences");
    let [load, step] = ["load", "step"].map(|name| m.input(name, Word::bit()));
    let [a, b] = ["a", "b"].map(|name| m.input(name, word));
    let [low, high] = ["low", "high"].map(|name| m.register_at(name, word, None, 0));
    m.on(&load, &low, &a);
    m.on(&step, &low, &low + &high + extra);
    m.on(&load, &high, &b);
    m.output("low", &low);
    m.output("high", &high);
    m.output("sum", m.pipe("sum", 3 * &low - &high));
    m.finish().unwrap()
}

/// The plain form and the chunks, and whether their outputs agree.
fn side_by_side(plain: &Rc<Module>, chunked: &Rc<Module>) -> Rc<Module> {
    let m = Builder::new("side_by_side");
    let [load, step] = ["load", "step"].map(|name| m.input(name, Word::bit()));
    let [a, b] = ["a", "b"].map(|name| m.input_at(name, Word::modular(WIDTH), LEAD));
    let chunked = m.instance("chunked", chunked, &[("load", &load), ("step", &step), ("a", &a), ("b", &b)]);
    let [late_load, late_step] = [&load, &step].map(|bit| m.at_time(bit, LEAD));
    let inputs = [("load", &late_load), ("step", &late_step), ("a", &a), ("b", &b)];
    let plain = m.instance("plain", plain, &inputs);
    let pairs: Vec<_> = ["low", "high", "sum"]
        .map(|name| (m.restart(&plain.out(name), plain.out(name).time().unwrap_or(0)), chunked.out(name)))
        .into_iter()
        .map(|(plain, chunked)| {
            let last = plain.time().max(chunked.time()).unwrap_or(0);
            let [plain, chunked] = [plain, chunked].map(|signal| m.at_time(&signal, last));
            // Bit for bit.
            let [plain, chunked] = [&plain, &chunked].map(|signal| m.slice(signal, 0, WIDTH));
            m.wire("agrees", m.compare(Relation::Equal, &plain, &chunked))
        })
        .collect();
    let last = pairs.iter().filter_map(|bit| bit.time()).max().unwrap_or(0);
    let pairs: Vec<_> = pairs.iter().map(|bit| m.at_time(bit, last)).collect();
    m.output("agree", m.all(&pairs.iter().collect::<Vec<_>>()));
    m.finish().unwrap()
}

/// Whether Yosys proves a claim; none where it is not installed.
fn proves(module: &Rc<Module>, claim: &str) -> Option<bool> {
    let folder = tempfile::tempdir().unwrap();
    let mut names = vec![];
    for file in verilog::print(module, "equivalence").unwrap() {
        fs::write(folder.path().join(&file.name), &file.text).unwrap();
        names.push(file.name);
    }
    let script = format!(
        "read_verilog {}; setattr -mod -unset keep_hierarchy *; prep -flatten -top side_by_side; \
         sat -verify -prove agree 1 {claim}",
        names.join(" ")
    );
    let run = Command::new("yosys").args(["-q", "-p", &script]).current_dir(folder.path()).output();
    let Ok(output) = run else {
        println!("skipped: yosys is not installed");
        return None;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() || said.contains("proof did fail"), "{said}");
    Some(output.status.success())
}

/// Clocks behind a load after which all that was before has left.
const LEFT: u32 = 8;

/// Clocks of agreement that the induction needs.
const AGREED: u32 = 6;

/// Both parts of the proof.
fn equivalent(extra: i128, chunk: u32) -> Option<[bool; 2]> {
    let chunked = skew(&differences(extra), chunk, SkewedPorts::default()).unwrap();
    let both = side_by_side(&differences(0), &chunked);
    let steps = LEFT + AGREED;
    let base = proves(&both, &format!("-set-at 1 load 1 -seq {steps} -prove-skip {LEFT}"))?;
    let step = proves(&both, &format!("-tempinduct -tempinduct-inductonly -maxsteps {AGREED}"))?;
    Some([base, step])
}

#[test]
fn chunks_of_every_size_are_the_plain_form() {
    for chunk in [2, 3, 4] {
        let Some(proved) = equivalent(0, chunk) else { return };
        assert_eq!(proved, [true; 2], "chunks of {chunk}");
    }
}

#[test]
fn another_sum_is_refuted() {
    let Some(proved) = equivalent(1, 3) else { return };
    assert_ne!(proved, [true; 2]);
}
