//! How the control of a walked level sends a column: which slice, and of which coordinate.
//!
//! ```text
//! at once    start ──► 0 1 2 ..                            a slice a clock, of x, y and z
//! in turn    start ──► x 0 1 2 .. | y 0 1 2 .. | z 0 1 2 ..
//!                      a period   │ a period   │ a vertex column: a period, a face column: the slices
//! ```
//!
//! A period is long enough for a walk around both ends of one coordinate. What happens next stands in a register.

use super::engine::slice_bits;
use super::schedule::Group;
use crate::hdl::{Builder, Signal, Word};

/// The register that counts the clocks of a coordinate's turn.
pub const PERIOD: &str = "clock_of_turn";

/// The word that says which coordinate is in turn.
pub fn axis_word() -> Word {
    Word::range(0, 2)
}

/// What leaves.
pub struct Sending {
    /// A column is on its way.
    pub sends: Signal,
    /// A slice leaves.
    pub leaves: Signal,
    /// It is the first one, of a coordinate where they take turns.
    pub begins: Signal,
    /// It is the last one of the column.
    pub whole: Signal,
    /// The last clock that the column takes.
    pub done: Signal,
    pub slice: Option<Signal>,
    pub axis: Option<Signal>,
}

/// Clocks of a coordinate's turn, for a window that stands so long for a walk.
pub fn period(group: &Group, walks: u32) -> u32 {
    // A walk sees its last neighbour two clocks behind those that the window stands for by itself.
    (walks + 2).max(group.most_slices())
}

/// All coordinates at once, in the clock after `starts`.
pub fn at_once(m: &Builder, group: &Group, starts: &Signal) -> Sending {
    let flag = |name: &str| m.register_reset(name, Word::bit(), 0);
    let [sends, begins] = ["sends", "sends_first_slice"].map(flag);
    m.always(&begins, starts);
    let slices = i128::from(group.most_slices());
    let (last, slice) = match slice_bits(group) {
        0 => (sends.clone(), None),
        bits => {
            let slice = m.register_reset("slice", Word::unsigned(bits), 0);
            m.on(&sends, &slice, m.wrap(&slice + 1, slice.word()));
            let last = flag("sends_last_slice");
            m.always(&last, &sends & m.is(&slice, slices - 2));
            (last, Some(slice))
        }
    };
    m.on(starts, &sends, m.bit(true));
    m.on(&last, &sends, m.bit(false));
    Sending { leaves: sends.clone(), whole: last.clone(), done: last, sends, begins, slice, axis: None }
}

/// One coordinate after the other, the first in the clock after `starts`.
pub fn in_turn(m: &Builder, group: &Group, starts: &Signal, vertex: &Signal, period: u32) -> Sending {
    let flag = |name: &str| m.register_reset(name, Word::bit(), 0);
    let period = i128::from(period);
    let [sends, begins, ends_turn, at_z] = ["sends", "sends_first_slice", "ends_turn", "at_z"].map(flag);
    let clock = m.register_reset(PERIOD, Word::range(0, period - 1), 0);
    let axis = m.register_reset("axis", axis_word(), 0);
    let ending = m.wire("turn_is_ending", &sends & m.is(&clock, period - 2));
    m.always(&ends_turn, &ending);
    // A column that begins or goes on, but not to another turn.
    let restarts = m.register_reset("clock_restarts", Word::bit(), 1);
    let done = flag("column_is_done");
    let goes_on = starts | &(&sends & !&done);
    m.always(&restarts, !&goes_on | &ending);
    let zero = m.constant(0, clock.word());
    m.on(&restarts, &clock, &zero);
    m.always(&clock, m.wrap(&clock + 1, clock.word()));
    m.on(&!&sends, &axis, m.constant(0, axis.word()));
    m.on(&(&ends_turn & !&at_z), &axis, m.wrap(&axis + 1, axis.word()));
    m.on(&!&sends, &at_z, m.bit(false));
    m.on(&(&ends_turn & m.is(&axis, 1)), &at_z, m.bit(true));
    let next = m.wire("begins_turn", starts | &(&ends_turn & !&at_z));
    m.always(&begins, &next);

    let slices = i128::from(group.most_slices());
    let (leaves, last, slice) = match slice_bits(group) {
        0 => (begins.clone(), begins.clone(), None),
        bits => {
            let [leaves, last] = ["slice_leaves", "sends_last_slice"].map(flag);
            m.on(&next, &leaves, m.bit(true));
            m.on(&last, &leaves, m.bit(false));
            m.always(&last, &leaves & m.is(&clock, slices - 2));
            (leaves, last, Some(m.slice(&clock, 0, bits)))
        }
    };
    // A clock before.
    let at_last = |clocks: i128| m.all(&[&sends, &at_z, &m.is(&clock, clocks - 2)]);
    let all_slices = if slices == 1 { &ends_turn & m.is(&axis, 1) } else { at_last(slices) };
    m.always(&done, m.select(vertex, at_last(period), &all_slices));
    m.on(starts, &sends, m.bit(true));
    m.on(&done, &sends, m.bit(false));
    let whole = m.wire("column_is_whole", &last & &at_z);
    Sending { sends, leaves, begins, whole, done, slice, axis: Some(axis) }
}
