//! `loop-fd` with reduced numbers: hardware and reference agree bit for bit in every format, and in every
//! simulator that is here, on hard packets under stalls.

use crate::core_trial;

use subdiv_rtl::Kind;
use subdiv_rtl::cores::loop_fd::proof::{prove, prove_flat};
use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm, build};
use subdiv_rtl::cosim::loop_bench::extra_fraction;
use subdiv_rtl::fixed::{Precision, Reduced, Rounding};
use subdiv_rtl::hdl::Flat;
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

#[test]
fn the_built_in_simulator_agrees_in_every_format_and_mode() {
    let each = |design| Rounding::TOTAL.map(|rounding| parameters(design, rounding));
    core_trial::built_in(DESIGNS.into_iter().flat_map(each).collect());
}

#[test]
fn verilator_and_icarus_agree_too() {
    let modes = Rounding::TOTAL.into_iter().cycle();
    core_trial::installed(DESIGNS.into_iter().zip(modes).map(|(d, mode)| parameters(d, mode)).collect());
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
