//! The loader: tells every word of the stream its place in the column, and where strips and columns begin.
//!
//! ```text
//! tuser   10:8 level   7 last word of its column   6:2 valence   1:0 role        level: first word of a strip
//! ```
//!
//! A strip that asks for another level than the one before waits until that one has left the levels; a strip
//! that asks for no level, or for more than there are, is swallowed whole.

use std::rc::Rc;

use super::fan::{End, fan_names};
use super::{LEVEL_BITS, Parameters, Role, USER_BITS, VALENCE_BITS};
use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Inputs: the stream (`valid`, `user`, `last`), `taken` (level 0 has room) and `idle` (nothing is to leave any
/// level). Outputs: `ready`, `comes` (a word comes), `accept` (it goes into the window, in a walked core two clocks later), one `write_..` for each place, `begins`,
/// `ends`, `first`, `last_column`, the valences, and the `level` of the strip.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("column_loader");
    m.purpose("Tells every word of the stream its place in the column, and when the column is complete.");
    let [valid, last, taken, idle] = ["valid", "last", "taken", "idle"].map(|n| m.input(n, Word::bit()));
    let user = m.input("user", Word::unsigned(USER_BITS));
    let role = m.slice(&user, 0, 2);
    let valence = m.slice(&user, 2, VALENCE_BITS);
    let complete = m.wire("complete", m.slice(&user, 7, 1) | &last);
    let wanted = m.wire("wanted", m.slice(&user, 8, LEVEL_BITS));

    let level = m.register_reset("level", Word::unsigned(LEVEL_BITS), 0);
    let starts = m.register_reset("starts", Word::bit(), 1);
    let drops = m.register_reset("drops", Word::bit(), 0);
    let most = m.constant(parameters.levels.into(), level.word());
    let none = m.is(&wanted, 0);
    let possible = m.wire("possible", !&none & m.compare(Relation::LessOrEqual, &wanted, &most));
    let same = m.wire("same_level", m.compare(Relation::Equal, &wanted, &level));
    // In a walked core a word stands for some clocks before it is judged.
    let judged = |name: &str, signal: Signal| match parameters.walked() {
        true => m.restart(&m.pipe(name, &signal), 0),
        false => signal,
    };
    let (possible, same) = (judged("is_possible", possible), judged("is_same_level", same));
    let settled = m.wire("settled", !&starts | &same | &idle);
    let dropped = m.wire("dropped", &drops | (&starts & !&possible));
    // Words are so far apart there that the room of the clock before is known to be that of now.
    let taken = judged("has_room", taken);
    let ready = m.wire("ready", &dropped | (&taken & &settled));
    let accepts = m.wire("accepts", m.all(&[&!&dropped, &taken, &settled]));
    // There a word stands still for a clock after it is known that it may go, and for another one in which it goes.
    let (moves, accept) = match parameters.walked() {
        true => {
            let [ready, accepts] = [("may_go", &ready), ("may_be_accepted", &accepts)]
                .map(|(name, may)| m.restart(&m.pipe(name, may), 0));
            let [moves, accept] = ["goes", "is_accepted"].map(|name| m.register_reset(name, Word::bit(), 0));
            m.always(&moves, m.all(&[&valid, &ready, &!&moves]));
            m.always(&accept, m.all(&[&valid, &accepts, &!&moves]));
            (moves, accept)
        }
        false => (m.wire("moves", &valid & &ready), m.wire("accept", &valid & &accepts)),
    };
    m.on(&(&accept & &starts), &level, &wanted);
    m.on(&(&moves & &last), &starts, m.bit(true));
    m.on(&moves, &starts, m.bit(false));
    m.on(&(&moves & &last), &drops, m.bit(false));
    m.on(&(&moves & &dropped), &drops, m.bit(true));

    // The first word of a column, and whether the column is the left guard.
    let fresh = m.register_reset("fresh", Word::bit(), 1);
    m.on(&accept, &fresh, &complete);
    let first = m.register_reset("first", Word::bit(), 1);
    m.on(&(&accept & &last), &first, m.bit(true));
    m.on(&(&accept & &complete), &first, m.bit(false));

    // In a walked core what a word is stands in registers, and what follows from that a clock later.
    let walked = parameters.walked();
    let late = |name: &str, signal: &Signal, reset: i128| match walked {
        true => m.restart(&m.pipe_reset(name, signal, reset), 0),
        false => signal.clone(),
    };
    let comes = accept;
    let accept = late("accepted", &comes, 0);
    let is = |r: Role| {
        let name = format!("is_{}", format!("{r:?}").to_lowercase());
        let is = m.wire(format!("{name}_here"), &comes & m.is(&role, r as i128));
        late(&name, &is, 0)
    };
    let fresh = late("begins", &fresh, 1);
    let [vertex, fan, left, right] = [Role::Vertex, Role::Fan, Role::OutsideLeft, Role::OutsideRight].map(is);
    // The end of the column that the words belong to: the first vertex is the top one.
    let at_bottom = m.register_reset("at_bottom", Word::bit(), 0);
    m.on(&vertex, &at_bottom, !&fresh);
    let top_vertex = m.wire("top_vertex", &vertex & &fresh);
    let bottom_vertex = m.wire("bottom_vertex", &vertex & !&fresh);

    let entries = 1 + fan_names(parameters).len();
    let entry = Word::range(0, entries as i128);
    let index = m.register_reset("index", entry, 0);
    m.on(&vertex, &index, m.constant(0, entry));
    m.on(&fan, &index, m.wrap(&index + 1, entry));

    let write = |place: String, when: &Signal| {
        let name = format!("write_{place}");
        m.output(name.clone(), if walked { late(&name, when, 0) } else { m.wire(name, when) });
    };
    write("row_0".into(), &top_vertex);
    write("row_1".into(), &bottom_vertex);
    for end in End::BOTH {
        let here = if end == End::Top { !&at_bottom } else { at_bottom.clone() };
        // The first entry of a fan is also the outside vertex on the left, the last neighbour that on the right.
        let even = !m.slice(&index, 0, 1);
        write(format!("{}_left", end.name()), &(&here & (&left | (&fan & m.is(&index, 0)))));
        write(format!("{}_right", end.name()), &(&here & (&right | (&fan & even))));
        for (at, place) in fan_names(parameters).iter().enumerate() {
            let when = m.all(&[&here, &fan, &m.is(&index, at as i128 + 1)]);
            write(format!("{}_{place}", end.name()), &when);
        }
    }
    let twice = |name: &str, signal: &Signal, reset: i128| {
        late(&format!("{name}_late"), &late(name, signal, reset), reset)
    };
    let valence = twice("valence", &valence, 0);
    for (end, vertex) in [("top", &top_vertex), ("bottom", &bottom_vertex)] {
        let kept = m.register(format!("{end}_valence"), Word::unsigned(VALENCE_BITS));
        m.on(&late(&format!("{end}_vertex_late"), vertex, 0), &kept, &valence);
        m.output(format!("{end}_valence"), &kept);
    }
    // What moves by a register does not ask the word.
    m.output("ready", if parameters.walked() { &moves } else { &ready });
    m.output("comes", m.wire("comes", &comes | &accept));
    m.output("accept", late("accepted_late", &accept, 0));
    m.output("begins", late("begins_late", &fresh, 1));
    m.output("ends", twice("ends", &complete, 0));
    m.output("first", twice("of_left_guard", &first, 1));
    m.output("last_column", twice("last_column", &last, 0));
    m.output("level", &level);
    m.finish()
}
