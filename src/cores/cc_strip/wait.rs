//! Signals at a later clock: where that is long, through RAMs that a counter goes through.
//!
//! ```text
//! turn ──► written ──► RAM of lookup tables ──► register ──► late         narrow words, 16 clocks
//!   └─ - k ──► read ────┘
//! register ──► block RAM ──► its register ──► register ──► late           wide ones, 64 clocks
//! ```
//!
//! One counter of a module serves all RAMs of a kind. It alone is reset, and one register alone reads it: that one and the
//! next may be copied all over the device, for a copy needs no reset, which reaches few registers in a clock. One
//! register less k serves all waits of k clocks, each by way of a copy.
//!
//! Block RAMs stand in few rows of a device, which makes wires longer, and yet the clock is higher: the lookup tables that
//! they spare are the place in which the units have to lie close together.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;

use super::Parameters;
use crate::hdl::{Builder, Signal, Word};

/// What RAMs are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    LookupTables,
    Blocks,
}

impl Kind {
    /// Narrower words would waste most of a block RAM.
    const NARROWEST: u32 = 18;

    fn name(self) -> &'static str {
        match self {
            Kind::LookupTables => "turn",
            Kind::Blocks => "long_turn",
        }
    }

    /// The bits of an address.
    fn log_words(self) -> u32 {
        match self {
            Kind::LookupTables => 4,
            Kind::Blocks => 6,
        }
    }

    /// Words whose RAMs share registers of the addresses.
    fn words_of_an_address(self) -> usize {
        match self {
            Kind::LookupTables => 8,
            Kind::Blocks => 2,
        }
    }

    /// Registers before the RAM and behind it, the first of the latter being the RAM's own.
    fn registers(self) -> (u32, u32) {
        match self {
            Kind::LookupTables => (0, 0),
            Kind::Blocks => (1, 2),
        }
    }

    /// The waits that a RAM makes; shorter ones are registers.
    fn clocks(self) -> std::ops::RangeInclusive<u32> {
        let (before, behind) = self.registers();
        // Those of lookup tables may be read at the edge at which a word is written.
        let most = (1 << self.log_words()) + u32::from(self == Kind::LookupTables);
        before + behind + 4..=before + behind + most
    }
}

/// The waits of a module.
pub struct Waits<'a> {
    pub m: &'a Builder,
    blocks: bool,
    turns: [OnceCell<Signal>; 2],
    behind: RefCell<BTreeMap<(Kind, i128), Signal>>,
}

impl<'a> Waits<'a> {
    /// Those of a core that sends slices take block RAMs.
    pub fn new(m: &'a Builder, parameters: Parameters) -> Waits<'a> {
        Waits {
            m,
            blocks: parameters.walked(),
            turns: [const { OnceCell::new() }; 2],
            behind: RefCell::default(),
        }
    }

    /// The counter, which never stops, two clocks late.
    fn turn(&self, kind: Kind) -> &Signal {
        self.turns[kind as usize].get_or_init(|| {
            let name = kind.name();
            let turn = self.m.register_reset(format!("{name}_of_waits"), Word::unsigned(kind.log_words()), 0);
            self.m.always(&turn, self.m.wrap(&turn + 1, turn.word()));
            let sent = self.m.copy(format!("{name}_sent"), &turn);
            self.m.restart(&self.m.copy(format!("{name}_goes_round"), &sent), 0)
        })
    }

    fn kind(&self, signal: &Signal, clocks: u32) -> Kind {
        let wide = signal.word().width() >= Kind::NARROWEST;
        match self.blocks && wide && clocks >= *Kind::Blocks.clocks().start() {
            true => Kind::Blocks,
            false => Kind::LookupTables,
        }
    }

    /// The signals, which are renamed, at clock `until`. `name` is that of the addresses.
    pub fn until(&self, name: &str, signals: &[(String, Signal)], until: u32) -> Vec<Signal> {
        // What comes earlier waits for longer, not first for the others.
        let of = |signal: &Signal| {
            let from = signal.time().unwrap_or(0);
            (from, self.kind(signal, until.saturating_sub(from)) as usize)
        };
        let mut groups: Vec<(u32, usize)> = signals.iter().map(|(_, signal)| of(signal)).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut late: Vec<Signal> = signals.iter().map(|(_, signal)| signal.clone()).collect();
        for &(from, kind) in &groups {
            let here: Vec<usize> =
                (0..signals.len()).filter(|&at| of(&signals[at].1) == (from, kind)).collect();
            let group: Vec<(String, Signal)> = here.iter().map(|&at| signals[at].clone()).collect();
            let name = match groups.len() {
                1 => name.to_string(),
                _ => format!("{name}_{from}{}", if kind == Kind::Blocks as usize { "_wide" } else { "" }),
            };
            for (at, signal) in here.into_iter().zip(self.together(&name, &group, from, until)) {
                late[at] = signal;
            }
        }
        late
    }

    /// Signals of one time and kind.
    fn together(&self, name: &str, signals: &[(String, Signal)], from: u32, until: u32) -> Vec<Signal> {
        let m = self.m;
        let clocks = until.saturating_sub(from);
        let Some(kind) = signals.first().map(|(_, signal)| self.kind(signal, clocks)) else { return vec![] };
        let range = kind.clocks();
        if clocks > *range.end() {
            // As many RAMs one behind the other as it takes, all of about one length.
            let hops = clocks.div_ceil(*range.end());
            let late = self.until(&format!("{name}_{hops}"), signals, from + clocks / hops);
            let names = signals.iter().map(|(word, _)| format!("{word}_{hops}"));
            let signals: Vec<(String, Signal)> = names.zip(late).collect();
            return self.until(name, &signals, until);
        }
        if !range.contains(&clocks) {
            return signals.iter().map(|(_, signal)| m.at_time(signal, until)).collect();
        }
        self.through_rams(kind, name, signals, from, until)
    }

    fn through_rams(
        &self,
        kind: Kind,
        name: &str,
        signals: &[(String, Signal)],
        from: u32,
        until: u32,
    ) -> Vec<Signal> {
        let m = self.m;
        let turn = self.turn(kind);
        let (before, behind) = kind.registers();
        // The registers of the difference are two clocks late, and what they hold two clocks on.
        let back = i128::from(until - from - before - behind) - 3;
        let address = |port: &str, nth: usize, value: &Signal| {
            m.restart(&m.copy(format!("{name}_{nth}_{port}"), value), from + before)
        };
        let now = turn.time().unwrap_or(0);
        let read = self
            .behind
            .borrow_mut()
            .entry((kind, back))
            .or_insert_with(|| {
                let behind = m.pipe(format!("{}_less_{back}", kind.name()), m.wrap(turn - back, turn.word()));
                m.restart(&behind, now)
            })
            .clone();
        let read = m.restart(&m.copy(format!("{name}_behind"), &read), now);
        let mut addresses = [turn.clone(), read.clone()];
        let mut late = vec![];
        for (nth, (word, signal)) in signals.iter().enumerate() {
            if nth % kind.words_of_an_address() == 0 {
                addresses = [address("written", nth, turn), address("read", nth, &read)];
            }
            let ram = m.memory(&format!("late_{word}"), 1 << kind.log_words(), signal.word(), vec![]);
            let ram = match kind {
                Kind::LookupTables => ram.distributed(),
                Kind::Blocks => ram.block().apart(),
            };
            let data = match before {
                0 => m.at_time(signal, from),
                _ => m.pipe(format!("early_{word}"), signal),
            };
            ram.write(&m.bit(true), &addresses[0], &data);
            let mut read = ram.read(&format!("late_{word}_read"), &addresses[1], None);
            for register in 0..behind {
                read = m.pipe(format!("late_{word}_behind_{register}"), &read);
            }
            late.push(m.restart(&read, until));
        }
        late
    }
}
