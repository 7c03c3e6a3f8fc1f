//! The core `cc-strip` in the built-in simulator: every schedule, folded or not, whole columns and slices, at
//! every level that it can be asked for; every bit against the reference, the whole against global refinement.

use std::rc::Rc;

use subdiv_rtl::cores::cc_strip::finish::{Kind, Normals};
use subdiv_rtl::cores::cc_strip::proof::prove;
use subdiv_rtl::cores::cc_strip::{Parameters, Precision, Schedule, build, stored_vertices};
use subdiv_rtl::cosim::strip_bench::StripBench;
use subdiv_rtl::cosim::{Builtin, Model, Simulator, Stall, Stimulus, device};
use subdiv_rtl::fixed::Format;
use subdiv_rtl::hdl::Module;
use subdiv_rtl::hdl::inventory::Operators;
use subdiv_rtl::mesh::{quantise, shape};
use subdiv_rtl::surface::catmull_clark::oracle::{QuadOracle, Target};
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};

const FORMAT: Format = Format { integer: 4, fraction: 12 };

fn quads(name: &str) -> QuadMesh {
    let mesh = quantise(&shape(name).unwrap(), FORMAT).unwrap();
    let quads = mesh.faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect();
    QuadMesh::new(mesh.positions, quads).unwrap()
}

fn exact(levels: u32) -> Parameters {
    Parameters::exact(FORMAT, levels, 10)
}

/// Every schedule, folded or not, in whole columns and in slices.
fn variants(levels: u32) -> Vec<Parameters> {
    let mut all = vec![];
    for (schedule, folded) in [
        (Schedule::Shared, false),
        (Schedule::Pipelined, false),
        (Schedule::Pipelined, true),
        (Schedule::Double, false),
        (Schedule::Double, true),
    ] {
        all.push(Parameters { schedule, folded, ..exact(levels) });
        let rows: Vec<u32> = [2, 4, 8].into_iter().filter(|rows| *rows <= 1 << levels).collect();
        if schedule == Schedule::Pipelined && !folded {
            let registered =
                |rows_per_clock| Parameters { registered: true, rows_per_clock, ..exact(levels) };
            all.extend([None, Some(2), Some(4)].map(registered));
            all.extend(
                [(2, 1), (2, levels - 1), (4, levels - 1)]
                    .map(|(rows, axes_in_turn)| Parameters { axes_in_turn, ..registered(Some(rows)) }),
            );
        }
        if schedule != Schedule::Double {
            all.extend(rows.into_iter().map(|r| Parameters {
                schedule,
                folded,
                rows_per_clock: Some(r),
                ..exact(levels)
            }));
        }
    }
    all
}

/// A mesh through a core at a level: no bit differs, nothing is missing, the error is that of the format.
fn run(core: &Rc<Module>, parameters: Parameters, name: &str, level: u32, stalls: [Stall; 2]) -> u64 {
    let what = format!("{name} level {level} {parameters:?} {stalls:?}");
    let mesh = quads(name);
    let rings = Rings::new(&mesh, Boundary::Ghosts).unwrap();
    let bench = StripBench::new(core, parameters, level, &mesh, &rings).unwrap();
    let mut stimulus = Stimulus::new(bench.input.clone(), bench.expected.clone());
    [stimulus.gaps, stimulus.back_pressure] = stalls;
    stimulus.expected_clocks = bench.clocks(&stimulus);
    let outcome = Builtin::new(|| Model::new(core)).run(&device(core, &[], None), &stimulus).unwrap();
    let located = outcome.error(&|beat| bench.locate(beat));
    assert!(outcome.passed(), "{what}: {located:?}");
    let drawn = bench.assemble(&mesh, &outcome.received).unwrap();
    assert_eq!((drawn.cracks(), drawn.missing()), (0, 0), "{what}");
    let oracle = QuadOracle::new(&mesh, level, Boundary::Ghosts.corners()).unwrap();
    let target = if parameters.limit { Target::Limit } else { Target::Refined };
    let error = oracle.error(&drawn.positions().unwrap(), target, 0).unwrap().max;
    assert!(error <= 0.5625, "{what}: {error}");
    outcome.clocks
}

#[test]
fn every_level_is_proved_for_every_valence() {
    for parameters in variants(4) {
        for precision in [Precision::Exact, Precision::Guard(4)] {
            let proof = prove(Parameters { precision, ..parameters }).unwrap();
            assert_eq!((proof.levels, proof.max_valence), (4, 10));
            // What a walk makes of the finest level has no fans, which no level behind it would take.
            let fans: u64 = if parameters.walked() { (5..=10).map(|d| 4 * (d - 4)).sum() } else { 0 };
            assert!(proof.vertices + fans > 1000 && proof.claims > 8, "{parameters:?}: {proof:?}");
        }
    }
}

#[test]
fn every_variant_draws_the_global_mesh_at_every_level() {
    for parameters in variants(3) {
        let core = build(parameters).unwrap();
        for level in 1..=3 {
            run(&core, parameters, "blob-quads", level, [Stall::None; 2]);
            run(&core, parameters, "cube-quads", level, ["bursts", "random:40"].map(|s| s.parse().unwrap()));
        }
    }
}

/// A vertex and a face column in cells, whose rows are read in their order; coarse levels in turn or not.
#[test]
fn columns_in_many_slices() {
    for axes_in_turn in [0, 3] {
        let parameters = Parameters {
            registered: true,
            rows_per_clock: Some(2),
            axes_in_turn,
            precision: Precision::Guard(5),
            ..exact(4)
        };
        prove(parameters).unwrap();
        let core = build(parameters).unwrap();
        run(&core, parameters, "blob-quads", 4, [Stall::None; 2]);
        for level in 1..=4 {
            run(&core, parameters, "cube-quads", level, ["bursts", "random:40"].map(|s| s.parse().unwrap()));
        }
    }
}

#[test]
fn guard_bits_in_every_schedule() {
    for parameters in variants(4).into_iter().filter(|p| p.rows_per_clock.is_none_or(|rows| rows == 4)) {
        let parameters = Parameters { precision: Precision::Guard(5), ..parameters };
        let core = build(parameters).unwrap();
        run(&core, parameters, "blob-quads", 4, [Stall::None; 2]);
        run(&core, parameters, "square-quads", 2, [Stall::None, "one-in-3".parse().unwrap()]);
    }
}

#[test]
fn every_shape_through_the_usual_core() {
    let core = build(exact(4)).unwrap();
    for name in ["cube-quads", "torus-quads", "double-torus-quads", "blob-quads", "square-quads"] {
        for level in 1..=4 {
            run(&core, exact(4), name, level, [Stall::None; 2]);
        }
    }
}

/// Limit positions, normals of both kinds, unit vectors, and rows along the strip.
#[test]
fn what_leaves_the_finest_level() {
    let normals = |kind, unit| Some(Normals { kind, point_fraction: FORMAT.fraction, unit });
    let outputs = [
        Parameters { limit: true, ..exact(3) },
        Parameters { limit: true, schedule: Schedule::Shared, precision: Precision::Guard(6), ..exact(3) },
        Parameters { normals: normals(Kind::Faces, None), ..exact(2) },
        Parameters { limit: true, normals: normals(Kind::Limit, Some(14)), folded: true, ..exact(3) },
        Parameters { longitudinal: Some(3), ..exact(3) },
        Parameters { longitudinal: Some(5), limit: true, schedule: Schedule::Shared, ..exact(2) },
    ];
    for parameters in outputs {
        let core = build(parameters).unwrap();
        for level in 1..=parameters.levels {
            run(&core, parameters, "blob-quads", level, [Stall::None; 2]);
            run(&core, parameters, "cube-quads", level, ["bursts", "random:40"].map(|s| s.parse().unwrap()));
            run(
                &core,
                parameters,
                "square-quads",
                level,
                ["random:20", "one-in-3"].map(|s| s.parse().unwrap()),
            );
        }
    }
}

#[test]
fn storage_at_five_levels_and_valence_ten() {
    let core = build(exact(5)).unwrap();
    let stored = stored_vertices(&core, exact(5)).unwrap();
    assert_eq!(stored, 335, "of at most 315 + 30");
}

/// A face and a vertex column together: 9X - 10 two-input adders for X = 3 + 2^l source rows, what recovers the
/// previous column's ends included.
#[test]
fn adders_of_the_separable_datapath() {
    for levels in 1..=5 {
        let core = build(exact(levels)).unwrap();
        let source = levels - 1;
        let engine = core.instances.iter().find(|i| i.name == format!("engine_{source}_x")).unwrap();
        let inner = |name: &str| {
            let unit = engine.module.instances.iter().find(|i| i.name == name).unwrap();
            Operators::of(&unit.module).two_operand_adders()
        };
        let fans = inner("top_fan") + inner("bottom_fan");
        let adders = Operators::of(&engine.module).two_operand_adders() - fans;
        let rows = 3 + (1 << source);
        println!("level {levels}: {adders} adders of at most {}", 9 * rows - 10);
        assert!(adders <= 9 * rows - 10, "level {levels}: {adders}");
        let parts = inner("face_column") + inner("vertex_column") + inner(&format!("window_{source}"));
        assert_eq!(adders, parts + 4);
    }
}
