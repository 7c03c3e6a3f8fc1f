//! The package of a `loop-fd`.

use std::rc::Rc;

use serde_json::{Value, json};

use super::{Draft, Package, assemble};
use crate::cores::loop_fd::proof::{Proof, prove};
use crate::cores::loop_fd::{Columns, Parameters, RegisterForm, build, words};
use crate::cosim::Beat;
use crate::cosim::loop_bench::{self, LoopBench, extra_fraction};
use crate::cosim::loop_trial::{LoopTrial, Packet};
use crate::error::{Error, Kind, Result};
use crate::fixed::{Precision, Reduced, Rounding};
use crate::hdl::{Module, verilog};
use crate::model::loop_fd_clocks;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::precision::{of_patch, total_lsb};

/// The command that generates the core with these parameters.
pub fn command(parameters: Parameters) -> String {
    let Parameters { coordinates, output_fraction, max_level, min_level, registers, precision, .. } =
        parameters;
    let Parameters { chunk, lanes, columns, .. } = parameters;
    let mut command = format!(
        "subdiv-rtl generate loop-fd --coordinates {coordinates} --output-fraction {output_fraction} --max-level {max_level} --registers {registers}"
    );
    if min_level > 0 {
        command += &format!(" --min-level {min_level}");
    }
    if let Some(chunk) = chunk {
        command += &format!(" --chunk {chunk}");
    }
    if let Some(lanes) = lanes {
        command += &format!(" --lanes {lanes}");
    }
    if columns != Columns::Shared {
        command += &format!(" --columns {columns}");
    }
    if let Some(Reduced { fractions, rounding, saturate }) = precision.reduced() {
        let option = if fractions.is_uniform() { "fraction" } else { "fractions" };
        command += &format!(" --{option} {fractions} --rounding {rounding}");
        command += if saturate { " --saturate" } else { "" };
    }
    command
}

/// The core and its files in memory; with `prove_it`, only if the proof holds.
///
/// # Errors
/// A core that cannot be built; a refuted proof, which is a [`crate::Kind::Mismatch`].
pub fn package(parameters: Parameters, prove_it: bool) -> Result<Package> {
    let core = build(parameters)?;
    let proof = if prove_it { Some(proved(&core, parameters)?) } else { None };
    let command = command(parameters);
    let sources = verilog::print(&core, &command)?;
    let dut = loop_bench::device(&core, &sources);
    let (input, expected) = sample(&core, parameters)?;

    let first = loop_bench::latency(&core, parameters.min_level);
    let draft = Draft {
        core: "loop-fd",
        purpose: "Forward-difference engine for Loop subdivision surfaces",
        command,
        parameters: parameters_json(parameters),
        streams: streams(parameters),
        latency: latency(&core, parameters, first),
        first: (first, "the last point of a patch to its first vertex"),
        initiation_interval: initiation_interval(&core, parameters),
        proofs: proofs(proof.as_ref(), parameters),
        input: &input,
        expected: &expected,
    };
    assemble(&core, &dut, draft)
}

/// Vectors that come with the testbench: an octahedron, whose patches are of every kind; a single patch for a
/// core that has no level 0.
fn sample(core: &Rc<Module>, parameters: Parameters) -> Result<(Vec<Beat>, Vec<Beat>)> {
    let c = parameters.coordinates.max() / 2;
    if parameters.min_level > 0 {
        let level = parameters.min_level;
        let finer = 4 * (parameters.max_level - level);
        let points = (0..12).map(|i: i64| [c - i * i * c / 100, i * c / 12, c / 3 - i * c / 9]);
        let points = points.map(|p| p.map(|x| i128::from(x) << finer)).collect();
        let trial = LoopTrial::new(core, parameters, &[Packet { level, points }])?;
        return Ok((trial.input, trial.expected));
    }
    let positions = vec![[c, 0, 0], [0, c, 0], [0, 0, c], [-c, 0, 0], [0, -c, 0], [0, 0, -c]];
    let triangles =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mesh = ControlMesh::new(positions, triangles)?;
    let bench = LoopBench::new(core, parameters, &mesh, parameters.max_level.min(3))?;
    Ok((bench.input, bench.expected))
}

fn parameters_json(parameters: Parameters) -> Value {
    let mut object = json!({
        "coordinates": parameters.coordinates.to_string(),
        "output_fraction": parameters.output_fraction,
        "max_level": parameters.max_level,
        "registers": parameters.registers.count(),
        "register_forms": RegisterForm::ALL.map(RegisterForm::count),
    });
    if parameters.min_level > 0 {
        object["min_level"] = json!(parameters.min_level);
    }
    if let Some(chunk) = parameters.chunk {
        object["chunk"] = json!(chunk);
    }
    if let Some(lanes) = parameters.lanes {
        object["lanes"] = json!(lanes);
        object["columns"] = json!(parameters.columns.to_string());
    }
    if let Some(reduced) = parameters.precision.reduced() {
        let width = |m: u32| words::difference(parameters, reduced, (m - m / 4, m / 4)).width();
        let widths = [0, 1, 2, 3, 4].map(width);
        let error = of_patch(reduced, parameters.max_level);
        let extra = extra_fraction(parameters);
        object["differences"] = json!({
            "fractions": reduced.fractions.all(),
            "widths": widths,
            "register_bits_of_a_coordinate": words::register_bits(parameters),
            "rounding": reduced.rounding.to_string(),
            "saturate": reduced.saturate,
            "error_before_last_rounding": {
                "unit": "of the control coordinates",
                "above": error.above.to_string(),
                "below": error.below.to_string(),
            },
            "bound_lsb": total_lsb(reduced, parameters.max_level, extra),
        });
    }
    object
}

fn streams(parameters: Parameters) -> Value {
    let (max, f) = (parameters.max_level, parameters.coordinates.fraction);
    let (beats, kept, last) = match parameters.lanes {
        None => (
            "for strip i the vertices p(i,j) and p(i+1,j), j = 0 .. 2^rho-i-1, then p(i,2^rho-i) alone"
                .into(),
            "low for the right vertex of the last beat of a strip",
            "last beat of a strip",
        ),
        Some(lanes) => (
            format!(
                "for every {lanes}th strip i, j = 0 .. 2^rho-i: the vertices p(i,j) ... p(i+{lanes},j) that exist"
            ),
            "low for vertices beyond the edge of the patch",
            "last beat of the strips that are sent together",
        ),
    };
    json!({
        "protocol": "AXI4-Stream",
        "s_axis": {
            "packet": "12 beats: the control points (0,-1) (1,-1) (2,-1) (-1,0) (0,0) (1,0) (2,0) (-1,1) (0,1) (1,1) (-1,2) (0,2)",
            "tuser": format!("the level rho of the patch, 0 to {max}"),
            "tlast": "on the twelfth beat; packets of another length or level are dropped whole",
            "fraction_bits": format!("{f} + 4 * ({max} - rho)"),
        },
        "m_axis": {
            "beats": beats,
            "tkeep": kept,
            "tuser": "bit 0: first beat of a patch; bit 1: last beat of a patch",
            "tlast": last,
            "fraction_bits": parameters.output_fraction,
        },
    })
}

fn latency(core: &Rc<Module>, parameters: Parameters, first: u64) -> Value {
    let depths = loop_bench::depths(core);
    let mut object = json!({
        "first_vertex_after_last_point": first,
        "startup": depths.startup,
        "rounding": depths.rounder,
    });
    if parameters.columns == Columns::Buffered {
        // The first column of a patch is kept before a vertex is sent.
        let levels = (parameters.min_level..=parameters.max_level)
            .map(|level| json!({ "level": level, "clocks": loop_bench::latency(core, level) }));
        object["first_vertex_of_levels"] = levels.collect();
    }
    object
}

fn initiation_interval(core: &Rc<Module>, parameters: Parameters) -> Value {
    let depths = loop_bench::depths(core);
    let clocks = |level: u32, patches: usize| {
        loop_fd_clocks::run(&vec![level; patches], depths, &[true], &[true]).total
    };
    let levels: Vec<Value> = (0..=parameters.max_level.min(6))
        .map(|level| {
            json!({
                "level": level,
                "clocks": (clocks(level, 6) - clocks(level, 4)) / 2,
                "beats": depths.beats(level),
            })
        })
        .collect();
    json!({ "clocks_per_beat": 1, "patches": levels })
}

/// The proof; of reduced numbers, it must not find larger errors than the bound of the format.
fn proved(core: &Rc<Module>, parameters: Parameters) -> Result<Proof> {
    let proof = prove(core, parameters)?;
    let (Some(reduced), Some(error)) = (parameters.precision.reduced(), proof.error) else {
        return Ok(proof);
    };
    let bound = total_lsb(reduced, parameters.max_level, extra_fraction(parameters));
    // Half to even the proof takes the correction of a tie in the start-up for an error of its own.
    let allowed = if reduced.rounding == Rounding::HalfEven { 3.0 * bound } else { bound };
    if error.largest() > allowed {
        let what = format!("errors of up to {} units, above the bound of {bound}", error.largest());
        return Err(Error::new(Kind::Mismatch, what).help("the core is wrong; nothing was written"));
    }
    Ok(proof)
}

fn proofs(proof: Option<&Proof>, parameters: Parameters) -> Value {
    let Some(proof) = proof else { return json!({ "linear_forms": { "result": "not run" } }) };
    let statement = match parameters.precision {
        Precision::Exact => {
            "for all inputs, every output coordinate of patches of every level is its exact mask, correctly rounded, and every claimed range holds"
        }
        Precision::Reduced(_) => {
            "for all inputs, every output coordinate of patches of every level is its exact mask up to an error within these bounds, and no register that a vertex depends on overflows; saturation, if any, comes after what is proved and moves a vertex towards the exact one"
        }
    };
    let mut object = json!({
        "statement": statement,
        "result": "proved",
        "patches": proof.patches,
        "coordinates": proof.coordinates,
        "clocks": proof.clocks,
        "claims": proof.claims,
    });
    if let Some(error) = proof.error {
        let number = |(numerator, denominator): (i128, i128)| numerator as f64 / denominator as f64;
        object["error_lsb"] = json!({ "below": number(error.below), "above": number(error.above) });
    }
    json!({ "linear_forms": object })
}
