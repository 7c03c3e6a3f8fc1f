//! `synth --compare FILE.toml`: several configurations side by side.
//!
//! The keys of a `[[configuration]]` are the options of the command line, and are read as such: what `generate` takes
//! can be compared. Keys before the first configuration are options of all of them.

use std::path::Path;

use serde_json::json;
use toml::{Table as Toml, Value};

use super::show::rate;
use super::{Core, Work, measured, write};
use crate::cli::output::{self, Format};
use crate::error::{Error, Result};
use crate::fpga::Report;
use crate::report::plot::{Axis, Mark, Plot, Point, Scale, Series};
use crate::report::table::{Align, Table, thousands};

/// One configuration.
struct Entry {
    name: String,
    core: Core,
}

/// Measures all and shows them.
pub(super) fn run(file: &Path, work: &Work, folder: Option<&Path>) -> Result<()> {
    let text = std::fs::read_to_string(file).map_err(|error| {
        Error::input(format!("the configurations cannot be read: {error}")).at(file.display())
    })?;
    let entries = entries(&text).map_err(|error| error.at(file.display()))?;
    let mut found = vec![];
    for (index, Entry { name, core }) in entries.iter().enumerate() {
        // The command line beats the file.
        let own = core.work();
        let work = Work {
            device: work.device.clone().or_else(|| own.device.clone()),
            seeds: work.seeds.or(own.seeds),
            clock: work.clock.or(own.clock),
            ..work.clone()
        };
        let label = format!("{} of {}, {name}: ", index + 1, entries.len());
        found.push((name.clone(), measured(&label, &core.subject()?, &work.options()?)?));
    }
    let rows: Vec<_> = found.iter().map(|(name, report)| json!({ "name": name, "report": report })).collect();
    let fields = json!({ "configurations": rows });
    if let Some(folder) = folder {
        write(folder, "synth.json", &output::object("synth-compare", 1, &fields)?)?;
        write(folder, "synth.md", &markdown(&found))?;
        write(folder, "synth.svg", &plot(&found).svg()?)?;
    }
    match work.format.format {
        Format::Text => output::print(&table(&found)),
        Format::Json => output::print_object("synth-compare", 1, &fields),
    }
}

fn entries(text: &str) -> Result<Vec<Entry>> {
    let mut file: Toml = toml::from_str(text).map_err(|error| {
        Error::input(format!("no TOML: {}", error.message()))
            .help("write one 'key = value' a line, and [[configuration]] above each configuration")
    })?;
    let configurations = match file.remove("configuration") {
        Some(Value::Array(all)) if !all.is_empty() => all,
        _ => return Err(Error::usage("there is no [[configuration]]").help("see 'subdiv-rtl synth --help'")),
    };
    let mut entries = vec![];
    for (index, configuration) in configurations.into_iter().enumerate() {
        let Value::Table(mut own) = configuration else {
            return Err(Error::usage(format!("configuration {} is no table", index + 1)));
        };
        let refuse = |what: String| Error::usage(format!("configuration {}: {what}", index + 1));
        let mut all = file.clone();
        let name = own.remove("name").and_then(|name| name.as_str().map(String::from));
        all.extend(own);
        let core = all.remove("core").and_then(|core| core.as_str().map(String::from));
        let core = core.ok_or_else(|| refuse("it has no 'core'".into()))?;
        let words = words(&all).map_err(|key| refuse(format!("'{key}' is no text, number or truth")))?;
        let name = name.unwrap_or_else(|| format!("{core} {}", words.join(" ").replace("--", "")));
        let core = super::core(std::iter::once(core).chain(words))
            .map_err(|error| Error { what: refuse(error.what.clone()).what, ..error })?;
        entries.push(Entry { name, core });
    }
    Ok(entries)
}

/// Options as words; the key of a value that cannot be one.
fn words(table: &Toml) -> Result<Vec<String>, String> {
    let mut words = vec![];
    for (key, value) in table {
        let text = match value {
            Value::Boolean(true) => {
                words.push(format!("--{key}"));
                continue;
            }
            Value::Boolean(false) => continue,
            Value::String(text) => text.clone(),
            Value::Integer(number) => number.to_string(),
            Value::Float(number) => number.to_string(),
            _ => return Err(key.clone()),
        };
        words.push(format!("--{key}={text}"));
    }
    Ok(words)
}

const COLUMNS: [&str; 10] = [
    "configuration",
    "device",
    "MHz",
    "least",
    "LUT",
    "FF",
    "block RAM",
    "DSP",
    "a clock for 1000 LUT",
    "a second",
];

fn rows(found: &[(String, Report)]) -> impl Iterator<Item = [String; 10]> {
    found.iter().map(|(name, report)| {
        [
            name.clone(),
            report.device.clone(),
            format!("{:.1}", report.clock.median),
            format!("{:.1}", report.clock.min),
            thousands(report.area.luts),
            thousands(report.area.flip_flops),
            report.area.block_rams.to_string(),
            report.area.dsps.to_string(),
            report.per_clock_per_1000_luts.to_string(),
            format!("{}{}", rate(report.per_second), report.throughput.what),
        ]
    })
}

fn table(found: &[(String, Report)]) -> String {
    let mut table = Table::new(&COLUMNS.map(|name| {
        (name, if ["configuration", "device"].contains(&name) { Align::Left } else { Align::Right })
    }));
    rows(found).for_each(|row| {
        table.row(row);
    });
    table.to_string()
}

fn markdown(found: &[(String, Report)]) -> String {
    let mut text = format!("| {} |\n|---|---|{}\n", COLUMNS.join(" | "), "---:|".repeat(COLUMNS.len() - 2));
    for row in rows(found) {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}

/// Clock against area, one series for each configuration.
fn plot(found: &[(String, Report)]) -> Plot {
    let series = found.iter().enumerate().map(|(index, (name, report))| {
        let point = |mhz: f64| Point {
            x: report.area.luts as f64,
            y: mhz,
            note: format!("{name}: {mhz:.1} MHz, {} LUT", report.area.luts),
            key: name.clone(),
        };
        let seeds = report.clock.seeds.iter().map(|seed| point(seed.mhz));
        Series::new(name.clone(), Mark::Line, seeds).colour(index)
    });
    Plot {
        title: "Clock against area, every seed".into(),
        x: Axis::new("LUT", Scale::Linear),
        y: Axis::new("clock (MHz)", Scale::Linear),
        series: series.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_the_options_of_the_command_line() {
        let text = "seeds = 3\n[[configuration]]\ncore = \"loop-fd\"\nmax-level = 2\ncoordinates = \"Q4.4\"\n\
                    [[configuration]]\nname = \"strips\"\ncore = \"cc-strip\"\nlimit = true\nseeds = 1\n";
        let entries = entries(text).unwrap();
        assert_eq!((entries[0].core.work().seeds, entries[1].core.work().seeds), (Some(3), Some(1)));
        assert!(entries[0].name.starts_with("loop-fd") && entries[1].name == "strips");
        let Core::LoopFd(one) = &entries[0].core else { panic!("another core") };
        assert_eq!(one.core.max_level, Some(2));
    }

    #[test]
    fn mistakes_name_their_configuration() {
        for (text, part) in [
            ("[[configuration]]\ncore = \"loop-fd\"\nmax-levl = 2", "configuration 1: unexpected argument"),
            ("[[configuration]]\nmax-level = 2", "has no 'core'"),
            ("[[configuration]]\ncore = \"loop-fd\"\nmax-level = [1]", "is no text"),
            ("seeds = 2", "no [[configuration]]"),
        ] {
            let error = entries(text).err().unwrap();
            assert!(error.what.contains(part) && error.exit_status() == 2, "{error}");
        }
        assert_eq!(entries("seeds = ").err().unwrap().exit_status(), 3);
    }
}
