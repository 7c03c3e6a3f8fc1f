//! Control of one lane: a step of the outer differences starts a strip, whose columns take their heads as these come.
//!
//! ```text
//! load ─► fire ─► rows ─► fire ─► rows ... ─► fire ─► rows ─► (the next patch)
//! ```
//!
//! A load and a fire take as many clocks as a number has digits, less than most strips have rows. All that decides a
//! row stands in registers: whether the next strip is prepared, whether rows run, and whether another one follows.
//!
//! Buffered, a pass in front of the strips fills the memory with the first column. It has as many rows as the first strip,
//! and sends none of them.

use std::rc::Rc;

use super::super::Parameters;
use crate::error::Result;
use crate::hdl::serial::Turn;
use crate::hdl::{Builder, Module, Signal, Word};

/// Clocks from a step of the outer differences to the strip: the heads leave these, and come near to the columns.
pub const LATER: u32 = 2;

/// Inputs: `waiting` (a patch is ready, of `level`), `has_room` (a beat may be issued). Outputs, out of registers: `load`
/// (the patch is no longer waiting), `released` (another one may come), `advance` for the outer differences, and `issue`
/// for the FIFO; and [`LATER`] `strip`, `step`, and for the beat that leaves `valid`, `keep_1` (it has
/// a second vertex), `strip_end`, `patch_start`, `patch_end`. Buffered, also `row` (one runs, whether sent or not) and
/// `makes` (it has a vertex of the column that runs).
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("lane_control");
    m.purpose("Steps from strip to strip, and counts the rows of the one that runs.");
    let waiting = m.input("waiting", Word::bit());
    let level = m.input("level", parameters.level());
    let has_room = m.input("has_room", Word::bit());
    let flag = |name: &str| m.register_reset(name, Word::bit(), 0);
    let sign = |number: &Signal| m.slice(number, number.width() - 1, 1);

    // prepared: the outer differences may step to the next strip; climbs: a row follows the one that is sent.
    let [owned, vacant, prepared, running, climbs] =
        ["owned", "vacant", "prepared", "running", "climbs"].map(flag);
    let valid = m.wire("valid_now", &running & &has_room);
    let step = m.wire("step_now", &climbs & &has_room);
    let free = m.wire("free", !&running | &(&has_room & &!&climbs));
    let fire = m.wire("fire", &prepared & &free);
    let moves = m.wire("moves", &fire | &step);
    m.on(&free, &running, &prepared);

    // Pairs of the strip that is prepared, and of those of this one that are to come, less two: their signs tell.
    let word = Word::range(-2, (1 << parameters.max_level) - 1);
    let [ahead, left] = ["pairs_ahead", "pairs_left"].map(|name| m.register(name, word));
    let load = m.wire("load_now", &waiting & &vacant);
    let pairs: Vec<Signal> = (0..=parameters.max_level).rev().map(|l| m.is(&level, l.into())).collect();
    let pairs = m.concat(&pairs.iter().collect::<Vec<_>>());
    m.on(&load, &ahead, m.wrap(&pairs - 2, word));
    // Buffered, the pass to come fills the memory, or this one does; the strip after it has as many pairs.
    let filling =
        parameters.is_buffered().then(|| ["empty", "fills"].map(|name| m.register(name, Word::bit())));
    if let Some([empty, fills]) = &filling {
        m.on(&load, empty, m.bit(true));
        m.on(&fire, empty, m.bit(false));
        m.on(&fire, fills, empty);
    }
    let passes_on = match &filling {
        Some([empty, _]) => m.wire("passes_on", &fire & &!empty),
        None => fire.clone(),
    };
    m.on(&passes_on, &ahead, m.wrap(&ahead - 1, word));
    let less = m.wire("left_less_1", m.wrap(&left - 1, word));
    m.on(&moves, &left, m.select(&climbs, &less, &ahead));
    // Every strip has a pair.
    m.on(&moves, &climbs, !&(&climbs & &sign(&left)));
    let last = match &filling {
        Some([empty, _]) => m.wire("prepares_last", &sign(&ahead) & &!empty),
        None => m.wire("prepares_last", sign(&ahead)),
    };
    let drains = m.wire("drains", &fire & &last);
    m.on(&load, &owned, m.bit(true));
    m.on(&drains, &owned, m.bit(false));

    // Both are known a clock late, as is that a turn is over.
    let turn = Turn::new(&m, parameters.digits().saturating_sub(1).max(1));
    let begins =
        if parameters.differences_wait() { m.wire("turn_begins", &load | &fire) } else { fire.clone() };
    turn.begins(&m, &begins);
    m.always(&prepared, m.all(&[&owned, &!&turn.busy, &!&fire]));
    m.always(&vacant, m.all(&[&!&owned, &!&turn.busy, &!&load]));
    let [first, fresh, last_strip] =
        ["first_strip", "fresh", "last_strip"].map(|name| m.register(name, Word::bit()));
    m.on(&load, &first, m.bit(true));
    m.on(&fire, &first, filling.as_ref().map_or(m.bit(false), |[empty, _]| empty.clone()));
    m.on(&m.wire("begins_row", &fire | &valid), &fresh, &first & &!&climbs);
    m.on(&fire, &last_strip, &last);

    let registered = |name: &str, now: &Signal| m.restart(&m.pipe_reset(name, now, 0), 0);
    let advance = registered("advance", &fire);
    let released = if parameters.differences_wait() {
        load.clone()
    } else {
        let drained = flag("drained");
        let release = m.wire("release", &drained & &vacant);
        m.on(&m.wire("drains_late", &advance & &last_strip), &drained, m.bit(true));
        m.on(&release, &drained, m.bit(false));
        release
    };
    let sends = match &filling {
        Some([_, fills]) => m.wire("sends", &valid & &!fills),
        None => valid.clone(),
    };
    let issue = registered("issue", &sends);
    for (name, now) in [("load", registered("load", &load)), ("released", registered("released", &released))]
    {
        m.output(name, &now);
    }
    m.output("advance", &advance);
    m.output("issue", &issue);
    let later = |now: &Signal| m.restart(&m.delay_reset(now, LATER, 0), 0);
    m.output("strip", later(&advance));
    m.output("step", later(&registered("step", &step)));
    m.output("valid", later(&issue));
    if let Some([_, fills]) = &filling {
        m.output("row", later(&registered("row", &valid)));
        m.output("makes", later(&registered("makes", &m.wire("makes_now", &valid & &(&climbs | fills)))));
    }
    let strip_end = m.wire("strip_end_now", !&climbs);
    let patch_end = m.wire("patch_end_now", &strip_end & &last_strip);
    let flags =
        [("keep_1", &climbs), ("strip_end", &strip_end), ("patch_start", &fresh), ("patch_end", &patch_end)];
    for (name, now) in flags {
        m.output(name, m.restart(&m.delay(&m.pipe(name, now), LATER), 0));
    }
    m.finish()
}
