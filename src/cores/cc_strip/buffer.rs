//! The buffer between the registered pipeline, which cannot stop, and a consumer that may.
//!
//! ```text
//! issue ──► control ┄┄► data, some clocks behind ──► push ──► RAM ──► register ──► consumer
//!   ▲                                                          │
//!   └── has_room ◄──────────── credits ◄── take ◄──────────────┘
//! ```
//!
//! As [`crate::cores::stream_fifo`], but cut for a high clock: every coordinate of a row has a FIFO with its own
//! pointers, which all do the same; a register stands behind every decision, so what is issued counts two clocks
//! later, and the last words of the RAM are kept for what is on its way. The RAM is made of lookup tables, which are
//! faster than block RAM; where it is deep, it is a block RAM, and what is read from that goes into a short FIFO of
//! lookup tables on credits of its own:
//!
//! ```text
//! push ──► block RAM ──► its register ──► push ──► RAM ──► in the middle ──┬──────────► stands ──► consumer
//!             ▲                                                            └──► spare ────┘
//!             └── has_room ◄── credits ◄── take
//! ```

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Credits that are kept back, beside those of the slices that leave without being asked about.
const RESERVE: i128 = 4;

/// Whether another column may leave. Inputs: `issue`, `take`. Outputs: `has_room`, and `empty`: nothing is on its way
/// or in the RAM.
pub fn credits(log_depth: u32, unasked: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("buffer_credits_{log_depth}"));
    let depth = 1i128 << log_depth;
    m.purpose(
        "One credit for each word of the buffer: who issues a word takes one, who takes a word returns one.",
    );
    let [issue, take] = ["issue", "take"].map(|name| m.input(name, Word::bit()));
    let flag = |name: &str, value: &Signal, reset: i128| {
        let register = m.register_reset(name, Word::bit(), reset);
        m.always(&register, value);
        register
    };
    // What else knows that a word is taken stands far from here.
    let (issued, taken) = (flag("issued", &issue, 0), m.unmerged(flag("taken", &take, 0)));
    let credits = m.register_reset("credits", Word::range(0, depth), depth);
    m.on(&(&issued & !&taken), &credits, m.wrap(&credits - 1, credits.word()));
    m.on(&(!&issued & &taken), &credits, m.wrap(&credits + 1, credits.word()));
    let reserve = RESERVE + i128::from(unasked);
    let reserve = m.constant(reserve, Word::range(reserve, reserve));
    let room = m.compare(Relation::LessOrEqual, &reserve, &credits);
    m.output("has_room", flag("has_room", &room, 1));
    let rests = m.all(&[&m.is(&credits, depth), &!&issued, &!&issue]);
    m.output("empty", flag("empty", &rests, 1));
    m.finish()
}

/// A FIFO of `2^log_depth` words, for a coordinate of a row; `deep` ones are read from block RAM.
///
/// Inputs: `push` and the lanes, `ready`. Outputs: `valid` and the lanes, and `take`: a word leaves the RAM that was
/// written to.
pub fn row(name: &str, log_depth: u32, deep: bool, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    match deep {
        true => far(name, log_depth, lanes),
        false => plain(name, log_depth, lanes),
    }
}

/// The pointers of a FIFO, and whether there is a word: for who reads, and a copy for who counts.
struct Pointers {
    written: Signal,
    read: Signal,
    some: Signal,
    counted: Signal,
}

impl Pointers {
    fn new(m: &Builder, log_depth: u32) -> Pointers {
        let [written, read] =
            [WRITTEN, "read"].map(|name| m.register_reset(name, Word::unsigned(log_depth), 0));
        let [some, counted] = ["some", "some_counted"].map(|name| own(m, name, 0));
        Pointers { written, read, some, counted }
    }

    /// `takes` is `take`, decided by what stands beside the counts.
    fn moves(&self, m: &Builder, push: &Signal, take: &Signal, takes: &Signal) {
        let depth = self.written.word().range.max + 1;
        for (when, pointer) in [(push, &self.written), (take, &self.read)] {
            m.on(when, pointer, m.wrap(pointer + 1, pointer.word()));
        }
        // Counts stand less what they are compared with, so that their signs tell.
        let moves = m.wire("stored_changes", push ^ takes);
        let [step_up, step_down] = [1, -1].map(|step| m.constant(step, Word::range(-1, 1)));
        let step = m.select(push, &step_up, &step_down);
        let at_least = |least: i128| {
            let word = Word::range(-least, depth - least);
            let count = m.register_reset(format!("stored_less_{least}"), word, -least);
            m.on(&moves, &count, m.wrap(&count + &step, word));
            m.wire(format!("stores_{least}"), !&m.slice(&count, word.width() - 1, 1))
        };
        let [one, two] = [1, 2].map(at_least);
        for some in [&self.some, &self.counted] {
            m.always(some, m.any(&[push, &two, &(&one & !takes)]));
        }
    }
}

/// A flag of which there are copies, each beside who reads it.
fn own(m: &Builder, name: &str, reset: i128) -> Signal {
    m.unmerged(m.register_reset(name, Word::bit(), reset))
}

/// The ports that every FIFO has: `push`, `ready` and the lanes.
fn ports(m: &Builder, lanes: &[(&str, Word)]) -> (Signal, Signal, Vec<Signal>) {
    let [push, ready] = ["push", "ready"].map(|name| m.input(name, Word::bit()));
    let lane = |(name, word): &(&str, Word)| m.input(format!("in_{name}"), *word);
    (push, ready, lanes.iter().map(lane).collect())
}

/// The word that is read stands in the register behind the RAM.
fn plain(name: &str, log_depth: u32, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    let depth = 1 << log_depth;
    m.purpose(format!("A FIFO of {depth} words; the pipeline before it runs on credits and never stalls."));
    let (push, ready, inputs) = ports(&m, lanes);
    let pointers = Pointers::new(&m, log_depth);
    let valid = m.register_reset("valid", Word::bit(), 0);
    let takes = |some: &Signal| some & (!&valid | &ready);
    let take = m.wire("take", takes(&pointers.some));
    m.on(&pointers.some, &valid, m.bit(true));
    m.on(&ready, &valid, m.bit(false));
    pointers.moves(&m, &push, &take, &m.wire("takes", takes(&pointers.counted)));
    m.output("take", &take);
    m.output("valid", &valid);
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        let ram = m.memory(&format!("ram_{name}"), depth, *word, vec![]).distributed();
        ram.write(&push, &pointers.written, input);
        let lane = ram.read(&format!("read_{name}"), &pointers.read, Some(&take));
        m.output(format!("out_{name}"), m.restart(&lane, 0));
    }
    m.finish()
}

/// A short FIFO whose RAM does not ask the consumer: the word that is read stands in the middle, and there is a spare
/// register for the one that comes when the consumer stops.
fn near(name: &str, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    m.purpose("A short FIFO: what it reads does not ask the consumer.");
    let (push, ready, inputs) = ports(&m, lanes);
    let pointers = Pointers::new(&m, LOG_NEAR);
    // The output may lie far from the RAM, and the counts from both: all have flags of their own.
    let flags = |reader: &str, some: &Signal| {
        let own = |name: &str, reset: i128| own(&m, &format!("{name}_{reader}"), reset);
        let (valid, middle, spare) = (own("valid", 0), own("in_the_middle", 0), own("spare", 1));
        m.always(&valid, m.any(&[&(&valid & !&ready), &!&spare, &middle]));
        m.on(some, &middle, m.bit(true));
        m.on(&spare, &middle, m.bit(false));
        m.always(&spare, m.any(&[&!&valid, &ready, &(&spare & !&middle)]));
        [valid, middle, spare]
    };
    let takes = |reader: &str, some: &Signal| {
        let [_, middle, spare] = flags(reader, some);
        some & (!middle | spare)
    };
    let take = m.wire("take", takes("read", &pointers.some));
    pointers.moves(&m, &push, &take, &m.wire("takes", takes("counted", &pointers.counted)));
    let [valid, _, spare] = flags("put_out", &pointers.some);
    let free = m.wire("free", !&valid | &ready);
    m.output("take", &take);
    m.output("valid", &valid);
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        let ram = m.memory(&format!("ram_{name}"), 1 << LOG_NEAR, *word, vec![]).distributed();
        ram.write(&push, &pointers.written, input);
        let read = m.restart(&ram.read(&format!("read_{name}"), &pointers.read, Some(&take)), 0);
        let [kept, lane] = ["kept", "stands"].map(|what| m.register(format!("{name}_{what}"), *word));
        m.on(&spare, &kept, &read);
        m.on(&free, &lane, m.select(&spare, &read, &kept));
        m.output(format!("out_{name}"), &lane);
    }
    m.finish()
}

/// A block RAM before a short FIFO, which runs on credits too.
fn far(name: &str, log_depth: u32, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    let depth = 1 << log_depth;
    m.purpose(format!("A FIFO of {depth} words in block RAM; the pipeline before it runs on credits."));
    let (push, ready, inputs) = ports(&m, lanes);
    let pointers = Pointers::new(&m, log_depth);
    let room = m.forward("has_room", Word::bit());
    let take = m.wire("take", &pointers.some & &room);
    pointers.moves(&m, &push, &take, &m.wire("takes", &pointers.counted & &room));
    let mut into = vec![
        ("push".to_string(), m.restart(&m.delay_reset(&take, FETCHES, 0), 0)),
        ("ready".to_string(), ready),
    ];
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        // A word is read a clock after it was written at least.
        let ram = m.memory(&format!("ram_{name}"), depth, *word, vec![]).block().apart();
        ram.write(&push, &pointers.written, input);
        let read = m.pipe(format!("word_{name}"), ram.read(&format!("read_{name}"), &pointers.read, None));
        into.push((format!("in_{name}"), m.restart(&read, 0)));
    }
    let into: Vec<(&str, &Signal)> = into.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
    let placed = m.instance(NEAR, &near(&format!("{name}_near"), lanes)?, &into);
    let credits =
        m.instance("room", &credits(LOG_NEAR, 0)?, &[("issue", &take), ("take", &placed.out("take"))]);
    m.drive(&room, credits.out("has_room"));
    m.output("take", &take);
    m.output("valid", placed.out("valid"));
    lanes.iter().map(|(lane, _)| format!("out_{lane}")).for_each(|lane| m.output(&*lane, placed.out(&lane)));
    m.finish()
}

/// The register that counts through all words of the RAM.
pub const WRITTEN: &str = "written";

/// The short FIFO of a deep one.
pub const NEAR: &str = "near";

/// Its words.
pub const LOG_NEAR: u32 = 4;

/// Clocks from the address of a block RAM to the register at its output.
const FETCHES: u32 = 2;
