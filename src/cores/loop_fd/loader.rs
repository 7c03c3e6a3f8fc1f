//! Gathers the 12 control points of a patch and hands them over one axis per clock.
//!
//! ```text
//! clock     0 .. 11        12     13     14     15
//!           points 0..11          x      y      z         tready is low in 12 and 13
//! ```
//!
//! Where numbers come in digits, each axis takes as many clocks as there are digits.
//!
//! The points themselves are kept in the start-up, which shifts them in and chooses the axis as told here.

use std::rc::Rc;

use super::{LEVEL_BITS, Parameters};
use crate::error::Result;
use crate::hdl::serial::Turn;
use crate::hdl::{Builder, Module, Word};

/// Inputs: the stream without its points, and `slot_free`: the engines can keep another patch. Outputs: `ready`; a
/// clock after a beat `shift`; `begins` with the first axis; and a clock later, out of registers, `strobe` with the
/// axis, `axis_x` or `axis_y` or neither, and the `level`, unless the core has but one.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("patch_loader");
    m.purpose("Counts the 12 control points of a patch, then hands over x, y and z in three clocks.");
    let valid = m.input("valid", Word::bit());
    let last = m.input("last", Word::bit());
    let user = m.input("level_in", Word::unsigned(LEVEL_BITS));
    let slot_free = m.input("slot_free", Word::bit());

    // Every beat goes through a register; after the last one of a packet the stream waits for the verdict.
    let ready = m.register_reset("ready", Word::bit(), 1);
    let accept = m.wire("accept", &valid & &ready);
    let beat = m.restart(&m.pipe_reset("beat", &accept, 0), 0);
    let [beat_last, beat_level] =
        [("beat_last", &last), ("beat_level", &user)].map(|(name, of)| m.restart(&m.pipe(name, of), 0));

    // full: 12 points are here. x, y, z: which axis is handed over next.
    let full = m.register_reset("full", Word::bit(), 0);
    let [first, second, third] =
        [("x", 1), ("y", 0), ("z", 0)].map(|(name, reset)| m.register_reset(name, Word::bit(), reset));
    // Numbers in digits take as many clocks for each axis.
    let clocks = if parameters.lanes.is_some() { parameters.digits() } else { 1 };
    let turn = Turn::new(&m, clocks);
    let strobe = m.wire("strobe_now", m.all(&[&full, &!&turn.busy, &(!&first | &slot_free)]));
    turn.begins(&m, &strobe);
    let leaving = m.wire("leaving", &strobe & &third);
    for (axis, before) in [(&first, &third), (&second, &first), (&third, &second)] {
        m.on(&strobe, axis, before);
    }

    // 0 .. 11: the number of points here; 12: too many, skip to the end of the packet. What is decided from it stands in
    // registers, one for each verdict.
    let count = m.register_reset("count", Word::range(0, 12), 0);
    let eleven = m.register_reset("eleven", Word::bit(), 0);
    let overlong = m.register_reset("overlong", Word::bit(), 0);
    let end = m.wire("packet_end", &beat & &beat_last);
    let counts = m.wire("counts", &beat & !&overlong);
    m.on(&end, &count, m.constant(0, count.word()));
    m.on(&counts, &count, m.wrap(&count + 1, count.word()));
    m.on(&end, &eleven, m.bit(false));
    m.on(&counts, &eleven, m.is(&count, 10));
    m.on(&end, &overlong, m.bit(false));
    m.on(&counts, &overlong, &eleven);
    let levels: Vec<_> =
        (parameters.min_level..=parameters.max_level).map(|level| m.is(&user, level.into())).collect();
    let known = m.restart(&m.pipe("known", m.any(&levels.iter().collect::<Vec<_>>())), 0);
    let good = m.wire("good", &eleven & &known);
    m.on(&(&end & &good), &full, m.bit(true));
    m.on(&leaving, &full, m.bit(false));
    // The next patch may come while the last axis of this one leaves.
    let opens = if clocks == 1 { &strobe & &second } else { &strobe & &third };
    m.on(&(&accept & &last), &ready, m.bit(false));
    m.on(&((&end & !&good) | opens), &ready, m.bit(true));

    if !parameters.has_one_level() {
        let level = m.register("level_kept", parameters.level());
        m.on(&(&end & &good), &level, m.wrap(&beat_level, parameters.level()));
        m.output("level", m.pipe("level", &level));
    }
    m.output("ready", &ready);
    m.output("shift", m.wire("shift", &beat));
    m.output("strobe", m.pipe_reset("strobe", &strobe, 0));
    m.output("axis_x", m.pipe("axis_x", &first));
    m.output("axis_y", m.pipe("axis_y", &second));
    // The slot is taken from the first axis on.
    m.output("begins", m.wire("begins", &strobe & &first));
    m.finish()
}
