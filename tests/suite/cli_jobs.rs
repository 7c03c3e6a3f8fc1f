//! The jobs of the program as its user starts them: generate and simulate, and what they do with bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"));
    command.env_remove("SUBDIV_RTL_CACHE");
    command
}

fn run(folder: &Path, arguments: &str) -> Output {
    program().current_dir(folder).args(arguments.split_whitespace()).output().expect("the program starts")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Every file below a folder with its bytes, in order.
fn contents(root: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut open, mut files) = (vec![root.to_path_buf()], vec![]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else {
                let bytes = fs::read(&path).expect("a file");
                files.push((path.strip_prefix(root).expect("below the root").to_path_buf(), bytes));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn generating_twice_gives_the_same_bytes_whatever_the_locale_and_the_threads() {
    let there = folder();
    let first = run(there.path(), "generate loop-fd --max-level 3 -o first");
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let second = program()
        .current_dir(there.path())
        .args(["generate", "loop-fd", "--max-level", "3", "-o", "second"])
        .env("LC_ALL", "tr_TR.UTF-8")
        .env("RAYON_NUM_THREADS", "1")
        .env("TZ", "Pacific/Auckland")
        .output()
        .expect("the program starts");
    assert!(second.status.success());
    let files = contents(&there.path().join("first"));
    assert_eq!(files, contents(&there.path().join("second")));
    let names: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    for name in
        ["manifest.json", "loop_fd.core", "loop_fd.f", "rtl/loop_fd.v", "testbench/loop_fd_testbench.v"]
    {
        assert!(names.iter().any(|n| n == name), "{name} is missing from {names:?}");
    }
    // Standard output lists what was written.
    assert_eq!(String::from_utf8_lossy(&first.stdout).lines().count(), files.len());
}

#[test]
fn the_manifest_holds_the_proof_and_the_hash_of_every_file() {
    let there = folder();
    assert!(run(there.path(), "generate loop-fd --coordinates Q4.8 --max-level 2 -o core").status.success());
    let core = there.path().join("core");
    let manifest: Value =
        serde_json::from_slice(&fs::read(core.join("manifest.json")).expect("a manifest")).expect("JSON");
    assert_eq!(manifest["schema"], "subdiv-rtl/manifest/1");
    assert_eq!(manifest["proofs"]["linear_forms"]["result"], "proved");
    // Levels 0, 1, 2 and three limit positions: 2 * (3 + 6 + 15) - ... coordinates, all compared.
    assert!(manifest["proofs"]["linear_forms"]["coordinates"].as_u64().is_some_and(|n| n > 100));
    let hashes = manifest["hashes"].as_object().expect("hashes");
    for (path, bytes) in contents(&core).into_iter().filter(|(path, _)| !path.ends_with("manifest.json")) {
        let hash = blake3::hash(&bytes).to_hex().to_string();
        assert_eq!(hashes[&path.display().to_string()], hash, "{}", path.display());
    }
    let quick = run(there.path(), "generate loop-fd --coordinates Q4.8 --max-level 2 --no-proof -o quick");
    assert!(quick.status.success());
    let text = fs::read_to_string(there.path().join("quick/manifest.json")).expect("a manifest");
    assert!(text.contains("\"result\": \"not run\""));
}

#[test]
fn a_folder_with_other_files_is_left_alone_unless_forced() {
    let there = folder();
    fs::create_dir(there.path().join("mine")).expect("a folder");
    fs::write(there.path().join("mine/thesis.txt"), "precious").expect("a file");
    let refused = run(there.path(), "generate loop-fd --max-level 1 -o mine");
    assert_eq!(refused.status.code(), Some(3));
    assert_eq!(contents(&there.path().join("mine")).len(), 1);
    assert!(run(there.path(), "generate loop-fd --max-level 1 -o mine --force").status.success());
    assert_eq!(fs::read_to_string(there.path().join("mine/thesis.txt")).expect("still there"), "precious");
    // A second time, the core's own files are no strangers.
    fs::remove_file(there.path().join("mine/thesis.txt")).expect("a file");
    assert!(run(there.path(), "generate loop-fd --max-level 2 -o mine").status.success());
}

#[test]
fn simulate_says_everything_in_one_object() {
    let there = folder();
    let output = run(
        there.path(),
        "simulate --shape tetrahedron --level 3 --format json -o fine.obj --picture fine.png",
    );
    assert!(output.status.success());
    let result: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(result.as_object().expect("an object").keys().next().map(String::as_str), Some("schema"));
    for key in [
        "mesh",
        "coordinates",
        "level",
        "patches",
        "triangles",
        "distinct_vertices",
        "cracks",
        "error_lsb",
        "simulators",
    ] {
        assert!(!result[key].is_null(), "{key}");
    }
    assert_eq!((&result["triangles"], &result["distinct_vertices"]), (&256.into(), &130.into()));
    for key in ["name", "version", "beats", "cycles", "mismatches", "build_seconds", "run_seconds"] {
        assert!(!result["simulators"][0][key].is_null(), "{key}");
    }
    let fine = fs::read_to_string(there.path().join("fine.obj")).expect("the fine mesh");
    assert_eq!(fine.lines().filter(|l| l.starts_with("v ")).count(), 130);
    assert_eq!(fine.lines().filter(|l| l.starts_with("f ")).count(), 256);
    assert!(fs::read(there.path().join("fine.png")).expect("the picture").starts_with(b"\x89PNG"));
}

#[test]
fn a_waveform_of_the_whole_run_can_be_had() {
    let there = folder();
    assert!(run(there.path(), "simulate --shape tetrahedron --level 1 --vcd run.vcd").status.success());
    let waveform = fs::read_to_string(there.path().join("run.vcd")).expect("the waveform");
    assert!(waveform.contains("$scope module engine_x $end") && waveform.contains(" left_0 $end"));
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn bad_input_gets_one_message_and_writes_nothing() {
    let long = format!("v 0 0 {}\n", "0".repeat(1 << 20));
    let cases: [(&str, String, &str, &str); 10] = [
        ("edge.obj", format!("{SQUARE}v 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n"), "", "edge"),
        (
            "vertex.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n".into(),
            "",
            "vertex",
        ),
        ("turned.obj", format!("{SQUARE}f 1 2 3\nf 1 3 4\nf 1 2 4\n"), "", ""),
        ("quad.obj", format!("{SQUARE}f 1 2 3 4\n"), "", "--triangulate"),
        ("open.obj", format!("{SQUARE}f 1 2\n"), "", ""),
        ("nan.obj", "v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(), "", "nan"),
        ("infinite.obj", "v 0 inf 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(), "", "inf"),
        ("large.obj", "v 0 9 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(), "--coordinates Q4.8", "Q5"),
        ("empty.obj", String::new(), "", "empty"),
        ("long.obj", long, "", ""),
    ];
    for (name, text, options, says) in cases {
        let there = folder();
        fs::write(there.path().join(name), text).expect("a file");
        let output = run(there.path(), &format!("simulate {name} -o fine.obj --picture fine.png {options}"));
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{name}: {message}");
        assert!(output.stdout.is_empty(), "{name}");
        assert_eq!(message.matches("error:").count(), 1, "{name}: {message}");
        assert!(
            message.contains("help:") && message.contains(name) && message.contains(says),
            "{name}: {message}"
        );
        assert_eq!(contents(there.path()).len(), 1, "{name}: nothing but the mesh is there");
    }
}

#[test]
fn what_does_not_exist_is_a_usage_error_that_teaches() {
    let there = folder();
    let cases = [
        ("simulate --shape bolb", "did you mean 'blob'?"),
        ("simulate --shape blob --simulator questa", "builtin"),
        ("simulate --shape blob --level 11", "0..=10"),
        ("simulate --shape blob --back-pressure sometimes", "one-in-N"),
        ("simulate --shape blob -o nowhere/fine.obj", "mkdir -p nowhere"),
        ("simulate --shape blob -o fine.docx", ".obj"),
        ("generate loop-fd --registers 21", "20"),
        ("generate loop-fd --coordinates Q40.40", "32 bits"),
    ];
    for (arguments, says) in cases {
        let output = run(there.path(), arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {message}");
        assert!(message.contains(says), "{arguments}: {message}");
    }
    assert!(contents(there.path()).is_empty());
}

#[test]
fn a_missing_tool_is_named_with_the_line_that_installs_it() {
    let there = folder();
    let output = program()
        .current_dir(there.path())
        .args(["simulate", "--shape", "tetrahedron", "--simulator", "verilator"])
        .env("PATH", there.path())
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(message.contains("verilator"), "{message}");
    // The built-in simulator needs nothing.
    let alone = program()
        .current_dir(there.path())
        .args(["simulate", "--shape", "tetrahedron", "--level", "2", "--simulator", "installed"])
        .env("PATH", there.path())
        .output()
        .expect("the program starts");
    assert!(alone.status.success());
}

#[test]
fn reduced_formats_are_simulated_with_their_cracks_counted_and_generated_with_their_bound() {
    let there = folder();
    let numbers = "--fractions 5,7,8,8,9 --max-level 3 --rounding half-even --saturate";
    let simulated = run(there.path(), &format!("simulate --shape blob --level 3 {numbers} --format json"));
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    let result: Value = serde_json::from_slice(&simulated.stdout).expect("JSON");
    assert_eq!(result["differences"], "5,7,8,8,9 half-even saturate");
    assert_eq!(result["simulators"][0]["mismatches"], 0);
    // Patches are rounded each by itself.
    assert!(result["cracks"].as_u64().is_some_and(|n| n > 0) && result["largest_crack"].as_i64() == Some(1));
    let error = |key: &str| result["error_lsb"][key].as_f64().expect("a number");
    assert!(error("max") <= error("bound") && error("bound") > 0.5);

    let generated = run(there.path(), &format!("generate loop-fd {numbers} -o core"));
    assert!(generated.status.success(), "{}", String::from_utf8_lossy(&generated.stderr));
    let manifest: Value =
        serde_json::from_slice(&fs::read(there.path().join("core/manifest.json")).expect("a manifest"))
            .expect("JSON");
    let differences = &manifest["parameters"]["differences"];
    assert_eq!(differences["fractions"], serde_json::json!([5, 7, 8, 8, 9]));
    let bound = differences["bound_lsb"].as_f64().expect("a bound");
    assert!(bound > 0.5 && bound < 4.0, "{bound}");
    let proof = &manifest["proofs"]["linear_forms"];
    assert_eq!(proof["result"], "proved");
    assert!(proof["error_lsb"]["above"].as_f64().is_some_and(|e| e > 0.5 && e < 3.0 * bound));
    assert!(
        manifest["command"]
            .as_str()
            .is_some_and(|c| c.ends_with("--fractions 5,7,8,8,9 --rounding half-even --saturate"))
    );
}

#[test]
fn a_core_of_fine_levels_takes_regular_meshes_only() {
    let there = folder();
    let numbers = "--level 3 --min-level 3 --max-level 3 --fractions 5,8,8,8,9";
    assert!(run(there.path(), &format!("simulate --shape torus {numbers}")).status.success());
    let irregular = run(there.path(), &format!("simulate --shape blob {numbers}"));
    assert_eq!(irregular.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&irregular.stderr).contains("irregular vertices"));
    assert!(run(there.path(), "generate loop-fd --min-level 2 --max-level 2 --fraction 6").status.success());
    assert_eq!(run(there.path(), "generate loop-fd --rounding floor").status.code(), Some(2));
    assert_eq!(
        run(there.path(), "generate loop-fd --fractions 4,5,5,5,5 --registers 19").status.code(),
        Some(2)
    );
}
