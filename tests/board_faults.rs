//! Every single-cell fault in the units of a board, the core excepted, is caught by the frame at the receiver, or why
//! it changes nothing is stated.

mod board_design;

use board_design::{QUICK, triangle};
use subdiv_rtl::board::simulate::Session;
use subdiv_rtl::hdl::{Flat, fault};

#[test]
fn every_fault_outside_of_the_core_is_caught() {
    let design = triangle(1);
    let flat = Flat::new(&design.top(QUICK).unwrap()).unwrap();
    let expected = design.expected();
    let twice = [&expected[..], &expected].concat();
    let once = board_design::run(&design, QUICK).clocks;
    let begin = once + 60;
    let passes = |flat: &Flat| {
        let session = Session {
            top: flat,
            clocks_per_bit: QUICK.clocks_per_bit,
            pressed: begin..begin + QUICK.press(),
            bytes: twice.len(),
            to_the_end: true,
            disturb: &|_, line| line,
        };
        session.run().is_ok_and(|received| received.broken == 0 && received.bytes == twice)
    };
    assert!(passes(&flat));
    let faults: Vec<_> = fault::all(&flat)
        .into_iter()
        .filter(|fault| !fault.to_string().starts_with("evaluator.core."))
        .collect();
    let missed: Vec<_> = faults
        .iter()
        .filter(|fault| fault.apply(&flat).is_ok_and(|broken| passes(&broken)))
        .map(ToString::to_string)
        .collect();
    println!("{} faults, {} missed", faults.len(), missed.len());
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
