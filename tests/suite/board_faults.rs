//! Every single-cell fault in the units of a board, the core excepted, is caught by what the receiver and the LEDs show,
//! or why it changes nothing is stated.

use crate::board_design::{run, two_triangles};
use std::collections::BTreeSet;
use subdiv_rtl::board::Pace;
use subdiv_rtl::board::simulate::{Received, Session};
use subdiv_rtl::hdl::{Flat, fault};

/// Quick, and odd.
const PACE: Pace = Pace { clocks_per_bit: 3, log_quiet: 4 };

/// Parts of the descriptions of faults that change nothing, and why.
const REASONS: [(&str, &str); 20] = [
    (
        "start (on the way to it): stuck at 1",
        "the evaluator ignores a start while it runs, and the sink ends after it",
    ),
    ("button_input.meta: reset", "the pin is 0 at reset; one clock of 1 is no press"),
    ("button_input.level: reset", "the pin is 0 at reset; one clock of 1 is no press"),
    (
        "button_input.quiet: reset",
        "the pin is 0 at reset, which clears the count; `pressed` then meets the first start",
    ),
    ("button_input.held: reset", "it follows the count, which is 0 at reset"),
    ("evaluator.begin_mesh (on the way", "the top starts nothing while the sink is at work"),
    ("evaluator.pair: shifted", "all bytes of the right vertex are kept, or none"),
    ("evaluator.source.valid: always", "the core stalls only before the first point of a packet"),
    ("evaluator.source.advance (on the way", "the core is ready when nothing is offered"),
    (
        "evaluator.source.level_read: always",
        "the core stalls only before the first point: the next has its level",
    ),
    (
        "evaluator.source.valid_index: always",
        "the core stalls only before the first point, behind which more follow",
    ),
    (
        "evaluator.source.last",
        "no end follows the first point; what reset leaves is replaced before it is valid",
    ),
    (
        "evaluator.source.level_2: always",
        "the core stalls only before the first point: the next has its level",
    ),
    (
        "evaluator.taken: another gate",
        "each last beat of a patch waits equally long for the line, so the count of patches, which then runs round, \
         comes out right at the end of the mesh; a sink that stalls at random sees it, as in board.rs",
    ),
    ("evaluator.running (on the way to it): another gate", "the sink is at work until after the last beat"),
    ("sink.byte_1", "only the header, which is loaded whole, is so long"),
    ("sink.crc.remainder: reset", "cleared by the header"),
    ("sink.crc.rest", "between bytes it shifts zeros and nothing reads it"),
    ("sink.crc.bits_left: reset", "it has counted down before the first vertex is there"),
    ("sink.serial_line.clocks_left", "loaded with every bit before it is read"),
];

#[test]
fn every_fault_outside_of_the_core_is_caught_or_explained() {
    let design = two_triangles(2);
    let flat = Flat::new(&design.top(PACE).unwrap()).unwrap();
    let expected = design.expected();
    let twice = [&expected[..], &expected].concat();
    let once = run(&design, PACE).clocks;
    // Presses while the mesh is on its way, one before its first byte; one too short; bounces, then a true one
    // that lasts beyond the second frame.
    let (middle, end) = (once / 2, once + 100);
    let pressed = [0..40, middle..middle + 60, end..end + 12, end + 15..end + 18, end + 20..end + 3 * once];
    let observe = |flat: &Flat| -> Option<Received> {
        let (clocks_per_bit, bytes, disturb) = (PACE.clocks_per_bit, twice.len(), &|_, line| line);
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
