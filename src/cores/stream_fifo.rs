//! The buffer between a pipeline that cannot stop and a consumer that may.
//!
//! ```text
//! issue ──► pipeline ──► push ──► RAM ──► register ──► m_valid, lanes ──► consumer
//!   ▲                                 │
//!   └────────── has_room ◄── credits ─┘ (a word leaves the RAM)
//! ```
//!
//! A word may be issued into the pipeline only against a credit, and there are as many credits as words
//! of RAM, so the RAM cannot overflow and the pipeline needs no stall. A word that is read stands behind the RAM, and
//! goes on to a register, which has it early in the clock (block RAMs of most devices have such a register); both wait
//! while the consumer does. The lanes come straight from there and change only when the consumer has taken the word.

use std::rc::Rc;

use crate::error::{Error, Result};
use crate::hdl::{Builder, Module, Signal, Word};

/// Words that may have been issued when the count of credits does not show it yet: one is in the register before
/// `issue`, one in the register of `has_room`.
const UNSEEN: i128 = 2;

/// Clocks from the decision to issue to the credit's return, beside those of the pipeline, and the words that are
/// never used: a FIFO this much deeper than its pipeline keeps it busy.
pub const OVERHEAD: u32 = 12;

/// Bits of the words that one reader takes: two or three block RAMs.
const MOST_TAKEN: u32 = 54;

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

    let mut readers: Vec<Reader> = vec![];
    let mut bits = 0;
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        bits += word.width();
        if readers.is_empty() || bits > MOST_TAKEN {
            readers.push(Reader::new(&m, log_depth, &pushes, &ready));
            bits = word.width();
        }
        // Where there is no word, none is read, perhaps from where one is written: nobody looks at it.
        let Some(Reader { push, written, read, moves_on, .. }) = readers.last() else { continue };
        let ram = m.memory(&format!("ram_{name}"), depth as u32, *word, vec![]).block().apart();
        ram.write(push, written, input);
        let stands = ram.read(&format!("read_{name}"), read, Some(moves_on));
        let lane = m.register(name, *word);
        m.on(moves_on, &lane, m.restart(&stands, 0));
        m.output(format!("out_{name}"), &lane);
    }
    // All of them do the same.
    let Some(Reader { take, valid, .. }) = readers.first() else {
        return Err(Error::usage("a FIFO without lanes"));
    };
    m.output("valid", valid);

    // All words of the RAM but one: a full RAM would look like an empty one.
    let has_room = m.register_reset("has_room", Word::bit(), 0);
    // By way of a register beside the output to one beside the credits.
    let returned = m.restart(&m.delay_reset(take, 2, 0), 0);
    let room = counted(&m, "credits_left", depth, depth - 1 - (UNSEEN + 1), [&issue, &returned], [-1, 1]);
    m.always(&has_room, &room);
    m.output("has_room", &has_room);
    m.finish()
}

/// A count, and whether it is not negative: it stands less what it is compared with, so that its sign tells. It steps
/// where one of two comes without the other, and which of them the first one says.
fn counted(
    m: &Builder,
    name: &str,
    depth: i128,
    start: i128,
    [one, other]: [&Signal; 2],
    steps: [i128; 2],
) -> Signal {
    let word = Word::range(start.min(0) - depth, start.max(0) + depth);
    let count = m.register_reset(name, word, start);
    let [with_one, with_other] = steps.map(|step| m.constant(step, Word::range(-1, 1)));
    let step = m.select(one, &with_one, &with_other);
    m.on(&m.wire(format!("{name}_steps"), one ^ other), &count, m.wrap(&count + &step, word));
    m.wire(format!("{name}_positive"), !&m.slice(&count, word.width() - 1, 1))
}

/// Who decides when some of the words are written and read, by registers of its own: what all of them read would be far
/// from most of them.
struct Reader {
    push: Signal,
    written: Signal,
    read: Signal,
    /// A word leaves the RAM.
    take: Signal,
    /// What stands behind the RAM goes to the output, and the RAM reads, whether there are words or not.
    moves_on: Signal,
    /// The output has a word.
    valid: Signal,
}

impl Reader {
    fn new(m: &Builder, log_depth: u32, pushes: &Signal, ready: &Signal) -> Reader {
        let own = |name: &str, word: Word| m.unmerged(m.register_reset(name, word, 0));
        let [filled, stands, valid] = ["filled", "stands", "valid"].map(|name| own(name, Word::bit()));
        let push = m.restart(&m.unmerged(m.pipe_reset("pushed", pushes, 0)), 0);
        let moves_on = m.wire("moves_on", !&valid | ready);
        // Not by way of `moves_on`, which has readers enough.
        let take = m.wire("take", &filled & (!&valid | ready));
        m.on(&moves_on, &stands, &filled);
        m.on(&moves_on, &valid, &stands);

        let stored = |least: i128| {
            let name = format!("stored_less_{least}");
            counted(m, &name, 1 << log_depth, -least, [&push, &take], [1, -1])
        };
        let (one, two) = (stored(1), stored(2));
        m.always(&filled, &two | &(&one & !&take));

        let [written, read] = [("written", &push), ("read", &take)].map(|(name, steps)| {
            let place = own(name, Word::unsigned(log_depth));
            m.on(steps, &place, m.wrap(&place + 1, place.word()));
            place
        });
        Reader { push, written, read, take, moves_on, valid }
    }
}
