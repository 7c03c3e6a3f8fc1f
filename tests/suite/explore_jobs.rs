//! `explore` as its user starts it: killed and started again, in shards and merged, in a workflow, with bad input;
//! and `report figures`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_subdiv-rtl"))
}

fn run(folder: &Path, arguments: &str) -> Output {
    program().current_dir(folder).args(arguments.split_whitespace()).output().expect("the program starts")
}

fn good(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {errors}");
    String::from_utf8(output.stdout).expect("text")
}

fn sorted_lines(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a file of points");
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    lines.sort();
    lines
}

const SWEEP: &str = "--shape blob,icosahedron --level 3..4 --fraction 4..20 --exact --registers 19,20,22 \
                     --rounding half-up,half-even,floor,truncate";

#[test]
fn killed_ten_times_the_result_is_that_of_an_uninterrupted_run() {
    let there = tempfile::tempdir().expect("a folder");
    good(there.path(), &format!("explore {SWEEP} -o whole.jsonl"));
    let whole = sorted_lines(&there.path().join("whole.jsonl"));
    assert!(whole.len() > 400, "{}", whole.len());

    let path = there.path().join("killed.jsonl");
    let (mut state, mut grown, mut before) = (7u64, 0, 0);
    for _ in 0..10 {
        let mut child = program()
            .current_dir(there.path())
            .args(format!("explore {SWEEP} --threads 1 -o killed.jsonl").split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(Duration::from_millis(30 + (state >> 33) % 150));
        child.kill().expect("it is ours");
        child.wait().expect("it ends");
        let now = fs::metadata(&path).map_or(0, |file| file.len());
        grown += usize::from(now > before);
        before = now;
    }
    assert!(grown >= 3, "most runs were killed before they wrote anything");
    good(there.path(), &format!("explore {SWEEP} -o killed.jsonl"));
    // Nothing is lost, nothing is there twice, and every byte is the same.
    assert_eq!(sorted_lines(&path), whole);
}

#[test]
fn a_torn_line_is_cut_off_and_its_point_done_again() {
    let there = tempfile::tempdir().expect("a folder");
    let sweep = "explore --shape octahedron --level 2 --fraction 4..8 -o points.jsonl";
    good(there.path(), sweep);
    let path = there.path().join("points.jsonl");
    let whole = fs::read(&path).expect("points");
    let lines = sorted_lines(&path);
    for cut in [1, 40, 200] {
        fs::write(&path, &whole[..whole.len() - cut]).expect("written");
        good(there.path(), sweep);
        assert_eq!(sorted_lines(&path), lines, "torn {cut} bytes before the end");
    }
    // A whole line that is no point is not passed over.
    fs::write(&path, b"{\"key\":1}\n").expect("written");
    let output = run(there.path(), sweep);
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("points.jsonl:1"));
}

#[test]
fn shards_merge_to_the_whole_and_a_missing_one_is_told() {
    let there = tempfile::tempdir().expect("a folder");
    let folder = there.path();
    let sweep = "--shape torus,octahedron --level 1..3 --fraction 6..9 --rounding half-up,floor";
    good(folder, &format!("explore plan {sweep} -o plan.jsonl"));
    good(folder, &format!("explore {sweep} -o whole.jsonl"));
    good(folder, "explore merge whole.jsonl -o sorted.jsonl");
    for shard in 1..=3 {
        good(folder, &format!("explore run plan.jsonl --shard {shard}/3 -o {shard}.jsonl"));
    }
    let early = run(folder, "explore merge 1.jsonl 3.jsonl --plan plan.jsonl -o merged.jsonl");
    assert_eq!(early.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&early.stderr).contains("points of the plan are missing"));
    assert!(!folder.join("merged.jsonl").exists());
    // A shard may come twice, and the order does not matter.
    good(folder, "explore merge 3.jsonl 1.jsonl 2.jsonl 1.jsonl --plan plan.jsonl -o merged.jsonl");
    let bytes = |name: &str| fs::read(folder.join(name)).expect("points");
    assert_eq!(bytes("merged.jsonl"), bytes("sorted.jsonl"));

    // Two results of one point that differ are refused.
    let text = fs::read_to_string(folder.join("1.jsonl")).expect("points");
    let (before, after) = text.split_once("\"bound_lsb\":").expect("a bound");
    fs::write(folder.join("other.jsonl"), format!("{before}\"bound_lsb\":9{after}")).expect("written");
    let output = run(folder, "explore merge 1.jsonl other.jsonl -o merged.jsonl");
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("two results of the point"));
}

#[test]
fn a_mesh_that_changed_after_the_plan_is_refused() {
    let there = tempfile::tempdir().expect("a folder");
    let mesh = there.path().join("square.obj");
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n").expect("written");
    good(there.path(), "explore plan square.obj --level 2");
    good(there.path(), "explore run plan.jsonl");
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 1 3 4\n").expect("written");
    let output = run(there.path(), "explore run plan.jsonl");
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("has changed"));
}

#[test]
fn one_line_recommends_and_its_command_generates_the_core() {
    let there = tempfile::tempdir().expect("a folder");
    let advice = good(
        there.path(),
        "explore --shape torus --level 3 --target-error 1lsb --recommend --by engine-bits",
    );
    assert_eq!(advice.lines().count(), 1, "{advice}");
    assert!(advice.contains("progressive") && advice.contains("proved"), "{advice}");
    let command = advice.trim().split_once("subdiv-rtl ").expect("a command").1;
    good(there.path(), &format!("{command} --no-proof -o core"));
    assert!(there.path().join("core/manifest.json").exists());
    let output =
        run(there.path(), "explore --shape torus --level 3 --fraction 4 --target-error 0.6 --recommend");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("help: the best one is proved for"));
}

#[test]
fn results_as_json_and_as_files() {
    let there = tempfile::tempdir().expect("a folder");
    let words =
        "explore --shape octahedron --level 2..3 --fraction 4..9 --exact --guard 3 --svg a.svg --html a.html";
    let text = good(there.path(), &format!("{words} --format json"));
    let object: Value = serde_json::from_str(&text).expect("JSON");
    assert!(text.starts_with("{\n  \"schema\": \"subdiv-rtl/explore/1\""));
    assert_eq!(object["points"].as_array().map(Vec::len), Some(14));
    assert_eq!(object["skipped"], 2);
    assert!(object["front"].as_array().is_some_and(|front| !front.is_empty()));
    let page = fs::read_to_string(there.path().join("a.html")).expect("a page");
    assert_eq!(page.matches("<tr data-key=").count(), 14);
    assert!(page.contains("generate loop-fd") && !page.contains("src=") && !page.contains("@import"));
    let before = (fs::read(there.path().join("a.svg")).expect("a plot"), page);
    good(there.path(), &format!("{words} --threads 3"));
    let after = fs::read_to_string(there.path().join("a.html")).expect("a page");
    assert_eq!(before, (fs::read(there.path().join("a.svg")).expect("a plot"), after));
}

#[test]
fn bad_input_is_told_in_one_line_with_its_exit_status() {
    let there = tempfile::tempdir().expect("a folder");
    for (words, status) in [
        ("explore", 2),
        ("explore --shape blob --fraction 9..4", 2),
        ("explore --shape blob --fractions 5,4,3,2,1", 2),
        ("explore --shape blob --guard 3", 2),
        ("explore --shape blob --target-error none", 2),
        ("explore --shape blob --shard 3/2", 2),
        ("explore --shape bloob", 2),
        ("explore none.obj", 3),
        ("explore --shape blob-quads --scheme loop", 3),
        ("explore --shape triangle --level 2 -o none/points.jsonl", 3),
        ("explore run none.jsonl", 3),
        ("explore merge none.jsonl -o a.jsonl", 3),
        ("explore emit snakemake plan;rm.jsonl", 2),
        ("report figures --only 15", 2),
    ] {
        let output = run(there.path(), words);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{words}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        assert!(output.stdout.is_empty(), "{words}");
    }
}

#[test]
fn figures_are_written_with_their_numbers() {
    let there = tempfile::tempdir().expect("a folder");
    good(there.path(), "report figures --only 16,17 --max-level 4 -o figures");
    let text = |name: &str| fs::read_to_string(there.path().join("figures").join(name)).expect("a file");
    assert!(text("figure-16.csv").contains("torus,2,2304,28080,12.1875"));
    let csv = text("figure-17.csv");
    for numbers in ["float32", "exact fixed point", "uniform, 1 lsb", "progressive, 1 lsb"] {
        assert_eq!(csv.matches(numbers).count(), 3 * 4, "{numbers}");
    }
    assert!(text("figure-16.svg").starts_with("<svg") && text("figure-17.svg").starts_with("<svg"));
}

/// Snakemake: from the path, else in an environment of its own, else none.
fn snakemake(folder: &Path) -> Option<PathBuf> {
    let works = |path: &Path| {
        let answer = Command::new(path).arg("--version").stderr(Stdio::null()).output();
        answer.is_ok_and(|output| output.status.success())
    };
    let found = PathBuf::from("snakemake");
    if works(&found) {
        return Some(found);
    }
    let environment = folder.join("environment");
    let quietly = |command: &mut Command| {
        command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    let made = quietly(Command::new("python3").args(["-m", "venv"]).arg(&environment))
        && quietly(Command::new(environment.join("bin/pip")).args(["install", "--quiet", "snakemake"]));
    let found = environment.join("bin/snakemake");
    (made && works(&found)).then_some(found)
}

#[test]
fn the_workflow_runs_in_snakemake_and_gives_the_same_points() {
    let there = tempfile::tempdir().expect("a folder");
    let folder = there.path();
    let Some(snakemake) = snakemake(folder) else {
        println!("skipped: snakemake is not installed, and pip cannot install it");
        return;
    };
    let sweep = "--shape octahedron --level 1..3 --fraction 4..12";
    good(folder, &format!("explore plan {sweep} -o plan.jsonl"));
    let emitted = program()
        .current_dir(folder)
        .args(["explore", "emit", "snakemake", "plan.jsonl", "--shards", "4", "--program"])
        .arg(env!("CARGO_BIN_EXE_subdiv-rtl"))
        .output()
        .expect("the program starts");
    assert!(emitted.status.success(), "{}", String::from_utf8_lossy(&emitted.stderr));
    let output = Command::new(snakemake)
        .current_dir(folder)
        .env("HOME", folder)
        .args(["--cores", "2", "--quiet", "all"])
        .output()
        .expect("snakemake starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    good(folder, &format!("explore {sweep} -o whole.jsonl"));
    good(folder, "explore merge whole.jsonl -o sorted.jsonl");
    let bytes = |name: &str| fs::read(folder.join(name)).expect("points");
    assert_eq!(bytes("points.jsonl"), bytes("sorted.jsonl"));
}
