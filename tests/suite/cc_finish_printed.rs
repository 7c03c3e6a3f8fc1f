//! The finishing stage of cc-strip as Verilog: silent in every tool, the same numbers in Icarus as in the built-in
//! simulator, and how large it is.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::cc_meshes::Random;
use crate::cc_stage::{Case, Stage, case, module, random_window};
use subdiv_rtl::cores::cc_strip::finish::Kind;
use subdiv_rtl::hdl::{Counts, NodeId, verilog};
use subdiv_rtl::model::cc_strip::around::Three;

/// The tools, each with the command that must say nothing.
const COMMANDS: [(&str, &str); 3] = [
    ("verilator", "verilator --lint-only -Wall --top-module finishing_stage *.v"),
    ("iverilog", "iverilog -g2005 -Wall -s finishing_stage -o /dev/null *.v"),
    ("yosys", "yosys -q -p 'read_verilog *.v; hierarchy -check -top finishing_stage; proc; check -assert'"),
];

#[test]
fn the_printed_stage_is_silent_in_every_tool() {
    let cases = [
        case(),
        Case {
            levels: [2, 2],
            max_valence: 4,
            limit: false,
            normals: Some((Kind::Faces, 4, None)),
            ..case()
        },
        Case { levels: [1, 2], extra_fraction: -2, normals: Some((Kind::Limit, 3, Some(14))), ..case() },
        Case { levels: [1, 1], limit: false, normals: Some((Kind::Limit, 0, None)), ..case() },
        Case { width: 4, levels: [1, 1], normals: Some((Kind::Faces, 0, Some(9))), ..case() },
    ];
    for case in cases {
        let folder = tempfile::tempdir().unwrap();
        print_to(folder.path(), &case);
        for (tool, command) in COMMANDS {
            if Command::new(tool).arg("-V").output().is_err() {
                println!("skipped: {tool} is not installed");
                continue;
            }
            let output =
                Command::new("sh").args(["-c", command]).current_dir(folder.path()).output().unwrap();
            let said = [output.stdout, output.stderr].concat();
            let said = String::from_utf8_lossy(&said);
            assert!(output.status.success() && said.trim().is_empty(), "{case:?}: {command}\n{said}");
        }
    }
}

fn print_to(folder: &Path, case: &Case) {
    for file in verilog::print(&module(case.parameters()).0, "test").unwrap() {
        std::fs::write(folder.join(file.name), file.text).unwrap();
    }
}

/// A testbench that sets the inputs of every clock and compares the outputs behind it, from `from` on.
fn testbench(stage: &mut Stage, case: &Case, clocks: usize) -> String {
    let (mut ports, mut body) = (String::from(".aclk(clock)"), String::new());
    let inputs: Vec<(String, NodeId)> = stage.simulator.flat.inputs.clone();
    let outputs: Vec<(String, NodeId)> = stage.simulator.flat.outputs.clone();
    let mut declarations = String::new();
    let width = |stage: &Stage, id: NodeId| stage.simulator.flat.node(id).word.width();
    let literal = |stage: &Stage, id: NodeId| {
        let width = width(stage, id);
        format!("{width}'h{:x}", *stage.simulator.get(id) as u128 & (u128::MAX >> (128 - width)))
    };
    for (kind, list) in [("reg", &inputs), ("wire", &outputs)] {
        for (name, id) in list {
            writeln!(declarations, "  {kind} [{}:0] {name};", width(stage, *id) - 1).unwrap();
            write!(ports, ", .{name}({name})").unwrap();
        }
    }
    let (mut random, mut moved) = (Random(11), 0);
    for _ in 0..clocks {
        let [p, c, n] = &random_window(case, case.levels[1], &mut random);
        stage.offer(&Three { previous: Some(p), column: c, next: Some(n) }, case.levels[1]);
        let moves = random.below(4) > 0;
        stage.advance(moves);
        moved += u32::from(moves);
        for (name, id) in &inputs {
            writeln!(body, "    {name} = {};", literal(stage, *id)).unwrap();
        }
        writeln!(body, "    #1 clock = 1; #1 clock = 0;").unwrap();
        if moved < stage.latency {
            continue;
        }
        for (name, id) in &outputs {
            let expected = literal(stage, *id);
            writeln!(body, "    if ({name} !== {expected}) $display(\"{name} %h {expected}\", {name});")
                .unwrap();
        }
    }
    format!(
        "module testbench;\n  reg clock = 0;\n{declarations}  finishing_stage dut({ports});\n  initial begin\n{body}    \
         $display(\"done\");\n  end\nendmodule\n"
    )
}

#[test]
fn the_printed_stage_computes_the_same_in_icarus() {
    if Command::new("iverilog").arg("-V").output().is_err() {
        println!("skipped: iverilog is not installed");
        return;
    }
    let cases = [
        Case { levels: [1, 2], normals: Some((Kind::Faces, 4, Some(14))), ..case() },
        Case { levels: [1, 2], normals: Some((Kind::Limit, 4, Some(12))), max_valence: 5, ..case() },
        Case { levels: [2, 2], limit: false, normals: Some((Kind::Limit, 4, None)), ..case() },
    ];
    for case in cases {
        let folder = tempfile::tempdir().unwrap();
        print_to(folder.path(), &case);
        let text = testbench(&mut Stage::new(case), &case, 60);
        std::fs::write(folder.path().join("testbench.v"), text).unwrap();
        let run = "iverilog -g2005 -s testbench -o test *.v && vvp -n test";
        let output = Command::new("sh").args(["-c", run]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert_eq!(said.trim(), "done", "{case:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// No limit position of a regular vertex costs a multiplier; the figures of the rest are printed.
#[test]
fn only_the_ends_of_limits_multiply() {
    let counts = |case: Case| Counts::of(&module(case.parameters()).0);
    let bare = Case { width: 16, max_valence: 10, levels: [5, 5], limit: true, normals: None, ..case() };
    let limit = counts(bare);
    // The two ends of each of the three coordinates.
    assert_eq!(limit.multipliers, 6);
    println!("level 5, valence 10, 16-bit coordinates: multipliers, adders, registers");
    for (what, normals) in [
        ("limit positions", None),
        ("and face normals", Some((Kind::Faces, 8, None))),
        ("and limit normals", Some((Kind::Limit, 8, None))),
        ("and unit limit normals", Some((Kind::Limit, 8, Some(14)))),
    ] {
        let counts = counts(Case { normals, ..bare });
        println!("{what}: {} {} {}", counts.multipliers, counts.adders, counts.registers);
    }
}
