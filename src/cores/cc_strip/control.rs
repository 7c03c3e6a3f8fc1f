//! The control of a group of levels: which window moves, which column leaves, and from which level.
//!
//! ```text
//! column c arrives at a level    c = -1   nothing leaves
//!                                c =  0   the face column -1
//!                                c >= 1   the vertex column 2 (c - 1), then the face column 2 c - 1
//! ```
//!
//! So the next level receives exactly the columns -1 .. 2 M + 1 of the finer strip, in order. In each clock the
//! unit serves the finest level whose column can be taken: by the next level of the group when that has nothing
//! to send, by the next group, or, from the level that the strip asks for, by the output. A column that leaves
//! in slices is finished before another one begins. Source: Hall, section 4.1; the order is that of its
//! recursion.

use std::rc::Rc;

use super::engine::{equals, slice_bits};
use super::schedule::Group;
use super::{LEVEL_BITS, VALENCE_BITS};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// The register of the control of a walked core that counts for how many clocks more the window stands.
pub const WALKS: &str = "clocks_of_walk";

/// What goes with a column or a slice of it.
pub(super) struct Flags {
    /// The first and the last slice of the column.
    pub begins: Signal,
    pub ends: Signal,
    /// The left and the right guard of the strip.
    pub first: Signal,
    pub last: Signal,
    pub valences: [Signal; 2],
}

/// That a column is whole: any, the left guard of the strip, another one.
pub(super) struct Whole {
    pub any: Signal,
    pub first: Signal,
    pub other: Signal,
}

/// The inputs of the control of a group, of either kind.
pub(super) struct Ports {
    pub valid: Signal,
    pub incoming: Flags,
    /// The level that the strip asks for.
    pub wanted: Signal,
    pub next_ready: Signal,
    pub output_ready: Signal,
}

impl Ports {
    pub fn new(m: &Builder) -> Ports {
        let bit = |name: &str| m.input(name, Word::bit());
        let valid = bit("valid");
        let valence = Word::unsigned(VALENCE_BITS);
        let incoming = Flags {
            begins: bit("begins"),
            ends: bit("ends"),
            first: bit("first"),
            last: bit("last"),
            valences: ["top", "bottom"].map(|end| m.input(format!("{end}_valence"), valence)),
        };
        let wanted = m.input("level", Word::unsigned(LEVEL_BITS));
        let [next_ready, output_ready] = ["next_ready", "output_ready"].map(bit);
        Ports { valid, incoming, wanted, next_ready, output_ready }
    }
}

/// Inputs: what comes in (`valid`, `begins`, `ends`, `first`, `last`, `top_valence`, `bottom_valence`), the `level`
/// that the strip asks for, `next_ready` and `output_ready`.
/// Outputs: `ready`, `shift_l` and `write_l` for each level, `serve_l`, `slice`, `face`, the valences of the middle
/// column; what leaves (`out_..`) when it does, to the `next` group or to the `output`; and `idle`.
///
/// In a `registered` core no decision goes through two levels within a clock: a level has room when nothing is to leave
/// it; only the level that puts out has it one clock earlier, when the last of its column leaves.
pub fn build(index: usize, group: &Group, registered: bool) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("strip_control_{index}"));
    m.purpose("Moves the windows of a group of levels and says which column leaves.");
    let Ports { valid, incoming, wanted, next_ready, output_ready } = Ports::new(&m);

    let levels: Vec<Level> = group.levels.clone().map(|level| Level::new(&m, level, group.double)).collect();
    let to_output: Vec<Signal> = levels
        .iter()
        .map(|l| m.wire(format!("to_output_{}", l.level), m.is(&wanted, i128::from(l.level) + 1)))
        .collect();
    let targets: Vec<Signal> = levels
        .iter()
        .zip(&to_output)
        .enumerate()
        .map(|(at, (l, to_output))| {
            let next = levels.get(at + 1).map_or(next_ready.clone(), |finer| !&finer.leaves);
            m.wire(format!("target_{}", l.level), m.select(to_output, &output_ready, &next))
        })
        .collect();
    let turn = Turn::new(&m, group, &levels, &targets);

    // What leaves, of the level that is served.
    let of_served = |name: &str, of: &dyn Fn(&Level) -> Signal| {
        let mut chosen = of(&levels[0]);
        for (level, serve) in levels.iter().zip(&turn.serve).skip(1) {
            chosen = m.select(serve, of(level), &chosen);
        }
        m.wire(name, &chosen)
    };
    let face = if group.double { m.bit(false) } else { of_served("is_face", &|l| !&l.vertex) };
    let degrees =
        [0, 1].map(|end| of_served(["top_degree", "bottom_degree"][end], &|l| l.middle[end].clone()));
    let regular = m.constant(4, Word::unsigned(VALENCE_BITS));
    let leaving = Flags {
        begins: turn.first_slice.clone(),
        ends: m.wire("leaves_whole", any(&m, &turn.done)),
        first: of_served("leaves_first", &|l| m.is(&l.age, 1)),
        last: of_served("leaves_last", &|l| !&l.vertex & &l.guarded),
        valences: [0, 1]
            .map(|end| m.wire(["top_out", "bottom_out"][end], m.select(&face, &regular, &degrees[end]))),
    };

    for (at, level) in levels.iter().enumerate() {
        let l = level.level;
        let (write, flags) = match at {
            0 => {
                // The slot of a column that is read for the last time may be filled in the same clock.
                let last_read = match registered {
                    _ if group.double => turn.done[0].clone(),
                    false => &turn.done[0] & !&level.vertex,
                    // The loader's level waits.
                    true if index == 0 => m.bit(false),
                    true => {
                        let last_slice = turn.slice.as_ref().map(|slice| m.is(slice, slice.word().range.max));
                        let goes = m.all(&[&level.leaves, &!&level.vertex, &to_output[0], &output_ready]);
                        last_slice.map_or(goes.clone(), |last| &goes & &last)
                    }
                };
                let ready = m.wire("ready", !&level.leaves | &last_read);
                m.output("ready", &ready);
                (&valid & &ready, &incoming)
            }
            _ => (&turn.serve[at - 1] & !&to_output[at - 1], &leaving),
        };
        let write = m.wire(format!("write_{l}"), write);
        m.output(format!("shift_{l}"), m.wire(format!("shift_{l}"), &write & &flags.begins));
        m.output(format!("write_{l}"), &write);
        let whole = m.wire(format!("arrived_{l}"), &write & &flags.ends);
        let whole = Whole { first: &whole & &flags.first, other: &whole & !&flags.first, any: whole };
        level.moves(&m, group.double, &turn.done[at], &whole, flags);
    }

    if levels.len() > 1 {
        levels.iter().zip(&turn.serve).for_each(|(l, serve)| m.output(format!("serve_{}", l.level), serve));
    }
    if let Some(slice) = &turn.slice {
        m.output("slice", slice);
    }
    if !group.double {
        m.output("face", &face);
    }
    m.output("top_degree", &degrees[0]);
    m.output("bottom_degree", &degrees[1]);
    let last = levels.len() - 1;
    m.output("out_next", m.wire("out_next", &turn.serve[last] & !&to_output[last]));
    let sent: Vec<Signal> = turn.serve.iter().zip(&to_output).map(|(serve, to)| serve & to).collect();
    m.output("out_output", m.wire("out_output", any(&m, &sent)));
    m.output("out_begins", &leaving.begins);
    m.output("out_ends", &leaving.ends);
    m.output("out_first", &leaving.first);
    m.output("out_last", &leaving.last);
    m.output("out_ending", of_served("leaves_ending", &|l| &l.vertex & &l.guarded));
    m.output("out_top_valence", &leaving.valences[0]);
    m.output("out_bottom_valence", &leaving.valences[1]);
    let leaves: Vec<Signal> = levels.iter().map(|l| l.leaves.clone()).collect();
    m.output("idle", m.wire("idle", !any(&m, &leaves)));
    m.finish()
}

fn any(m: &Builder, signals: &[Signal]) -> Signal {
    match signals {
        [one] => one.clone(),
        _ => m.any(&signals.iter().collect::<Vec<_>>()),
    }
}

/// Whose turn it is.
struct Turn {
    /// By level: a slice of it leaves in this clock; it is the last one of its column.
    serve: Vec<Signal>,
    done: Vec<Signal>,
    /// The number of the slice, where columns leave in slices.
    slice: Option<Signal>,
    first_slice: Signal,
}

impl Turn {
    fn new(m: &Builder, group: &Group, levels: &[Level], targets: &[Signal]) -> Turn {
        let bits = slice_bits(group);
        let slice = (bits > 0).then(|| m.register_reset("slice", Word::unsigned(bits), 0));
        let within = slice.as_ref().map(|slice| m.wire("within_column", m.is_not(slice, 0)));
        // Which level's column is on its way.
        let active: Vec<Option<Signal>> = levels
            .iter()
            .map(|l| slice.as_ref().map(|_| m.register_reset(format!("active_{}", l.level), Word::bit(), 0)))
            .collect();

        let (mut serve, mut finer) = (vec![], m.bit(false));
        for (at, level) in levels.iter().enumerate().rev() {
            let mut can = &level.leaves & &targets[at];
            if let (Some(within), Some(active)) = (&within, &active[at]) {
                can = &can & (!within | active);
            }
            let can = m.wire(format!("can_{}", level.level), &can);
            serve.push(m.wire(format!("serve_{}", level.level), &can & !&finer));
            finer = &finer | &can;
        }
        serve.reverse();

        let digits: Vec<Signal> =
            slice.iter().flat_map(|slice| (0..bits).map(|at| m.slice(slice, at, 1))).collect();
        let done: Vec<Signal> = levels
            .iter()
            .zip(&serve)
            .map(|(l, serve)| {
                let count = group.slices(l.level);
                let last = equals(m, &digits[..count.ilog2() as usize], count - 1);
                m.wire(format!("done_{}", l.level), last.map_or(serve.clone(), |last| serve & &last))
            })
            .collect();
        if let Some(slice) = &slice {
            m.on(&any(m, &done), slice, m.constant(0, slice.word()));
            m.on(&any(m, &serve), slice, m.wrap(slice + 1, slice.word()));
            for ((active, serve), done) in active.iter().flatten().zip(&serve).zip(&done) {
                m.on(done, active, m.bit(false));
                m.on(serve, active, m.bit(true));
            }
        }
        let first_slice = slice.as_ref().map_or(m.bit(true), |slice| m.wire("first_slice", m.is(slice, 0)));
        Turn { serve, done, slice, first_slice }
    }
}

/// The state of a level.
pub(super) struct Level {
    level: u32,
    /// A vertex column is to leave, before a face column.
    pub vertex: Signal,
    /// Something is to leave.
    pub leaves: Signal,
    /// The columns of the strip that are here: none or one (0), two (1), three (2).
    pub age: Signal,
    /// The right guard is here.
    pub guarded: Signal,
    /// Valences of the next and of the middle column.
    pub next: [Signal; 2],
    pub middle: [Signal; 2],
}

impl Level {
    pub fn new(m: &Builder, level: u32, double: bool) -> Level {
        let name = |what: &str| format!("{what}_{level}");
        let vertex = m.register_reset(name("vertex"), Word::bit(), 0);
        // Where both columns leave at once, there is nothing between vertex column and rest.
        let leaves = if double { vertex.clone() } else { m.register_reset(name("leaves"), Word::bit(), 0) };
        let valences = |stage: &str| {
            ["top", "bottom"]
                .map(|end| m.register(format!("{end}_{stage}_{level}"), Word::unsigned(VALENCE_BITS)))
        };
        Level {
            level,
            vertex,
            leaves,
            age: m.register_reset(name("age"), Word::range(0, 2), 0),
            guarded: m.register_reset(name("guarded"), Word::bit(), 0),
            next: valences("next"),
            middle: valences("middle"),
        }
    }

    /// `done`: a column has left; `whole`: one has arrived.
    pub fn moves(&self, m: &Builder, double: bool, done: &Signal, whole: &Whole, flags: &Flags) {
        let l = self.level;
        let none = m.is(&self.age, 0);
        let Whole { any: whole, first, other } = whole;
        let first = m.wire(format!("first_{l}"), first);
        let second = m.wire(format!("second_{l}"), other & &none);
        let later = m.wire(format!("later_{l}"), other & !&none);
        for (when, age) in [(&first, 0), (&second, 1), (&later, 2)] {
            m.on(when, &self.age, m.constant(age, self.age.word()));
        }
        m.on(&later, &self.vertex, m.bit(true));
        m.on(done, &self.vertex, m.bit(false));
        if !double {
            m.on(other, &self.leaves, m.bit(true));
            m.on(&(done & !&self.vertex), &self.leaves, m.bit(false));
        }
        m.on(whole, &self.guarded, &flags.last);
        for end in [0, 1] {
            m.on(whole, &self.next[end], &flags.valences[end]);
            m.on(whole, &self.middle[end], &self.next[end]);
        }
    }
}
