//! What an exploration promises: no measured error above its proven bound in any point of a large sweep, worst-case
//! control points that come near the bound, formats at least as cheap as those derived by hand, and hardware that
//! agrees bit for bit with the reference that was measured.

use std::rc::Rc;

use subdiv_rtl::cores::loop_fd::RegisterForm;
use subdiv_rtl::cosim::loop_bench::{self, LoopBench};
use subdiv_rtl::cosim::strip_bench::StripBench;
use subdiv_rtl::cosim::{Builtin, External, Model, Settings, Simulator, Stimulus, Tool, device};
use subdiv_rtl::explore::axes::Axes;
use subdiv_rtl::explore::evaluate::{Core, Evaluator};
use subdiv_rtl::explore::meshes::Subject;
use subdiv_rtl::explore::pareto::{Price, candidates, recommend};
use subdiv_rtl::explore::point::{Design, Origin, Point, Precision, Scheme};
use subdiv_rtl::explore::ranges::Numbers;
use subdiv_rtl::explore::record::Record;
use subdiv_rtl::explore::run::{available_threads, run};
use subdiv_rtl::explore::{cc_strip, loop_fd, search};
use subdiv_rtl::fixed::{Fractions, Rounding};
use subdiv_rtl::hdl::verilog;
use subdiv_rtl::surface::precision::search::{REGISTERS_20, cost};

fn shapes(names: &[&str]) -> Vec<Subject> {
    names.iter().map(|name| Subject::load(&Origin::Shape(name.to_string()), false).unwrap()).collect()
}

fn axes(levels: &str, coordinates: &[&str], precisions: Vec<Precision>) -> Axes {
    Axes {
        scheme: None,
        levels: levels.parse().unwrap(),
        coordinates: coordinates.iter().map(|text| text.parse().unwrap()).collect(),
        precisions,
        tables: None,
        roundings: Rounding::TOTAL.to_vec(),
        registers: vec![RegisterForm::Minimal20],
    }
}

/// Uniform and progressive formats from far too few bits to more than enough.
fn loop_precisions() -> Vec<Precision> {
    let mut precisions: Vec<Precision> = (0..=22).step_by(2).map(Precision::Uniform).collect();
    for first in [2, 5, 8] {
        for step in [1, 3, 5] {
            precisions.push(Precision::Progressive([0, 1, 2, 3, 3].map(|order| first + step * order)));
            precisions.push(Precision::Progressive([0, 0, 1, 1, 2].map(|order| first + step * order)));
        }
    }
    precisions
}

fn evaluated(subjects: Vec<Subject>, points: &[Point]) -> Vec<Record> {
    let evaluator = Evaluator::new(subjects, false);
    run(&evaluator, points, None, available_threads(), |_| {}).unwrap()
}

#[test]
fn no_error_exceeds_its_bound_in_a_sweep_of_thousands() {
    let subjects = shapes(&["octahedron", "torus", "disc", "double-torus"]);
    let sweep = axes("1..4", &["Q2.10", "Q2.14"], loop_precisions()).sweep(&subjects).unwrap();
    let mut records = evaluated(subjects, &sweep.points);

    let subjects = shapes(&["cube-quads", "square-quads", "double-torus-quads"]);
    let guards = [Precision::Exact].into_iter().chain((0..=6).map(Precision::Guard)).collect();
    let strips = Axes { tables: Some("14..28".parse().unwrap()), ..axes("1..3", &["Q2.12"], guards) };
    let sweep = strips.sweep(&subjects).unwrap();
    records.extend(evaluated(subjects, &sweep.points));

    assert!(records.len() >= 2000, "{} points", records.len());
    for record in &records {
        assert!(record.within_bound(), "{} on {}: {record:?}", record.label(), record.point.mesh.name);
        // Exact formats and strips have no cracks; a crack of a reduced format is no wider than two errors.
        let crack = record.cracks.largest as f64;
        let limit =
            if record.point.precision.contains(['u', 'p']) && !record.point.precision.contains("guard") {
                2.0 * record.bound_lsb
            } else {
                0.0
            };
        assert!(crack <= limit, "{} on {}: a crack of {crack}", record.label(), record.point.mesh.name);
    }
    let near = records.iter().filter(|r| r.worst() > 0.9 * r.bound_lsb).count();
    println!("{} points, none above its bound, {near} within a tenth of it", records.len());
    // A bound that is never approached would not be worth much.
    assert!(near > records.len() / 10, "{near}");
}

fn loop_design(level: u32, precision: Precision) -> Design {
    let coordinates = "Q4.20".parse().unwrap();
    Design {
        scheme: Scheme::Loop,
        coordinates,
        level,
        precision,
        table: Design::usual_table(Scheme::Loop, coordinates),
        rounding: Rounding::HalfUp,
        registers: RegisterForm::Minimal20,
    }
}

#[test]
fn worst_case_points_reach_nine_tenths_of_the_uniform_bound() {
    let torus = &shapes(&["torus"])[0];
    for level in 4..=8 {
        // From a unit of error to many.
        for fraction in [4 * level - 3, 4 * level - 5, 3 * level - 2] {
            let design = loop_design(level, Precision::Uniform(fraction));
            let bound = loop_fd::Stage::new(torus, design.coordinates, 1).map(|_| ()).and_then(|()| {
                // The bound of a regular mesh, at this level: that of the format alone.
                let fractions = Fractions::uniform(fraction)?;
                Ok(subdiv_rtl::surface::precision::total_lsb(
                    subdiv_rtl::fixed::Reduced::new(fractions),
                    level,
                    0,
                ))
            });
            let (bound, worst) = (bound.unwrap(), loop_fd::worst(&design).unwrap().unwrap());
            assert!(
                worst <= bound && worst >= 0.9 * bound,
                "level {level}, F = {fraction}: {worst} of {bound}"
            );
        }
    }
}

#[test]
fn the_search_reproduces_the_uniform_table_and_beats_the_progressive_one() {
    let uniform = [1, 2, 5, 8, 13, 17];
    let progressive =
        [[2, 2, 2, 2, 2], [4, 5, 5, 5, 5], [5, 8, 8, 8, 11], [7, 10, 12, 12, 15], [7, 11, 15, 18, 18]];
    let subjects = shapes(&["torus"]);
    let evaluator = Evaluator::new(subjects.clone(), false);
    for level in 1..=5u32 {
        let axes = Axes {
            levels: Numbers::from(level),
            roundings: vec![Rounding::HalfUp],
            ..axes("1", &["Q4.20"], vec![])
        };
        let points = search::points(&evaluator, &axes, &subjects, 1.0).unwrap();
        let meets = |p: &&Point| evaluator.bound(p).unwrap() <= 1.0;
        let found: Vec<Precision> = points.iter().filter(meets).map(|p| p.design.precision).collect();
        let least =
            found.iter().filter_map(|p| if let Precision::Uniform(f) = p { Some(*f) } else { None }).min();
        assert_eq!(least, Some(uniform[level as usize]), "level {level}");
        let price = |bits: [u32; 5]| cost(Fractions::new(bits).unwrap(), REGISTERS_20);
        let cheapest = found
            .iter()
            .filter_map(|p| if let Precision::Progressive(f) = p { Some(price(*f)) } else { None });
        let by_hand = price(progressive[level as usize - 1]);
        // At level 1 the cheapest progressive format is the uniform one.
        let cheapest = cheapest.min().unwrap_or(price([least.unwrap(); 5]));
        println!("level {level}: {cheapest} fraction bits a coordinate, by hand {by_hand}");
        assert!(cheapest <= by_hand, "level {level}: {cheapest} against {by_hand}");
    }
}

#[test]
fn what_is_recommended_is_the_cheapest_that_meets_the_target() {
    let subjects = shapes(&["blob-quads"]);
    let evaluator = Evaluator::new(subjects.clone(), false);
    let axes = Axes { roundings: vec![Rounding::HalfUp], ..axes("2", &["Q2.12"], vec![]) };
    let points = search::points(&evaluator, &axes, &subjects, 1.0).unwrap();
    let records = run(&evaluator, &points, None, 1, |_| {}).unwrap();
    let all = candidates(&records, Price::RegisterBits);
    let found = recommend(&all, 1.0, Price::RegisterBits).unwrap();
    // L 2^-(g+1) <= 1/2 for two levels: one guard bit, and a second one for the table.
    assert!(matches!(found.record.point.precision.as_str(), "guard 1" | "guard 2"), "{:?}", found.record);
    assert!(found.bound_lsb <= 1.0 && found.error_lsb <= found.bound_lsb);
    let less = all.iter().find(|c| c.register_bits < found.register_bits);
    assert!(less.is_some_and(|c| c.bound_lsb > 1.0), "one bit less is shown, and misses the target");
}

/// A point's core against the reference, on the point's own mesh.
fn cosimulate(
    evaluator: &Evaluator,
    subject: &Subject,
    point: &Point,
    simulator: impl Fn(&Rc<subdiv_rtl::hdl::Module>) -> Box<dyn Simulator>,
) {
    let Design { coordinates, level, .. } = point.design;
    let core = evaluator.core(point).unwrap();
    let (built, command) = (core.build().unwrap(), core.command());
    let sources = verilog::print(&built, &command).unwrap();
    let (dut, mut stimulus) = match core {
        Core::LoopFd(parameters) => {
            let stage = loop_fd::Stage::new(subject, coordinates, level).unwrap();
            let mut bench = LoopBench::new(&built, parameters, &stage.control, level).unwrap();
            let vectors = (std::mem::take(&mut bench.input), std::mem::take(&mut bench.expected));
            (loop_bench::device(&built, &sources), Stimulus::new(vectors.0, vectors.1))
        }
        Core::CcStrip(parameters) => {
            let stage = cc_strip::Stage::new(subject, coordinates, level).unwrap();
            let bench =
                StripBench::new(&built, parameters, parameters.levels, &stage.quads, &stage.rings).unwrap();
            (device(&built, &sources, None), Stimulus::new(bench.input, bench.expected))
        }
    };
    stimulus.back_pressure = "random:20".parse().unwrap();
    let outcome = simulator(&built).run(&dut, &stimulus).unwrap();
    assert_eq!((outcome.failures, outcome.mismatches), (vec![], 0), "{}", point.design);
    assert!(outcome.beats > 0);
}

/// `count` different points, by a linear congruence from a seed.
fn drawn(points: &[Point], count: usize, seed: u64) -> Vec<&Point> {
    let mut state = seed;
    let mut left: Vec<&Point> = points.iter().collect();
    let mut chosen = vec![];
    while chosen.len() < count && !left.is_empty() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        chosen.push(left.swap_remove((state >> 33) as usize % left.len()));
    }
    chosen
}

#[test]
fn fifty_points_drawn_by_seed_are_simulated_without_a_mismatch() {
    let subjects = shapes(&["octahedron", "triangle", "cube-quads"]);
    let precisions =
        loop_precisions().into_iter().chain([Precision::Exact]).chain((0..=6).map(Precision::Guard));
    let sweep = Axes {
        registers: RegisterForm::ALL.to_vec(),
        ..axes("1..3", &["Q2.8", "Q2.14"], precisions.collect())
    }
    .sweep(&subjects)
    .unwrap();
    let evaluator = Evaluator::new(subjects.clone(), false);
    let subject = |point: &Point| subjects.iter().find(|s| s.name == point.mesh).unwrap();
    let chosen = drawn(&sweep.points, 50, 2000);
    assert_eq!(chosen.len(), 50);
    for point in &chosen {
        cosimulate(&evaluator, subject(point), point, |core| {
            let core = core.clone();
            Box::new(Builtin::new(move || Model::new(&core)))
        });
    }
    let verilator = External::new(Tool::Verilator, Settings::default());
    if let Err(error) = verilator.version() {
        println!("skipped: {error}");
        return;
    }
    let small = chosen.iter().filter(|p| p.design.scheme == Scheme::Loop && p.design.level < 3).take(3);
    for point in small {
        cosimulate(&evaluator, subject(point), point, |_| {
            Box::new(External::new(Tool::Verilator, Settings::default()))
        });
    }
}
