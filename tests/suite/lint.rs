//! Every emitted file is silent in Verilator (`-Wall`), Icarus (`-g2005 -Wall`) and Yosys, over the spread of
//! parameters that the cores take.

use std::path::Path;
use std::process::Command;

use subdiv_rtl::cores::cc_strip::{self, Schedule};
use subdiv_rtl::cores::loop_fd::{Columns, Parameters, RegisterForm};
use subdiv_rtl::fixed::{Format, Precision, Reduced, Rounding};
use subdiv_rtl::hdl::{Word, verilog};
use subdiv_rtl::package;
use subdiv_rtl::package::Package;

/// The tools, each with the command that must say nothing. `TOP` is the top module.
const COMMANDS: [(&str, &str); 3] = [
    ("verilator", "verilator --lint-only -Wall --top-module TOP rtl/*.v"),
    ("iverilog", "iverilog -g2005 -Wall -s TOP -o /dev/null rtl/*.v"),
    ("yosys", "yosys -q -p 'read_verilog rtl/*.v; hierarchy -check -top TOP; proc; check -assert'"),
];

fn check(package: &Package, what: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    package.write(&folder.path().join("core"), false).expect("the core is written");
    silent_everywhere(&folder.path().join("core"), &package.top, what);
}

/// In every tool that is installed; the sources are in `rtl/`.
fn silent_everywhere(folder: &Path, top: &str, what: &str) {
    for (tool, command) in COMMANDS {
        if Command::new(tool).arg("-V").output().is_err() {
            println!("skipped: {tool} is not installed");
            continue;
        }
        silent(folder, &command.replace("TOP", top), what);
    }
}

fn silent(folder: &Path, command: &str, what: &str) {
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).output().expect("a shell");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(output.status.success() && said.trim().is_empty(), "{what}: {command}\n{said}");
}

#[test]
fn loop_fd_is_silent() {
    let cases = [
        ("Q12.12", 12, 8, 20),
        ("Q12.12", 12, 8, 23),
        ("Q12.12", 12, 8, 22),
        ("Q12.12", 12, 8, 19),
        ("Q2.2", 2, 0, 20),
        ("Q4.8", 8, 1, 19),
        ("Q4.8", 4, 2, 20),
        ("Q1.31", 31, 10, 20),
        ("Q8.8", 16, 5, 23),
        ("Q2.0", 0, 3, 20),
    ];
    for (coordinates, fraction, level, registers) in cases {
        let form = RegisterForm::from_count(registers).expect("a register form");
        let format = coordinates.parse().expect("a format");
        let parameters = Parameters::new(format, fraction, level, form).expect("a core that exists");
        let what = format!("{coordinates}, output fraction {fraction}, level {level}, {registers} registers");
        check(&package::loop_fd::package(parameters, level <= 3).expect(&what), &what);
    }
}

#[test]
fn reduced_loop_fd_is_silent() {
    let cases = [
        ("Q12.12", 12, (0, 8), 20, "29", Rounding::HalfUp, false),
        ("Q12.12", 12, (0, 8), 20, "11,18,23,29,30", Rounding::HalfUp, false),
        ("Q4.8", 8, (0, 3), 19, "8", Rounding::HalfEven, true),
        ("Q4.8", 6, (0, 2), 23, "4,5,5,6,8", Rounding::Truncate, false),
        ("Q2.2", 4, (0, 1), 22, "2", Rounding::Floor, true),
        ("Q2.6", 6, (0, 0), 20, "4", Rounding::Truncate, false),
        ("Q4.8", 8, (3, 3), 20, "5,8,8,8,9", Rounding::HalfEven, true),
        ("Q4.8", 13, (1, 3), 20, "5,8,9,10,11", Rounding::Floor, false),
    ];
    for (coordinates, output, (min_level, max_level), registers, fractions, rounding, saturate) in cases {
        let form = RegisterForm::from_count(registers).expect("a register form");
        let format = coordinates.parse().expect("a format");
        let fractions = fractions.parse().expect("fractions");
        let precision = Precision::Reduced(Reduced { fractions, rounding, saturate });
        let parameters = Parameters::new(format, output, max_level, form)
            .and_then(|p| p.with_min_level(min_level))
            .and_then(|p| p.with_precision(precision))
            .expect("a core that exists");
        let what = format!("{parameters:?}");
        check(&package::loop_fd::package(parameters, max_level <= 3).expect(&what), &what);
    }
}

#[test]
fn lanes_of_loop_fd_are_silent() {
    let cases = [
        ("Q12.12", (8, 8), Some(15), 1, Columns::Shared),
        ("Q4.8", (0, 3), Some(12), 3, Columns::Shared),
        ("Q4.8", (0, 2), None, 2, Columns::Shared),
        ("Q12.12", (8, 8), Some(15), 1, Columns::Buffered),
        ("Q4.8", (0, 3), None, 1, Columns::Buffered),
        ("Q4.4", (3, 5), Some(16), 1, Columns::Buffered),
        ("Q2.2", (0, 0), None, 1, Columns::Buffered),
    ];
    for (coordinates, (min_level, max_level), chunk, lanes, columns) in cases {
        let format: Format = coordinates.parse().expect("a format");
        let parameters = Parameters::new(format, format.fraction, max_level, RegisterForm::Minimal20)
            .and_then(|p| {
                p.with_min_level(min_level)?.with_chunk(chunk)?.with_lanes(lanes)?.with_columns(columns)
            })
            .expect("a core that exists");
        let what = format!("{parameters:?}");
        check(&package::loop_fd::package(parameters, max_level <= 3).expect(&what), &what);
    }
}

#[test]
fn cc_strip_is_silent() {
    let cases = [
        ("Q12.12", 12, 1, 4, cc_strip::Precision::Exact, 37, Schedule::Pipelined, false, None),
        ("Q4.8", 8, 2, 6, cc_strip::Precision::Exact, 25, Schedule::Shared, false, None),
        ("Q4.8", 6, 3, 5, cc_strip::Precision::Guard(0), 20, Schedule::Double, true, None),
        ("Q2.14", 14, 3, 10, cc_strip::Precision::Guard(4), 29, Schedule::Pipelined, true, None),
        ("Q4.8", 8, 3, 5, cc_strip::Precision::Exact, 25, Schedule::Shared, false, Some(2)),
        ("Q4.8", 8, 3, 4, cc_strip::Precision::Guard(3), 25, Schedule::Pipelined, false, Some(4)),
        ("Q4.8", 8, 3, 5, cc_strip::Precision::Guard(4), 25, Schedule::Pipelined, false, Some(2)),
        ("Q4.8", 8, 3, 4, cc_strip::Precision::Exact, 25, Schedule::Pipelined, false, None),
        ("Q4.8", 8, 5, 5, cc_strip::Precision::Guard(4), 25, Schedule::Pipelined, false, Some(2)),
    ];
    for (
        nth,
        (coordinates, output_fraction, levels, max_valence, precision, table_bits, schedule, folded, rows),
    ) in cases.into_iter().enumerate()
    {
        let coordinates = coordinates.parse().expect("a format");
        let parameters = cc_strip::Parameters {
            output_fraction,
            precision,
            table_bits,
            schedule,
            folded,
            rows_per_clock: rows,
            registered: nth >= 6,
            axes_in_turn: if nth == 8 { 3 } else { 0 },
            ..cc_strip::Parameters::exact(coordinates, levels, max_valence)
        };
        let what = format!("{parameters:?}");
        check(&package::cc_strip::package(parameters, true).expect(&what), &what);
    }
}

#[test]
fn the_buffer_of_longitudinal_strips_is_silent() {
    for (log_columns, levels, width) in [(1, 1, 8), (5, 3, 24), (3, 5, 40)] {
        let module =
            cc_strip::longitudinal::build(log_columns, levels, Word::signed(width)).expect("a buffer");
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("rtl")).expect("a folder");
        for file in verilog::print(&module, "a test").expect("Verilog") {
            std::fs::write(folder.path().join("rtl").join(file.name), file.text).expect("a file");
        }
        silent_everywhere(folder.path(), &module.name, &format!("N = 2^{log_columns}, {levels} levels"));
    }
}
