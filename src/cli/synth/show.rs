//! What `synth` has measured, for people.

use crate::fpga::{Area, Clock, Report, SeedClock};
use crate::report::table::{Align, Table, thousands};

/// Thousands, millions, billions a second.
pub fn rate(value: f64) -> String {
    match value {
        v if v >= 1e9 => format!("{:.2} G", v / 1e9),
        v if v >= 1e6 => format!("{:.1} M", v / 1e6),
        v => format!("{v:.0}"),
    }
}

/// Facts in two columns.
fn facts(report: &Report) -> Vec<(String, String)> {
    let Report { clock, area, throughput, critical_path: path, .. } = report;
    let what = &throughput.what;
    let mut facts = vec![
        ("core".to_string(), report.command.replacen("subdiv-rtl generate ", "", 1)),
        ("device".into(), format!("{} ({})", report.device, report.part)),
        ("tools".into(), format!("{}; {}", report.yosys, report.nextpnr)),
    ];
    facts.extend(clocks(clock));
    facts.push(("area".into(), area_text(area, Some(report.carry_cells))));
    if let Some(estimate) = &report.estimate {
        let off = |error: f64| format!("{:+.1} %", 100.0 * error);
        facts.push((
            "estimate".into(),
            format!(
                "{} LUT ({}), {} FF ({}), {:.1} MHz ({})",
                thousands(estimate.luts),
                off(estimate.luts_error),
                thousands(estimate.flip_flops),
                off(estimate.flip_flops_error),
                estimate.clock_mhz,
                off(estimate.clock_error)
            ),
        ));
    }
    if let Some(rest) = &report.area_without_startup {
        facts.push(("without start-up".into(), area_text(rest, None)));
    }
    facts.push(("throughput".into(), {
        let per = format!("{} {what} a clock", (1000.0 * throughput.per_clock).round() / 1000.0);
        let density = report.per_clock_per_1000_luts_without_startup;
        let rest = density.map(|rest| format!(" ({rest} without start-up)")).unwrap_or_default();
        let second = rate(report.per_second);
        format!("{per}, {second} a second, {} a clock for 1000 LUT{rest}", report.per_clock_per_1000_luts)
    }));
    let engines = report.engines_held.map(|count| format!(", {count} engines beside one start-up"));
    facts.push((
        "the device holds".into(),
        format!("{} cores{}", report.cores_held, engines.unwrap_or_default()),
    ));
    facts.push((
        "critical path".into(),
        format!(
            "{} -> {}, {:.2} ns logic, {:.2} ns routing",
            path.from, path.to, path.logic_ns, path.routing_ns
        ),
    ));
    if path.through.len() > 1 {
        facts.push(("through".into(), path.through.join(", ")));
    }
    facts
}

/// Those of all seeds, and where they come from.
fn clocks(clock: &Clock) -> Vec<(String, String)> {
    let list = |mhz: fn(&SeedClock) -> f64| {
        let all: Vec<String> = clock.seeds.iter().map(|seed| format!("{:.1}", mhz(seed))).collect();
        all.join(", ")
    };
    let count = clock.seeds.len();
    let text = format!(
        "median {:.1} MHz, least {:.1} MHz over {count} seed{} ({}); asked for {} MHz",
        clock.median,
        clock.min,
        if count == 1 { "" } else { "s" },
        list(|seed| seed.mhz),
        clock.target
    );
    let mut facts = vec![("clock".to_string(), text)];
    if clock.seeds.iter().any(|seed| seed.mhz != seed.reported_mhz) {
        let reported = list(|seed| seed.reported_mhz);
        let why = "which counts the upper halves of carries as lower ones";
        facts.push(("reported".into(), format!("{reported} MHz by nextpnr, {why}")));
    }
    let remarks = clock.seeds.iter().filter_map(|seed| Some((seed.seed, seed.remark.clone()?)));
    facts.extend(remarks.map(|(seed, remark)| (format!("clock of seed {seed}"), remark)));
    facts
}

fn area_text(area: &Area, carries: Option<u64>) -> String {
    let carries = carries.map(|count| format!("{} carry cells, ", thousands(count))).unwrap_or_default();
    format!(
        "{} LUT, {} FF, {carries}{} block RAM, {} DSP",
        thousands(area.luts),
        thousands(area.flip_flops),
        area.block_rams,
        area.dsps
    )
}

const COUNTED: &str = "Counted are the cells that are placed, without those of the harness around the core; a carry \
                       cell is two LUT. Units are counted as synthesised.";

fn unit_rows(report: &Report) -> impl Iterator<Item = [String; 6]> {
    report.units.iter().map(|unit| {
        let Area { luts, flip_flops, block_rams, dsps } = unit.area;
        [
            unit.name.clone(),
            thousands(luts),
            thousands(flip_flops),
            thousands(unit.carry_cells),
            block_rams.to_string(),
            dsps.to_string(),
        ]
    })
}

const COLUMNS: [&str; 6] = ["unit", "LUT", "FF", "carry", "block RAM", "DSP"];

pub fn text(report: &Report) -> String {
    let mut list = Table::new(&[("", Align::Left), ("", Align::Left)]);
    for (name, value) in facts(report) {
        list.row([name, value]);
    }
    let columns = COLUMNS.map(|name| (name, if name == "unit" { Align::Left } else { Align::Right }));
    let mut units = Table::new(&columns);
    unit_rows(report).for_each(|row| {
        units.row(row);
    });
    format!("{list}\n{units}\n{COUNTED}\n")
}

pub fn markdown(report: &Report) -> String {
    let mut text = format!("# {} on {}\n\n| | |\n|---|---|\n", report.core, report.device);
    for (name, value) in facts(report) {
        text += &format!("| {name} | {value} |\n");
    }
    text += &format!("\n| {} |\n|---|---:|---:|---:|---:|---:|\n", COLUMNS.join(" | "));
    for row in unit_rows(report) {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text + &format!("\n{COUNTED}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clocks_say_where_they_come_from() {
        let seed = |seed, mhz, reported_mhz| SeedClock { seed, mhz, reported_mhz, remark: None };
        let of = |seeds: &[SeedClock]| {
            clocks(&Clock { target: 300.0, min: 250.0, median: 255.0, seeds: seeds.into() })
        };
        let plain = of(&[seed(1, 250.0, 250.0)]);
        let text = "median 255.0 MHz, least 250.0 MHz over 1 seed (250.0); asked for 300 MHz";
        assert_eq!(plain, [("clock".to_string(), text.to_string())]);

        let doubtful = SeedClock { remark: Some("as reported".into()), ..seed(2, 260.0, 260.0) };
        let facts = of(&[seed(1, 250.0, 230.0), doubtful]);
        assert!(facts[0].1.contains("over 2 seeds (250.0, 260.0)"), "{facts:?}");
        assert!(facts[1].1.starts_with("230.0, 260.0 MHz by nextpnr"), "{facts:?}");
        assert_eq!(facts[2], ("clock of seed 2".into(), "as reported".into()));
    }
}
