//! `loop-fd` in chunks with skewed carry: the same vertices as the reference for every chunk size and form, in every
//! simulator that is here, on hard packets under stalls, in as many clocks as predicted.

use crate::core_trial;

use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm};
use subdiv_rtl::fixed::{Precision, Reduced};

const CHUNKS: [Option<u32>; 6] = [Some(4), Some(8), Some(12), Some(16), Some(20), None];

/// One core for each chunk size; all forms, some with one level only.
fn cores() -> Vec<Parameters> {
    let forms = RegisterForm::ALL.into_iter().cycle();
    let ranges = [(0, 3), (3, 3), (2, 4)].into_iter().cycle();
    let mut cores: Vec<Parameters> = CHUNKS
        .into_iter()
        .zip(forms)
        .zip(ranges)
        .map(|((chunk, form), (low, high))| {
            let exact = Parameters::new("Q4.4".parse().unwrap(), 5, high, form).unwrap();
            let exact = exact.with_min_level(low).unwrap();
            chunk.map_or(exact, |chunk| exact.with_chunk(chunk).unwrap())
        })
        .collect();
    let plain = Parameters::new("Q4.4".parse().unwrap(), 4, 3, RegisterForm::Minimal20).unwrap();
    let reduced = Precision::Reduced(Reduced::new("5,8,8,8,9".parse().unwrap()));
    cores.push(plain.with_precision(reduced).and_then(|p| p.with_chunk(7)).unwrap());
    cores
}

#[test]
fn the_built_in_simulator_agrees() {
    core_trial::built_in(cores());
}

#[test]
fn verilator_and_icarus_agree_too() {
    core_trial::installed(cores());
}
