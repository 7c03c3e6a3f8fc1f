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

/// The stalls that every mesh goes through: none, and some on both sides.
const STALLS: [&[&str]; 2] = [&[], &["--back-pressure", "random:40", "--input-gaps", "bursts"]];

fn have(tools: &[[&str; 2]]) -> bool {
    let missing = tools.iter().find(|[tool, question]| Command::new(tool).arg(question).output().is_err());
    if let Some([tool, _]) = missing {
        println!("skipped: {tool} is not installed");
    }
    missing.is_none()
}

const VERILATOR: [&str; 2] = ["verilator", "--version"];
const ICARUS: [&str; 2] = ["iverilog", "-V"];

/// One core of level 5 at all its levels, in the built-in simulator and in Verilator.
#[test]
fn every_quad_mesh_at_every_level_of_one_core() {
    let simulators = if have(&[VERILATOR]) { "builtin,verilator" } else { "builtin" };
    let core = ["--max-level", "5", "--max-valence", "10", "--coordinates", "Q3.12"];
    for source in sources() {
        for level in 1..=5 {
            for stalls in STALLS {
                check(&source, level, &[&core[..], stalls, &["--simulator", simulators]].concat());
            }
        }
    }
}

/// Points of the limit surface, against those of the oracle.
#[test]
fn every_quad_mesh_on_the_limit_surface() {
    for source in sources() {
        for level in 1..=5 {
            check(&source, level, &["--limit"]);
        }
    }
}

/// A core of its own for every level, in Icarus: the meshes by turns, so that two tests share the work. It is slow: the fine
/// levels are run with stalls or without them, in turn.
fn in_icarus(turn: usize) {
    if !have(&[ICARUS]) {
        return;
    }
    for (number, source) in sources().into_iter().skip(turn).step_by(2).enumerate() {
        for level in 1..=5 {
            let some = if level <= 3 { &STALLS[..] } else { &STALLS[number % 2..][..1] };
            for stalls in some {
                let core = ["--coordinates", "Q3.12", "--simulator", "icarus"];
                check(&source, level, &[&core[..], stalls].concat());
            }
        }
    }
}

#[test]
fn every_quad_mesh_in_icarus() {
    in_icarus(0);
}

#[test]
fn every_other_quad_mesh_in_icarus() {
    in_icarus(1);
}

/// Every schedule, slices, guard bits and their rounding, limit positions, normals, and rows along the strip.
#[test]
fn every_kind_of_core_in_every_simulator() {
    if !have(&[VERILATOR, ICARUS]) {
        return;
    }
    let kinds = [
        "--schedule shared",
        "--schedule shared --rows-per-clock 2 --guard 4",
        "--fold --guard 5 --rounding half-even",
        "--schedule double --fold --guard 3 --rounding floor",
        "--rows-per-clock 4 --guard 6 --rounding truncate",
        "--limit",
        "--limit --normals limit --unit-normals 14 --guard 6",
        "--normals faces --schedule shared",
        "--row-major 3",
    ];
    let core = ["--max-level", "3", "--max-valence", "10", "--coordinates", "Q3.12"];
    for kind in kinds {
        let kind: Vec<&str> = kind.split(' ').collect();
        // The same core, so that no simulator builds it twice; Icarus is slow.
        for (source, level, stalls, simulators) in [
            ("blob-quads", 3, STALLS[1], "builtin,verilator"),
            ("cube-quads", 3, STALLS[1], "icarus"),
            ("cube-quads", 2, STALLS[0], "all"),
        ] {
            let source = ["--shape".to_string(), source.to_string()];
            let options = [&core[..], &kind, stalls, &["--simulator", simulators]].concat();
            let result = simulate(&source, level, &options);
            assert_eq!((&result["cracks"], &result["missing"]), (&0.into(), &0.into()), "{kind:?}");
            let count = if simulators == "all" { 3 } else { simulators.split(',').count() };
            let simulators = result["simulators"].as_array().expect("a list");
            assert_eq!(simulators.len(), count);
            assert!(simulators.iter().all(|s| s["mismatches"] == 0), "{kind:?}: {result}");
        }
    }
}

/// Ends that are walked around, coordinates in turn, waits in block RAM.
#[test]
fn a_walked_core_in_every_simulator() {
    if !have(&[VERILATOR, ICARUS]) {
        return;
    }
    let core = "--max-level 3 --max-valence 6 --coordinates Q3.12 --guard 4 --rounding floor --registered \
                --rows-per-clock 2 --axes-in-turn 2 --simulator all";
    let core: Vec<&str> = core.split_whitespace().collect();
    let source = ["--shape".to_string(), "cube-quads".to_string()];
    let result = simulate(&source, 2, &[&core[..], STALLS[1]].concat());
    let simulators = result["simulators"].as_array().expect("a list");
    assert_eq!((simulators.len(), &result["cracks"]), (3, &0.into()));
    assert!(simulators.iter().all(|s| s["mismatches"] == 0), "{result}");
}

/// The mesh that the wildest valences are tested on has them.
#[test]
fn the_blob_has_valences_three_to_nine_and_neighbours_of_valence_three() {
    let mesh = subdiv_rtl::mesh::shape("blob-quads").expect("a shape");
    let mut valence = vec![0; mesh.positions.len()];
    let mut edges = std::collections::BTreeSet::new();
    for face in &mesh.faces {
        for (at, &a) in face.iter().enumerate() {
            let b = face[(at + 1) % face.len()];
            edges.insert((a.min(b), a.max(b)));
        }
    }
    for &(a, b) in &edges {
        valence[a as usize] += 1;
        valence[b as usize] += 1;
    }
    assert!((3..=9).all(|d| valence.contains(&d)));
    assert!(edges.iter().any(|&(a, b)| valence[a as usize] == 3 && valence[b as usize] == 3));
}

#[test]
fn a_valence_above_the_maximum_names_the_vertex_and_the_option() {
    let output = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"))
        .args(["simulate", "--shape", "blob-quads", "--scheme", "catmull-clark", "--max-valence", "8"])
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{errors}");
    let named = errors.contains("vertex") && errors.contains("has valence 9");
    assert!(named && errors.contains("--max-valence"), "{errors}");
}
