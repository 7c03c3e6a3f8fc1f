//! What `explore` has found, for people: a table, a plot, a page.

use super::Found;
use crate::error::Result;
use crate::explore::pareto::{Candidate, Price};
use crate::explore::point::Scheme;
use crate::report::page::{Cell as PageCell, Column, Page, Row};
use crate::report::plot::{Axis, Mark, Plot, Point, Scale, Series};
use crate::report::table::{Align, Cell, Table, Tone, thousands};

/// An error in units of the last place.
pub fn lsb(error: f64) -> String {
    match error {
        e if e >= 1e5 => format!("{e:.2e}"),
        e if e >= 100.0 => format!("{e:.1}"),
        e => format!("{e:.4}"),
    }
}

fn worst_case(candidate: &Candidate) -> String {
    candidate.worst_case_lsb.map_or("-".into(), lsb)
}

fn cracks(candidate: &Candidate) -> String {
    match candidate.cracks {
        0 => "0".into(),
        count => format!("{} up to {}", thousands(count), candidate.largest_crack),
    }
}

/// The line that `--recommend` prints.
pub fn advice(candidate: &Candidate, price: Price, target_lsb: f64) -> String {
    format!(
        "{}: error proved to be at most {} lsb (target {target_lsb}), {} {price}: {}",
        candidate.record.label(),
        lsb(candidate.bound_lsb),
        thousands(candidate.price(price)),
        candidate.record.command
    )
}

/// The front as a table, and what there is to say about the rest.
pub fn text(found: &Found) -> String {
    let mut text = String::new();
    let meshes: Vec<&str> = found.meshes.iter().map(String::as_str).collect();
    let designs = found.candidates.len();
    text += &format!("{}: {designs} designs, {} points", meshes.join(", "), found.records.len());
    if found.known > 0 {
        text += &format!(" ({} of them known before)", found.known);
    }
    text += "\n";
    if found.skipped > 0 {
        let reason =
            found.reason.as_ref().map_or(String::new(), |error| format!(", the first: {}", error.what));
        text += &format!("{} combinations skipped that no core has{reason}\n", found.skipped);
    }
    text += &format!("\nNothing is both more accurate and cheaper in {} than\n\n", found.price);
    let mut table = Table::new(&[
        ("design", Align::Left),
        ("proven", Align::Right),
        ("measured", Align::Right),
        ("worst case", Align::Right),
        ("cracks", Align::Right),
        ("register bits", Align::Right),
        ("engines", Align::Right),
        ("LUTs", Align::Right),
        ("MHz", Align::Right),
    ]);
    let mut front: Vec<&Candidate> = found.candidates.iter().filter(|c| c.on_front).collect();
    front.sort_by_key(|c| (c.group(), c.price(found.price)));
    for candidate in front {
        let tone = if candidate.cracks == 0 { Tone::Normal } else { Tone::Faint };
        table.row([
            Cell::from(candidate.record.label()),
            Cell::from(lsb(candidate.bound_lsb)),
            Cell::from(lsb(candidate.error_lsb)),
            Cell::from(worst_case(candidate)),
            Cell::new(cracks(candidate), tone),
            Cell::from(thousands(candidate.register_bits)),
            Cell::from(thousands(candidate.engine_bits)),
            Cell::from(thousands(candidate.luts)),
            Cell::from(format!("{:.0}", candidate.clock_mhz)),
        ]);
    }
    text += &table.to_string();
    text += "\nErrors in units of the last place (lsb). Bits are counted; LUTs and MHz are estimated, with --synth placed.\n";
    if let Some((candidate, target)) = &found.recommended {
        text += &format!("\nRecommended: {}\n", advice(candidate, found.price, *target));
    }
    text
}

/// The front and everything else as a plot: error against cost.
pub fn plot(found: &Found, price: Price) -> Plot {
    let mut series = vec![];
    let point = |candidate: &Candidate, error: f64| Point {
        x: candidate.price(price) as f64,
        y: error,
        note: format!(
            "{}: proven {}, measured {}, {} {price}",
            candidate.record.label(),
            lsb(candidate.bound_lsb),
            lsb(candidate.error_lsb),
            thousands(candidate.price(price))
        ),
        key: candidate.record.point.key.clone(),
    };
    let all = crate::explore::pareto::candidates(&found.records, price);
    let mut groups: Vec<(Scheme, u32)> = all.iter().map(Candidate::group).collect();
    groups.sort();
    groups.dedup();
    let several = groups.len() > 1;
    for (index, group) in groups.into_iter().enumerate() {
        let own: Vec<&Candidate> = all.iter().filter(|candidate| candidate.group() == group).collect();
        let name = |what: &str| match several {
            true => format!("{what}, {} level {}", group.0, group.1),
            false => what.to_string(),
        };
        let beaten = own.iter().filter(|c| !c.on_front).map(|c| point(c, c.bound_lsb));
        series.push(Series::new(name("proven"), Mark::Dots, beaten).colour(index));
        let measured = own.iter().map(|c| point(c, c.error_lsb));
        series.push(Series::new(name("measured"), Mark::Rings, measured).grey());
        let mut front: Vec<&&Candidate> = own.iter().filter(|c| c.on_front).collect();
        front.sort_by_key(|c| c.price(price));
        let front = front.into_iter().map(|c| point(c, c.bound_lsb));
        series.push(Series::new(name("front of the proven"), Mark::Stairs, front).colour(index));
    }
    series.retain(|series| !series.points.is_empty());
    Plot {
        title: format!("{}: error against {price}", found.meshes.join(", ")),
        x: Axis::new(price.to_string(), Scale::Linear),
        y: Axis::new("error (units of the last place)", Scale::Logarithmic),
        series,
    }
}

/// Everything as one page.
///
/// # Errors
/// None that a user can cause.
pub fn page(found: &Found) -> Result<String> {
    let columns = [
        ("design", "coordinates, level, number format, table, registers", true),
        ("proven", "no vertex is farther from the surface, in units of the last place", false),
        ("measured", "the largest error of any vertex of the meshes", false),
        ("rms", "root of the mean square error over the vertices of one mesh", false),
        ("worst case", "the largest error over control points made to be the worst", false),
        ("cracks", "vertices that came out at more than one place", false),
        ("largest", "the largest distance between such places, in units of the last place", false),
        ("register bits", "counted over the whole core", false),
        ("engines", "register bits of the difference engines alone", false),
        ("adder bits", "counted over the whole core", false),
        ("LUTs", "estimated, or placed with --synth", false),
        ("MHz", "estimated for ecp5-85k, or placed and routed with --synth", false),
    ];
    let columns = columns.map(|(name, note, left)| Column { name: name.into(), note: note.into(), left });
    let mut sorted: Vec<&Candidate> = found.candidates.iter().collect();
    sorted.sort_by(|a, b| {
        let prices = (a.group(), a.price(found.price)).cmp(&(b.group(), b.price(found.price)));
        prices.then(a.bound_lsb.total_cmp(&b.bound_lsb))
    });
    let rows = sorted.into_iter().map(|candidate| {
        let record = &candidate.record;
        let number = |value: f64| PageCell::number(lsb(value), value);
        let count = |value: u64| PageCell::number(thousands(value), value as f64);
        Row {
            key: record.point.key.clone(),
            command: record.command.clone(),
            front: candidate.on_front,
            cells: vec![
                PageCell::words(record.label()),
                number(candidate.bound_lsb),
                number(candidate.error_lsb),
                number(record.error_lsb.rms),
                PageCell::number(worst_case(candidate), candidate.worst_case_lsb.unwrap_or(-1.0)),
                count(candidate.cracks),
                count(candidate.largest_crack),
                count(candidate.register_bits),
                count(candidate.engine_bits),
                count(record.cost.adder_bits),
                count(candidate.luts),
                PageCell::number(format!("{:.0}", candidate.clock_mhz), candidate.clock_mhz),
            ],
        }
    });
    let (advice, advised_command) = match &found.recommended {
        None => (String::new(), String::new()),
        Some((candidate, target)) => {
            let text = format!(
                "For a target of {target} lsb: {}, proved to stay within {} lsb.",
                candidate.record.label(),
                lsb(candidate.bound_lsb)
            );
            (text, candidate.record.command.clone())
        }
    };
    let other = if found.price == Price::Luts { Price::RegisterBits } else { Price::Luts };
    let page = Page {
        title: format!("Number formats for {}", found.meshes.join(", ")),
        lead: format!(
            "{} designs, {} points. The bar marks designs that nothing beats in {}.",
            found.candidates.len(),
            found.records.len(),
            found.price
        ),
        advice,
        advised_command,
        plots: vec![plot(found, found.price).svg()?, plot(found, other).svg()?],
        columns: columns.to_vec(),
        rows: rows.collect(),
        footer: "Errors are distances from the exact surface in units of the last place of the output, per \
                 coordinate. Proven bounds hold for every vertex of these meshes; the worst case is measured on \
                 control points derived to come near the bound. Register, adder and memory bits are counted from \
                 the generated core; LUTs and clock are estimates of a simple model, unless the core was \
                 synthesised."
            .into(),
    };
    page.html()
}
