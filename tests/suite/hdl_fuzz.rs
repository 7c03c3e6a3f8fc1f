//! The language means one thing: random designs in the built-in simulator, in Icarus and in Verilator, bit for bit.
//!
//! ```text
//! design ─┬─► Flat ─► Simulator<Integers> ─────────────────────────┐
//!         └─► Verilog ─► one testbench ─┬─► Icarus ────► lines ────┼─► equal
//!                                       └─► Verilator ─► lines ────┘
//! ```

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::rc::Rc;

use crate::hdl_designs::{WARM, design};
use crate::noise::Noise;
use subdiv_rtl::hdl::{Direction, Flat, Integers, Module, Simulator, Word, verilog};

/// Clocks that are compared, after the reset.
const CLOCKS: usize = 100;

/// A port as the testbench sees it: a name, and for each of its parts the lowest bit and the port of the module.
struct Pin {
    name: String,
    width: u32,
    parts: Vec<(u32, usize)>,
}

fn pins(module: &Module, direction: Direction) -> Vec<Pin> {
    let count = if direction == Direction::Input { module.inputs.len() } else { module.outputs.len() };
    let mut pins: Vec<Pin> = vec![];
    for port in 0..count {
        let (name, word) = match direction {
            Direction::Input => {
                let node = module.node(module.inputs[port]);
                (node.name.clone().unwrap(), node.word)
            }
            Direction::Output => {
                (module.outputs[port].name.clone(), module.node(module.outputs[port].node).word)
            }
        };
        let mut buses = module.buses.iter().filter(|bus| bus.direction == direction);
        match buses.find(|bus| bus.lanes.iter().any(|lane| lane.port == port)) {
            None => pins.push(Pin { name, width: word.width(), parts: vec![(0, port)] }),
            Some(bus) if bus.lanes[0].port == port => {
                let parts = bus.lanes.iter().map(|lane| (lane.low, lane.port)).collect();
                pins.push(Pin { name: bus.name.clone(), width: bus.width, parts });
            }
            Some(_) => {}
        }
    }
    pins
}

/// The low bits as a string of binary digits, the highest first.
fn digits(value: i128, width: u32) -> String {
    (0..width).rev().map(|bit| if value >> bit.min(127) & 1 == 1 { '1' } else { '0' }).collect()
}

/// The values of the outputs in every clock, and the inputs that made them, as binary digits.
fn expected(module: &Rc<Module>, seed: u64) -> (Vec<String>, Vec<String>) {
    let mut simulator = Simulator::new(Flat::new(module).unwrap(), Integers);
    simulator.scramble(seed);
    let (mut noise, mut inputs, mut outputs) = (Noise(seed ^ 0xf00d), vec![], vec![]);
    let (ins, outs) = (pins(module, Direction::Input), pins(module, Direction::Output));
    for clock in 0..WARM + CLOCKS {
        let warming = clock < WARM;
        let values: Vec<i128> = module
            .inputs
            .iter()
            .map(|&id| {
                let node = module.node(id);
                match node.name.as_deref() {
                    Some("warm") => warming.into(),
                    _ => number(&mut noise, node.word),
                }
            })
            .collect();
        for ((_, id), &value) in simulator.flat.inputs.clone().iter().zip(&values) {
            simulator.set(*id, value);
        }
        simulator.settle();
        let mut line = String::new();
        for pin in &ins {
            let mut bits: Vec<char> = vec!['0'; pin.width as usize];
            for &(low, port) in &pin.parts {
                place(&mut bits, low, &digits(values[port], module.node(module.inputs[port]).word.width()));
            }
            line.extend(bits);
        }
        inputs.push(line);
        let mut line = String::new();
        for pin in &outs {
            let mut bits: Vec<char> = vec!['0'; pin.width as usize];
            for (at, &(low, port)) in pin.parts.iter().enumerate() {
                let (_, id) = simulator.flat.outputs[port];
                // A lane of a bus is filled with the sign.
                let high = pin.parts.get(at + 1).map_or(pin.width, |(next, _)| *next);
                place(&mut bits, low, &digits(*simulator.get(id), high - low));
            }
            line.extend(bits);
            line.push(' ');
        }
        outputs.push(line.trim_end().to_string());
        simulator.edge(warming).unwrap();
    }
    (inputs, outputs)
}

/// Puts digits where they end `low` from the right.
fn place(bits: &mut [char], low: u32, digits: &str) {
    let end = bits.len() - low as usize;
    let start = end - digits.len();
    bits[start..end].iter_mut().zip(digits.chars()).for_each(|(bit, digit)| *bit = digit);
}

/// Numbers at the ends of the range come more often than others.
fn number(noise: &mut Noise, word: Word) -> i128 {
    match noise.below(8) {
        0 => word.range.min,
        1 => word.range.max,
        2 => word.range.wrap(noise.below(3) as i128 - 1),
        _ => word.range.wrap(noise.wide()),
    }
}

/// All designs in one testbench: a line of outputs for each clock and design.
fn testbench(modules: &[Rc<Module>]) -> String {
    let mut text = String::from(
        "`timescale 1ns/1ns\nmodule testbench;\n    reg aclk = 0, aresetn = 0;\n    integer t;\n",
    );
    let (mut load, mut drive, mut show) = (String::new(), String::new(), String::new());
    for (k, module) in modules.iter().enumerate() {
        let (ins, outs) = (pins(module, Direction::Input), pins(module, Direction::Output));
        let width: u32 = ins.iter().map(|pin| pin.width).sum();
        let last = WARM + CLOCKS - 1;
        writeln!(
            text,
            "    reg [{}:0] vectors_{k} [0:{last}];\n    reg [{}:0] in_{k};",
            width - 1,
            width - 1
        )
        .unwrap();
        writeln!(load, "        $readmemb(\"vectors_{k}.txt\", vectors_{k});").unwrap();
        writeln!(drive, "            in_{k} = vectors_{k}[t];").unwrap();
        let mut connected = vec![];
        if module.needs_clock() {
            connected.push(".aclk(aclk)".to_string());
        }
        if module.needs_reset() {
            connected.push(".aresetn(aresetn)".to_string());
        }
        let mut low = width;
        for pin in &ins {
            low -= pin.width;
            connected.push(format!(".{}(in_{k}[{}:{low}])", pin.name, low + pin.width - 1));
        }
        let mut names = vec![];
        for (o, pin) in outs.iter().enumerate() {
            writeln!(text, "    wire [{}:0] out_{k}_{o};", pin.width - 1).unwrap();
            connected.push(format!(".{}(out_{k}_{o})", pin.name));
            names.push(format!("out_{k}_{o}"));
        }
        writeln!(text, "    {} dut_{k} ({});", module.name, connected.join(", ")).unwrap();
        let format = vec!["%b"; names.len()].join(" ");
        writeln!(show, "            $display(\"{k} {format}\", {});", names.join(", ")).unwrap();
    }
    write!(
        text,
        "    initial begin\n{load}        for (t = 0; t < {}; t = t + 1) begin\n            aresetn = t >= {WARM};\n\
         {drive}            #1;\n{show}            aclk = 1;\n            #1 aclk = 0;\n            #1;\n        end\n\
         \x20       $finish;\n    end\nendmodule\n",
        WARM + CLOCKS
    )
    .unwrap();
    text
}

/// What a simulator is built and run with, in the folder of the sources.
const SIMULATORS: [(&str, &str, &str); 2] = [
    ("iverilog", "iverilog -g2005 -s testbench -o bench.vvp *.v", "vvp -n bench.vvp"),
    (
        "verilator",
        "verilator --binary --timing -Wno-fatal -Wno-lint -Wno-style -CFLAGS -O0 --top-module testbench -Mdir verilated *.v",
        "verilated/Vtestbench",
    ),
];

fn shell(folder: &Path, command: &str) -> String {
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).output().expect("a shell");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{command} in {}\n{errors}{}",
        folder.display(),
        String::from_utf8_lossy(&output.stdout)
    );
    String::from_utf8(output.stdout).expect("text")
}

/// Whether the numbers are the same; Verilator prints some that are always 0 with more digits than they have.
fn equal(said: &str, wanted: &str) -> bool {
    let numbers = |line: &str| -> Vec<String> {
        line.split(' ').map(|number| number.trim_start_matches('0').to_string()).collect()
    };
    numbers(said) == numbers(wanted)
}

/// The designs of the seeds from `first` on; `SUBDIV_RTL_FUZZ_SEED=N` shifts them all by N.
fn compare(first: u64, count: u64, size: usize) {
    let shift = std::env::var("SUBDIV_RTL_FUZZ_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let seeds = first + shift..first + shift + count;
    let modules: Vec<Rc<Module>> = seeds.clone().map(|seed| design(seed, size)).collect();
    let mut folder = tempfile::tempdir().expect("a temporary folder");
    // For whoever looks for the reason of a difference.
    let keep = std::env::var_os("SUBDIV_RTL_FUZZ_KEEP").is_some();
    folder.disable_cleanup(keep);
    let mut wanted = vec![];
    for (k, module) in modules.iter().enumerate() {
        for file in verilog::print(module, "a test").unwrap() {
            std::fs::write(folder.path().join(file.name), file.text).unwrap();
        }
        let (inputs, outputs) = expected(module, seeds.start + k as u64);
        std::fs::write(folder.path().join(format!("vectors_{k}.txt")), inputs.join("\n") + "\n").unwrap();
        wanted.push(outputs);
    }
    std::fs::write(folder.path().join("testbench.v"), testbench(&modules)).unwrap();
    for (tool, build, run) in SIMULATORS {
        if Command::new(tool).arg("-V").output().is_err() {
            println!("skipped: {tool} is not installed");
            continue;
        }
        shell(folder.path(), build);
        let said = shell(folder.path(), run);
        let mut clocks = vec![0; modules.len()];
        let mut differ = vec![];
        for line in said.lines() {
            let Some((k, bits)) = line.split_once(' ') else { continue };
            let Ok(k) = k.parse::<usize>() else { continue };
            let clock = clocks[k];
            clocks[k] += 1;
            if clock >= WARM && !equal(bits, &wanted[k][clock]) {
                differ.push((seeds.start + k as u64, clock));
                if keep && differ.len() < 4 {
                    println!("{tool} {} clock {clock}\n{bits}\n{}", modules[k].name, wanted[k][clock]);
                }
            }
        }
        assert_eq!(clocks, vec![WARM + CLOCKS; modules.len()], "{tool} did not show every clock");
        if let Some((seed, clock)) = differ.first() {
            panic!(
                "{tool} differs from the built-in simulator first in design({seed}, {size}) at clock {clock}: {differ:?}"
            );
        }
    }
}

#[test]
fn random_designs_do_the_same_in_every_simulator() {
    compare(1, 24, 40);
}

#[test]
fn very_small_designs_do_the_same_in_every_simulator() {
    compare(1000, 60, 5);
}

/// Random operations are no worse to read than those of the cores: no tool finds anything to remark.
#[test]
fn random_designs_are_silent() {
    let tools = [
        ("verilator", "verilator --lint-only -Wall --top-module TOP"),
        ("iverilog", "iverilog -g2005 -Wall -o /dev/null -s TOP"),
    ];
    for seed in 1..25 {
        let module = design(seed, 40);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let files = verilog::print(&module, "a test").unwrap();
        files.iter().for_each(|file| std::fs::write(folder.path().join(&file.name), &file.text).unwrap());
        for (tool, command) in tools {
            if Command::new(tool).arg("-V").output().is_err() {
                println!("skipped: {tool} is not installed");
                continue;
            }
            let command = command.replace("TOP", &module.name);
            let said = shell(folder.path(), &format!("{command} *.v 2>&1"));
            assert_eq!(said, "", "design({seed}, 40)");
        }
    }
}

/// The designs are worth the name: among them is every operation.
#[test]
fn the_designs_hold_every_kind_of_cell() {
    use subdiv_rtl::hdl::Cell;
    let mut found = std::collections::BTreeSet::new();
    for seed in 1..25 {
        for module in design(seed, 40).hierarchy() {
            found.extend(module.nodes.iter().map(|node| match node.cell {
                Cell::Input => "input",
                Cell::Wire { .. } => "wire",
                Cell::Constant(_) => "constant",
                Cell::Sum { .. } => "sum",
                Cell::Product { .. } => "product",
                Cell::ShiftRight { .. } => "shift",
                Cell::Wrap { .. } => "wrap",
                Cell::Claim { .. } => "claim",
                Cell::Select { .. } => "select",
                Cell::Compare { .. } => "compare",
                Cell::Logic { .. } => "logic",
                Cell::Not { .. } => "not",
                Cell::Slice { .. } => "slice",
                Cell::Concat { .. } => "concat",
                Cell::Register { .. } => "register",
                Cell::MemoryRead { .. } => "memory",
                Cell::InstanceOutput { .. } => "instance",
            }));
        }
    }
    // Forward wires close loops that these designs do not have.
    assert_eq!(found.len(), 16, "{found:?}");
}
