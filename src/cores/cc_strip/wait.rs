//! Signals at a later clock: where that is long, through RAMs made of lookup tables that a counter goes through.

use crate::hdl::{Builder, Signal, Word};

/// Words whose RAMs share a register of the address.
const WORDS_OF_A_COUNTER: usize = 8;

/// The waits that RAMs of 16 words make; shorter ones are registers.
const CLOCKS: std::ops::RangeInclusive<u32> = 4..=17;

/// The signals, which are renamed, at clock `until`. `name` is that of the counter.
pub fn wait(m: &Builder, name: &str, signals: &[(String, Signal)], until: u32) -> Vec<Signal> {
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
            for (at, signal) in here.into_iter().zip(wait(m, &format!("{name}_{time}"), &group, until)) {
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
        let late = wait(m, &format!("{name}_{hops}"), signals, from + clocks / hops);
        let names = signals.iter().map(|(word, _)| format!("{word}_{hops}"));
        let signals: Vec<(String, Signal)> = names.zip(late).collect();
        return wait(m, name, &signals, until);
    }
    if !CLOCKS.contains(&clocks) {
        return signals.iter().map(|(_, signal)| m.at_time(signal, until)).collect();
    }
    // A word is read where the next one is written, and stands in the register behind a clock later.
    let words = clocks - 1;
    let word = Word::range(0, i128::from(words) - 1);
    let slot = m.register_reset(name, word, 0);
    m.on(&m.is(&slot, i128::from(words) - 1), &slot, m.constant(0, word));
    m.always(&slot, m.wrap(&slot + 1, word));
    let mut address = slot.clone();
    let mut late = vec![];
    for (nth, (word, signal)) in signals.iter().enumerate() {
        if nth % WORDS_OF_A_COUNTER == 0 {
            address = m.restart(&m.copy(format!("{name}_{nth}"), &slot), from);
        }
        let ram = m.memory(&format!("late_{word}"), words, signal.word(), vec![]).distributed();
        ram.write(&m.bit(true), &address, &m.at_time(signal, from));
        let read = ram.read(&format!("late_{word}_read"), &address, None);
        late.push(m.restart(&read, until));
    }
    late
}
