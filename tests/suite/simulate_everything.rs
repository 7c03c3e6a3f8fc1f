//! The main job over everything: every simulator, every triangle shape and mesh, levels 0 to 6, with and
//! without stalls, through the program as its user starts it. Icarus, to which it is a hundred times as long as to the
//! others, runs the fine levels with stalls or without them, in turn from mesh to mesh, and the finest one of our own
//! shapes alone.
//!
//! Each run must report no mismatch, no crack, every vertex of the subdivided mesh exactly once, and an
//! error within its bound. Runs need tools; what is missing is skipped with a line that says so.

use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::Value;
use subdiv_rtl::mesh::{read, shapes};

const LEVELS: std::ops::RangeInclusive<u32> = 0..=6;

/// From this level on Icarus runs each mesh once.
const ICARUS_IN_TURN: u32 = 5;

/// Without and with stalls on both sides.
const STALLS: [(&str, &str); 2] = [("none", "none"), ("random:35", "bursts")];

struct Run {
    source: Vec<String>,
    level: u32,
    stalls: (&'static str, &'static str),
    simulator: &'static str,
}

/// Every triangle mesh: the built-in shapes, and those beside the project where they are there.
fn sources() -> Vec<Vec<String>> {
    let mut sources: Vec<Vec<String>> = shapes()
        .iter()
        .filter(|shape| shape.mesh().is_triangle_mesh())
        .map(|shape| vec!["--shape".into(), shape.name.into()])
        .collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    match std::fs::read_dir(&folder) {
        Err(_) => println!("skipped: no meshes in {}", folder.display()),
        Ok(entries) => {
            let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
            paths.sort();
            let triangles = |path: &&std::path::PathBuf| read(path).is_ok_and(|mesh| mesh.is_triangle_mesh());
            sources.extend(paths.iter().filter(triangles).map(|path| vec![path.display().to_string()]));
        }
    }
    sources
}

fn check(run: &Run) -> Result<(), String> {
    let output = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"))
        .arg("simulate")
        .args(&run.source)
        .args(["--level", &run.level.to_string(), "--simulator", run.simulator, "--format", "json"])
        .args(["--back-pressure", run.stalls.0, "--input-gaps", run.stalls.1, "--seed", "7"])
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .map_err(|e| e.to_string())?;
    let errors = String::from_utf8_lossy(&output.stderr);
    let result: Value = serde_json::from_slice(&output.stdout).map_err(|e| format!("{e}; {errors}"))?;
    if !output.status.success() {
        return Err(errors.into_owned());
    }
    let number = |value: &Value| value.as_f64().ok_or_else(|| format!("no number in {result}"));
    let error = &result["error_lsb"];
    let regular = result["patches"]["semi_regular"] == 0 && result["patches"]["irregular"] == 0;
    let allowed = if regular { 0.5 } else { 0.5625 };
    let right = result["cracks"] == 0
        && result["missing"] == 0
        && result["distinct_vertices"] == result["vertices"]
        && number(&error["max"])? <= allowed
        && (!regular || error["at_most_half"] == true)
        && number(&error["max"])? <= number(&error["bound"])? + number(&error["uncertainty"])?
        && result["simulators"].as_array().is_some_and(|all| all.len() == 1 && all[0]["mismatches"] == 0);
    if right { Ok(()) } else { Err(result.to_string()) }
}

/// The runs of one simulator, on all cores.
fn everything(simulator: &'static str) {
    let mut runs = vec![];
    for level in LEVELS.rev() {
        for (number, source) in sources().into_iter().enumerate() {
            let slow = simulator == "icarus";
            if slow && level == *LEVELS.end() && source[0] != "--shape" {
                continue;
            }
            let both = !slow || level < ICARUS_IN_TURN;
            let stalls = STALLS.into_iter().enumerate().filter(|(at, _)| both || at % 2 == number % 2);
            runs.extend(stalls.map(|(_, stalls)| Run { source: source.clone(), level, stalls, simulator }));
        }
    }
    let (next, failures) = (AtomicUsize::new(0), Mutex::new(vec![]));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(run) = runs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Err(error) = check(run) {
                        let place =
                            format!("{} level {} {:?}: {error}", run.source.join(" "), run.level, run.stalls);
                        // A thread that panicked while it held the lock has failed the test anyway.
                        failures.lock().unwrap().push(place);
                    }
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(
        failures.is_empty(),
        "{} of {} runs failed:\n{}",
        failures.len(),
        runs.len(),
        failures.join("\n")
    );
    println!("{simulator}: {} runs, all equal, bit for bit", runs.len());
}

fn installed(tool: &str, question: &str) -> bool {
    let found = Command::new(tool).arg(question).output().is_ok();
    if !found {
        println!("skipped: {tool} is not installed");
    }
    found
}

#[test]
fn the_built_in_simulator_agrees_with_the_reference_everywhere() {
    everything("builtin");
}

#[test]
fn verilator_agrees_with_the_reference_everywhere() {
    if installed("verilator", "--version") {
        everything("verilator");
    }
}

#[test]
fn icarus_agrees_with_the_reference_everywhere() {
    if installed("iverilog", "-V") {
        everything("icarus");
    }
}
