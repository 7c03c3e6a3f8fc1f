//! `report`: what is printed, on which stream, as text and as JSON.

use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn run(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.args(words).stdin(Stdio::null()).output().unwrap()
}

#[test]
fn the_thesis_stands_beside_what_is_measured() {
    let output = run(&["report", "thesis", "--level", "3", "--format", "json"]);
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("{\n  \"schema\": \"subdiv-rtl/report-thesis/1\""));
    let found: Value = serde_json::from_str(&text).unwrap();
    let figure = |name: &str| {
        let list = found["figures"].as_array().unwrap();
        list.iter().find(|f| f["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    // 9l + 3 * 2^(l+1) - 3, and + 6
    let windows = figure("three columns of each level");
    assert_eq!((&windows["printed"], &windows["corrected"]), (&72.0.into(), &81.0.into()));
    let kept: i64 = found["storage"].as_array().unwrap().iter().map(|s| s["columns"].as_i64().unwrap()).sum();
    assert_eq!(windows["measured"].as_f64(), Some(kept as f64));
    let clocks = figure("clocks a column, one unit a level");
    assert_eq!((&clocks["corrected"], &clocks["measured"]), (&8.0.into(), &8.0.into()));
    assert_eq!(figure("multipliers by 1/3")["measured"].as_f64(), Some(0.0));
}

#[test]
fn the_text_has_the_printed_the_corrected_and_the_measured_number_in_a_row() {
    let output = run(&["report", "thesis"]);
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
    let text = String::from_utf8(output.stdout).unwrap();
    let row = |name: &str| {
        let line =
            text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}\n{text}"));
        line[name.len()..].split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(row("storage  ")[..3], ["(6.4)", "410", "435"]);
    assert_eq!(row("clocks a column, one unit a level")[1..], ["32", "32", "clocks"]);
    assert_eq!(row("adders of four inputs")[..2], ["158", "108"]);
    assert_eq!(row("multipliers  "), ["4", "2", "2"]);
}

#[test]
fn a_level_that_no_core_has_is_a_mistake_on_the_command_line() {
    for words in
        [&["report"][..], &["report", "thesis", "--level", "8"], &["report", "thesis", "--max-valence", "3"]]
    {
        let output = run(words);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{words:?}");
    }
}
