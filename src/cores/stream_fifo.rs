//! The buffer between a pipeline that cannot stop and a consumer that may.
//!
//! ```text
//! issue ──► pipeline ──► push ──► RAM ──► m_valid, lanes ──► consumer
//!   ▲                                        │
//!   └───────────── has_room ◄── credits ◄────┘ (a word leaves the RAM)
//! ```
//!
//! A word may be issued into the pipeline only against a credit, and there are as many credits as words
//! of RAM, so the RAM cannot overflow and the pipeline needs no stall. The lanes come straight from the
//! read registers of the RAM and change only when the consumer has taken the word.

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// Words that may have been issued when the count of credits does not show it yet: one is in the register before
/// `issue`, one in the register of `has_room`.
const UNSEEN: i128 = 2;

/// Clocks from the decision to issue to the credit's return, beside those of the pipeline, and the words that are
/// never used: a FIFO this much deeper than its pipeline keeps it busy.
pub const OVERHEAD: u32 = 12;

/// Bits that one count reads from the RAM, and that one signal takes from there.
const MOST_READ: u32 = 16;
const MOST_TAKEN: u32 = 32;

/// A FIFO of 2^`log_depth` words made of `lanes`.
///
/// Inputs: `issue` (a word entered the pipeline in the clock before), `push` (one leaves it in the clock after) and then
/// the lanes, `ready`.
/// Outputs: `has_room` (one more may be issued), `valid` and the lanes.
pub fn build(log_depth: u32, lanes: &[(String, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new("stream_fifo");
    let depth = 1i128 << log_depth;
    m.purpose(format!("A FIFO of {depth} words behind a pipeline that runs on credits and never stalls."));
    let [issue, pushes, ready] = ["issue", "push", "ready"].map(|name| m.input(name, Word::bit()));
    let inputs: Vec<_> = lanes.iter().map(|(name, word)| m.input(format!("in_{name}"), *word)).collect();

    let pointer = Word::unsigned(log_depth);
    let valid = m.register_reset("valid", Word::bit(), 0);
    let filled = m.register_reset("filled", Word::bit(), 0);
    let takes = |filled: &Signal, valid: &Signal| filled & &(!valid | &ready);
    let take = m.wire("take", takes(&filled, &valid));

    let pushed = |name: &str| m.restart(&m.unmerged(m.pipe_reset(name, &pushes, 0)), 0);
    let push = pushed("pushed");
    m.on(&take, &valid, m.bit(true));
    m.on(&ready, &valid, m.bit(false));

    // Counts stand less what they are compared with, so that their signs tell; they step where one comes or one goes,
    // and which of the two a register says.
    let counted = |name: &str, start: i128, comes: &Signal, goes: &Signal, comes_or_goes: [i128; 2]| {
        let word = Word::range(start.min(0) - depth, start.max(0) + depth);
        let count = m.register_reset(name, word, start);
        let [one, other] = comes_or_goes.map(|step| m.constant(step, Word::range(-1, 1)));
        let step = m.select(comes, &one, &other);
        m.on(&m.wire(format!("{name}_steps"), comes ^ goes), &count, m.wrap(&count + &step, word));
        m.wire(format!("{name}_positive"), !&m.slice(&count, word.width() - 1, 1))
    };
    let one = counted("stored_less_1", -1, &push, &take, [1, -1]);
    let two = counted("stored_less_2", -2, &push, &take, [1, -1]);
    let stays_filled = |take: &Signal| &two | &(&one & !take);
    m.always(&filled, stays_filled(&take));

    // All words of the RAM but one: a full RAM would look like an empty one.
    let has_room = m.register_reset("has_room", Word::bit(), 0);
    // By way of a register beside the output to one beside the credits.
    let returned = m.restart(&m.delay_reset(&take, 2, 0), 0);
    let room = counted("credits_left", depth - 1 - (UNSEEN + 1), &issue, &returned, [-1, 1]);
    m.always(&has_room, &room);
    m.output("has_room", &has_room);

    m.output("valid", &valid);
    // Bits are put and taken by several signals, each decided from registers of its own, at places that these count.
    let place = |name: &str, steps: &Signal| {
        let place = m.unmerged(m.register_reset(name, pointer, 0));
        m.on(steps, &place, m.wrap(&place + 1, pointer));
        place
    };
    let (mut at, mut bits, mut reads) = (None, MOST_TAKEN, 0);
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        if bits + word.width() > MOST_TAKEN {
            at = None;
            bits = 0;
        }
        bits += word.width();
        let (push, written, take, read) = at.get_or_insert_with(|| {
            let copy = |name: &str| m.unmerged(m.register_reset(format!("{name}_copy"), Word::bit(), 0));
            let (filled, valid) = (copy("filled"), copy("valid"));
            let take = m.wire("take_copy", takes(&filled, &valid));
            m.always(&filled, stays_filled(&take));
            m.on(&take, &valid, m.bit(true));
            m.on(&ready, &valid, m.bit(false));
            let push = pushed("pushed_copy");
            reads = 0;
            (push.clone(), place("written", &push), take.clone(), place("read", &take))
        });
        if reads > 0 && reads + word.width() > MOST_READ {
            (*read, reads) = (place("read", take), 0);
        }
        reads += word.width();
        let ram = m.memory(&format!("ram_{name}"), depth as u32, *word, vec![]);
        ram.write(push, written, input);
        let lane = m.restart(&ram.read(&format!("read_{name}"), read, Some(take)), 0);
        m.output(format!("out_{name}"), &lane);
    }
    m.finish()
}
