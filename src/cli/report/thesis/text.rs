//! The report as tables.

use super::hardware::Storage;
use super::measure::Measured;
use crate::report::table::{Align, Cell, Table, Tone};
use crate::surface::catmull_clark::thesis::{Figure, operators, operators_printed};

const MEASURED: [&str; 5] = [
    "vertices: registers of the core with a unit for each level; the outside vertices uL and uR of a column",
    "  count as columns, what else lies around as fans",
    "clocks: strips of valence 4 in the built-in simulator; before the first column from the first word on, of",
    "  the twelve words of three columns",
    "words: the last mesh below",
];

/// The whole report.
pub fn text(level: u32, valence: u32, figures: &[Figure], measured: &Measured) -> String {
    let differs = |f: &&Figure| f.printed.is_some_and(|printed| printed != f.corrected);
    let notes: Vec<String> = figures
        .iter()
        .filter(differs)
        .map(|f| format!("  {} ({}): {}\n", f.name, f.source.trim_matches(['(', ')']), f.note))
        .collect();
    let how: String = MEASURED.iter().map(|line| format!("  {line}\n")).collect();
    format!(
        "Level {level}, valences up to {valence}\n\n\
         {}\nWhy the printed numbers differ\n\n{}\n\
         How the rest was measured\n\n{how}\n\
         Operators of one coordinate at the finest level, for one column a clock\n\n{}\n\
         What the core keeps\n\n{}\n\
         Meshes: words that are sent, and pointers in software, for each vertex\n\n{}",
        chapter(figures, measured),
        notes.concat(),
        gates(level, valence, measured),
        storage(measured),
        meshes(measured),
    )
}

/// Whole numbers as such, others with one place.
fn number(value: Option<f64>) -> String {
    match value {
        None => String::new(),
        Some(value) if value.fract() == 0.0 => format!("{value:.0}"),
        Some(value) => format!("{value:.1}"),
    }
}

fn chapter(figures: &[Figure], measured: &Measured) -> Table {
    let mut table = Table::new(&[
        ("figure", Align::Left),
        ("source", Align::Left),
        ("printed", Align::Right),
        ("corrected", Align::Right),
        ("measured", Align::Right),
        ("unit", Align::Left),
    ]);
    for figure in figures.iter().filter(|figure| figure.source != "6.4") {
        let wrong = figure.printed.is_some_and(|printed| printed != figure.corrected);
        table.row([
            Cell::from(figure.name),
            Cell::from(figure.source),
            Cell::new(number(figure.printed), if wrong { Tone::Bad } else { Tone::Normal }),
            Cell::from(number(Some(figure.corrected))),
            Cell::from(number(measured.of(figure.quantity))),
            Cell::new(figure.unit, Tone::Faint),
        ]);
    }
    table
}

/// The gate list of 6.4: as printed, counted again, and in the generated core.
fn gates(level: u32, valence: u32, measured: &Measured) -> Table {
    let (old, new, found) =
        (operators_printed(level, valence), operators(level, valence), &measured.operators);
    let mut table = Table::new(&[
        ("operator", Align::Left),
        ("printed", Align::Right),
        ("counted again", Align::Right),
        ("generated", Align::Right),
    ]);
    let adders = |operands: u32| found.adders.get(&operands).copied().unwrap_or(0);
    let more: u64 = found.adders.range(5..).map(|(_, count)| count).sum();
    let mut row = |name: &str, numbers: [u64; 3]| {
        let [printed, counted, generated] = numbers.map(|n| n.to_string());
        table.row([name, &printed, &counted, &generated]);
    };
    row("adders of two inputs", [0, 0, adders(2)]);
    row("adders of three inputs", [old.three_input_adders, new.three_input_adders, adders(3)]);
    row("adders of four inputs", [old.four_input_adders, new.four_input_adders, adders(4)]);
    row("adders of more, the fans", [old.fan_adders, new.fan_adders, more]);
    let two = |four: u64, three: u64, fans: u64| 3 * four + 2 * three + fans * u64::from(valence - 1);
    row(
        "all as adders of two inputs",
        [
            two(old.four_input_adders, old.three_input_adders, old.fan_adders),
            two(new.four_input_adders, new.three_input_adders, new.fan_adders),
            found.two_operand_adders(),
        ],
    );
    row("multipliers by 1/3", [old.multipliers_by_third, new.multipliers_by_third, 0]);
    // The text of 6.4 has four multipliers, which its list leaves out.
    row("multipliers", [4, new.multipliers, found.multipliers]);
    row("tables, for both ends of a column", [old.tables, 2 * new.tables, found.tables.len() as u64]);
    let entries = found.tables.first().copied().unwrap_or(0);
    row("entries of a table", [old.table_entries, new.table_entries, entries]);
    table
}

fn storage(measured: &Measured) -> Table {
    let mut table = Table::new(&[
        ("part", Align::Left),
        ("columns", Align::Right),
        ("fans", Align::Right),
        ("vertices", Align::Right),
        ("bits", Align::Right),
    ]);
    let all = measured.storage.iter().fold(Storage::default(), |all, part| Storage {
        part: "all".into(),
        columns: all.columns + part.columns,
        fans: all.fans + part.fans,
        bits: all.bits + part.bits,
    });
    for part in measured.storage.iter().chain([&all]) {
        let numbers = [part.columns, part.fans, part.columns + part.fans, part.bits].map(|n| n.to_string());
        let [columns, fans, vertices, bits] = &numbers;
        table.row([part.part.as_str(), columns, fans, vertices, bits]);
    }
    table
}

fn meshes(measured: &Measured) -> Table {
    let mut table = Table::new(&[
        ("mesh", Align::Left),
        ("strips", Align::Right),
        ("mean length", Align::Right),
        ("words", Align::Right),
        ("winged edges", Align::Right),
        ("face based", Align::Right),
        ("winged strips", Align::Right),
        ("3 levels finer", Align::Right),
    ]);
    for mesh in &measured.meshes {
        let numbers = [
            mesh.mean_length,
            mesh.words,
            mesh.winged_edge_pointers,
            mesh.face_based_pointers,
            mesh.strip_pointers,
            mesh.strip_pointers_refined,
        ];
        let [length, words, edges, faces, strips, finer] = numbers.map(|x| format!("{x:.2}"));
        table.row([&mesh.mesh, &mesh.strips.to_string(), &length, &words, &edges, &faces, &strips, &finer]);
    }
    table
}
