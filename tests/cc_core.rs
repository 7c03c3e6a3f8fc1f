//! The core `cc-strip` in the built-in simulator: every strip of a mesh, bit for bit against the reference,
//! and the whole against global refinement.

use subdiv_rtl::cores::cc_strip::proof::prove;
use subdiv_rtl::cores::cc_strip::{Parameters, Precision, build};
use subdiv_rtl::cosim::strip_bench::words;
use subdiv_rtl::cosim::{Clocked, Model, device};
use subdiv_rtl::fixed::Format;
use subdiv_rtl::mesh::{quantise, shape};
use subdiv_rtl::model::cc_strip::{self as reference, CcStrip};
use subdiv_rtl::surface::catmull_clark::assembly::QuadAssembly;
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::oracle::{QuadOracle, Target};
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::records::records;
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

fn quads(name: &str, format: Format) -> QuadMesh {
    let mesh = quantise(&shape(name).unwrap(), format).unwrap();
    let quads = mesh.faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect();
    QuadMesh::new(mesh.positions, quads).unwrap()
}

/// Every strip through the core; returns the largest error, the cracks, the missing vertices, and the clocks
/// and columns of the longest strip.
fn run(name: &str, levels: u32, precision: Precision) -> (f64, usize, usize, u64, u64) {
    let format = Format { integer: 4, fraction: 12 };
    let mesh = quads(name, format);
    let rings = Rings::new(&mesh, Boundary::Ghosts).unwrap();
    let parameters = Parameters {
        coordinates: format,
        output_fraction: 12,
        levels,
        max_valence: 10,
        precision,
        table_bits: 36,
    };
    let core = build(parameters).unwrap();
    let dut = device(&core, &[], None);
    let reference = CcStrip::new(reference::Parameters {
        width: format.width(),
        max_valence: 10,
        table_bits: parameters.table_bits,
        numbers: match precision {
            Precision::Exact => Numbers::Exact,
            Precision::Guard(bits) => Numbers::Guard(bits),
        },
        ..reference::Parameters::exact(format.width())
    })
    .unwrap();
    let grid = QuadGrid::new(&mesh, levels).unwrap();
    let oracle = QuadOracle::new(&mesh, levels, Boundary::Ghosts.corners()).unwrap();
    let mut assembly = QuadAssembly::new(QuadGrid::new(&mesh, levels).unwrap());
    let mut model = Model::new(&core).unwrap();
    let (mut clocks, mut columns) = (0, 0);
    model.reset();
    for strip in cut(&mesh, Method::Natural) {
        let numbers = records(&mesh, &rings, &strip);
        let strip_words = words(&dut.input, &numbers.map(|&v| rings.positions()[v as usize])).unwrap();
        let expected = reference.columns(levels, &numbers.map(|&v| rings.positions()[v as usize])).unwrap();
        let mut waiting = strip_words.iter().peekable();
        let fine = (strip.len() << levels) + 1;
        let (mut column, mut clock) = (0, 0);
        while column < fine {
            let seen = model.clock(waiting.peek().copied(), true);
            if seen.input_ready {
                waiting.next();
            }
            if let Some(beat) = seen.output {
                for row in 0..=1usize << levels {
                    let position = [0, 1, 2].map(|axis| dut.output.number(&beat, 3 * row + axis) as i64);
                    assert_eq!(
                        position, expected[column].vertices[row],
                        "{name}: column {column}, row {row}"
                    );
                    assembly.put(strip.fine_vertex(&grid, column, row), position);
                }
                column += 1;
                assert_eq!(beat.last, column == fine, "{name}");
            }
            clock += 1;
            assert!(clock < 100_000, "{name}: only {column} of {fine} columns came out");
        }
        if strip.len() as u64 > columns {
            (clocks, columns) = (clock, strip.len() as u64);
        }
    }
    let error = oracle.error(&assembly.positions().unwrap(), Target::Refined, 0).unwrap().max;
    (error, assembly.cracks(), assembly.missing(), clocks, columns)
}

#[test]
fn every_level_is_proved_for_every_valence() {
    for precision in [Precision::Exact, Precision::Guard(4)] {
        let format = Format { integer: 12, fraction: 12 };
        let parameters = Parameters {
            coordinates: format,
            output_fraction: 12,
            levels: 4,
            max_valence: 10,
            precision,
            table_bits: 37,
        };
        let proof = prove(parameters).unwrap();
        assert_eq!((proof.levels, proof.max_valence), (4, 10));
        assert!(proof.vertices > 1000 && proof.claims > 50, "{proof:?}");
    }
}

#[test]
fn every_strip_of_every_shape_is_the_global_mesh() {
    for name in ["cube-quads", "torus-quads", "double-torus-quads", "blob-quads", "square-quads"] {
        for levels in 1..=4 {
            for precision in [Precision::Exact, Precision::Guard(5)] {
                let (error, cracks, missing, clocks, columns) = run(name, levels, precision);
                println!(
                    "{name} level {levels} {precision:?}: error {error}, {clocks} clocks for {columns} quads"
                );
                assert_eq!((cracks, missing), (0, 0), "{name} {levels}");
                assert!(error <= 0.5625, "{name} {levels} {precision:?}: {error}");
            }
        }
    }
}
