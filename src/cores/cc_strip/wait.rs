//! Signals at a later clock: where that is long, through RAMs made of lookup tables that a counter goes through.
//!
//! ```text
//! turn ──► written ──► RAM of 16 words ──► register ──► late
//!   └─ - k ──► read ────┘
//! ```
//!
//! One counter of a module serves all of its RAMs. It alone is reset, and one register alone reads it: that one and the
//! next may be copied all over the device, for a copy needs no reset, which reaches few registers in a clock.
//!
//! Block RAMs would take fewer cells, but stand in few rows of a device: of a core of five levels, 51 of them made all
//! wires together 30 percent longer.

use std::cell::OnceCell;

use crate::hdl::{Builder, Signal, Word};

/// Words whose RAMs share registers of the addresses.
const WORDS_OF_AN_ADDRESS: usize = 8;

/// The bits of an address of a RAM.
const LOG_WORDS: u32 = 4;

/// The waits that a RAM makes; shorter ones are registers.
const CLOCKS: std::ops::RangeInclusive<u32> = 4..=17;

/// The waits of a module.
pub struct Waits<'a> {
    pub m: &'a Builder,
    turn: OnceCell<Signal>,
}

impl<'a> Waits<'a> {
    pub fn new(m: &'a Builder) -> Waits<'a> {
        Waits { m, turn: OnceCell::new() }
    }

    /// The counter, which never stops, two clocks late.
    fn turn(&self) -> &Signal {
        self.turn.get_or_init(|| {
            let turn = self.m.register_reset("turn_of_waits", Word::unsigned(LOG_WORDS), 0);
            self.m.always(&turn, self.m.wrap(&turn + 1, turn.word()));
            let sent = self.m.copy("turn_sent", &turn);
            self.m.restart(&self.m.copy("turn_goes_round", &sent), 0)
        })
    }

    /// The signals, which are renamed, at clock `until`. `name` is that of the addresses.
    pub fn until(&self, name: &str, signals: &[(String, Signal)], until: u32) -> Vec<Signal> {
        let m = self.m;
        // What comes earlier waits for longer, not first for the others.
        let mut times: Vec<u32> = signals.iter().filter_map(|(_, signal)| signal.time()).collect();
        times.sort_unstable();
        times.dedup();
        if times.len() > 1 {
            let mut late: Vec<Signal> = signals.iter().map(|(_, signal)| signal.clone()).collect();
            for time in times {
                let here: Vec<usize> =
                    (0..signals.len()).filter(|&at| signals[at].1.time() == Some(time)).collect();
                let group: Vec<(String, Signal)> = here.iter().map(|&at| signals[at].clone()).collect();
                for (at, signal) in here.into_iter().zip(self.until(&format!("{name}_{time}"), &group, until))
                {
                    late[at] = signal;
                }
            }
            return late;
        }
        let from = signals.iter().filter_map(|(_, signal)| signal.time()).max().unwrap_or(0);
        let clocks = until.saturating_sub(from);
        if clocks > *CLOCKS.end() {
            // As many RAMs one behind the other as it takes, all of about one length.
            let hops = clocks.div_ceil(*CLOCKS.end());
            let late = self.until(&format!("{name}_{hops}"), signals, from + clocks / hops);
            let names = signals.iter().map(|(word, _)| format!("{word}_{hops}"));
            let signals: Vec<(String, Signal)> = names.zip(late).collect();
            return self.until(name, &signals, until);
        }
        if !CLOCKS.contains(&clocks) {
            return signals.iter().map(|(_, signal)| m.at_time(signal, until)).collect();
        }
        self.through_rams(name, signals, from, until)
    }

    /// What is read stands in the register behind the RAM a clock later.
    fn through_rams(&self, name: &str, signals: &[(String, Signal)], from: u32, until: u32) -> Vec<Signal> {
        let m = self.m;
        let turn = self.turn();
        let back = i128::from(until - from) - 1;
        let address = |port: &str, nth: usize, value: &Signal| {
            m.restart(&m.copy(format!("{name}_{nth}_{port}"), value), from)
        };
        let behind = m.wrap(turn - back, turn.word());
        let mut addresses = [turn.clone(), behind.clone()];
        let mut late = vec![];
        for (nth, (word, signal)) in signals.iter().enumerate() {
            if nth % WORDS_OF_AN_ADDRESS == 0 {
                addresses = [address("written", nth, turn), address("read", nth, &behind)];
            }
            let ram = m.memory(&format!("late_{word}"), 1 << LOG_WORDS, signal.word(), vec![]).distributed();
            ram.write(&m.bit(true), &addresses[0], &m.at_time(signal, from));
            let read = ram.read(&format!("late_{word}_read"), &addresses[1], None);
            late.push(m.restart(&read, until));
        }
        late
    }
}
