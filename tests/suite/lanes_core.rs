//! `loop-fd` with lanes: neighbouring strips at once, whole and in digits of every size, against the reference on hard
//! packets under stalls, in every simulator that is here, in as many clocks as predicted. And proved, where whole.

use crate::core_trial;

use subdiv_rtl::cores::loop_fd::proof::prove;
use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm, build};

/// Lanes, bits of a chunk, coarsest and finest level.
const CORES: [(u32, Option<u32>, u32, u32); 11] = [
    (1, None, 0, 3),
    (1, None, 6, 6),
    (1, Some(15), 6, 6),
    (1, Some(16), 0, 3),
    (2, None, 0, 3),
    (3, Some(8), 2, 4),
    (1, Some(4), 3, 3),
    (4, Some(12), 4, 4),
    (8, Some(20), 0, 4),
    (5, Some(28), 1, 3),
    (7, Some(200), 1, 2),
];

fn cores() -> Vec<Parameters> {
    CORES.into_iter().map(|(lanes, chunk, low, high)| core(lanes, chunk, low, high)).collect()
}

fn core(lanes: u32, chunk: Option<u32>, low: u32, high: u32) -> Parameters {
    let plain = Parameters::new("Q4.4".parse().unwrap(), 5, high, RegisterForm::Minimal20).unwrap();
    plain.with_min_level(low).and_then(|p| p.with_chunk(chunk)).and_then(|p| p.with_lanes(lanes)).unwrap()
}

#[test]
fn the_built_in_simulator_agrees() {
    core_trial::built_in(cores());
}

#[test]
fn verilator_and_icarus_agree_too() {
    // Each takes a while to build: one lane with and without patches that wait, few lanes and many, whole and in digits.
    let built = [(1, Some(15), 6), (1, Some(16), 0), (2, None, 0), (4, Some(12), 4), (8, Some(20), 0)];
    let built = |p: &Parameters| built.contains(&(p.lanes.unwrap_or(0), p.chunk, p.min_level));
    core_trial::installed(cores().into_iter().filter(built).collect());
}

#[test]
fn every_number_of_lanes_is_proved() {
    for (lanes, low, high) in [(1, 0, 4), (1, 6, 6), (2, 0, 3), (3, 2, 4), (5, 0, 3), (8, 4, 4), (32, 0, 2)] {
        let parameters = core(lanes, None, low, high);
        let proof = prove(&build(parameters).unwrap(), parameters).unwrap();
        assert!(proof.coordinates > 0 && !proof.claims.is_empty(), "{lanes} lanes");
    }
}

#[test]
fn lanes_that_no_core_has_are_refused() {
    let plain = core(1, None, 0, 2);
    for lanes in [0, Parameters::MOST_LANES + 1] {
        assert_eq!(plain.with_lanes(lanes).unwrap_err().exit_status(), 2);
    }
    let other = Parameters { registers: RegisterForm::Relative19, ..plain };
    assert_eq!(other.with_lanes(2).unwrap_err().exit_status(), 2);
}
