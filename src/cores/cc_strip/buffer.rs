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
//! faster than block RAM.

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Credits that are kept back, beside those of the slices that leave without being asked about.
const RESERVE: i128 = 4;

/// Whether another column may leave. Inputs: `issue`, `take`. Outputs: `has_room`, and `empty`: nothing is on its way
/// or in the RAM.
pub fn credits(log_depth: u32, unasked: u32) -> Result<Rc<Module>> {
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
    let reserve = RESERVE + i128::from(unasked);
    let reserve = m.constant(reserve, Word::range(reserve, reserve));
    let room = m.compare(Relation::LessOrEqual, &reserve, &credits);
    m.output("has_room", flag("has_room", &room, 1));
    let rests = m.all(&[&m.is(&credits, depth), &!&issued, &!&issue]);
    m.output("empty", flag("empty", &rests, 1));
    m.finish()
}

/// Words of a bank of a deep buffer: as many as can be read within a clock.
const LOG_BANK: u32 = 6;

/// The FIFO of a coordinate of a row, of a bank more than one where it is deep: then the word of the bank in turn stands
/// in a register between the banks and the output, and there is a spare one for the word that comes when the consumer
/// stops: what is read from the RAM does not ask the consumer.
///
/// ```text
/// banks ──► in the middle ──┬──────────► stands ──► consumer
///                           └──► spare ────┘
/// ```
///
/// Inputs: `push` and the lanes, `ready`. Outputs: `valid` and the lanes, and `take`: a word goes from the RAM into the
/// register behind it.
pub fn row(name: &str, log_depth: u32, deep: bool, lanes: &[(&str, Word)]) -> Result<Rc<Module>> {
    let m = Builder::new(name);
    let depth = 1i128 << log_depth;
    m.purpose(format!("A FIFO of {depth} words; the pipeline before it runs on credits and never stalls."));
    let [push, ready] = ["push", "ready"].map(|name| m.input(name, Word::bit()));
    let inputs: Vec<_> = lanes.iter().map(|(name, word)| m.input(format!("in_{name}"), *word)).collect();

    let pointer = Word::unsigned(log_depth);
    let [written, read] = [WRITTEN, "read"].map(|name| m.register_reset(name, pointer, 0));
    let [some, valid] = ["some", "valid"].map(|name| m.register_reset(name, Word::bit(), 0));
    let free = m.wire("free", !&valid | &ready);
    let steps = deep.then(|| {
        let middle = m.register_reset(MIDDLE, Word::bit(), 0);
        let spare = m.register_reset(SPARE, Word::bit(), 1);
        m.on(&some, &middle, m.bit(true));
        m.on(&spare, &middle, m.bit(false));
        m.always(&spare, &free | &(&spare & &!&middle));
        m.on(&free, &valid, !&spare | &middle);
        (middle, spare)
    });
    let room = steps.as_ref().map_or(free.clone(), |(middle, spare)| !middle | spare);
    let take = m.wire("take", &some & &room);
    if !deep {
        m.on(&some, &valid, m.bit(true));
        m.on(&ready, &valid, m.bit(false));
    }
    m.on(&push, &written, m.wrap(&written + 1, pointer));
    m.on(&take, &read, m.wrap(&read + 1, pointer));

    // Counts stand less what they are compared with, so that their signs tell.
    let moves = m.wire("stored_changes", &push ^ &take);
    let [step_up, step_down] = [1, -1].map(|step| m.constant(step, Word::range(-1, 1)));
    let step = m.select(&push, &step_up, &step_down);
    let at_least = |least: i128| {
        let word = Word::range(-least, depth - least);
        let count = m.register_reset(format!("stored_less_{least}"), word, -least);
        m.on(&moves, &count, m.wrap(&count + &step, word));
        m.wire(format!("stores_{least}"), !&m.slice(&count, word.width() - 1, 1))
    };
    let [one, two] = [1, 2].map(at_least);
    m.always(&some, m.any(&[&push, &two, &(&one & &!&take)]));

    m.output("take", &take);
    m.output("valid", &valid);
    let Some((_, spare)) = &steps else {
        for ((name, word), input) in lanes.iter().zip(&inputs) {
            let ram = m.memory(&format!("ram_{name}"), depth as u32, *word, vec![]).distributed();
            ram.write(&push, &written, input);
            let lane = m.restart(&ram.read(&format!("read_{name}"), &read, Some(&take)), 0);
            m.output(format!("out_{name}"), &lane);
        }
        return m.finish();
    };
    let banks = 1u32 << log_depth.saturating_sub(LOG_BANK);
    let size = (depth as u32) / banks;
    let within = |pointer: &Signal| m.slice(pointer, 0, size.ilog2());
    // The bank of the word in the middle.
    let turn: Vec<Signal> = (0..banks.ilog2())
        .map(|bit| {
            let digit = m.slice(&read, log_depth - banks.ilog2() + bit, 1);
            let turn = m.register(format!("turn_{bit}"), Word::bit());
            m.on(&take, &turn, &digit);
            turn
        })
        .collect();
    for ((name, word), input) in lanes.iter().zip(&inputs) {
        let mut words: Vec<Signal> = (0..banks)
            .map(|bank| {
                let here = |pointer: &Signal| bank_of(&m, pointer, banks, bank);
                let ram = m.memory(&format!("ram_{name}_{bank}"), size, *word, vec![]).distributed();
                ram.write(&(&push & &here(&written)), &within(&written), input);
                let enable = &take & &here(&read);
                m.restart(&ram.read(&format!("read_{name}_{bank}"), &within(&read), Some(&enable)), 0)
            })
            .collect();
        for bit in 0..banks.ilog2() {
            let chosen = |pair: &[Signal]| m.select(&turn[bit as usize], &pair[1], &pair[0]);
            words = words.chunks(2).map(chosen).collect();
        }
        let [kept, lane] = ["kept", "stands"].map(|what| m.register(format!("{name}_{what}"), *word));
        m.on(spare, &kept, &words[0]);
        m.on(&free, &lane, m.select(spare, &words[0], &kept));
        m.output(format!("out_{name}"), &lane);
    }
    m.finish()
}

/// The register that counts through all words of the RAM.
pub const WRITTEN: &str = "written";

/// The register of a deep buffer that says that a word stands between the banks and the output.
pub const MIDDLE: &str = "in_the_middle";

/// That which says that no word waits beside the output.
const SPARE: &str = "spare";

/// Whether a pointer is in a bank.
fn bank_of(m: &Builder, pointer: &Signal, banks: u32, bank: u32) -> Signal {
    match banks.ilog2() {
        0 => m.bit(true),
        bits => m.is(&m.slice(pointer, pointer.width() - bits, bits), bank.into()),
    }
}
