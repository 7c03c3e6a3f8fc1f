//! `simulate --netlist`: what is placed on a device computes what the core does, and a wrong cell in it is seen.

use std::process::{Command, Output, Stdio};

use serde_json::Value;
use subdiv_rtl::cores::loop_fd::{Columns, Parameters, RegisterForm, build};
use subdiv_rtl::cosim::loop_trial::{LoopTrial, Packet};
use subdiv_rtl::cosim::{Dut, External, Outcome, Settings, Simulator, Stimulus, Tool, loop_bench};
use subdiv_rtl::fpga::{Device, GateLevel, Netlist};
use subdiv_rtl::hdl::verilog;

fn simulate(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.stdin(Stdio::null()).env_remove("CLICOLOR_FORCE").arg("simulate").args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Whether Yosys is here, with its models of cells.
fn installed() -> bool {
    let source = verilog::SourceFile {
        name: "m.v".into(),
        text: "module m(output y); assign y = 1; endmodule".into(),
    };
    let device = Device::named("ecp5-85k").unwrap();
    let there = GateLevel::of("m", &[source], device, &Settings::default()).and_then(|m| m.verilog()).is_ok();
    if !there {
        eprintln!("skipped: no Yosys here; 'make fpga-tools' installs it");
    }
    there
}

/// The verdict on a netlist: the family, its cells, and the mismatches of each simulator.
fn verdict(words: &[&str]) -> (Value, Vec<u64>) {
    let output = simulate(&[words, &["--format", "json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", text(&output.stderr));
    let object: Value = serde_json::from_slice(&output.stdout).unwrap();
    let simulators = object["simulators"].as_array().unwrap().iter();
    let mismatches = simulators.map(|simulator| {
        assert!(simulator["passed"] == true && simulator["beats"].as_u64().unwrap() > 0, "{simulator}");
        simulator["mismatches"].as_u64().unwrap()
    });
    (object["netlist"].clone(), mismatches.collect())
}

const TRIANGLES: [&str; 8] =
    ["--shape", "octahedron", "--level", "1", "--max-level", "1", "--coordinates", "Q3.3"];
const QUADS: [&str; 14] = [
    "--shape",
    "cube-quads",
    "--scheme",
    "catmull-clark",
    "--level",
    "1",
    "--coordinates",
    "Q3.3",
    "--guard",
    "2",
    "--schedule",
    "shared",
    "--rows-per-clock",
    "2",
];

#[test]
fn without_yosys_the_status_is_4_with_the_line_that_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    for tool in ["verilator", "make", "g++", "sh"] {
        let file = folder.path().join(tool);
        std::fs::write(&file, "#!/bin/sh\necho 'tool 99.9'\n").unwrap();
        let run = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&file, run).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.env("PATH", folder.path()).env("SUBDIV_RTL_CACHE", folder.path());
    command.arg("simulate").args(TRIANGLES).args(["--netlist", "ecp5"]);
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("make fpga-tools"), "{}", text(&output.stderr));
}

#[test]
fn the_built_in_simulator_has_no_netlist() {
    let output = simulate(&[&TRIANGLES[..], &["--netlist", "ecp5", "--simulator", "builtin"]].concat());
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn netlists_of_both_cores_are_equal_bit_for_bit() {
    if !installed() {
        return;
    }
    let stalled = ["--back-pressure", "random", "--input-gaps", "bursts"];
    let (netlist, mismatches) =
        verdict(&[&TRIANGLES[..], &stalled, &["--netlist", "ecp5", "--simulator", "all"]].concat());
    assert_eq!(mismatches, [0, 0]);
    assert_eq!(netlist["family"], "ecp5");
    let cells = |kind: &str| netlist["cells"][kind].as_u64().unwrap();
    assert!(cells("CCU2C") > 100 && cells("LUT4") > 100 && cells("TRELLIS_FF") > 1000, "{netlist}");
    assert!(netlist["tidied"]["unread_carries"].as_u64().unwrap() > 0, "{netlist}");

    let icarus = ["--simulator", "icarus"];
    for family in ["ecp5", "gowin"] {
        let (_, mismatches) = verdict(&[&QUADS[..], &icarus, &["--netlist", family]].concat());
        assert_eq!(mismatches, [0], "strips on {family}");
    }
    for more in [&["--netlist", "ecp5", "--chunk", "12"][..], &["--netlist", "ice40"]] {
        let (_, mismatches) = verdict(&[&TRIANGLES[..], &icarus, more].concat());
        assert_eq!(mismatches, [0], "triangles with {more:?}");
    }
}

/// Coordinates that take turns stand in RAMs of three words, which lie where an address bit without a wire reads one.
#[test]
fn rams_that_lie_where_a_pin_without_a_wire_reads_one() {
    if !installed() {
        return;
    }
    let turns = ["--max-level", "2", "--level", "2", "--max-valence", "4", "--axes-in-turn", "1"];
    let walked =
        ["--rounding", "floor", "--registered", "--back-pressure", "random", "--simulator", "icarus"];
    let taken = ["--schedule", "shared", "--level", "1"];
    let quads: Vec<&str> = QUADS.into_iter().filter(|word| !taken.contains(word)).collect();
    let (netlist, mismatches) = verdict(&[&quads[..], &turns, &walked, &["--netlist", "ecp5"]].concat());
    assert_eq!(mismatches, [0]);
    assert!(netlist["tidied"]["raised_pins"].as_u64().unwrap() > 100, "{netlist}");
}

/// A cell's bits at a port: constants as text, nets as numbers.
fn bit(cell: &Value, port: &str) -> Value {
    cell["connections"][port][0].clone()
}

/// Cells of a type that read two nets at least, in the order of the netlist.
fn candidates(netlist: &Netlist, kind: &str, inputs: [&str; 4]) -> Vec<(String, String)> {
    let mut found = vec![];
    for (module, content) in netlist.0["modules"].as_object().unwrap() {
        for (name, cell) in content["cells"].as_object().into_iter().flatten() {
            let nets = inputs.iter().filter(|port| bit(cell, port).is_u64()).count() >= 2;
            // The engines: what they compute is put out.
            let engine = module.contains("engine") || name.contains("engine_x.");
            if cell["type"] == kind && nets && engine {
                found.push((module.clone(), name.clone()));
            }
        }
    }
    found
}

/// Flips the bit of a table that is read while all nets at the inputs are 0.
fn flip(netlist: &mut Netlist, (module, name): &(String, String), table: &str, inputs: [&str; 4]) {
    let cell = &mut netlist.0["modules"][module]["cells"][name];
    let ones = inputs.iter().enumerate().filter(|(_, port)| bit(cell, port) == "1");
    let index: usize = ones.map(|(place, _)| 1 << place).sum();
    let mut bits: Vec<u8> = cell["parameters"][table].as_str().unwrap().bytes().collect();
    let at = bits.len() - 1 - index;
    bits[at] ^= b'0' ^ b'1';
    cell["parameters"][table] = String::from_utf8(bits).unwrap().into();
}

/// A core of triangles as a netlist, and a run of it against the reference.
struct Placed {
    gates: GateLevel,
    dut: Dut,
    stimulus: Stimulus,
}

impl Placed {
    fn new(parameters: Parameters, packets: &[Packet]) -> Placed {
        let core = build(parameters).unwrap();
        let sources = verilog::print(&core, "test").unwrap();
        let device = Device::named("ecp5-85k").unwrap();
        let gates = GateLevel::of(&core.name, &sources, device, &Settings::default()).unwrap();
        let trial = LoopTrial::new(&core, parameters, packets).unwrap();
        let mut stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
        Placed { gates, dut: loop_bench::device(&core, &sources), stimulus }
    }

    fn run(&self, gates: &GateLevel) -> Outcome {
        let files = gates.verilog().unwrap().into_iter().map(|file| (file.name, file.text)).collect();
        let dut = Dut { files, ..self.dut.clone() };
        External::new(Tool::Icarus, Settings::default()).run(&dut, &self.stimulus).unwrap()
    }
}

/// Numbers of the format, in another order in each patch.
fn packets(level: u32, count: i128) -> Vec<Packet> {
    let number = |patch: i128, place: i128| (patch * 29 + place * 37).rem_euclid(64) - 32;
    let packets = (0..count).map(|patch| {
        let point = |place| [0, 1, 2].map(|axis| number(patch + 5 * axis, place * (2 * patch + 1)));
        Packet { level, points: (0..12).map(point).collect() }
    });
    packets.collect()
}

fn small(level: u32) -> Parameters {
    Parameters::new("Q3.3".parse().unwrap(), 3, level, RegisterForm::Minimal20).unwrap()
}

#[test]
fn a_flipped_bit_in_a_table_is_seen() {
    if !installed() {
        return;
    }
    let placed = Placed::new(small(1), &packets(1, 12));
    let gates = &placed.gates;
    assert_eq!(placed.run(gates).failures, []);
    for (kind, table, inputs) in
        [("CCU2C", "INIT0", ["A0", "B0", "C0", "D0"]), ("LUT4", "INIT", ["A", "B", "C", "D"])]
    {
        let candidates = candidates(&gates.netlist, kind, inputs);
        // A table may have bits that nothing ever reads, a register differences that so short a strip does not reach.
        let spread = candidates.iter().rev().step_by(candidates.len() / 6 + 1);
        let seen = spread.into_iter().any(|cell| {
            let mut wrong = gates.clone();
            flip(&mut wrong.netlist, cell, table, inputs);
            assert_ne!(wrong.netlist.0, gates.netlist.0);
            !placed.run(&wrong).failures.is_empty()
        });
        assert!(seen, "{kind}: {candidates:?}");
    }
}

#[test]
fn block_rams_with_their_registers_keep_what_they_should() {
    if !installed() {
        return;
    }
    // The column before, in block RAM; and the buffers of a strip core that walks around the ends.
    let parameters = small(5).with_min_level(5).and_then(|p| p.with_columns(Columns::Buffered)).unwrap();
    let placed = Placed::new(parameters, &packets(5, 2));
    assert_eq!(placed.run(&placed.gates).failures, []);
    assert_eq!(placed.gates.cells()["DP16KD"], 10);
    assert!(placed.gates.tidied.registered_outputs > 0);
    for (unit, count) in [("buffer.", 3), ("output_fifo.", 7)] {
        let mut wrong = placed.gates.clone();
        let cells = wrong.netlist.0["modules"]["loop_fd"]["cells"].as_object_mut().unwrap();
        let rams = cells.iter_mut().filter(|(name, cell)| cell["type"] == "DP16KD" && name.starts_with(unit));
        let changed = rams.map(|(_, ram)| {
            for side in ["REGMODE_A", "REGMODE_B"] {
                ram["parameters"][side] = "NOREG".into();
            }
        });
        assert_eq!(changed.count(), count, "block RAMs in {unit}");
        assert!(!placed.run(&wrong).failures.is_empty(), "a word of {unit} that comes a clock early");
    }

    let walked = ["--max-level", "1", "--rounding", "floor", "--registered", "--back-pressure", "random"];
    let quads: Vec<&str> =
        QUADS.into_iter().filter(|word| !["--schedule", "shared"].contains(word)).collect();
    let (netlist, mismatches) =
        verdict(&[&quads[..], &walked, &["--netlist", "ecp5", "--simulator", "icarus"]].concat());
    assert_eq!(mismatches, [0]);
    assert_eq!(netlist["cells"]["DP16KD"], 10);
}
