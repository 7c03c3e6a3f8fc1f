//! The strip control: which strip, which row, and when.
//!
//! ```text
//! idle ──load──► starting ──strip──► running ── 2^r - i pairs, one single ──► strip (i + 1) ... ──► idle
//! ```
//!
//! `load` costs one clock between patches; between strips there is none: the next one starts at the edge
//! that ends the one before.

use std::rc::Rc;

use super::Parameters;
use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Inputs: `waiting` (a patch is ready, of `level`), `has_room` (a beat may be issued). Outputs: `load`,
/// `strip`, `step` for the engines; for the beat that leaves in this clock `valid`, `pair` (it has a right
/// vertex), `strip_end`, `patch_start`, `patch_end`.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("strip_control");
    m.purpose("Counts strips and rows of a patch; one pair of vertices per clock while there is room.");
    let waiting = m.input("waiting", Word::bit());
    let level = m.input("level", parameters.level());
    let has_room = m.input("has_room", Word::bit());

    let steps = Word::range(0, 1 << parameters.max_level);
    let mut phase = m.state_machine("phase", &["idle", "starting", "running"]);
    let [idle, starting, running] = ["idle", "starting", "running"].map(|state| phase.is(state));
    // Pairs of the current strip, and how many of them are still to come.
    let length = m.register_reset("length", steps, 0);
    let pairs_left = m.register_reset("pairs_left", steps, 0);
    let fresh = m.register_reset("fresh", Word::bit(), 0);

    let valid = m.wire("valid", &running & &has_room);
    let strip_end = m.wire("strip_end", m.is(&pairs_left, 0));
    let last_strip = m.wire("last_strip", m.compare(Relation::LessOrEqual, &length, m.constant(1, steps)));
    let patch_end = m.wire("patch_end", &strip_end & &last_strip);
    let finishing = m.wire("finishing", &valid & &patch_end);
    let load = m.wire("load", &waiting & &(&idle | &finishing));
    let step = m.wire("step", &valid & !&strip_end);
    let next_strip = m.all(&[&valid, &strip_end, &!&last_strip]);
    let strip = m.wire("strip", &starting | &next_strip);

    phase.go("idle", &load, "starting");
    phase.go("starting", &m.bit(true), "running");
    phase.go("running", &load, "starting");
    phase.go("running", &finishing, "idle");
    phase.finish();

    // 2^level: one bit for each level.
    let decoded: Vec<Signal> = (0..=parameters.max_level).rev().map(|l| m.is(&level, l.into())).collect();
    let start = m.wire("steps", m.concat(&decoded.iter().collect::<Vec<_>>()));
    let shorter = m.wrap(&length - 1, steps);
    m.on(&load, &length, m.wrap(&start, steps));
    m.on(&next_strip, &length, &shorter);
    m.on(&starting, &pairs_left, &length);
    m.on(&next_strip, &pairs_left, &shorter);
    m.on(&step, &pairs_left, m.wrap(&pairs_left - 1, steps));
    m.on(&starting, &fresh, m.bit(true));
    m.on(&valid, &fresh, m.bit(false));

    m.output("load", &load);
    m.output("strip", &strip);
    m.output("step", &step);
    m.output("valid", &valid);
    m.output("pair", m.wire("pair", !&strip_end));
    m.output("strip_end", &strip_end);
    m.output("patch_start", m.wire("patch_start", &fresh));
    m.output("patch_end", &patch_end);
    m.finish()
}
