//! `loop-fd` with reduced numbers: hardware and reference agree bit for bit in every format, and in every
//! simulator that is here, on hard packets under stalls.

use subdiv_rtl::Kind;
use subdiv_rtl::cores::loop_fd::proof::{prove, prove_flat};
use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm, build};
use subdiv_rtl::cosim::loop_bench::{device, extra_fraction};
use subdiv_rtl::cosim::loop_trial::LoopTrial;
use subdiv_rtl::cosim::{Builtin, External, Model, Simulator, Stall, Stimulus, Tool};
use subdiv_rtl::fixed::{Precision, Reduced, Rounding};
use subdiv_rtl::hdl::{Flat, verilog};
use subdiv_rtl::surface::precision::total_lsb;

/// Coordinates, output fraction, levels, registers, fractions, saturation.
type Design = (&'static str, u32, (u32, u32), RegisterForm, &'static str, bool);

const DESIGNS: [Design; 12] = [
    ("Q4.4", 4, (0, 3), RegisterForm::Minimal20, "8", false),
    ("Q4.4", 4, (0, 3), RegisterForm::Minimal20, "5,8,8,8,9", false),
    ("Q4.4", 6, (0, 3), RegisterForm::Published23, "5,7,9,12,14", true),
    ("Q3.3", 2, (0, 2), RegisterForm::Relative19, "5", true),
    ("Q3.3", 3, (0, 2), RegisterForm::WithoutZero22, "4,5,5,5,7", false),
    // No error that a format makes here is small, and some differences have more bits than exact ones.
    ("Q2.2", 2, (0, 3), RegisterForm::Minimal20, "0", false),
    ("Q2.2", 2, (0, 3), RegisterForm::Minimal20, "0,0,1,2,4", true),
    ("Q2.1", 2, (0, 0), RegisterForm::Minimal20, "4,6,8,9,9", false),
    ("Q2.1", 1, (0, 1), RegisterForm::Minimal20, "12", false),
    // The output has all the bits of the differences.
    ("Q5.3", 8, (0, 2), RegisterForm::Minimal20, "5,6,7,8,9", false),
    // Only fine levels.
    ("Q4.4", 4, (3, 3), RegisterForm::Minimal20, "5,8,8,8,9", false),
    ("Q4.8", 8, (2, 4), RegisterForm::Minimal20, "7,10,12,12,13", true),
];

fn parameters(design: Design, rounding: Rounding) -> Parameters {
    let (coordinates, output_fraction, (min_level, max_level), registers, fractions, saturate) = design;
    let reduced = Reduced { fractions: fractions.parse().unwrap(), rounding, saturate };
    Parameters::new(coordinates.parse().unwrap(), output_fraction, max_level, registers)
        .and_then(|parameters| parameters.with_min_level(min_level))
        .and_then(|parameters| parameters.with_precision(Precision::Reduced(reduced)))
        .unwrap()
}

fn check(
    parameters: Parameters,
    simulator: &dyn Fn(&std::rc::Rc<subdiv_rtl::hdl::Module>) -> Box<dyn Simulator>,
) {
    let core = build(parameters).unwrap();
    let files = verilog::print(&core, "subdiv-rtl generate loop-fd").unwrap();
    let dut = device(&core, &files);
    for (seed, (gaps, back_pressure)) in
        [(Stall::None, Stall::None), (Stall::Bursts, Stall::Random { percent: 40 })].into_iter().enumerate()
    {
        let trial = LoopTrial::random(&core, parameters, seed as u64 + 1).unwrap();
        let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        let mut stimulus = Stimulus { gaps, back_pressure, seed: 3, ..stimulus };
        stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
        let outcome = simulator(&core).run(&dut, &stimulus).unwrap();
        assert_eq!(outcome.failures, [], "{parameters:?}, {gaps}, {back_pressure}");
        assert!(outcome.beats > 0);
    }
}

#[test]
fn the_built_in_simulator_agrees_in_every_format_and_mode() {
    for design in DESIGNS {
        for rounding in Rounding::TOTAL {
            check(parameters(design, rounding), &|core| {
                let core = core.clone();
                Box::new(Builtin::new(move || Model::new(&core)))
            });
        }
    }
}

#[test]
fn verilator_and_icarus_agree_too() {
    for tool in [Tool::Verilator, Tool::Icarus] {
        let settings = subdiv_rtl::cosim::Settings::default();
        if let Err(error) = External::new(tool, settings.clone()).version() {
            println!("skipped: {error}");
            continue;
        }
        for (index, design) in DESIGNS.into_iter().enumerate() {
            let rounding = Rounding::TOTAL[index % 4];
            check(parameters(design, rounding), &|_| Box::new(External::new(tool, settings.clone())));
        }
    }
}

#[test]
fn every_core_is_proved_to_be_within_the_bound_of_its_format() {
    for design in DESIGNS {
        for rounding in Rounding::TOTAL {
            let parameters = parameters(design, rounding);
            let reduced = parameters.precision.reduced().unwrap();
            let proof = prove(&build(parameters).unwrap(), parameters).unwrap();
            let proved = proof.error.unwrap().largest();
            let bound = total_lsb(reduced, parameters.max_level, extra_fraction(parameters));
            if rounding == Rounding::HalfEven {
                // The proof does not see that the start-up corrects only ties.
                assert!(proved <= 3.0 * bound, "{design:?}: {proved}, {bound}");
            } else {
                // At coarse levels the fractions of a start-up are few, and the bound takes them for all.
                let sharp = parameters.max_level < 2 || proved >= 0.9 * bound;
                assert!(proved <= bound && sharp, "{design:?}, {rounding}: {proved}, {bound}");
            }
        }
    }
}

#[test]
fn a_register_that_is_too_narrow_is_refuted() {
    // The level of the core decides the widths; a core built for fine levels only fails at a coarse one.
    let coarse = parameters(DESIGNS[0], Rounding::HalfUp);
    let fine = coarse.with_min_level(3).unwrap();
    assert!(prove(&build(coarse).unwrap(), coarse).is_ok());
    assert!(prove(&build(fine).unwrap(), fine).is_ok());
    let narrow = Parameters { min_level: 0, ..fine };
    let flat = Flat::new(&build(fine).unwrap()).unwrap();
    assert_eq!(prove_flat(flat, narrow).unwrap_err().kind, Kind::Mismatch);
}

#[test]
fn formats_that_no_core_has_are_refused() {
    let exact = |registers| Parameters::new("Q4.8".parse().unwrap(), 8, 3, registers).unwrap();
    let reduced = |text: &str| Precision::Reduced(Reduced::new(text.parse().unwrap()));
    assert!(exact(RegisterForm::Relative19).with_precision(reduced("7")).is_ok());
    let progressive = exact(RegisterForm::Relative19).with_precision(reduced("7,8,8,8,8"));
    assert!(progressive.unwrap_err().help.unwrap().contains("--registers 20"));
    let narrow = Parameters::new("Q4.8".parse().unwrap(), 10, 3, RegisterForm::Minimal20).unwrap();
    assert!(narrow.with_precision(reduced("1")).is_err());
    assert!(narrow.with_precision(reduced("2")).is_ok());
    assert!(narrow.with_min_level(4).is_err());
}
