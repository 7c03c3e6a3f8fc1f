//! Around the simulation: builds, cache, waveforms, coverage, kept folders, and tools that are missing,
//! old, failing or hanging.

use crate::cosim_stub::{AddOne, Fault, dut, external, settings, simulators, vectors};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};
use subdiv_rtl::Kind;
use subdiv_rtl::cosim::{
    Beat, Builtin, Dut, External, Failure, Latency, Port, Settings, Simulator, Stimulus, Tool, testbench,
    testbench_name, tools,
};

const TOOLS: [Tool; 3] = [Tool::Verilator, Tool::VerilatorTestbench, Tool::Icarus];

fn stimulus(fault: Fault) -> Stimulus {
    let (input, expected) = vectors(12, fault);
    Stimulus { patience: 500, ..Stimulus::new(input, expected) }
}

/// A folder with programs that are shell scripts, to stand in for the tools.
fn fake_tools(scripts: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, script) in scripts {
        let file = folder.path().join(name);
        fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(file, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

fn settings_with(path: &Path, cache: &Path) -> Settings {
    let (path, cache) = (Some(path.into()), Some(cache.to_path_buf()));
    Settings { path, cache, timeout: Duration::from_secs(20), ..Settings::default() }
}

/// The text of a line of `add_one.v` replaced by another, which must be there.
fn changed(from: &str, to: &str) -> Dut {
    let mut dut = dut();
    let text = &mut dut.files[0].1;
    assert!(text.contains(from), "add_one.v has no '{from}'");
    *text = text.replace(from, to);
    dut
}

/// Removes the folder that a failing tool leaves for its log.
fn remove_kept(error: &subdiv_rtl::Error) {
    let log = error.place.as_ref().expect("the error names the log");
    fs::remove_dir_all(Path::new(log).parent().unwrap()).unwrap();
}

#[test]
fn the_testbench_is_silent_under_lint() {
    let folder = tempfile::tempdir().unwrap();
    let bench = testbench_name(&dut());
    fs::write(folder.path().join("add_one.v"), &dut().files[0].1).unwrap();
    let file = format!("{bench}.v");
    fs::write(folder.path().join(&file), testbench(&dut()).unwrap()).unwrap();
    let verilator = ["verilator", "--lint-only", "--timing", "-Wall", "--top-module", &bench];
    let icarus = ["iverilog", "-g2005", "-Wall", "-o", "/dev/null", "-s", &bench];
    for line in [&verilator[..], &icarus[..]] {
        let mut command = Command::new(line[0]);
        command.args(&line[1..]).args(["add_one.v", &file]).current_dir(&folder);
        match command.output() {
            Err(_) => println!("skipped: {} is not installed", line[0]),
            Ok(output) => {
                let said = [output.stdout, output.stderr].concat();
                assert_eq!(String::from_utf8_lossy(&said), "", "{}", line[0]);
            }
        }
    }
}

#[test]
fn the_testbench_is_printed_the_same_every_time() {
    assert_eq!(testbench(&dut()).unwrap(), testbench(&dut()).unwrap());
}

#[test]
fn a_missing_tool_is_exit_status_4_with_the_line_that_installs_it() {
    let nowhere = Settings { path: Some("".into()), ..Settings::default() };
    for tool in TOOLS {
        let error = External::new(tool, nowhere.clone()).run(&dut(), &stimulus(Fault::None));
        let error = error.unwrap_err();
        assert_eq!((error.kind, error.exit_status()), (Kind::ToolMissing, 4));
        assert!(error.help.unwrap().contains("install"));
    }
}

#[test]
fn a_tool_that_is_too_old_is_said_so() {
    let folder = fake_tools(&[("verilator", "echo Verilator 4.038 2020-07-11")]);
    let settings = settings_with(folder.path(), folder.path());
    let error = External::new(Tool::Verilator, settings.clone()).version().unwrap_err();
    assert_eq!(error.what, "verilator 4.038 is installed, but 5.006 or newer is needed");
    let status = tools(&settings).into_iter().find(|tool| tool.name == "verilator").unwrap();
    assert!(!status.usable() && status.found.is_some());
}

#[test]
fn a_compiler_that_hangs_is_stopped_and_said_so() {
    let verilator = r#"[ "$1" = --version ] && echo Verilator 5.006 && exit; /bin/sleep 60"#;
    let version = "echo version 12.0";
    let folder = fake_tools(&[("verilator", verilator), ("make", version), ("g++", version)]);
    let timeout = Duration::from_millis(300);
    let settings = Settings { timeout, ..settings_with(folder.path(), folder.path()) };
    let begun = Instant::now();
    let error = External::new(Tool::Verilator, settings).run(&dut(), &stimulus(Fault::None));
    let error = error.unwrap_err();
    assert!(begun.elapsed() < Duration::from_secs(20));
    assert_eq!(error.kind, Kind::ToolFailed);
    assert_eq!(error.what, "verilator was stopped: it ran longer than 300ms");
    assert!(error.help.as_ref().unwrap().contains("--timeout"));
    remove_kept(&error);
}

#[test]
fn a_simulation_that_hangs_is_stopped_and_said_so() {
    let timeout = Duration::from_secs(3);
    let Some(icarus) = external(Tool::Icarus, Settings { timeout, ..settings() }) else { return };
    let endless = "reg spin; initial while (1'b1) spin = 1'b0;\nendmodule";
    let dut = changed("endmodule", endless);
    let error = icarus.run(&dut, &stimulus(Fault::None)).unwrap_err();
    assert_eq!(error.what, "vvp was stopped: it ran longer than 3s");
    remove_kept(&error);
}

#[test]
fn a_failing_compiler_shows_its_words_and_keeps_its_log() {
    for tool in [Tool::Verilator, Tool::Icarus] {
        let Some(simulator) = external(tool, settings()) else { continue };
        let mut dut = dut();
        dut.files[0].1 = dut.files[0].1.replace("assign", "assing");
        let error = simulator.run(&dut, &stimulus(Fault::None)).unwrap_err();
        assert_eq!((error.kind, error.exit_status()), (Kind::ToolFailed, 5));
        assert!(error.what.contains("failed (exit status") && error.what.contains("add_one.v:"));
        let log = error.place.as_ref().unwrap();
        assert!(fs::read_to_string(log).unwrap().contains("add_one.v:"));
        remove_kept(&error);
    }
}

#[test]
fn a_simulation_without_a_verdict_is_no_pass() {
    let Some(icarus) = external(Tool::Icarus, settings()) else { return };
    let mut dut = dut();
    dut.files[0].1 = dut.files[0].1.replace("endmodule", "initial #50 $finish;\nendmodule");
    let error = icarus.run(&dut, &stimulus(Fault::None)).unwrap_err();
    assert_eq!(error.kind, Kind::ToolFailed);
    assert!(error.what.contains("ended without a verdict"), "{error}");
    remove_kept(&error);
}

#[test]
fn the_second_build_comes_from_the_cache_and_is_faster() {
    let folder = tempfile::tempdir().unwrap();
    let fresh = Settings { cache: Some(folder.path().into()), ..settings() };
    for tool in [Tool::Verilator, Tool::Icarus] {
        let Some(simulator) = external(tool, fresh.clone()) else { continue };
        let run = |dut: &Dut| simulator.run(dut, &stimulus(Fault::None)).unwrap();
        let (first, second) = (run(&dut()), run(&dut()));
        assert_eq!((first.cached, second.cached), (false, true));
        assert!(second.build_seconds < first.build_seconds);
        if tool == Tool::Icarus {
            let mut changed = dut();
            changed.files[0].1.push_str("// changed\n");
            assert!(!run(&changed).cached, "a changed source must be compiled again");
        }
    }
}

#[test]
fn a_failure_writes_the_waveform_around_it() {
    let folder = tempfile::tempdir().unwrap();
    for tool in TOOLS {
        let Some(simulator) = external(tool, settings()) else { continue };
        let vcd = folder.path().join(simulator.name());
        let (input, mut expected) = vectors(400, Fault::None);
        expected[200].data[0] ^= 1;
        let stimulus = Stimulus { vcd: Some(vcd.clone()), ..Stimulus::new(input, expected) };
        let outcome = simulator.run(&dut(), &stimulus).unwrap();
        assert_eq!(outcome.failures[0].clock(), 202);
        assert_eq!(outcome.vcd.as_ref(), Some(&vcd));
        let wave = fs::read_to_string(vcd).unwrap();
        assert!(wave.contains("m_axis_tdata"), "{}", simulator.name());
        let times: Vec<u64> = wave.lines().filter_map(|l| l.strip_prefix('#')?.parse().ok()).collect();
        // 10 units a clock, 4 clocks of reset before clock 0; 32 clocks before, 8 after.
        let clocks = |time: u64| time as f64 / 10.0 - 4.0;
        let unit = times[times.len() - 1] / 2100;
        let (start, end) = (clocks(times[0] / unit), clocks(times[times.len() - 1] / unit));
        assert!((170.0..171.0).contains(&start), "{} starts at {start}", simulator.name());
        assert!((210.0..212.0).contains(&end), "{} ends at {end}", simulator.name());
    }
}

#[test]
fn the_builtin_simulator_traces_the_same_window() {
    let folder = tempfile::tempdir().unwrap();
    let vcd = folder.path().join("wave.vcd");
    let stimulus = Stimulus { vcd: Some(vcd.clone()), ..stimulus(Fault::Hangs) };
    let outcome = Builtin::new(|| Ok(AddOne::default())).run(&dut(), &stimulus).unwrap();
    assert_eq!(outcome.failures[0].window(), 0..=16);
    assert_eq!(fs::read_to_string(vcd).unwrap(), "#0\n");
}

#[test]
fn a_right_core_writes_no_waveform() {
    let folder = tempfile::tempdir().unwrap();
    let vcd = folder.path().join("wave.vcd");
    let stimulus = Stimulus { vcd: Some(vcd.clone()), ..stimulus(Fault::None) };
    for simulator in simulators() {
        assert_eq!(simulator.run(&dut(), &stimulus).unwrap().vcd, None);
        assert!(!vcd.exists());
    }
}

#[test]
fn coverage_names_what_no_run_has_reached() {
    let coverage = Settings { coverage: true, ..settings() };
    let Some(verilator) = external(Tool::Verilator, coverage) else { return };
    let of = |fault| verilator.run(&dut(), &stimulus(fault)).unwrap().coverage.unwrap();
    let misses = |coverage: &subdiv_rtl::cosim::Coverage, name: &str| {
        coverage.missed().any(|point| point.name == name && point.file == "add_one.v")
    };
    let mut all = of(Fault::None);
    assert!(misses(&all, "repeated") && misses(&all, "m_axis_tdata[23]"));
    all.merge(&of(Fault::Repeats));
    assert!(!misses(&all, "repeated") && misses(&all, "m_axis_tdata[23]"));
}

#[test]
fn a_kept_folder_holds_all_that_is_needed_to_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let keep = Settings { keep: Some(folder.path().join("kept")), ..settings() };
    let Some(icarus) = external(Tool::Icarus, keep) else { return };
    let outcome = icarus.run(&dut(), &stimulus(Fault::None)).unwrap();
    let kept = outcome.folder.unwrap();
    let received = fs::read(kept.join("received.hex")).unwrap();
    fs::remove_file(kept.join("received.hex")).unwrap();
    let again = Command::new("sh").arg("commands.sh").current_dir(&kept).output().unwrap();
    assert!(String::from_utf8_lossy(&again.stdout).ends_with("PASS\n"), "{again:?}");
    assert_eq!(fs::read(kept.join("received.hex")).unwrap(), received);
}

#[test]
fn unknown_bits_are_found_by_icarus() {
    let Some(icarus) = external(Tool::Icarus, settings()) else { return };
    let unknown = "assign m_axis_tdata = {71'd0, b_index == 8'd2 ? 1'bx : 1'b0} ^ b_data";
    let dut = changed("assign m_axis_tdata = b_data", unknown);
    let outcome = icarus.run(&dut, &stimulus(Fault::None)).unwrap();
    let words = "beat 2: m_axis_tdata has unknown bits (x) at clock 4";
    assert_eq!(outcome.failures[0].to_string(), words);
}

#[test]
fn an_unknown_bit_that_is_not_kept_does_not_matter() {
    let Some(icarus) = external(Tool::Icarus, settings()) else { return };
    let unknown = "assign m_axis_tdata = {b_last ? 1'bx : 1'b0, 71'd0} ^ b_data";
    let dut = changed("assign m_axis_tdata = b_data", unknown);
    let outcome = icarus.run(&dut, &stimulus(Fault::None)).unwrap();
    assert_eq!(outcome.failures, []);
}

#[test]
fn a_register_that_reset_forgets_is_found_by_verilator() {
    let Some(verilator) = external(Tool::Verilator, settings()) else { return };
    let forgotten = "reg [71:0] forgotten; always @(posedge aclk) forgotten <= forgotten;
        assign m_axis_tdata = forgotten ^ b_data";
    let dut = changed("assign m_axis_tdata = b_data", forgotten);
    assert!(!verilator.run(&dut, &stimulus(Fault::None)).unwrap().passed());
}

/// A core as wide as a column of Catmull-Clark patches: wider than any simulator can scan at once.
#[test]
fn a_very_wide_core_runs_everywhere() {
    const BITS: u32 = 10_000;
    let text = "module wide (input wire aclk, input wire aresetn,
        input wire [9999:0] s_axis_tdata, input wire s_axis_tvalid, output wire s_axis_tready,
        output reg [9999:0] m_axis_tdata, output reg m_axis_tvalid, input wire m_axis_tready);
        assign s_axis_tready = !m_axis_tvalid || m_axis_tready;
        always @(posedge aclk)
            if (!aresetn) m_axis_tvalid <= 1'b0;
            else if (s_axis_tready) begin
                m_axis_tvalid <= s_axis_tvalid;
                m_axis_tdata <= ~s_axis_tdata;
            end
        endmodule\n";
    let port = Port { data: BITS, ..Port::default() };
    let mut input = vec![port.beat(); 5];
    for (at, beat) in input.iter_mut().enumerate() {
        let mix = |word: usize| (word as u64 * 77 + at as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        beat.data.iter_mut().enumerate().for_each(|(word, bits)| *bits = mix(word));
        beat.data[156] &= 0xffff;
    }
    let invert = |beat: &Beat| {
        let mut data: Vec<u64> = beat.data.iter().map(|word| !word).collect();
        data[156] &= 0xffff;
        Beat { data, ..beat.clone() }
    };
    let mut expected: Vec<Beat> = input.iter().map(invert).collect();
    expected[3].data[130] ^= 1 << 5;
    let wide = Dut {
        top: "wide".into(),
        files: vec![("wide.v".into(), text.into())],
        input: port.clone(),
        output: port,
        latency: Some(Latency { beat: 4, clocks: 2 }),
    };
    for tool in TOOLS {
        let Some(simulator) = external(tool, settings()) else { continue };
        let stimulus = Stimulus::new(input.clone(), expected.clone());
        let outcome = simulator.run(&wide, &stimulus).unwrap();
        let name = simulator.name();
        let [Failure::Value { beat: 3, signal, .. }, Failure::Latency { measured: -3, .. }] =
            outcome.failures.as_slice()
        else {
            panic!("{name}: {:?}", outcome.failures)
        };
        assert_eq!((signal.as_str(), outcome.mismatches), ("tdata[8327:8320]", 1), "{name}");
    }
}
