//! Hardware and reference are written from the same mathematics by different means: the sources of one may
//! not name the other.

use std::path::{Path, PathBuf};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// Files of a room that name one of the other rooms outside of comments.
fn offenders(room: &str, forbidden: &[&str]) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(room);
    let files = sources(&folder);
    assert!(!files.is_empty(), "src/{room} has no sources");
    let mut found = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        for (number, line) in text.lines().enumerate().filter(|(_, l)| !l.trim_start().starts_with("//")) {
            if forbidden.iter().any(|other| line.contains(other)) {
                found.push(format!("{}:{}: {line}", file.display(), number + 1));
            }
        }
    }
    found
}

#[test]
fn the_model_knows_no_hardware_and_the_hardware_no_model() {
    let empty: [String; 0] = [];
    assert_eq!(offenders("model", &["hdl::", "cores::", "::hdl", "::cores"]), empty);
    assert_eq!(offenders("cores", &["model::", "::model"]), empty);
    assert_eq!(offenders("hdl", &["model::", "::model"]), empty);
}

#[test]
fn the_surface_knows_neither() {
    let empty: [String; 0] = [];
    assert_eq!(offenders("surface", &["model::", "::model", "hdl::", "::hdl", "cores::", "::cores"]), empty);
}
