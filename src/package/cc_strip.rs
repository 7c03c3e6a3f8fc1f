//! The package of a `cc-strip`.

use serde_json::{Value, json};

use super::{Draft, Package, assemble};
use crate::cores::cc_strip::finish::{Kind, Normals};
use crate::cores::cc_strip::{Parameters, Precision, Schedule, build, finish_proof, proof, stored_vertices};
use crate::cosim::device;
use crate::cosim::strip_bench::{StripBench, protocol, reference_parameters};
use crate::error::Result;
use crate::fixed::Rounding;
use crate::hdl::verilog;
use crate::model::cc_strip_clocks;
use crate::surface::catmull_clark::error_bound::{Accuracy, error_bound_lsb};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Boundary, Rings};

/// The command that generates the core with these parameters.
pub fn command(parameters: Parameters) -> String {
    let Parameters { coordinates, output_fraction, levels, max_valence, table_bits, precision, .. } =
        parameters;
    let guard = match precision {
        Precision::Exact => String::new(),
        Precision::Guard(bits) => format!(" --guard {bits}"),
    };
    let mut more = guard;
    if parameters.rounding != Rounding::HalfUp {
        more += &format!(" --rounding {}", parameters.rounding);
    }
    if parameters.schedule != Schedule::Pipelined {
        more += &format!(" --schedule {}", parameters.schedule);
    }
    if parameters.folded {
        more += " --fold";
    }
    if let Some(rows) = parameters.rows_per_clock {
        more += &format!(" --rows-per-clock {rows}");
    }
    if parameters.registered {
        more += " --registered";
    }
    if parameters.axes_in_turn > 0 {
        more += &format!(" --axes-in-turn {}", parameters.axes_in_turn);
    }
    if parameters.limit {
        more += " --limit";
    }
    if let Some(Normals { kind, point_fraction, unit }) = parameters.normals {
        let kind = if kind == Kind::Faces { "faces" } else { "limit" };
        more += &format!(" --normals {kind} --normal-fraction {point_fraction}");
        if let Some(bits) = unit {
            more += &format!(" --unit-normals {bits}");
        }
    }
    if let Some(log_columns) = parameters.longitudinal {
        more += &format!(" --row-major {log_columns}");
    }
    format!(
        "subdiv-rtl generate cc-strip --coordinates {coordinates} --output-fraction {output_fraction} \
         --max-level {levels} --max-valence {max_valence} --table {table_bits}{more}"
    )
}

/// The core and its files in memory; with `prove_it`, only if the proof holds.
///
/// # Errors
/// A core that cannot be built; a refuted proof, which is a [`crate::Kind::Mismatch`].
pub fn package(parameters: Parameters, prove_it: bool) -> Result<Package> {
    let core = build(parameters)?;
    let proof = if prove_it { Some(Proofs::of(parameters)?) } else { None };
    let command = command(parameters);
    let sources = verilog::print(&core, &command)?;
    let dut = device(&core, &sources, None);
    let (mesh, rings) = sample(parameters)?;
    let bench = StripBench::new(&core, parameters, parameters.levels, &mesh, &rings)?;

    let protocol = protocol(&core, parameters);
    let first = cc_strip_clocks::latency(protocol);
    let draft = Draft {
        core: "cc-strip",
        purpose: "Catmull-Clark subdivision of quad strips by a sliding window",
        command,
        parameters: parameters_json(parameters, stored_vertices(&core, parameters)?),
        streams: streams(parameters),
        latency: json!({ "first_beat_after_first_word": first }),
        first: (first, "the first word of a strip to its first beat"),
        initiation_interval: json!({
            "clocks_per_input_column": cc_strip_clocks::clocks_per_column(protocol),
            "where": "strips of the finest level, valence 4, no stalls",
        }),
        proofs: proofs(proof.as_ref()),
        input: &bench.input,
        expected: &bench.expected,
    };
    assemble(&core, &dut, draft)
}

fn parameters_json(parameters: Parameters, stored: u64) -> Value {
    json!({
        "coordinates": parameters.coordinates.to_string(),
        "output_fraction": parameters.output_fraction,
        "levels": parameters.levels,
        "max_valence": parameters.max_valence,
        "table_bits": parameters.table_bits,
        "precision": format!("{:?}", parameters.precision),
        "rounding": parameters.rounding.to_string(),
        "schedule": parameters.schedule.to_string(),
        "folded": parameters.folded,
        "rows_per_clock": parameters.rows_per_clock,
        "registered": parameters.registered,
        "axes_in_turn": parameters.axes_in_turn,
        "stored_vertices": stored,
        "positions": if parameters.limit { "limit" } else { "refined" },
        "normals": parameters.normals.map(|n| format!("{n:?}")),
        "row_major": parameters.longitudinal.map(|log| 1u32 << log),
        "error_lsb": { "bound": bound(parameters) },
    })
}

/// Vectors that come with the testbench: a cube, whose vertices all have valence 3.
fn sample(parameters: Parameters) -> Result<(QuadMesh, Rings)> {
    let c = parameters.coordinates.max() / 2;
    let corner = |i: i64| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { c } else { -c });
    let quads = vec![[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mesh = QuadMesh::new((0..8).map(corner).collect(), quads)?;
    let rings = Rings::new(&mesh, Boundary::Ghosts)?;
    Ok((mesh, rings))
}

fn streams(parameters: Parameters) -> Value {
    json!({
        "protocol": "AXI4-Stream",
        "s_axis": {
            "strip": "columns -1 .. M + 1 of a strip of M quads, the first and the last are guards; tlast on its last word",
            "column": "top vertex, what lies outside of it, bottom vertex, what lies outside of it",
            "outside": "valence 4 and more: the fan a_1, x_2, a_2, ...; valence 3 and guards: the outside vertices left and right",
            "tuser": "bits 1:0 vertex, fan, outside left, outside right; 6:2 valence of a vertex; 7 last word of its column; 10:8 on the first word of a strip its level, 1 and up",
            "dropped": "strips of a level that the core does not have",
        },
        "m_axis": {
            "beats": beats(parameters),
            "tkeep": "the vertices that are there",
            "tlast": "last beat of a strip",
        },
    })
}

fn beats(parameters: Parameters) -> String {
    let rows = parameters.rows(parameters.levels);
    if let Some(log) = parameters.longitudinal {
        return format!(
            "a vertex: row 0 of up to {} columns from left to right, row 1, ...; tuser 0 ends a row, tuser 1 a chunk",
            1u32 << log
        );
    }
    match (parameters.schedule, parameters.rows_per_clock) {
        (Schedule::Double, _) => format!(
            "columns 0 .. 2^l M of the fine strip, {rows} vertices from top to bottom; at level {} two columns in a beat",
            parameters.levels
        ),
        (_, Some(rows)) => format!(
            "columns 0 .. 2^l M of the fine strip in slices of {rows} vertices, one more in the last; tuser 1 ends a column"
        ),
        _ => format!("columns 0 .. 2^l M of the fine strip, {rows} vertices from top to bottom"),
    }
}

/// What was proved of the levels, and of the finishing stage.
struct Proofs {
    levels: proof::Proof,
    finish: Option<finish_proof::Proof>,
}

impl Proofs {
    fn of(parameters: Parameters) -> Result<Proofs> {
        let finish = parameters.finish().map(finish_proof::prove).transpose()?;
        Ok(Proofs { levels: proof::prove(parameters)?, finish })
    }
}

fn proofs(proof: Option<&Proofs>) -> Value {
    let Some(Proofs { levels, finish }) = proof else {
        return json!({ "linear_forms": { "result": "not run" } });
    };
    json!({
        "linear_forms": {
            "statement": "for all inputs, every vertex of the face and vertex columns of every level is its mask, for every valence, and every claimed range holds",
            "result": "proved",
            "levels": levels.levels,
            "max_valence": levels.max_valence,
            "vertices": levels.vertices,
            "claims": levels.claims,
            "finishing_stage": finish,
        },
    })
}

/// The proven bound on the error of a coordinate that leaves, for a mesh of any valences that the core takes.
fn bound(parameters: Parameters) -> f64 {
    let reference = reference_parameters(parameters);
    error_bound_lsb(&Accuracy {
        width: reference.width,
        extra_fraction: reference.extra_fraction,
        levels: parameters.levels,
        numbers: reference.numbers,
        rounding: reference.rounding,
        table_bits: parameters.table_bits,
        largest_irregular_valence: Some(parameters.max_valence as usize),
        limit: parameters.limit,
    })
}
