//! How many clocks a `cc-strip` takes, under any stalls: its protocol without its data.
//!
//! ```text
//! words ─► level 0 ─► level 1 ─► ... ─► level L-1 ─► output register ─► consumer
//!          a level has columns to send; its unit serves the finest of its levels that can
//! ```
//!
//! A core that computes the right columns but needs other clocks than these is wrong. Rules:
//!
//! - A word is taken when level 0 has nothing to send, or sends the last of it in this clock.
//! - Column c of a level (c = 0, 1, ... after the left guard) lets leave a vertex column (c >= 1), then a face
//!   column; each takes as many clocks as it has slices. A unit of two columns sends both at once, and nothing
//!   for c = 0.
//! - A level may send when the one behind it has nothing to send (within a unit), is ready as level 0 is for
//!   words (between units), or the output register is free (from the level of the strip).
//! - Guards reach the output too, and are not kept.
//! - A registered core sends into a buffer whose room is known a clock late; what is sent comes there, and counts,
//!   later still. All is settled when every place of the buffer is free again.
//! - Where the ends of columns are walked around, that takes its clocks from the first slice of a vertex column on; so
//!   long nothing comes in. There a word is looked at from its third clock on, taken two clocks after it may
//!   be from where it waits, and none comes before it has gone; it counts two clocks after that, a column a clock after it was whole, and
//!   nothing is taken while that has not counted; and a level asks for room for a whole column, two clocks before its first slice.
//! - Where a level works on x, y and z in turn, each has its slices in the first clocks of a period, in which the
//!   ends are walked around; the next level has the column with the last slice of z, the output has it slice by
//!   slice with those. A vertex column takes all three periods, a face column until then.
//! - A strip of another level than the one before waits until no level has anything to send, and the finishing
//!   stage is empty.

use super::cc_strip::schedule::Schedule;
pub use super::cc_strip_buffer::Buffer;
use super::cc_strip_buffer::{Buffered, COUNTS_LATE};
use super::cc_strip_levels::{Arrival, Level, Rests};

/// What the core is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Core {
    pub levels: u32,
    pub schedule: Schedule,
    pub folded: bool,
    /// Rows in a clock; none for whole columns.
    pub rows_per_clock: Option<u32>,
    /// Clocks of the finishing stage behind the finest level's window, where there is one.
    pub finish: Option<u32>,
    /// The buffer of a registered core.
    pub buffer: Option<Buffer>,
    /// Clocks of a walk around the ends of a column, by level; none where ends are not walked around.
    pub walks: [u32; 7],
    /// Clocks from one coordinate to the next, by level; none where they do not take turns.
    pub periods: [u32; 7],
}

/// One strip of the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Strip {
    /// 0 for a strip that is dropped whole.
    pub level: u32,
    /// Words of each column, guards included.
    pub words: Vec<u32>,
}

/// Clocks from the first one after reset to the last output beat, both counted, for beats of the output. In clock c a waiting
/// word may be offered if `offer[c % len]`, and then stays offered until it is taken; the output is taken if
/// `ready[c % len]`.
pub fn run(core: Core, strips: &[Strip], offer: &[bool], ready: &[bool]) -> u64 {
    run_until(core, strips, offer, ready, u64::MAX)
}

/// Clocks to the last output beat, or to the one of number `most`.
fn run_until(core: Core, strips: &[Strip], offer: &[bool], ready: &[bool], most: u64) -> u64 {
    let mut machine = Machine::new(core);
    let wanted = strips.iter().map(|strip| machine.beats(strip)).sum::<u64>().min(most);
    let mut words = strips.iter().flat_map(|strip| {
        let last = strip.words.len() - 1;
        strip.words.iter().enumerate().flat_map(move |(column, &count)| {
            (1..=count).map(move |word| Word {
                level: strip.level,
                first: column == 0 && word == 1,
                guard: column == 0,
                complete: word == count,
                last: column == last && word == count,
            })
        })
    });
    let mut waiting = words.next();
    let (mut received, mut offering, mut clock) = (0, false, 0u64);
    while received < wanted {
        let at = |pattern: &[bool]| pattern[clock as usize % pattern.len()];
        offering |= waiting.is_some() && at(offer);
        received += u64::from(machine.output() && at(ready));
        if machine.clock(waiting.filter(|_| offering), at(ready)) {
            waiting = words.next();
            offering = false;
        }
        clock += 1;
    }
    clock
}

#[derive(Clone, Copy)]
struct Word {
    level: u32,
    first: bool,
    /// Of the left guard.
    guard: bool,
    complete: bool,
    last: bool,
}

struct Machine {
    core: Core,
    levels: Vec<Level>,
    /// The levels of each unit, and the slice it is at with its level.
    units: Vec<(std::ops::Range<usize>, u32, usize)>,
    wanted: usize,
    dropping: bool,
    /// The finishing stage: whether its window's middle column waits, how old the window is, its pipeline.
    finishing: (bool, u32),
    pipeline: Vec<bool>,
    buffered: Option<Buffered>,
    /// Of a registered core: all was settled a clock ago, and nothing came in.
    was_idle: bool,
    /// What that comes from where ends are walked around.
    rests: Rests,
    /// A word that waits, for so many clocks; one that does not count yet.
    waits: Option<(Word, u32)>,
    taken: [Option<Word>; 2],
    /// The word that waits is taken in this clock; it may be, as it was known a clock ago.
    goes: bool,
    may_go: bool,
    /// Of the clock before.
    had_room: bool,
}

impl Machine {
    fn new(core: Core) -> Machine {
        let count = core.levels as usize;
        let alone = match (core.schedule, core.folded) {
            (Schedule::Shared, _) => 0,
            (_, false) => count,
            (Schedule::Pipelined, true) => 1,
            (Schedule::Double, true) => 2,
        };
        let together = count.saturating_sub(alone);
        let mut units = vec![];
        if together > 0 {
            units.push((0..together, 0, 0));
        }
        units.extend((together..count).map(|level| (level..level + 1, 0, level)));
        let mut levels = vec![Level::default(); count];
        for (range, ..) in &units {
            let whole = 1u32 << (range.end - 1);
            let cells = core.rows_per_clock.map_or(whole, |rows| (rows / 2).max(1).min(whole));
            for level in range.clone() {
                levels[level].slices = ((1u32 << level) / cells).max(1);
                levels[level].period = core.periods[level];
            }
        }
        levels[count - 1].double = core.schedule == Schedule::Double;
        let pipeline = vec![false; core.finish.unwrap_or(1) as usize];
        let unasked = if core.walks == [0; 7] { 0 } else { levels[count - 1].slices + COUNTS_LATE as u32 };
        let buffered = core.buffer.map(|buffer| Buffered::new(buffer, unasked));
        Machine {
            core,
            levels,
            units,
            wanted: 0,
            dropping: false,
            finishing: (false, 0),
            pipeline,
            buffered,
            was_idle: true,
            rests: Rests { levels: [true; COUNTS_LATE + 1], buffer: true, quiet: true, came: [false; 3] },
            waits: None,
            taken: [None; 2],
            goes: false,
            may_go: false,
            had_room: false,
        }
    }

    /// Output beats of a strip.
    fn beats(&self, strip: &Strip) -> u64 {
        if strip.level == 0 || strip.level > self.core.levels {
            return 0;
        }
        let source = &self.levels[strip.level as usize - 1];
        let columns = ((strip.words.len() as u64 - 3) << strip.level) + 1;
        if source.double { columns.div_ceil(2) } else { columns * u64::from(source.slices) }
    }

    fn output(&self) -> bool {
        self.buffered.as_ref().map_or_else(|| self.pipeline[self.pipeline.len() - 1], Buffered::standing)
    }

    /// Whether the ends of columns are walked around.
    fn walks(&self) -> bool {
        self.core.walks != [0; 7]
    }

    /// One clock; returns whether the offered word was taken.
    fn clock(&mut self, offered: Option<Word>, ready: bool) -> bool {
        let advance = !self.output() || ready;
        let output_ready = match &self.buffered {
            Some(buffered) => buffered.room,
            None => advance || (self.core.finish.is_some() && !self.finishing.0),
        };
        // Who sends, from the output backwards; and what that means for the one before.
        let walks = self.walks();
        let (mut serves, mut starts): (Vec<Option<usize>>, Vec<usize>) = (vec![], vec![]);
        let mut may = vec![];
        let mut next_ready = false;
        for (range, slice, active) in self.units.iter().rev() {
            let can = |level: &usize| {
                let target = match *level + 1 {
                    next if next == self.wanted => output_ready,
                    next if next == range.end => next_ready,
                    next => self.levels[next].columns == 0,
                };
                self.levels[*level].columns > 0 && target && (*slice == 0 || active == level)
            };
            let serve = match (walks, range.start) {
                (false, _) => range.clone().rev().find(can),
                (true, level) => {
                    let Level { sends, may_send, columns, .. } = self.levels[level];
                    starts.extend(Some(level).filter(|_| columns > 0 && !sends && may_send));
                    may.push(if level + 1 == self.wanted { output_ready } else { next_ready && !sends });
                    Some(level).filter(|_| sends)
                }
            };
            let first = range.start;
            let ends = serve == Some(first) && slice + 1 == self.levels[first].slices;
            // A registered core sees the end of a column in time only where that leaves, and not in front.
            let seen = self.core.buffer.is_none() || (!walks && first > 0 && first + 1 == self.wanted);
            next_ready = self.levels[first].columns == 0 || (ends && self.levels[first].columns == 1 && seen);
            next_ready &= self.levels[first].walk == 0 && self.levels[first].comes.is_none();
            serves.push(serve);
        }
        serves.reverse();
        // The finishing stage looks at the level all the way through.
        let stage = self.core.finish.is_some() && (self.finishing.0 || self.pipeline.contains(&true));
        let empty = self.buffered.as_ref().is_none_or(|buffered| buffered.empty);
        let idle =
            self.levels.iter().all(|level| level.columns == 0 && level.comes.is_none()) && !stage && empty;
        let settles = if self.core.buffer.is_some() { self.was_idle } else { idle };

        let enters = walks && self.waits.is_none();
        let looked_at =
            if walks { self.waits.filter(|(_, clocks)| *clocks > 1).map(|(word, _)| word) } else { offered };
        let goes = std::mem::take(&mut self.goes);
        let word = looked_at.filter(|word| {
            let dropped = self.dropping || (word.first && (word.level == 0 || word.level > self.core.levels));
            let settled = !word.first || word.level as usize == self.wanted || settles;
            // Words come so seldom that the room is that of the clock before.
            let room = if walks { self.had_room } else { next_ready };
            goes || dropped || (room && settled)
        });
        let judged = self.waits.is_some_and(|(_, clocks)| clocks > 2);
        self.goes = walks && judged && self.may_go && !goes;
        self.may_go = word.is_some();
        let word = word.filter(|_| !walks || goes);

        // The edge.
        let levels_rest = self.levels.iter().all(|level| level.columns == 0 && level.comes.is_none());
        self.was_idle = if walks { self.rests.all() } else { idle };
        self.had_room = next_ready;
        let (mut reaches, mut arrivals) = (None, vec![]);
        self.levels.iter_mut().for_each(|level| level.walk = level.walk.saturating_sub(1));
        for (unit, serve) in serves.iter().enumerate() {
            let Some(level) = *serve else { continue };
            let sender = self.levels[level];
            let (_, slice, active) = &mut self.units[unit];
            if *slice == 0 && sender.columns == 2 {
                self.levels[level].walk = self.core.walks[level];
            }
            (*slice, *active) = (*slice + 1, level);
            // The slices of z come last, and the next level waits for them.
            let others = 2 * sender.period;
            let whole = *slice == others + sender.slices;
            let leaves = *slice > others && *slice <= others + sender.slices;
            let done = if sender.period > 0 && sender.columns == 2 {
                3 * sender.period
            } else {
                others + sender.slices
            };
            let done = *slice == done;
            self.levels[level].sends &= !done;
            if done {
                *slice = 0;
                self.levels[level].columns -= 1;
            }
            let arrival = Arrival {
                first: sender.columns == 1 && sender.age == 1,
                last: sender.columns == 1 && sender.guarded,
            };
            if level + 1 == self.wanted && !leaves {
                continue;
            }
            if level + 1 == self.wanted {
                reaches = Some((arrival, whole, sender.double));
            } else if whole {
                arrivals.push((level + 1, arrival));
            }
        }
        starts.into_iter().for_each(|level| self.levels[level].sends = true);
        let levels = self.levels.iter_mut().zip(may.into_iter().rev());
        levels.for_each(|(level, may)| level.may_send = may);
        // A level may take a column in the clock in which it sends its last.
        for level in &mut self.levels {
            level.comes.take().into_iter().for_each(|arrival| level.arrives(arrival));
        }
        arrivals.into_iter().for_each(|(level, arrival)| self.comes(level, arrival));
        self.finish(reaches, advance, ready);
        let [first, second] = self.taken;
        self.taken = [None, first];
        second.into_iter().for_each(|word| self.counts(word));
        let mut came = false;
        if let Some(word) = word {
            let dropped = self.dropping || (word.first && (word.level == 0 || word.level > self.core.levels));
            self.dropping = dropped && !word.last;
            self.was_idle &= dropped;
            came = !dropped;
            if !dropped {
                if word.first && self.wanted != word.level as usize {
                    self.wanted = word.level as usize;
                    if let (Some(buffered), Some(buffer)) = (&mut self.buffered, self.core.buffer) {
                        buffered.set_delay(buffer.delays[self.wanted - 1]);
                    }
                }
                match walks {
                    true => self.taken[0] = Some(word),
                    false => self.counts(word),
                }
            }
        }
        if walks {
            self.was_idle &= !came && !self.rests.came.contains(&true);
            self.rests.clock(levels_rest, empty, came);
            self.waits = match self.waits {
                None => offered.map(|word| (word, 0)),
                Some(_) if word.is_some() => None,
                Some((waiting, clocks)) => Some((waiting, clocks + 1)),
            };
            return enters && offered.is_some();
        }
        word.is_some()
    }

    fn counts(&mut self, word: Word) {
        if word.complete {
            self.comes(0, Arrival { first: word.guard, last: word.last });
        }
    }

    fn comes(&mut self, level: usize, arrival: Arrival) {
        match self.walks() {
            true => self.levels[level].comes = Some(arrival),
            false => self.levels[level].arrives(arrival),
        }
    }

    /// What the output takes in: kept at once, or finished when the column behind it is there.
    fn finish(&mut self, reaches: Option<(Arrival, bool, bool)>, advance: bool, ready: bool) {
        let seen = |(arrival, _, double): (Arrival, bool, bool)| double || !(arrival.first || arrival.last);
        if let Some(buffered) = &mut self.buffered {
            buffered.clock(reaches.is_some_and(seen), ready);
            return;
        }
        if self.core.finish.is_none() {
            if advance {
                self.pipeline[0] = reaches.is_some_and(seen);
            }
            return;
        }
        let begins = self.finishing.0 && advance;
        if advance {
            self.pipeline.rotate_right(1);
            self.pipeline[0] = begins;
        }
        self.finishing.0 &= !begins;
        if let Some((arrival, true, _)) = reaches {
            self.finishing = match (arrival.first, self.finishing.1) {
                (true, _) => (self.finishing.0, 0),
                (_, 0) => (self.finishing.0, 1),
                _ => (true, 2),
            };
        }
    }
}

/// Clocks for each further column of a strip of the finest level whose vertices all have valence 4, in the
/// long run.
pub fn clocks_per_column(core: Core) -> f64 {
    let clocks = |quads: u32| run(core, &[regular(core, quads)], &[true], &[true]);
    (clocks(40) - clocks(8)) as f64 / 32.0
}

/// Clocks from the first word after reset to the first output beat, both counted, of such a strip.
pub fn latency(core: Core) -> u64 {
    run_until(core, &[regular(core, 8)], &[true], &[true], 1)
}

/// A strip of the finest level whose vertices all have valence 4.
fn regular(core: Core, quads: u32) -> Strip {
    Strip { level: core.levels, words: vec![4; quads as usize + 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn core(levels: u32, schedule: Schedule, folded: bool) -> Core {
        Core {
            levels,
            schedule,
            folded,
            rows_per_clock: None,
            finish: None,
            buffer: None,
            walks: [0; 7],
            periods: [0; 7],
        }
    }

    /// The formulas of the schedules, from the level on where four words take fewer clocks than a column.
    #[test]
    fn as_many_clocks_as_the_schedules_say() {
        for levels in 4..=7 {
            for schedule in Schedule::ALL {
                for folded in [false, true] {
                    let clocks = clocks_per_column(core(levels, schedule, folded));
                    assert_eq!(clocks, schedule.clocks_per_column(levels) as f64, "{schedule:?} {levels}");
                }
            }
        }
    }

    #[test]
    fn five_levels() {
        let clocks = Schedule::ALL.map(|schedule| clocks_per_column(core(5, schedule, false)));
        assert_eq!(clocks, [62.0, 32.0, 16.0]);
    }

    #[test]
    fn the_first_beat_comes_before_the_last_one_and_later_with_every_level() {
        let latencies = [1, 2, 3, 4].map(|levels| latency(core(levels, Schedule::Pipelined, false)));
        assert!(latencies.is_sorted_by(|one, next| one < next), "{latencies:?}");
        // Three columns of four words at least before there is a vertex column between them.
        assert!(latencies[0] > 12, "{latencies:?}");
        let core = core(4, Schedule::Pipelined, false);
        assert!(latency(core) < run(core, &[regular(core, 8)], &[true], &[true]));
    }

    #[test]
    fn slices_take_their_clocks() {
        let sliced = |rows, schedule| {
            clocks_per_column(Core { rows_per_clock: Some(rows), ..core(5, schedule, false) })
        };
        // 2 columns of level 1, 4 of level 2, ..., in slices of 8 rows: 1, 1, 1, 2 and 4 clocks a column.
        assert_eq!(sliced(8, Schedule::Shared), (2 + 4 + 8 + 2 * 16 + 4 * 32) as f64);
        assert!(sliced(8, Schedule::Pipelined) < sliced(8, Schedule::Shared));
    }

    #[test]
    fn stalls_cost_clocks_and_dropped_strips_cost_their_words() {
        let core = core(3, Schedule::Pipelined, false);
        let strip = Strip { level: 2, words: vec![4; 8] };
        let free = run(core, std::slice::from_ref(&strip), &[true], &[true]);
        assert!(run(core, std::slice::from_ref(&strip), &[true], &[true, false]) > free);
        let bad = Strip { level: 4, words: vec![4; 5] };
        assert_eq!(run(core, &[bad, strip], &[true], &[true]), free + 20);
    }
}
