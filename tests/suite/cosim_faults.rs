//! Every simulator must find every fault of a broken core, say the same about it, and stall on the same
//! clocks as the others.

use crate::cosim_stub::{Fault, dut, simulators, vectors};
use subdiv_rtl::cosim::{Outcome, Stall, Stimulus};

const BEATS: usize = 12;

fn run_all(fault: Fault, change: impl Fn(&mut Stimulus)) -> Vec<Outcome> {
    let (input, expected) = vectors(BEATS, fault);
    let mut stimulus = Stimulus { patience: 500, ..Stimulus::new(input, expected) };
    change(&mut stimulus);
    simulators().iter().map(|one| one.run(&dut(), &stimulus).unwrap()).collect()
}

/// The first failure is in these words, and in the same ones everywhere.
fn says(fault: Fault, words: &str, change: impl Fn(&mut Stimulus)) {
    let outcomes = run_all(fault, change);
    for outcome in &outcomes {
        let said = outcome.failures.first().map(ToString::to_string).unwrap_or_default();
        assert_eq!(said, words, "{fault:?} in {}", outcome.name);
        assert_eq!(outcome.failures, outcomes[0].failures, "{fault:?} in {}", outcome.name);
        assert_eq!(outcome.mismatches, outcomes[0].mismatches, "{fault:?} in {}", outcome.name);
    }
}

fn as_it_is(_: &mut Stimulus) {}

#[test]
fn a_right_core_passes_under_every_stall_with_the_same_clocks_everywhere() {
    let kinds = ["none", "random", "random:90", "bursts", "one-in-7"];
    let stalls = kinds.map(|kind| kind.parse::<Stall>().unwrap());
    for (at, (gaps, back_pressure)) in
        stalls.iter().flat_map(|gaps| stalls.iter().map(move |back| (*gaps, *back))).enumerate()
    {
        let outcomes = run_all(Fault::None, |stimulus| {
            (stimulus.gaps, stimulus.back_pressure, stimulus.seed) = (gaps, back_pressure, at as u64);
        });
        for outcome in &outcomes {
            let name = format!("{} under {gaps} and {back_pressure}", outcome.name);
            assert_eq!(outcome.failures, [], "{name}");
            assert_eq!(outcome.beats, BEATS as u64, "{name}");
            assert_eq!(outcome.latency, outcomes[0].latency, "{name}");
            assert_eq!(outcome.clocks, outcomes[0].clocks, "{name}");
            let clocks = |of: &Outcome| of.received.iter().map(|(clock, _)| *clock).collect::<Vec<_>>();
            assert_eq!(clocks(outcome), clocks(&outcomes[0]), "{name}");
        }
    }
}

#[test]
fn a_right_core_needs_exactly_its_clocks() {
    for outcome in run_all(Fault::None, |stimulus| stimulus.expected_clocks = Some(14)) {
        assert_eq!((outcome.failures.as_slice(), outcome.latency), (&[][..], Some(2)));
    }
}

#[test]
fn a_wrong_bit() {
    let words = "beat 5, y: expected 0xffffde (-34), got 0xfffdde (-546), clock 7";
    says(Fault::WrongBit, words, as_it_is);
}

#[test]
fn a_dropped_beat() {
    let words = "beat 5, x: expected 0x000006 (6), got 0x000007 (7), clock 8; as if a beat was lost here";
    says(Fault::Drops, words, as_it_is);
}

#[test]
fn a_repeated_beat() {
    let words =
        "beat 7, x: expected 0x000008 (8), got 0x000007 (7), clock 9; as if the beat before came twice";
    says(Fault::Repeats, words, as_it_is);
}

#[test]
fn data_that_changes_under_stall() {
    let words = "beat 0: m_axis_tdata changed at clock 3 before tready took it";
    says(Fault::Changes, words, |stimulus| stimulus.back_pressure = Stall::OneIn(4));
}

#[test]
fn valid_that_falls_under_stall() {
    let words = "beat 0: m_axis_tvalid fell at clock 3 before tready took it";
    says(Fault::Falls, words, |stimulus| stimulus.back_pressure = Stall::OneIn(4));
}

#[test]
fn lost_clocks() {
    let words = "every beat is right, but it took 15 clocks instead of 14";
    says(Fault::LosesClocks, words, |stimulus| stimulus.expected_clocks = Some(14));
}

#[test]
fn a_wrong_tlast() {
    says(Fault::WrongLast, "beat 6, tlast: expected 0x0 (0), got 0x1 (1), clock 8", as_it_is);
}

#[test]
fn a_wrong_tuser() {
    says(Fault::WrongUser, "beat 4, tuser: expected 0x1 (1), got 0x0 (0), clock 6", as_it_is);
}

#[test]
fn a_wrong_tkeep() {
    says(Fault::WrongKeep, "beat 3, tkeep: expected 0x007 (7), got 0x1ff (511), clock 5", as_it_is);
}

#[test]
fn a_hang() {
    let words = "hangs: no transfer for 500 clocks up to clock 508, with 7 of 12 input beats accepted \
                 and 7 of 12 output beats received";
    says(Fault::Hangs, words, as_it_is);
}

#[test]
fn a_beat_too_many() {
    says(Fault::Extra, "a beat too many at clock 14: only 12 are expected", as_it_is);
}

#[test]
fn a_wrong_latency() {
    says(Fault::Late, "the first output came after 3 clocks, its latency is 2", as_it_is);
}

#[test]
fn the_latency_is_not_judged_while_something_stalls() {
    for outcome in run_all(Fault::Late, |stimulus| stimulus.gaps = Stall::OneIn(3)) {
        assert_eq!(outcome.failures, [], "{}", outcome.name);
    }
}
