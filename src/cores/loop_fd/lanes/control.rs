//! Control of the lanes: one part prepares the heads of the next group of strips, the other runs through the rows of
//! this one.
//!
//! ```text
//! prepare   load ─► advance, advance, ... K times ─► made ─► (until the group is fired) advance ...
//! run                                       fire ─► rows ─► fire ─► rows ...
//! ```
//!
//! A load and an advance take as many clocks as a number has digits. Between groups there is no clock lost unless the
//! next one is not made yet, as after a group of few rows.

use std::rc::Rc;

use super::super::Parameters;
use crate::error::Result;
use crate::hdl::serial::Turn;
use crate::hdl::{Builder, Module, Signal, Word};

/// Inputs: `waiting` (a patch is ready, of `level`), `has_room` (a beat may be issued). Outputs: `taken` (the patch is
/// no longer waiting), and a clock later, out of registers, `load`, `advance` for the outer differences, and for the
/// columns a clock after that `take_k`; `strip`, `step`; for the beat that leaves `valid`, `keep_k` (column k has a
/// vertex in it), `strip_end`, `patch_start`, `patch_end`.
pub fn build(parameters: Parameters, lanes: u32) -> Result<Rc<Module>> {
    let m = Builder::new("lanes_control");
    m.purpose("Prepares the heads of the next strips, and counts the rows of those that run.");
    m.parameter("lanes", lanes);
    let waiting = m.input("waiting", Word::bit());
    let level = m.input("level", parameters.level());
    let has_room = m.input("has_room", Word::bit());
    let sign = |number: &Signal| m.slice(number, number.width() - 1, 1);

    // ---- the outer differences -----------------------------------------------------------------------
    let owned = m.register_reset("owned", Word::bit(), 0);
    let made = m.register_reset("made", Word::bit(), 0);
    let turn = Turn::new(&m, parameters.digits());
    let load = m.wire("load_now", m.all(&[&waiting, &!&owned, &!&turn.busy]));
    let advance = m.wire("advance_now", m.all(&[&owned, &!&made, &!&turn.busy]));
    turn.begins(&m, &m.wire("turn_begins", &load | &advance));

    let places: Vec<Signal> =
        (0..lanes).map(|k| m.register_reset(format!("step_{k}"), Word::bit(), i128::from(k == 0))).collect();
    for (k, place) in places.iter().enumerate() {
        m.on(&advance, place, &places[(k + lanes as usize - 1) % lanes as usize]);
    }
    let makes = m.wire("makes", &advance & &places[lanes as usize - 1]);

    // Pairs of the first strip of the group that is prepared, less the lanes, less one: its sign tells that it is the last.
    let lanes_more = i128::from(lanes) + 1;
    let word = Word::range(-lanes_more, 1 << parameters.max_level);
    let ahead = m.register("pairs_ahead", word);
    let pairs: Vec<Signal> = (0..=parameters.max_level).rev().map(|l| m.is(&level, l.into())).collect();
    let pairs = m.concat(&pairs.iter().collect::<Vec<_>>());
    m.on(&load, &ahead, m.wrap(&pairs - lanes_more, word));
    m.on(&makes, &ahead, m.wrap(&ahead - i128::from(lanes), word));
    let last = m.wire("prepares_last", sign(&ahead));
    m.on(&load, &owned, m.bit(true));
    m.on(&(&makes & &last), &owned, m.bit(false));

    // ---- from one to the other -----------------------------------------------------------------------
    let first_group = m.register("first_group", Word::bit());
    m.on(&load, &first_group, m.bit(true));
    m.on(&makes, &first_group, m.bit(false));
    let kept = |name: &str, value: &Signal| {
        let register = m.register(format!("made_{name}"), value.word());
        m.on(&makes, &register, value);
        register
    };
    let made_left = kept("left", &ahead);
    let made_last = kept("last", &last);
    let made_first = kept("first", &first_group);
    // A vertex of column k where the first strip has at least k pairs.
    let few = m.slice(&ahead, 0, ahead.width() - 1);
    let room = 1i128 << few.width();
    let mut fewer = m.bit(false);
    let mut made_keeps = vec![];
    for k in 1..=lanes {
        made_keeps.push(kept(&format!("keep_{k}"), &m.wire(format!("at_least_{k}"), !&(&last & &fewer))));
        fewer = &fewer | &m.is(&few, room + i128::from(k) - lanes_more);
    }

    // ---- the columns ---------------------------------------------------------------------------------
    let running = m.register_reset("running", Word::bit(), 0);
    let prepared = m.register_reset("prepared", Word::bit(), 0);
    let left = m.register("pairs_left", word);
    let keeps: Vec<Signal> = (1..=lanes).map(|k| m.register(format!("has_{k}"), Word::bit())).collect();
    let last_group = m.register("last_group", Word::bit());
    let fresh = m.register("fresh", Word::bit());
    let valid = m.wire("valid_now", &running & &has_room);
    let ends = m.wire("ends", !&keeps[0]);
    let free = m.wire("free", &!&running | &(&valid & &ends));
    let fire = m.wire("fire", &prepared & &free);
    let step = m.wire("step_now", &valid & &keeps[0]);

    m.on(&makes, &made, m.bit(true));
    m.on(&fire, &made, m.bit(false));
    m.always(&prepared, &made & &!&fire);
    m.on(&fire, &running, m.bit(true));
    m.on(&free, &running, m.bit(false));
    m.on(&fire, &left, &made_left);
    m.on(&step, &left, m.wrap(&left - 1, word));
    let enough = m.wire("enough", !&sign(&left));
    for (k, keep) in keeps.iter().enumerate() {
        m.on(&fire, keep, &made_keeps[k]);
        m.on(&step, keep, keeps.get(k + 1).unwrap_or(&enough));
    }
    m.on(&fire, &last_group, &made_last);
    m.on(&fire, &fresh, &made_first);
    m.on(&valid, &fresh, m.bit(false));

    m.output("taken", m.wire("taken", &load));
    let registered = |name: &str, now: &Signal| m.restart(&m.pipe_reset(name, now, 0), 0);
    m.output("load", registered("load", &load));
    let advances = registered("advance", &advance);
    m.output("advance", &advances);
    for (k, place) in places.iter().enumerate() {
        let chosen =
            registered(&format!("take_{k}_next"), &m.wire(format!("take_{k}_now"), &advance & place));
        m.output(format!("take_{k}"), registered(&format!("take_{k}"), &chosen));
    }
    for (name, now) in [("strip", &fire), ("step", &step), ("valid", &valid)] {
        m.output(name, registered(name, now));
    }
    for (k, keep) in keeps.iter().enumerate() {
        m.output(format!("keep_{}", k + 1), m.restart(&m.pipe(format!("keep_{}", k + 1), keep), 0));
    }
    let patch_end = m.wire("patch_end_now", &ends & &last_group);
    let flags = [("strip_end", &ends), ("patch_start", &fresh), ("patch_end", &patch_end)];
    flags.iter().for_each(|(name, now)| m.output(*name, m.restart(&m.pipe(*name, *now), 0)));
    m.finish()
}
