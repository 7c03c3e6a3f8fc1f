//! The buffer between the registered pipeline, which cannot stop, and a consumer that may.
//!
//! ```text
//! issue ──► control ┄┄► data, some clocks behind ──► push ──► RAM ──► register ──► consumer
//!   ▲                                                          │
//!   └── has_room ◄──────────── credits ◄── take ◄──────────────┘
//! ```
//!
//! As [`crate::cores::stream_fifo`], but cut for a high clock: every row of the column has a FIFO with its own
//! pointers, which all do the same; a register stands behind every decision, so what is issued counts two clocks
//! later, and the last words of the RAM are kept for what is on its way. The RAM is made of lookup tables, which are
//! faster than block RAM.

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Credits that are kept back.
const RESERVE: i128 = 4;

/// Whether another column may leave. Inputs: `issue`, `take`. Outputs: `has_room`, and `empty`: nothing is on its way
/// or in the RAM.
pub fn credits(log_depth: u32) -> Result<Rc<Module>> {
    let m = Builder::new("buffer_credits");
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
    let (issued, taken) = (flag("issued", &issue, 0), flag("taken", &take, 0));
    let credits = m.register_reset("credits", Word::range(0, depth), depth);
    m.on(&(&issued & !&taken), &credits, m.wrap(&credits - 1, credits.word()));
    m.on(&(!&issued & &taken), &credits, m.wrap(&credits + 1, credits.word()));
    let reserve = m.constant(RESERVE, Word::range(RESERVE, RESERVE));
    let room = m.compare(Relation::LessOrEqual, &reserve, &credits);
    m.output("has_room", flag("has_room", &room, 1));
    let rests = m.all(&[&m.is(&credits, depth), &!&issued, &!&issue]);
    m.output("empty", flag("empty", &rests, 1));
    m.finish()
}

/// The FIFO of a row. Inputs: `push` and the lanes, `ready`. Outputs: `valid` and the lanes, and `take`: a word goes from
/// the RAM into the register behind it.
pub fn row(name: &str, log_depth: u32, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    let depth = 1i128 << log_depth;
    m.purpose(format!("A FIFO of {depth} words; the pipeline before it runs on credits and never stalls."));
    let [push, ready] = ["push", "ready"].map(|name| m.input(name, Word::bit()));
    let inputs: Vec<_> = lanes.iter().map(|(name, word)| m.input(format!("in_{name}"), *word)).collect();

    let pointer = Word::unsigned(log_depth);
    let [written, read] = ["written", "read"].map(|name| m.register_reset(name, pointer, 0));
    let [some, valid] = ["some", "valid"].map(|name| m.register_reset(name, Word::bit(), 0));
    let stored = m.register_reset("stored", Word::range(0, depth), 0);
    let take = m.wire("take", &some & &(!&valid | &ready));
    m.on(&push, &written, m.wrap(&written + 1, pointer));
    m.on(&take, &read, m.wrap(&read + 1, pointer));
    m.on(&some, &valid, m.bit(true));
    m.on(&ready, &valid, m.bit(false));
    let one = m.wire("one", m.is(&stored, 1));
    m.on(&push, &some, m.bit(true));
    m.on(&(&take & &one), &some, m.bit(false));
    m.on(&(&push & !&take), &stored, m.wrap(&stored + 1, stored.word()));
    m.on(&(!&push & &take), &stored, m.wrap(&stored - 1, stored.word()));

    m.output("take", &take);
    m.output("valid", &valid);
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        let ram = m.memory(&format!("ram_{name}"), depth as u32, *word, vec![]).distributed();
        ram.write(&push, &written, input);
        let lane = m.restart(&ram.read(&format!("read_{name}"), &read, Some(&take)), 0);
        m.output(format!("out_{name}"), &lane);
    }
    m.finish()
}
