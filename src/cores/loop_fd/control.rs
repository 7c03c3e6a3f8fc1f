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
use crate::hdl::{Builder, Module, Signal, Word};

/// Inputs: `waiting` (a patch is ready, of `level`), `has_room` (a beat may be issued). Outputs: `taken` (the patch
/// is no longer waiting), and a clock later, out of registers, `load`, `strip`, `step` for the engines; for the beat
/// that leaves `valid`, `pair` (it has a right vertex), `strip_end`, `patch_start`, `patch_end`.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("strip_control");
    m.purpose("Counts strips and rows of a patch; one pair of vertices per clock while there is room.");
    let waiting = m.input("waiting", Word::bit());
    let level = m.input("level", parameters.level());
    let has_room = m.input("has_room", Word::bit());

    let mut phase = m.state_machine("phase", &["idle", "starting", "running"]);
    let [idle, starting, running] = ["idle", "starting", "running"].map(|state| phase.is(state));
    // Pairs of the strip after this one, and pairs still to come in this one, each less one: their signs tell, without
    // a comparison, that there are none.
    let less_one = Word::range(-1, (1 << parameters.max_level) - 1);
    let strips_left = m.register_reset("pairs_of_next_less_1", less_one, -1);
    let pairs_left = m.register_reset("pairs_left_less_1", less_one, -1);
    let none = |left: &Signal| m.slice(left, left.width() - 1, 1);
    let fresh = m.register_reset("fresh", Word::bit(), 0);

    let valid = m.wire("valid_now", &running & &has_room);
    let strip_end = m.wire("strip_end_now", none(&pairs_left));
    let last_strip = m.wire("last_strip", none(&strips_left));
    let patch_end = m.wire("patch_end_now", &strip_end & &last_strip);
    let finishing = m.wire("finishing", &valid & &patch_end);
    let load = m.wire("load_now", &waiting & &(&idle | &finishing));
    let step = m.wire("step_now", &valid & !&strip_end);
    let next_strip = m.all(&[&valid, &strip_end, &!&last_strip]);
    let strip = m.wire("strip_now", &starting | &next_strip);

    phase.go("idle", &load, "starting");
    phase.go("starting", &m.bit(true), "running");
    phase.go("running", &load, "starting");
    phase.go("running", &finishing, "idle");
    phase.finish();

    // 2^level - 1: bit b of it is 1 where the level is above b.
    let levels = |above: u32| (above + 1..=parameters.max_level).map(|l| m.is(&level, l.into()));
    let bits = (0..parameters.max_level)
        .rev()
        .map(|b| m.any(&levels(b).collect::<Vec<_>>().iter().collect::<Vec<_>>()));
    let start =
        m.concat(&[m.bit(false)].into_iter().chain(bits).collect::<Vec<_>>().iter().collect::<Vec<_>>());
    m.on(&load, &strips_left, m.wrap(&start, less_one));
    m.on(&strip, &strips_left, m.wrap(&strips_left - 1, less_one));
    m.on(&strip, &pairs_left, &strips_left);
    m.on(&step, &pairs_left, m.wrap(&pairs_left - 1, less_one));
    m.on(&starting, &fresh, m.bit(true));
    m.on(&valid, &fresh, m.bit(false));

    m.output("taken", m.wire("taken", &load));
    for (name, now) in [("load", &load), ("strip", &strip), ("step", &step), ("valid", &valid)] {
        m.output(name, m.pipe_reset(name, now, 0));
    }
    let flags = [("strip_end", &strip_end), ("patch_start", &fresh), ("patch_end", &patch_end)];
    m.output("pair", m.pipe("pair", !&strip_end));
    flags.iter().for_each(|(name, now)| m.output(*name, m.pipe(*name, *now)));
    m.finish()
}
