//! The control of a level in a registered core that sends columns in slices: every decision stands in a register.
//!
//! ```text
//! leaves, and there is room behind ──► sends: a slice a clock until the last (see sending) ──► vertex, leaves
//!                                        └──► the next level, whose column is whole with the last slice
//! ```
//!
//! Whether a column may leave is asked once, two clocks before its first slice. See [`super::control`] for the order
//! of the columns, and for the ports.

use std::rc::Rc;

use super::VALENCE_BITS;
use super::control::{Flags, Level, Ports, WALKS, Whole};
use super::schedule::Group;
use super::sending::{self, Sending};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// The control of a group of one level, whose window stands for `walks` clocks from the first slice of a vertex column
/// on. Further output: `walk`, in the clock of that slice.
///
/// Where coordinates take turns: inputs `comes` (a slice or a word of a coordinate comes in) and `from_axis` (of which
/// one); outputs `axis` (which one leaves) and `looks_at` (which one the window is to be read and written of).
pub fn build(index: usize, group: &Group, walks: u32) -> Result<Rc<Module>> {
    let period = sending::period(group, walks);
    let m = Builder::new(&format!("strip_control_{index}"));
    m.purpose("Moves the window of a level and says which column leaves.");
    let Ports { valid, incoming, wanted, next_ready, output_ready } = Ports::new(&m);
    let l = group.finest();
    let level = Level::new(&m, l, false);
    // The level of a strip stands before its first column leaves.
    let here = m.copy("goes_to_output", m.is(&wanted, i128::from(l) + 1));
    let to_output = m.restart(&here, 0);
    let start = m.forward("starts", Word::bit());
    let sending = match group.in_turn {
        true => sending::in_turn(&m, group, &start, &level.vertex, period),
        false => sending::at_once(&m, group, &start),
    };
    let Sending { sends, leaves, begins, whole: sent, done, slice, axis } = sending;
    // The next level knows of a column a clock after that was whole.
    let target = m.register_reset("may_send", Word::bit(), 0);
    m.always(&target, m.select(&to_output, &output_ready, &next_ready & !&sends));
    m.drive(&start, m.wire("begins_to_send", m.all(&[&level.leaves, &!&sends, &target])));
    // What leaves is known a clock before, at the latest.
    let first_walk = m.restart(&m.pipe_reset("first_walk", &start & &level.vertex, 0), 0);

    // The window stands as long as its ends are being looked at.
    let walk = m.wire("walk", &begins & &level.vertex);
    let walks = if axis.is_some() { 2 * period + walks } else { walks };
    let rest = m.register_reset(WALKS, Word::range(0, walks.into()), 0);
    let stands = m.register_reset("stands", Word::bit(), 0);
    m.on(&first_walk, &rest, m.constant(walks.into(), rest.word()));
    m.on(&stands, &rest, m.wrap(&rest - 1, rest.word()));
    // It stands for more than two clocks, and no other column leaves meanwhile but the one between.
    let falls = m.register_reset("stands_no_more", Word::bit(), 0);
    m.always(&falls, &stands & &m.is(&rest, 2));
    m.on(&first_walk, &stands, m.bit(true));
    m.on(&falls, &stands, m.bit(false));

    // A column that is whole counts a clock later.
    let known = |name: &str, now: Signal| m.restart(&m.pipe_reset(format!("{name}_{l}"), now, 0), 0);
    let ends = m.wire("is_whole", &valid & &incoming.ends);
    let whole = known("arrived", ends.clone());
    let kinds = Whole {
        any: whole.clone(),
        first: known("first_arrived", &ends & &incoming.first),
        other: known("other_arrived", &ends & !&incoming.first),
    };
    let late = |name: &str, signal: &Signal| m.restart(&m.pipe(format!("{name}_arrived"), signal), 0);
    let arrived = Flags {
        begins: incoming.begins.clone(),
        ends: whole.clone(),
        first: late("first", &incoming.first),
        last: late("last", &incoming.last),
        valences: [0, 1].map(|end| late(["top", "bottom"][end], &incoming.valences[end])),
    };
    level.moves(&m, false, &done, &kinds, &arrived);
    let rests = m.wire("rests", !(&level.leaves | &whole));

    let face = m.wire("is_face", !&level.vertex);
    let regular = m.constant(4, Word::unsigned(VALENCE_BITS));
    m.output("ready", m.wire("ready", &rests & !&stands));
    m.output(format!("shift_{l}"), m.wire(format!("shift_{l}"), &valid & &incoming.begins));
    m.output(format!("write_{l}"), m.wire(format!("write_{l}"), &valid));
    m.output("walk", &walk);
    slice.iter().for_each(|slice| m.output("slice", slice));
    m.output("face", &face);
    for (end, name) in ["top", "bottom"].iter().enumerate() {
        let degree = m.wire(format!("{name}_degree"), &level.middle[end]);
        m.output(format!("{name}_degree"), &degree);
        let out = m.wire(format!("{name}_out"), m.select(&face, &regular, &degree));
        m.output(format!("out_{name}_valence"), &out);
    }
    m.output("out_next", m.wire("out_next", &leaves & !&to_output));
    // The output has a vertex when its z comes.
    let put_out = match &axis {
        Some(axis) => m.all(&[&leaves, &to_output, &m.is(axis, 2)]),
        None => &leaves & &to_output,
    };
    m.output("out_output", m.wire("out_output", &put_out));
    m.output("out_begins", &begins);
    m.output("out_ends", m.wire("leaves_whole", &sent));
    if let Some(axis) = &axis {
        let comes = m.input("comes", Word::bit());
        let from = m.input("from_axis", axis.word());
        m.output("axis", axis);
        m.output("looks_at", m.wire("looks_at", m.select(&comes, &from, axis)));
    }
    m.output("out_first", m.wire("leaves_first", m.is(&level.age, 1)));
    m.output("out_last", m.wire("leaves_last", !&level.vertex & &level.guarded));
    m.output("out_ending", m.wire("leaves_ending", &level.vertex & &level.guarded));
    m.output("idle", &rests);
    m.finish()
}
