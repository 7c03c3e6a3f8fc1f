//! Boards: the whole top with a receiver at its serial line, its Verilog, its checksum, and what the program says.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::rc::Rc;

use crate::board_design::{QUICK, design, design_on, run, triangle};
use subdiv_rtl::board::frame;
use subdiv_rtl::board::simulate::Session;
use subdiv_rtl::board::{Pace, project};
use subdiv_rtl::cores::board::{VertexStream, coordinate_names, evaluator, top};
use subdiv_rtl::cores::loop_fd::Parameters;
use subdiv_rtl::hdl::{Builder, Flat, Integers, Module, Simulator, Word};
use subdiv_rtl::mesh;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::fine_grid::FineGrid;

#[test]
fn what_comes_over_the_line_is_the_reference_and_the_whole_mesh() {
    for (shape, level, coordinates) in [
        ("octahedron", 0, "Q6.10"),
        ("octahedron", 3, "Q6.10"),
        ("tetrahedron", 2, "Q4.4"),
        ("torus", 1, "Q4.6"),
        ("square", 2, "Q3.21"),
        ("blob", 1, "Q4.12"),
    ] {
        let design = design(shape, level, coordinates);
        let received = run(&design, QUICK);
        let what = format!("{shape}, level {level}, {coordinates}");
        assert_eq!(received.broken, 0, "{what}");
        assert!(received.bytes == design.expected(), "{what}");

        let frame = frame::decode(frame::find(&received.bytes).unwrap().unwrap()).unwrap();
        assert_eq!(frame, design.contents.frame, "{what}");
        let control = mesh::shape(shape).unwrap();
        let positions = mesh::quantise(&control, coordinates.parse().unwrap()).unwrap().positions;
        let control = ControlMesh::new(positions, control.triangles().unwrap()).unwrap();
        let grid = FineGrid::new(&control, level).unwrap();
        let fine = frame.mesh();
        assert_eq!(fine.faces.len(), grid.triangle_count(), "{what}");
        assert_eq!(fine.positions.len(), grid.vertex_count(), "{what}");
    }
}

#[test]
fn the_real_pace_sends_the_same() {
    let design = triangle(0);
    assert_eq!(design.pace, Pace { clocks_per_bit: 434, log_quiet: 17 });
    let received = run(&design, design.pace);
    assert!(received.bytes == design.expected());
    // 434 clocks for each of the ten bits of a byte.
    assert!(received.clocks > 4340 * (received.bytes.len() as u64 - 1));
}

#[test]
fn a_byte_follows_the_other_without_a_gap_at_two_clocks_a_bit() {
    let pace = Pace { clocks_per_bit: 2, ..QUICK };
    let received = run(&triangle(1), pace);
    assert!(received.bytes == triangle(1).expected());
}

#[test]
fn the_button_sends_the_mesh_again() {
    let design = triangle(1);
    let expected = design.expected();
    let flat = Flat::new(&design.top(QUICK).unwrap()).unwrap();
    let once = run(&design, QUICK).clocks;
    let twice = [&expected[..], &expected].concat();
    let run = |pressed: &[std::ops::Range<u64>], bytes| {
        let (top, clocks_per_bit) = (&flat, QUICK.clocks_per_bit);
        let disturb = &|_, line| line;
        Session { top, clocks_per_bit, pressed, bytes, to_the_end: true, disturb }.run().unwrap()
    };
    let begin = once + 100;
    let press = begin..begin + QUICK.press();
    assert!(run(&[press], twice.len()).bytes == twice);
    // Held for long it counts once; a touch too short, and a press while the mesh is on its way, do not count.
    for (pressed, bytes) in [
        (begin..begin + 3 * once, twice.len()),
        (begin..begin + 10, expected.len()),
        (0..40, expected.len()),
        (once / 2..once / 2 + 40, expected.len()),
    ] {
        assert_eq!(run(&[pressed], bytes).bytes.len(), bytes);
    }
}

#[test]
fn a_flipped_bit_on_the_line_is_noticed() {
    let design = triangle(1);
    let flat = Flat::new(&design.top(QUICK).unwrap()).unwrap();
    let expected = design.expected();
    let clean = run(&design, QUICK);
    let start = clean.clocks - 11 * 4 * expected.len() as u64;
    let (mut noticed, mut changed) = (0, 0);
    for flip in (0..40).map(|nth| start + 37 * nth) {
        let line = |clock: u64, line: bool| line ^ (flip..flip + 4).contains(&clock);
        let dialogue = Session {
            top: &flat,
            clocks_per_bit: 4,
            pressed: &[],
            bytes: expected.len(),
            to_the_end: true,
            disturb: &line,
        };
        let Ok(received) = dialogue.run() else { continue };
        changed += usize::from(received.bytes != expected);
        let frame = frame::find(&received.bytes);
        let wrong = match frame {
            Ok(Some(frame)) => frame::decode(frame).is_err(),
            Ok(None) => true,
            Err(_) => true,
        };
        noticed += usize::from(wrong);
        assert_eq!(wrong, received.bytes != expected, "clock {flip}");
    }
    assert!(noticed > 10 && noticed == changed, "{noticed} of {changed}");
}

/// Another sink in the place of the serial line: it shows each vertex pair for a clock, and takes it when `hold` is 0.
fn screen(parameters: Parameters) -> Rc<Module> {
    let m = Builder::new("screen");
    let stream = VertexStream::inputs(&m, parameters);
    let hold = m.input("hold", Word::bit());
    let ready = m.wire("ready", !&hold);
    let shown = m.pipe_reset("shown", &stream.valid & &ready, 0);
    m.output("show", m.restart(&shown, 0));
    for (name, coordinate) in coordinate_names().iter().zip(&stream.coordinates) {
        m.output(format!("pixel_{name}"), m.restart(&m.pipe(format!("at_{name}"), coordinate), 0));
    }
    m.output("pair", m.restart(&m.pipe("was_pair", stream.flag("pair")), 0));
    m.output("last", m.restart(&m.pipe("was_last", stream.flag("mesh_end")), 0));
    m.output("ready", &ready);
    m.output("busy", m.bit(false));
    m.finish().unwrap()
}

#[test]
fn another_output_takes_the_place_of_the_serial_line() {
    let design = design("octahedron", 2, "Q6.10");
    let parameters = design.settings.parameters;
    let evaluator = evaluator(parameters, &design.contents.patches).unwrap();
    let board = top::build(&evaluator, &screen(parameters), 4).unwrap();
    let flat = Flat::new(&board).unwrap();
    let input = |name: &str| flat.input(name).unwrap();
    let output = |name: &str| flat.output(name).unwrap();
    let (button, hold, show) = (input("button"), input("hold"), output("show"));
    let pixels: Vec<_> = coordinate_names().iter().map(|name| output(&format!("pixel_{name}"))).collect();
    let (pair, end) = (output("pair"), output("last"));

    let mut simulator = Simulator::new(flat, Integers);
    simulator.scramble(3);
    let (mut seen, mut noise) = (vec![], 1u32);
    for clock in 0..20_000 {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        simulator.set(button, 0);
        simulator.set(hold, i128::from(noise >> 30 == 0));
        simulator.settle();
        if clock > 4 && *simulator.get(show) == 1 {
            let at: Vec<i64> = pixels.iter().map(|&pixel| *simulator.get(pixel) as i64).collect();
            let right = (*simulator.get(pair) == 1).then(|| [at[3], at[4], at[5]]);
            seen.push(([at[0], at[1], at[2]], right, *simulator.get(end) == 1));
        }
        simulator.edge(clock < 4).unwrap();
    }
    let beats = &design.contents.frame.beats;
    let expected: Vec<_> =
        beats.iter().enumerate().map(|(i, beat)| (beat.left, beat.right, i + 1 == beats.len())).collect();
    assert!(seen == expected);
}

fn installed(tool: &str, question: &str) -> bool {
    let there = Command::new(tool).arg(question).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !there {
        println!("skipped: {tool} is not installed");
    }
    there
}

fn shell(folder: &Path, command: &str) -> (bool, String) {
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&said).into_owned())
}

#[test]
fn the_printed_verilog_sends_the_same_in_icarus_and_verilator() {
    let design = design("tetrahedron", 1, "Q4.8");
    let expected = design.expected();
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().join("board");
    project(&design, None).unwrap().write(&home, false).unwrap();
    for (tool, question, target) in [("iverilog", "-V", "sim"), ("verilator", "--version", "sim-verilator")] {
        if !installed(tool, question) || !installed("make", "--version") {
            continue;
        }
        let received = || -> Vec<u8> {
            let text = std::fs::read_to_string(home.join("build/received.hex")).unwrap();
            text.lines().map(|line| u8::from_str_radix(line, 16).unwrap()).collect()
        };
        let (passed, said) = shell(&home, &format!("make {target}"));
        assert!(passed && said.contains("PASS: two frames"), "{said}");
        assert!(!said.to_lowercase().contains("warning"), "{said}");
        assert!(received() == [&expected[..], &expected].concat(), "{tool}");
        let (passed, said) = shell(&home, &format!("make {target} FLIP=1f3"));
        assert!(!passed && said.contains("FAIL: 1 wrong bytes"), "{said}");
        let flipped = received();
        assert_eq!(flipped[62] ^ expected[62], 8);
        assert_eq!(frame::decode(&flipped[..expected.len()]).unwrap_err().exit_status(), 1);
    }
}

#[test]
fn the_emitted_files_are_silent_in_every_tool() {
    let modules = "$(ls rtl/*.v | grep -v board_top)";
    let cells = |name: &str| if name == "ulx3s" { "+/ecp5/cells_bb.v" } else { "+/gowin/cells_sim.v" };
    for (name, shape, level, coordinates) in [
        ("ulx3s", "octahedron", 2, "Q6.10"),
        ("ulx3s", "square", 0, "Q2.2"),
        ("tang-nano-20k", "tetrahedron", 1, "Q4.4"),
    ] {
        let design = design_on(name, shape, level, coordinates);
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("board");
        project(&design, None).unwrap().write(&home, false).unwrap();
        let yosys = format!(
            "yosys -q -p 'read_verilog -lib {}; read_verilog rtl/*.v; hierarchy -check -top board_top; proc; check -assert'",
            cells(name)
        );
        for (tool, question, command) in [
            (
                "verilator",
                "--version",
                format!("verilator --lint-only -Wall --top-module mesh_board {modules}"),
            ),
            ("iverilog", "-V", format!("iverilog -g2005 -Wall -s mesh_board -o /dev/null {modules}")),
            ("yosys", "-V", yosys),
        ] {
            if installed(tool, question) {
                let (passed, said) = shell(&home, &command);
                assert!(passed && said.trim().is_empty(), "{command}\n{said}");
            }
        }
    }
}

fn program(words: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.args(words).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

/// The exit status and all that was said.
fn outcome(words: &str, folder: &Path) -> (Option<i32>, String) {
    let output = program(&words.split(' ').collect::<Vec<_>>(), folder);
    (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
}

#[test]
fn a_project_is_the_same_each_time_and_says_how_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a", "b"] {
        let (status, said) =
            outcome(&format!("generate board ulx3s --shape tetrahedron -l 1 -o {name}"), folder.path());
        assert_eq!(status, Some(0), "{said}");
    }
    let (same, said) = shell(folder.path(), "diff -r a b");
    assert!(same, "{said}");
    let manifest = std::fs::read_to_string(folder.path().join("a/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(manifest["check"]["core"], "proved by linear forms");
    assert_eq!(manifest["clocks_per_bit"], 434);
    let command = manifest["command"].as_str().unwrap().strip_prefix("subdiv-rtl ").unwrap();
    let (status, said) = outcome(&format!("{command} -o c"), folder.path());
    assert_eq!(status, Some(0), "{said}");
    assert!(shell(folder.path(), "diff -r a c").0);
}

#[test]
fn what_does_not_fit_is_told_with_figures() {
    let folder = tempfile::tempdir().unwrap();
    for (words, status, part) in [
        ("generate board ulx3s --shape blob -l 5 --device 12f", 3, "block RAMs"),
        ("generate board ulx3s --shape octahedron -l 2 --coordinates Q1.7", 3, "does not fit Q1.7"),
        ("generate board ulx3s --shape blob -l 7 --coordinates Q4.12", 3, "1089920 pairs"),
        ("generate board icebreaker --shape blob", 2, "the boards are ulx3s, tang-nano-20k"),
        ("generate board ulx3s --shape blob --device 100f", 2, "85f, 45f, 25f, 12f"),
        ("generate board ulx3s --shape blob --clock 25 --baud 3000000", 2, "% off"),
        ("generate board ulx3s --shape blob --clock 48", 2, "46.875 MHz"),
        ("generate board ulx3s", 2, "--shape"),
        ("generate board ulx3s --shape torus-quads", 3, "triangle"),
    ] {
        let (code, said) = outcome(words, folder.path());
        assert_eq!(code, Some(status), "{words}: {said}");
        assert!(said.contains(part), "{words}: {said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn receive_reads_a_mesh_and_refuses_a_broken_one() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = design("octahedron", 2, "Q6.10").expected();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("noisy", &[b"boot: SDV", &bytes[..], &bytes[..100]].concat());
    write("short", &bytes[..bytes.len() - 1]);
    let mut flipped = bytes.clone();
    flipped[200] ^= 16;
    write("flipped", &flipped);
    let (status, said) = outcome("receive noisy -o mesh.obj", folder.path());
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("66 vertices, 128 triangles"), "{said}");
    let mesh = mesh::read(&folder.path().join("mesh.obj")).unwrap();
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (66, 128));
    let (status, said) = outcome("receive noisy --format json", folder.path());
    assert!(status == Some(0) && said.starts_with("{\n  \"schema\": \"subdiv-rtl/receive/1\""), "{said}");
    for (words, status, part) in [
        ("receive short", 3, "no whole frame"),
        ("receive flipped -o flipped.obj", 1, "checksum"),
        ("receive nothing", 3, "cannot read"),
        ("receive -", 3, "no whole frame in 0 bytes"),
    ] {
        let (code, said) = outcome(words, folder.path());
        assert_eq!(code, Some(status), "{words}: {said}");
        assert!(said.contains(part), "{words}: {said}");
    }
    assert!(!folder.path().join("flipped.obj").exists());
}
