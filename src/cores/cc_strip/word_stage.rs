//! The word that waits before the loader of a walked core.
//!
//! ```text
//! s_axis ──► word, full ──► judged: the loader has looked at it, and knows of the word before ──► taken
//! ```
//!
//! A word takes six clocks at least, of which a column of a fine strip has many.

use crate::hdl::{Builder, Signal, StreamInput, Word};

/// The word, and what moves it.
pub struct WordStage {
    pub word: StreamInput,
    /// To be driven: the word is taken.
    pub goes: Signal,
    /// There is none.
    pub free: Signal,
}

/// The stage behind a port.
pub fn build(m: &Builder, port: &StreamInput) -> WordStage {
    let flag = |name: &str| m.register_reset(name, Word::bit(), 0);
    let full = flag("word_is_here");
    let goes = m.forward("word_is_taken", Word::bit());
    let free = m.wire("word_is_free", !&full);
    // No choice, of which synthesis would make a gate before the reset: that gate then lies far from a copy of the flag.
    m.always(&full, m.any(&[&port.valid, &full]) & !&goes);
    let judged =
        ["word_is_seen", "word_is_known", "word_is_judged"].into_iter().fold(full.clone(), |before, name| {
            let after = flag(name);
            m.always(&after, &before & !&goes);
            after
        });
    let keep = |name: &str, signal: &Signal| {
        let register = m.register(format!("word_{name}"), signal.word());
        m.on(&free, &register, signal);
        register
    };
    let lanes = port.lanes.iter().zip(["x", "y", "z"]).map(|(lane, axis)| keep(axis, lane)).collect();
    let word = StreamInput {
        lanes,
        user: keep("user", &port.user),
        last: keep("is_last", &port.last),
        valid: judged,
    };
    WordStage { word, goes, free }
}
