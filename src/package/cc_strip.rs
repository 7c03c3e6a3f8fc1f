//! The package of a `cc-strip`.

use serde_json::{Value, json};

use super::{Draft, Package, assemble};
use crate::cores::cc_strip::proof::{Proof, prove};
use crate::cores::cc_strip::{Parameters, Precision, Schedule, build, stored_vertices};
use crate::cosim::device;
use crate::cosim::strip_bench::{StripBench, protocol};
use crate::error::Result;
use crate::hdl::verilog;
use crate::model::cc_strip_clocks;
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
    let schedule = match parameters.schedule {
        Schedule::Pipelined => String::new(),
        schedule => format!(" --schedule {schedule}"),
    };
    let fold = if parameters.folded { " --fold" } else { "" };
    let rows = parameters.rows_per_clock.map_or(String::new(), |rows| format!(" --rows-per-clock {rows}"));
    format!(
        "subdiv-rtl generate cc-strip --coordinates {coordinates} --output-fraction {output_fraction} \
         --max-level {levels} --max-valence {max_valence} --table {table_bits}{guard}{schedule}{fold}{rows}"
    )
}

/// The core and its files in memory; with `prove_it`, only if the proof holds.
///
/// # Errors
/// A core that cannot be built; a refuted proof, which is a [`crate::Kind::Mismatch`].
pub fn package(parameters: Parameters, prove_it: bool) -> Result<Package> {
    let core = build(parameters)?;
    let proof = if prove_it { Some(prove(parameters)?) } else { None };
    let command = command(parameters);
    let sources = verilog::print(&core, &command)?;
    let dut = device(&core, &sources, None);
    let (mesh, rings) = sample(parameters)?;
    let bench = StripBench::new(&core, parameters, parameters.levels, &mesh, &rings)?;

    let draft = Draft {
        core: "cc-strip",
        purpose: "Catmull-Clark subdivision of quad strips by a sliding window",
        command,
        parameters: parameters_json(parameters, stored_vertices(&core, parameters)?),
        streams: streams(parameters),
        latency: Value::Null,
        initiation_interval: json!({
            "clocks_per_input_column": cc_strip_clocks::clocks_per_column(protocol(parameters)),
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
        "stored_vertices": stored,
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

fn proofs(proof: Option<&Proof>) -> Value {
    match proof {
        Some(proof) => json!({
            "linear_forms": {
                "statement": "for all inputs, every vertex of the face and vertex columns of every level is its mask, for every valence, and every claimed range holds",
                "result": "proved",
                "levels": proof.levels,
                "max_valence": proof.max_valence,
                "vertices": proof.vertices,
                "claims": proof.claims,
            },
        }),
        None => json!({ "linear_forms": { "result": "not run" } }),
    }
}
