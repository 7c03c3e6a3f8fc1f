//! The order of the house, read from its own text: which room may use which, and how a file looks.
//!
//! The table in `src/lib.rs` is the rule; this test reads it there. Hardware and reference are written from
//! the same mathematics by different means, and that stays true only while neither can see the other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

type Names = BTreeSet<String>;

fn home() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below a folder of the project, as a path from its root and the text, in order.
fn texts(folder: &str) -> Vec<(String, String)> {
    fn gather(path: &Path, found: &mut Vec<PathBuf>) {
        if path.is_dir() {
            std::fs::read_dir(path).unwrap().for_each(|entry| gather(&entry.unwrap().path(), found));
        } else {
            found.push(path.to_path_buf());
        }
    }
    let mut paths = vec![];
    gather(&home().join(folder), &mut paths);
    paths.sort();
    let name = |path: &Path| path.strip_prefix(home()).unwrap().display().to_string();
    let texts = paths.iter().filter_map(|path| Some((name(path), std::fs::read_to_string(path).ok()?)));
    texts.collect()
}

fn rust(folders: &[&str]) -> Vec<(String, String)> {
    let files: Vec<_> = folders.iter().flat_map(|folder| texts(folder)).collect();
    let files: Vec<_> = files.into_iter().filter(|(name, _)| name.ends_with(".rs")).collect();
    assert!(!files.is_empty(), "no sources in {folders:?}");
    files
}

/// The text without its comments, line by line.
fn code(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// The room of a file of `src`; nothing for the two roots, which belong to no room.
fn room(file: &str) -> Option<String> {
    let inside = file.strip_prefix("src/")?;
    let room = inside.split('/').next()?.trim_end_matches(".rs");
    (!["lib", "main"].contains(&room)).then(|| room.into())
}

/// The words in backquotes.
fn quoted(text: &str) -> Names {
    text.split('`').skip(1).step_by(2).map(String::from).collect()
}

/// The table of the rooms: each with those it may use. The rooms of the first row are everybody's.
fn table() -> BTreeMap<String, Names> {
    let library = std::fs::read_to_string(home().join("src/lib.rs")).unwrap();
    let rows = library.lines().filter_map(|line| line.strip_prefix("//! | "));
    let (mut table, mut above) = (BTreeMap::new(), Names::new());
    let mut shared: Option<Names> = None;
    for row in rows.filter(|row| row.starts_with("[`")) {
        let cells: Vec<&str> = row.split(" | ").collect();
        let [rooms, _, uses] = cells[..] else { panic!("three cells in a row: {row}") };
        let rooms = quoted(rooms);
        let shared = shared.get_or_insert_with(|| rooms.clone());
        let named = if uses.starts_with("all above") { above.clone() } else { quoted(uses) };
        above.extend(rooms.clone());
        for room in rooms {
            let uses = named.iter().chain(&*shared).cloned().chain([room.clone()]).collect();
            table.insert(room, uses);
        }
    }
    table
}

/// The first names of the paths that begin at the root of the crate: `crate::a::b`, `crate::{a::b, c}`.
fn used(code: &str) -> Names {
    let mut found = Names::new();
    for rest in code.split("crate::").skip(1) {
        let Some(list) = rest.strip_prefix('{') else {
            found.insert(first_name(rest));
            continue;
        };
        let mut depth = 0;
        let mut start = true;
        for (at, character) in list.char_indices() {
            match character {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                _ if start && !character.is_whitespace() => {
                    found.insert(first_name(&list[at..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found
}

fn first_name(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn every_room_is_in_the_table_and_every_row_has_its_room() {
    let rooms: Names = rust(&["src"]).iter().filter_map(|(file, _)| room(file)).collect();
    assert_eq!(table().into_keys().collect::<Names>(), rooms);
}

#[test]
fn a_room_uses_only_the_rooms_of_its_row() {
    let table = table();
    // What `lib.rs` says again of the rooms that everybody uses.
    let again = ["Error", "Kind", "Result"].map(String::from);
    for (file, text) in rust(&["src"]) {
        let Some(room) = room(&file) else { continue };
        for name in used(&code(&text)) {
            let allowed = table[&room].contains(&name) || again.contains(&name);
            assert!(allowed, "{file}: {room} uses {name}, which its row in src/lib.rs does not allow");
        }
    }
}

#[test]
fn no_path_goes_around_the_table() {
    let rooms = table();
    for (file, text) in rust(&["src"]) {
        let code = code(&text);
        for name in rooms.keys().filter(|_| room(&file).is_some()) {
            for way in [format!("super::{name}::"), format!("subdiv_rtl::{name}")] {
                assert!(!code.contains(&way), "{file}: write crate::{name} instead of {way}");
            }
        }
    }
}

#[test]
fn the_table_keeps_hardware_and_reference_apart() {
    let table = table();
    for (room, never) in [
        ("model", &["hdl", "cores", "cosim"][..]),
        ("hdl", &["model", "surface", "cores", "cosim"]),
        ("cores", &["model", "cosim"]),
        ("surface", &["model", "hdl", "cores", "cosim"]),
        ("mesh", &["surface", "model", "hdl", "cores", "cosim"]),
        ("fixed", &["mesh", "surface", "model", "hdl", "cores", "cosim"]),
        ("report", &["mesh", "surface", "model", "hdl", "cores", "cosim"]),
    ] {
        let broken: Vec<_> = never.iter().filter(|name| table[room].contains(**name)).collect();
        assert!(broken.is_empty(), "the table lets {room} use {broken:?}");
    }
}

#[test]
fn the_hardware_takes_from_the_surface_only_what_its_proof_compares_with() {
    for (file, text) in rust(&["src/cores"]) {
        let code = code(&text);
        let taken: Names = code.split("crate::surface::").skip(1).map(first_name).collect();
        let allowed: Names = file.ends_with("/proof.rs").then(|| "basis".into()).into_iter().collect();
        assert!(taken.is_subset(&allowed), "{file} uses {taken:?} of the surface");
    }
}

#[test]
fn the_paths_of_a_use_are_found() {
    let text = "use crate::{\n    cores::{a, b},\n    hdl,\n};\nfn f() { crate::model::g(); }";
    assert_eq!(used(text), ["cores", "hdl", "model"].map(String::from).into());
    assert_eq!(used(&code("    // crate::cores\n//! crate::hdl\n")), Names::new());
}

#[test]
fn no_file_is_longer_than_500_lines() {
    for (file, text) in rust(&["src", "tests", "benches"]) {
        assert!(text.lines().count() <= 500, "{file} has {} lines: split it", text.lines().count());
    }
}

#[test]
fn every_file_says_first_what_it_is_for() {
    for (file, text) in rust(&["src", "tests", "benches"]) {
        assert!(text.starts_with("//! "), "{file} does not begin with a line of //!");
    }
}

#[test]
fn nothing_is_left_for_later() {
    // Put together here, so that this file does not hold them.
    let marks =
        [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("unimple", "mented!"), concat!("to", "do!")];
    let folders =
        ["src", "tests", "benches", "rtl-templates", "testbenches", "tools", "README.md", "Makefile"];
    for (file, text) in folders.iter().flat_map(|folder| texts(folder)) {
        let left = marks.iter().find(|mark| text.contains(**mark));
        assert_eq!(left, None, "{file}");
    }
}

/// The sources must stand by themselves: no paper of the workshop, no folder of somebody's machine.
#[test]
fn no_source_refers_to_what_is_not_in_the_project() {
    let foreign =
        [concat!("MA", "TH.md"), concat!("MA", "TH "), concat!("ARCHITECTURE", ".md"), concat!("/wo", "rk/")];
    for (file, text) in
        ["src", "tests", "benches", "rtl-templates", "testbenches"].into_iter().flat_map(texts)
    {
        let found = foreign.iter().find(|name| text.contains(**name));
        assert_eq!(found, None, "{file}");
    }
}
