//! What `synth` has measured, for people.

use crate::fpga::{Area, Report};
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
    let seeds: Vec<String> = clock.seeds.iter().map(|seed| format!("{:.1}", seed.mhz)).collect();
    let mut facts = vec![
        ("core".to_string(), report.command.replacen("subdiv-rtl generate ", "", 1)),
        ("device".into(), format!("{} ({})", report.device, report.part)),
        ("tools".into(), format!("{}; {}", report.yosys, report.nextpnr)),
        (
            "clock".into(),
            format!(
                "median {:.1} MHz, least {:.1} MHz over {} ({}); asked for {} MHz",
                clock.median,
                clock.min,
                if seeds.len() == 1 { "1 seed".into() } else { format!("{} seeds", seeds.len()) },
                seeds.join(", "),
                clock.target
            ),
        ),
        ("area".into(), area_text(area, Some(report.carry_cells))),
    ];
    if clock.seeds.iter().any(|seed| seed.mhz != seed.reported_mhz) {
        let reported: Vec<String> =
            clock.seeds.iter().map(|seed| format!("{:.1}", seed.reported_mhz)).collect();
        let why = "which counts the upper halves of carries as lower ones";
        facts.insert(4, ("reported".into(), format!("{} MHz by nextpnr, {why}", reported.join(", "))));
    }
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
