//! `loop-fd` with buffered columns: the beats of one lane from one running column and a memory, whole and in digits of
//! every size, against the reference on hard packets under stalls, in every simulator that is here, in as many clocks as
//! predicted. Proved, where whole. And what is broken in its control and its memory is seen.

use crate::core_trial;

use std::rc::Rc;

use subdiv_rtl::cores::loop_fd::proof::prove;
use subdiv_rtl::cores::loop_fd::{Columns, Parameters, RegisterForm, build};
use subdiv_rtl::cosim::loop_bench::device;
use subdiv_rtl::cosim::loop_trial::LoopTrial;
use subdiv_rtl::cosim::{Builtin, Model, Outcome, Simulator, Stall, Stimulus};
use subdiv_rtl::fixed::{Precision, Reduced};
use subdiv_rtl::hdl::fault::{self, Kind};
use subdiv_rtl::hdl::{Flat, Module};
use subdiv_rtl::package;

/// Bits of a chunk, coarsest and finest level.
const CORES: [(Option<u32>, u32, u32); 10] = [
    (None, 0, 0),
    (None, 0, 3),
    (None, 2, 4),
    (None, 6, 6),
    (Some(15), 6, 6),
    (Some(16), 0, 3),
    (Some(4), 3, 3),
    (Some(8), 1, 4),
    (Some(12), 6, 7),
    (Some(200), 0, 2),
];

fn cores() -> Vec<Parameters> {
    CORES.into_iter().map(|(chunk, low, high)| core(chunk, low, high)).collect()
}

fn core(chunk: Option<u32>, low: u32, high: u32) -> Parameters {
    let plain = plain(high).with_min_level(low).and_then(|p| p.with_chunk(chunk));
    plain.and_then(|p| p.with_columns(Columns::Buffered)).unwrap()
}

fn plain(high: u32) -> Parameters {
    Parameters::new("Q4.4".parse().unwrap(), 5, high, RegisterForm::Minimal20).unwrap()
}

#[test]
fn the_built_in_simulator_agrees() {
    core_trial::built_in(cores());
}

#[test]
fn verilator_and_icarus_agree_too() {
    // Each takes a while to build: with and without patches that wait, whole and in digits.
    let built = [(None, 0, 3), (Some(15), 6, 6), (Some(16), 0, 3), (Some(8), 1, 4)];
    core_trial::installed(built.map(|(chunk, low, high)| core(chunk, low, high)).to_vec());
}

#[test]
fn every_range_of_levels_is_proved() {
    for (low, high) in [(0, 0), (0, 1), (0, 4), (1, 3), (2, 5), (4, 4), (6, 6)] {
        let parameters = core(None, low, high);
        let proof = prove(&build(parameters).unwrap(), parameters).unwrap();
        let other = Parameters { columns: Columns::Shared, ..parameters };
        let shared = prove(&build(other).unwrap(), other).unwrap();
        assert_eq!(proof.coordinates, shared.coordinates, "levels {low} to {high}");
        assert!(proof.coordinates > 0 && !proof.claims.is_empty());
    }
}

#[test]
fn the_beats_are_those_of_shared_columns_and_the_clocks_those_and_a_column_a_patch() {
    let parameters = core(Some(15), 6, 6);
    let shared = Parameters { columns: Columns::Shared, ..parameters };
    let [(buffered, clocks), (other, fewer)] = [parameters, shared].map(|parameters| {
        let core = build(parameters).unwrap();
        let trial = LoopTrial::random(&core, parameters, 4).unwrap();
        let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        let outcome = simulate(&core, &Flat::new(&core).unwrap(), &stimulus);
        assert_eq!(outcome.failures, []);
        (trial.expected.clone(), trial.clocks(&core, &stimulus).total)
    });
    assert_eq!(buffered, other);
    let patches = buffered.iter().filter(|beat| beat.user & 1 == 1).count() as u64;
    let (most, more) = (patches * 65 + 100, clocks - fewer);
    assert!((patches * 65..most).contains(&more), "{more} clocks more in {patches} patches");
}

/// Why a fault changes nothing: part of its description, its kind, the reason.
const REASONS: [(&str, Kind, &str); 6] = [
    ("", Kind::Reset, "what is 1 for a clock is over before the first patch is there"),
    (
        "control.free (",
        Kind::Stuck,
        "a pass that begins while there is no room waits for its first row instead",
    ),
    ("control.pairs_ahead (", Kind::Stuck, "one pair less two is negative, and so is none"),
    ("control.prepared (", Kind::Stuck, "whole, a turn is over when it is asked for"),
    ("control.vacant (", Kind::Stuck, "whole, a turn is over when it is asked for"),
    ("control.makes_now (", Kind::Stuck, "says to the proof alone what a vertex means"),
];

#[test]
fn faults_of_control_and_buffer_are_seen() {
    let parameters = core(None, 0, 2);
    let core = build(parameters).unwrap();
    let flat = Flat::new(&core).unwrap();
    let stalls = [
        (Stall::None, Stall::None),
        (Stall::Random { percent: 30 }, Stall::Random { percent: 40 }),
        (Stall::Bursts, Stall::OneIn(3)),
        // Long enough to fill the FIFO.
        (Stall::None, Stall::Random { percent: 80 }),
    ];
    let stimuli: Vec<Stimulus> = (1..)
        .zip(stalls)
        .map(|(seed, (gaps, back_pressure))| {
            let trial = LoopTrial::random(&core, parameters, seed).unwrap();
            let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
            let stimulus = Stimulus { gaps, back_pressure, seed, patience: 1000, ..stimulus };
            let clocks = trial.clocks(&core, &stimulus).total;
            Stimulus { expected_clocks: Some(clocks), ..stimulus }
        })
        .collect();
    let passes =
        |flat: &Flat| stimuli.iter().all(|stimulus| simulate(&core, flat, stimulus).failures.is_empty());
    assert!(passes(&flat));

    let (mut seen, mut missed) = (0, vec![]);
    for fault in fault::all(&flat) {
        let text = fault.to_string();
        if !["control.", "buffer."].iter().any(|unit| text.starts_with(unit)) {
            continue;
        }
        // One that closes a combinational loop cannot be built.
        let Ok(broken) = fault.apply(&flat) else { continue };
        let stated = REASONS.iter().any(|(part, kind, _)| text.contains(part) && *kind == fault.kind());
        match passes(&broken) {
            false => seen += 1,
            true if stated => {}
            true => missed.push(format!("{:?} {text}", fault.kind())),
        }
    }
    assert!(missed.is_empty(), "faults that nobody sees:\n{}", missed.join("\n"));
    assert!(seen > 50, "only {seen} faults");
}

fn simulate(core: &Rc<Module>, flat: &Flat, stimulus: &Stimulus) -> Outcome {
    Builtin::new(|| Model::from_flat(core, flat.clone())).run(&device(core, &[]), stimulus).unwrap()
}

#[test]
fn the_command_in_the_manifest_says_the_columns() {
    let parameters = core(Some(15), 6, 6);
    let command = package::loop_fd::command(parameters);
    assert!(command.ends_with("--chunk 15 --lanes 1 --columns buffered"), "{command}");
}

#[test]
fn buffered_columns_that_no_core_has_are_refused() {
    let buffered = core(None, 0, 2);
    assert_eq!(buffered.lanes, Some(1));
    for refused in [
        plain(2).with_lanes(2).and_then(|p| p.with_columns(Columns::Buffered)),
        buffered.with_lanes(2),
        Parameters { registers: RegisterForm::Relative19, ..plain(2) }.with_columns(Columns::Buffered),
        plain(2)
            .with_precision(Precision::Reduced(Reduced::new("8".parse().unwrap())))
            .and_then(|p| p.with_columns(Columns::Buffered)),
    ] {
        let error = refused.unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.help.is_some(), "{}", error.what);
    }
    // Not said, the lane stays one.
    assert_eq!(buffered.with_lanes(None).unwrap(), buffered);
    for columns in Columns::ALL {
        assert_eq!(columns.to_string().parse::<Columns>().unwrap(), columns);
    }
    assert_eq!("both".parse::<Columns>().unwrap_err().exit_status(), 2);
}
