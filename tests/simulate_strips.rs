//! Catmull-Clark through the program as its user starts it: every quad shape, and the quad meshes beside the
//! project where they are there, in the built-in simulator; small ones in Verilator and Icarus too.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use subdiv_rtl::mesh::shapes;

fn simulate(source: &[String], level: u32, options: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"))
        .arg("simulate")
        .args(source)
        .args(["--scheme", "catmull-clark", "--format", "json", "--level", &level.to_string()])
        .args(options)
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{source:?} level {level} {options:?}: {errors}");
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

fn check(source: &[String], level: u32, options: &[&str]) {
    let result = simulate(source, level, options);
    let place = format!("{source:?} level {level} {options:?}: {result}");
    assert_eq!((&result["cracks"], &result["missing"]), (&0.into(), &0.into()), "{place}");
    assert_eq!(result["distinct_vertices"], result["vertices"], "{place}");
    let number = |key: &str| result["error_lsb"][key].as_f64().expect("a number");
    assert!(number("max") <= number("bound") + number("uncertainty"), "{place}");
    assert!(number("max") <= 0.5625, "{place}");
    for simulator in result["simulators"].as_array().expect("a list") {
        assert_eq!(simulator["mismatches"], 0, "{place}");
    }
}

fn sources() -> Vec<Vec<String>> {
    let quads = shapes().iter().filter(|shape| shape.name.ends_with("-quads"));
    let mut sources: Vec<Vec<String>> = quads.map(|s| vec!["--shape".into(), s.name.into()]).collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    for name in ["cube", "torus_quad", "square_quad", "disc_quad", "spot_cc"] {
        let path = folder.join(format!("{name}.obj"));
        if path.exists() {
            sources.push(vec![path.display().to_string()]);
        } else {
            println!("skipped: {} is not there", path.display());
        }
    }
    sources
}

#[test]
fn every_quad_mesh_in_the_built_in_simulator() {
    for source in sources() {
        for level in 1..=4 {
            check(&source, level, &[]);
            check(
                &source,
                level,
                &["--guard", "5", "--back-pressure", "random:40", "--input-gaps", "bursts"],
            );
        }
    }
}

#[test]
fn small_strips_in_every_simulator() {
    for (tool, question) in [("verilator", "--version"), ("iverilog", "-V")] {
        if Command::new(tool).arg(question).output().is_err() {
            println!("skipped: {tool} is not installed");
            return;
        }
    }
    for (shape, level) in [("cube-quads", 1), ("blob-quads", 2), ("square-quads", 2)] {
        let source = ["--shape".to_string(), shape.to_string()];
        check(&source, level, &["--simulator", "all"]);
        check(&source, level, &["--simulator", "all", "--guard", "4", "--back-pressure", "one-in-3"]);
    }
}
