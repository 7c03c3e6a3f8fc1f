//! The control of a level in a registered core that sends columns in slices: every decision stands in a register.
//!
//! ```text
//! leaves, and there is room behind ──► sends: a slice a clock until the last ──► vertex, leaves
//!                                        └──► the next level, whose column is whole with the last slice
//! ```
//!
//! Whether a column may leave is asked once, in the clock before its first slice. See [`super::control`] for the order
//! of the columns, and for the ports.

use std::rc::Rc;

use super::VALENCE_BITS;
use super::control::{Flags, Level, Ports, WALKS};
use super::engine::slice_bits;
use super::schedule::Group;
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// The control of a group of one level, whose window stands for `walks` clocks from the first slice of a vertex column
/// on. Further output: `walk`, in the clock of that slice.
pub fn build(index: usize, group: &Group, walks: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("strip_control_{index}"));
    m.purpose("Moves the window of a level and says which column leaves.");
    let Ports { valid, incoming, wanted, next_ready, output_ready } = Ports::new(&m);
    let l = group.finest();
    let level = Level::new(&m, l, false);
    // The level of a strip stands before its first column leaves.
    let here = m.pipe("goes_to_output", m.is(&wanted, i128::from(l) + 1));
    let to_output = m.restart(&here, 0);
    let target = m.select(&to_output, &output_ready, &next_ready);

    let flag = |name: &str| m.register_reset(name, Word::bit(), 0);
    let [sends, begins] = ["sends", "sends_first_slice"].map(flag);
    let starts = m.wire("starts", m.all(&[&level.leaves, &!&sends, &target]));
    m.always(&begins, &starts);
    let slices = group.most_slices();
    let (last, slice) = match slice_bits(group) {
        0 => (sends.clone(), None),
        bits => {
            let slice = m.register_reset("slice", Word::unsigned(bits), 0);
            m.on(&starts, &slice, m.constant(0, slice.word()));
            m.on(&sends, &slice, m.wrap(&slice + 1, slice.word()));
            let last = flag("sends_last_slice");
            m.always(&last, &sends & m.is(&slice, i128::from(slices) - 2));
            (last, Some(slice))
        }
    };
    m.on(&starts, &sends, m.bit(true));
    m.on(&last, &sends, m.bit(false));

    // The window stands as long as its ends are being looked at.
    let walk = m.wire("walk", &begins & &level.vertex);
    let rest = m.register_reset(WALKS, Word::range(0, walks.into()), 0);
    let stands = flag("stands");
    m.on(&walk, &rest, m.constant(walks.into(), rest.word()));
    m.on(&stands, &rest, m.wrap(&rest - 1, rest.word()));
    m.on(&walk, &stands, m.bit(true));
    m.on(&m.is(&rest, 1), &stands, m.bit(false));

    // A column that is whole counts a clock later.
    let whole = m.pipe_reset(format!("arrived_{l}"), &valid & &incoming.ends, 0);
    let whole = m.restart(&whole, 0);
    let late = |name: &str, signal: &Signal| m.restart(&m.pipe(format!("{name}_arrived"), signal), 0);
    let arrived = Flags {
        begins: incoming.begins.clone(),
        ends: whole.clone(),
        first: late("first", &incoming.first),
        last: late("last", &incoming.last),
        valences: [0, 1].map(|end| late(["top", "bottom"][end], &incoming.valences[end])),
    };
    level.moves(&m, false, &last, &whole, &arrived);
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
    m.output("out_next", m.wire("out_next", &sends & !&to_output));
    m.output("out_output", m.wire("out_output", &sends & &to_output));
    m.output("out_begins", &begins);
    m.output("out_ends", m.wire("leaves_whole", &last));
    m.output("out_first", m.wire("leaves_first", m.is(&level.age, 1)));
    m.output("out_last", m.wire("leaves_last", !&level.vertex & &level.guarded));
    m.output("out_ending", m.wire("leaves_ending", &level.vertex & &level.guarded));
    m.output("idle", &rests);
    m.finish()
}
