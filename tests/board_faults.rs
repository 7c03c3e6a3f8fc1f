//! Every single-cell fault in the units of a board, the core excepted, is caught by what the receiver and the LEDs show,
//! or why it changes nothing is stated.

mod board_design;

use board_design::{QUICK, run, triangle};
use std::collections::BTreeSet;
use subdiv_rtl::board::simulate::{Received, Session};
use subdiv_rtl::hdl::{Flat, fault};

/// Parts of the descriptions of faults that change nothing, and why.
const REASONS: &[(&str, &str)] = &[];

#[test]
fn every_fault_outside_of_the_core_is_caught_or_explained() {
    let design = triangle(2);
    let flat = Flat::new(&design.top(QUICK).unwrap()).unwrap();
    let expected = design.expected();
    let twice = [&expected[..], &expected].concat();
    let once = run(&design, QUICK).clocks;
    // Presses while the mesh is on its way, one before its first byte; one too short; bounces, then a true one.
    let (middle, end) = (once / 2, once + 100);
    let pressed = [0..40, middle..middle + 60, end..end + 12, end + 15..end + 18, end + 20..end + 50];
    let observe = |flat: &Flat| -> Option<Received> {
        let (clocks_per_bit, bytes, disturb) = (QUICK.clocks_per_bit, twice.len(), &|_, line| line);
        Session { top: flat, clocks_per_bit, pressed: &pressed, bytes, to_the_end: true, disturb }.run().ok()
    };
    let sound = observe(&flat);
    assert!(sound.as_ref().is_some_and(|seen| seen.broken == 0 && seen.bytes == twice));

    let faults = fault::all(&flat);
    let faults = faults.iter().filter(|fault| !fault.to_string().starts_with("evaluator.core."));
    let (mut count, mut unseen, mut used) = (0, vec![], BTreeSet::new());
    for fault in faults {
        count += 1;
        if fault.apply(&flat).is_ok_and(|broken| observe(&broken) == sound) {
            let text = fault.to_string();
            match REASONS.iter().find(|(part, _)| text.contains(part)) {
                Some((part, _)) => drop(used.insert(*part)),
                None => unseen.push(text),
            }
        }
    }
    println!("{count} faults");
    assert!(unseen.is_empty(), "faults that nobody sees:\n{}", unseen.join("\n"));
    let idle: Vec<_> = REASONS.iter().filter(|(part, _)| !used.contains(part)).collect();
    assert!(idle.is_empty(), "reasons for faults that are caught: {idle:?}");
}
