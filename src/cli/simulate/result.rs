//! What `simulate` prints: a table for people, one object for programs, and the verdict.

use serde_json::{Value, json};

use super::{Settings, Source, netlist};
use crate::cli::output::{self, Format};
use crate::cores::loop_fd::Parameters;
use crate::cosim::Outcome;
use crate::cosim::loop_bench::LoopBench;
use crate::error::{Error, Kind, Result};
use crate::fixed::Precision;
use crate::mesh::{Mesh, Rounding};
use crate::report::table::{Align, Cell, Table, Tone, seconds, thousands};
use crate::surface::assembly::Assembly;
use crate::surface::limit_oracle::ErrorLsb;

/// Everything that a run has found out.
pub struct Found<'a> {
    pub settings: &'a Settings,
    pub mesh: &'a Mesh,
    pub notes: Vec<String>,
    pub rounding: Rounding,
    pub parameters: Parameters,
    pub bench: &'a LoopBench,
    pub drawn: &'a Assembly<'a>,
    /// Nothing where vertices are missing.
    pub error: Option<ErrorLsb>,
    /// The proven bound of the error.
    pub bound: f64,
    pub outcomes: &'a [Outcome],
    /// What they ran in place of the core.
    pub netlist: Option<&'a netlist::Facts>,
}

pub enum Verdict {
    Right,
    Wrong(Error),
}

/// Right only if every simulator agrees with the reference, nothing is missing, the error stays below its
/// bound, and no crack is open; patches of reduced numbers may disagree within that bound.
pub fn verdict(found: &Found) -> Verdict {
    let locate = |beat| found.bench.locate(beat);
    if let Some(error) = found.outcomes.iter().find_map(|outcome| outcome.error(&locate)) {
        return Verdict::Wrong(error);
    }
    let drawn = found.drawn;
    let cracked = drawn.cracks() > 0 && found.parameters.precision == Precision::Exact;
    if cracked || drawn.missing() > 0 {
        let what = format!("{} cracks, {} vertices missing", drawn.cracks(), drawn.missing());
        return Verdict::Wrong(Error::new(Kind::Mismatch, what));
    }
    match found.error {
        Some(error) if error.max > found.bound + error.uncertainty => Verdict::Wrong(Error::new(
            Kind::Mismatch,
            format!("the error is {} units, above its proven bound of {}", error.max, found.bound),
        )),
        _ => Verdict::Right,
    }
}

pub fn print(found: &Found, verdict: &Verdict) -> Result<()> {
    match found.settings.format {
        Format::Json => output::print_object("simulate", 1, &object(found)),
        Format::Text => output::print(&text(found, verdict)),
    }
}

fn object(found: &Found) -> Value {
    let counts = found.bench.counts;
    let lsb = (-f64::from(found.parameters.output_fraction)).exp2();
    let source = match &found.settings.source {
        Source::File(path) => json!({ "file": path.display().to_string() }),
        Source::Shape(name) => json!({ "shape": name }),
    };
    json!({
        "mesh": {
            "name": found.mesh.name,
            "source": source,
            "vertices": found.mesh.positions.len(),
            "triangles": found.mesh.faces.len(),
            "notes": found.notes,
        },
        "scheme": "loop",
        "coordinates": {
            "format": found.parameters.coordinates.to_string(),
            "lsb": found.parameters.coordinates.lsb(),
            "rounded": found.rounding.coordinates,
            "largest_rounding": found.rounding.largest,
        },
        "output": { "fraction": found.parameters.output_fraction, "lsb": lsb },
        "level": found.settings.level,
        "max_level": found.parameters.max_level,
        "registers": found.parameters.registers.count(),
        "chunk": found.parameters.chunk,
        "lanes": found.parameters.lanes,
        "columns": found.parameters.columns.to_string(),
        "differences": found.parameters.precision.to_string(),
        "patches": {
            "regular": counts.regular,
            "semi_regular": counts.semi_regular,
            "irregular": counts.irregular,
            "packets": counts.regular_packets + counts.one_packets,
        },
        "triangles": counts.triangles,
        "distinct_vertices": found.drawn.distinct_vertices(),
        "vertices": found.drawn.grid().vertex_count(),
        "cracks": found.drawn.cracks(),
        "largest_crack": found.drawn.largest_crack(),
        "missing": found.drawn.missing(),
        "error_lsb": found.error.map(|e| json!({
            "max": e.max,
            "rms": e.rms,
            "bound": found.bound,
            "at_most_half": e.at_most_half,
            "uncertainty": e.uncertainty,
        })),
        "back_pressure": found.settings.back_pressure.to_string(),
        "input_gaps": found.settings.input_gaps.to_string(),
        "seed": found.settings.seed,
        "netlist": found.netlist.map(netlist::Facts::object),
        "simulators": found.outcomes.iter().map(|o| simulator(o, &|beat| found.bench.locate(beat))).collect::<Vec<_>>(),
    })
}

pub(super) fn simulator(outcome: &Outcome, locate: &dyn Fn(u64) -> String) -> Value {
    let mut object = json!({
        "name": outcome.name,
        "version": outcome.version,
        "beats": outcome.beats,
        "cycles": outcome.clocks,
        "latency": outcome.latency,
        "mismatches": outcome.mismatches,
        "passed": outcome.passed(),
        "build_seconds": outcome.build_seconds,
        "run_seconds": outcome.run_seconds,
        "cached": outcome.cached,
    });
    if !outcome.failures.is_empty() {
        let failures = outcome.failures.iter().map(|f| f.describe(locate)).collect::<Vec<_>>();
        object["failures"] = json!(failures);
        object["vcd"] = json!(outcome.vcd.as_ref().map(|path| path.display().to_string()));
    }
    object
}

fn text(found: &Found, verdict: &Verdict) -> String {
    let (counts, p) = (found.bench.counts, found.parameters);
    let mut facts = Table::new(&[("", Align::Left), ("", Align::Left)]);
    let vertices = thousands(found.mesh.positions.len() as u128);
    let triangles = thousands(found.mesh.faces.len() as u128);
    facts.row(["mesh", &format!("{}, {vertices} vertices, {triangles} triangles", found.mesh.name)]);
    for note in &found.notes {
        facts.row(["", note]);
    }
    let rounded = match found.rounding.coordinates {
        0 => "every control point exact".into(),
        n => format!(
            "{} control coordinates rounded, by at most {:.3e}",
            thousands(n as u128),
            found.rounding.largest
        ),
    };
    facts.row(["coordinates", &format!("{}, unit {:e}; {rounded}", p.coordinates, p.coordinates.lsb())]);
    let differences = match p.precision {
        Precision::Exact => format!("{}-bit differences", p.modulus()),
        reduced => format!("differences of {reduced} fraction bits"),
    };
    let lanes = p.lanes.map_or(String::new(), |count| format!(", lanes: {count}, {} columns", p.columns));
    let chunks = p.chunk.map_or(String::new(), |bits| format!(" in chunks of {bits} bits"));
    let core = format!(
        "loop-fd up to level {}, {} registers, {differences}{chunks}{lanes}",
        p.max_level,
        p.register_count()
    );
    facts.row(["core", &core]);
    if let Some(netlist) = found.netlist {
        facts.row(["netlist", &netlist.text()]);
    }
    let kinds = format!(
        "{} regular, {} semi-regular, {} irregular",
        counts.regular, counts.semi_regular, counts.irregular
    );
    let packets = thousands((counts.regular_packets + counts.one_packets) as u128);
    facts.row(["patches", &format!("{kinds}; {packets} sent")]);
    let surface = format!(
        "level {}: {} triangles, {} distinct vertices",
        found.settings.level,
        thousands(counts.triangles),
        thousands(found.drawn.distinct_vertices() as u128)
    );
    facts.row(["surface", &surface]);
    let cracks = found.drawn.cracks();
    let line = match cracks {
        0 => "0".into(),
        n => format!("{}, at most {} units wide", thousands(n as u128), found.drawn.largest_crack()),
    };
    let allowed = cracks == 0 || p.precision != Precision::Exact;
    facts.row([Cell::from("cracks"), Cell::new(line, tone(allowed))]);
    if let Some(error) = found.error {
        let exact =
            if error.at_most_half { "every vertex correctly rounded" } else { "irregular vertices included" };
        let line = format!(
            "at most {:.6} units (proven {:.6}), rms {:.6}; {exact}",
            error.max, found.bound, error.rms
        );
        facts.row([Cell::from("error"), Cell::new(line, tone(error.max <= found.bound + error.uncertainty))]);
    }

    let runs = runs("vertex pairs", found.outcomes);
    let written = match verdict {
        Verdict::Right => written(found.settings),
        Verdict::Wrong(_) => String::new(),
    };
    format!("{facts}\n{runs}{written}")
}

pub(super) fn tone(good: bool) -> Tone {
    if good { Tone::Good } else { Tone::Bad }
}

/// A row for each simulator; `beats` is what a beat is called.
pub(super) fn runs(beats: &str, outcomes: &[Outcome]) -> Table {
    let mut runs = Table::new(&[
        ("simulator", Align::Left),
        ("version", Align::Left),
        (beats, Align::Right),
        ("clocks", Align::Right),
        ("mismatches", Align::Right),
        ("build", Align::Right),
        ("run", Align::Right),
        ("verdict", Align::Left),
    ]);
    for outcome in outcomes {
        let passed = outcome.passed();
        runs.row([
            Cell::from(outcome.name.clone()),
            Cell::from(outcome.version.clone()),
            Cell::from(thousands(outcome.beats)),
            Cell::from(thousands(outcome.clocks)),
            Cell::new(thousands(outcome.mismatches), tone(outcome.mismatches == 0)),
            if outcome.cached {
                Cell::new("cached", Tone::Faint)
            } else {
                Cell::from(seconds(outcome.build_seconds))
            },
            Cell::from(seconds(outcome.run_seconds)),
            Cell::new(if passed { "equal, bit for bit" } else { "DIFFERS" }, tone(passed)),
        ]);
    }
    runs
}

/// Where the results are.
pub(super) fn written(settings: &Settings) -> String {
    let picture = settings.picture.as_ref().map(|p| &p.file);
    let files = [
        ("fine mesh", settings.fine_mesh.as_ref()),
        ("picture", picture),
        ("waveform", settings.vcd.as_ref()),
    ];
    let lines: Vec<String> = files
        .into_iter()
        .filter_map(|(what, path)| path.map(|path| format!("wrote the {what} to {}\n", path.display())))
        .collect();
    if lines.is_empty() { String::new() } else { format!("\n{}", lines.concat()) }
}
