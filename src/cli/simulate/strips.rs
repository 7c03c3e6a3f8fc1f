//! `simulate --scheme catmull-clark`: a quad mesh, cut into strips, through the strip core.

use std::mem::take;

use serde_json::json;

use super::result::{runs, simulator, tone, written};
use super::run::{Runs, load, run_all, stimulus};
use super::strip_picture::{Drawn, draw};
use super::{Settings, Source, netlist};
use crate::cli::output::{self, Format as Output};
use crate::cores::cc_strip::{Parameters, Precision, build};
use crate::cosim::strip_bench::{StripBench, reference_parameters};
use crate::cosim::{Outcome, device};
use crate::error::{Error, Kind, Result};
use crate::fixed::{Format, Rounding};
use crate::hdl::verilog;
use crate::mesh::{self, FineMesh, Mesh};
use crate::package;
use crate::report::table::{Align, Cell, Table, thousands};
use crate::surface::catmull_clark::assembly::QuadAssembly;
use crate::surface::catmull_clark::control::control;
use crate::surface::catmull_clark::error_bound::{Accuracy, error_bound_lsb};
use crate::surface::catmull_clark::oracle::{QuadOracle, Target};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Boundary, Rings};
use crate::surface::limit_oracle::ErrorLsb;

/// Everything that a run has found out.
struct Found<'a> {
    settings: &'a Settings,
    mesh: &'a Mesh,
    quads: &'a QuadMesh,
    parameters: Parameters,
    bench: &'a StripBench,
    drawn: &'a QuadAssembly<'a>,
    oracle: &'a QuadOracle,
    target: Target,
    /// Nothing where vertices are missing.
    error: Option<ErrorLsb>,
    bound: f64,
    outcomes: &'a [Outcome],
    netlist: Option<&'a netlist::Facts>,
}

/// Runs everything and prints the result; files are written only when all is right.
///
/// # Errors
/// Of kind `Mismatch` when a bit differs.
pub fn run(settings: &Settings) -> Result<()> {
    if !(1..=7).contains(&settings.level) {
        return Err(
            Error::usage(format!("level {} of a strip", settings.level)).help("choose --level 1 to 7")
        );
    }
    let (mesh, _) = load(settings)?;
    let wanted = match settings.coordinates {
        Some(format) => format,
        None => mesh::widest_format(&mesh, 24)?,
    };
    let quantised = mesh::quantise(&mesh, wanted)?;
    let boundary = Boundary::Ghosts;
    let quads = control(&mesh, &quantised, boundary.corners(), 0)?.mesh;
    let rings = Rings::new(&quads, boundary)?;
    // Ghosts may lie outside of the coordinates' range; the core has the integer bits for them.
    let more = rings.width().saturating_sub(wanted.width());
    let coordinates = Format { integer: wanted.integer + more, ..wanted };
    let max_valence = settings.max_valence.unwrap_or(rings.largest_valence().max(4) as u32);
    let topology = quads.topology();
    let above = |v: &u32| topology.valence(*v) > max_valence;
    if let Some(v) = (0..topology.vertex_count()).find(above) {
        // A step that makes quads of other polygons puts new vertices behind those of the file.
        let (number, place) = match (v as usize) < mesh.positions.len() {
            true => (mesh.vertex_number(v), mesh.vertex_place(v)),
            false => (v, mesh.place().to_string()),
        };
        let valence = topology.valence(v);
        let what = format!("vertex {number} has valence {valence}, more than the core's {max_valence}");
        return Err(Error::input(what).at(place).help("raise --max-valence (up to 16)"));
    }
    let plain = Parameters {
        output_fraction: settings.output_fraction.unwrap_or(coordinates.fraction),
        precision: settings.guard.map_or(Precision::Exact, Precision::Guard),
        rounding: settings.rounding.unwrap_or(Rounding::HalfUp),
        ..Parameters::exact(coordinates, settings.strip_levels.unwrap_or(settings.level), max_valence)
    };
    let parameters = settings.strip_output.on(settings.units.on(plain)).check()?;

    let core = build(parameters)?;
    let mut bench = StripBench::new(&core, parameters, settings.level, &quads, &rings)?;
    let sources = verilog::print(&core, &package::cc_strip::command(parameters))?;
    let mut vectors = stimulus(settings, take(&mut bench.input), take(&mut bench.expected));
    vectors.expected_clocks = bench.clocks(&vectors);
    let Runs { outcomes, netlist } = run_all(settings, &core, &device(&core, &sources, None), vectors)?;

    let drawn = bench.assemble(&quads, outcomes.first().map_or(&[], |outcome| &outcome.received))?;
    let oracle = QuadOracle::new(&quads, settings.level, boundary.corners())?;
    let reference = reference_parameters(parameters);
    let positions = drawn.positions();
    let target = if parameters.limit { Target::Limit } else { Target::Refined };
    let error = positions.as_ref().map(|p| oracle.error(p, target, reference.extra_fraction)).transpose()?;
    let accuracy = Accuracy {
        width: coordinates.width(),
        extra_fraction: reference.extra_fraction,
        levels: settings.level,
        numbers: reference.numbers,
        rounding: reference.rounding,
        table_bits: parameters.table_bits,
        largest_irregular_valence: quads.largest_irregular_valence(),
        limit: parameters.limit,
    };
    let found = Found {
        settings,
        mesh: &mesh,
        quads: &quads,
        parameters,
        bench: &bench,
        drawn: &drawn,
        oracle: &oracle,
        target,
        error,
        bound: error_bound_lsb(&accuracy),
        outcomes: &outcomes,
        netlist: netlist.as_ref(),
    };
    let verdict = verdict(&found);
    if let (Ok(()), Some(positions)) = (&verdict, positions) {
        write(&found, positions)?;
    }
    print(&found, verdict.is_ok())?;
    verdict
}

fn verdict(found: &Found) -> Result<()> {
    let locate = |beat| found.bench.locate(beat);
    if let Some(error) = found.outcomes.iter().find_map(|outcome| outcome.error(&locate)) {
        return Err(error);
    }
    let (cracks, missing) = (found.drawn.cracks(), found.drawn.missing());
    if cracks > 0 || missing > 0 {
        return Err(Error::new(Kind::Mismatch, format!("{cracks} cracks, {missing} vertices missing")));
    }
    match found.error {
        Some(error) if error.max > found.bound + error.uncertainty => Err(Error::new(
            Kind::Mismatch,
            format!("the error is {} units, above its proven bound of {}", error.max, found.bound),
        )),
        _ => Ok(()),
    }
}

fn write(found: &Found, positions: Vec<[i64; 3]>) -> Result<()> {
    let (settings, p) = (found.settings, found.parameters);
    let format = Format { integer: p.coordinates.integer, fraction: p.output_fraction };
    if let Some(path) = &settings.fine_mesh {
        let faces = found.drawn.grid().quads().collect();
        mesh::write(path, &FineMesh { format, positions: positions.clone(), faces })?;
    }
    if let Some(picture) = &settings.picture {
        let target = found.target;
        let extra = reference_parameters(p).extra_fraction;
        let error = |vertex: usize| found.oracle.vertex_error(vertex, positions[vertex], target, extra);
        let drawn = Drawn {
            grid: found.drawn.grid(),
            strips: found.bench.strips(),
            control: found.mesh,
            positions: &positions,
            format,
            error: &error,
        };
        let image = draw(&drawn, picture)?;
        crate::files::write_whole(&picture.file, &image)?;
    }
    Ok(())
}

fn print(found: &Found, right: bool) -> Result<()> {
    match found.settings.format {
        Output::Json => output::print_object("simulate", 1, &object(found)),
        Output::Text => output::print(&text(found, right)),
    }
}

fn object(found: &Found) -> serde_json::Value {
    let (p, statistics, locate) =
        (found.parameters, &found.bench.statistics, |beat: u64| found.bench.locate(beat));
    let source = match &found.settings.source {
        Source::File(path) => json!({ "file": path.display().to_string() }),
        Source::Shape(name) => json!({ "shape": name }),
    };
    json!({
        "mesh": {
            "name": found.mesh.name,
            "source": source,
            "vertices": found.mesh.positions.len(),
            "faces": found.mesh.faces.len(),
            "quads": found.quads.quads().len(),
        },
        "scheme": "catmull-clark",
        "coordinates": { "format": p.coordinates.to_string(), "lsb": p.coordinates.lsb() },
        "output": { "fraction": p.output_fraction },
        "level": found.settings.level,
        "max_valence": p.max_valence,
        "precision": reference_parameters(p).numbers.to_string(),
        "rounding": p.rounding.to_string(),
        "schedule": p.schedule.to_string(),
        "positions": if p.limit { "limit" } else { "refined" },
        "strips": {
            "count": statistics.strips,
            "mean_length": statistics.mean_length(),
            "words_per_vertex": statistics.words_per_vertex(),
        },
        "quads": found.drawn.grid().quad_count(),
        "distinct_vertices": found.drawn.distinct_vertices(),
        "vertices": found.drawn.grid().vertex_count(),
        "cracks": found.drawn.cracks(),
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
        "simulators": found.outcomes.iter().map(|o| simulator(o, &locate)).collect::<Vec<_>>(),
    })
}

fn text(found: &Found, right: bool) -> String {
    let (p, statistics) = (found.parameters, &found.bench.statistics);
    let mut facts = Table::new(&[("", Align::Left), ("", Align::Left)]);
    let faces = thousands(found.mesh.faces.len() as u128);
    facts.row([
        "mesh",
        &format!("{}, {} vertices, {faces} faces", found.mesh.name, found.mesh.positions.len()),
    ]);
    facts.row(["coordinates", &format!("{}, unit {:e}", p.coordinates, p.coordinates.lsb())]);
    let numbers = reference_parameters(p).numbers;
    let core = format!("cc-strip of level {}, valences up to {}, {numbers}", p.levels, p.max_valence);
    facts.row(["core", &core]);
    if let Some(netlist) = found.netlist {
        facts.row(["netlist", &netlist.text()]);
    }
    facts.row(["vertices", if p.limit { "points of the limit surface" } else { "refined control points" }]);
    let strips = format!(
        "{} of {:.1} quads on average, {:.2} words sent for each vertex",
        statistics.strips,
        statistics.mean_length(),
        statistics.words_per_vertex()
    );
    facts.row(["strips", &strips]);
    let quads = thousands(found.drawn.grid().quad_count() as u128);
    let vertices = thousands(found.drawn.distinct_vertices() as u128);
    facts.row(["mesh drawn", &format!("level {}: {quads} quads, {vertices} distinct vertices", p.levels)]);
    let cracks = found.drawn.cracks();
    facts.row([Cell::from("cracks"), Cell::new(cracks.to_string(), tone(cracks == 0))]);
    if let Some(error) = found.error {
        let line =
            format!("at most {:.6} units (proven {:.6}), rms {:.6}", error.max, found.bound, error.rms);
        facts.row([Cell::from("error"), Cell::new(line, tone(error.max <= found.bound + error.uncertainty))]);
    }
    let files = if right { written(found.settings) } else { String::new() };
    format!("{facts}\n{}{files}", runs("columns", found.outcomes))
}
