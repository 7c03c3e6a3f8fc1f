//! How many clocks a strip takes when a unit makes one column a clock.
//!
//! ```text
//!   shared      one unit makes the columns of all levels      M (2^(L+1) - 2) + 3L
//!   pipelined   one unit a level, all at once                 M 2^L + 2L + 3
//!   double      the finest unit makes a vertex column and     M 2^(L-1) + 2L + 2
//!               a face column each clock
//! ```
//!
//! Assumptions, which [`timeline`] plays clock by clock: clock 0 is the one in which column -1 is accepted; the
//! host has the next column ready whenever a slot is free, and one is accepted a clock; a column can be read
//! from the clock after the one it was made in; a level keeps three columns, and a slot may be written in the
//! clock of its last reading; the consumer takes every column at once. In the shared schedule the unit is busy
//! in every clock, and the input is accepted beside it, so that the clocks are those of the unit.
//! Source: Hall, section 6.3, for the shared unit; the other two do what its section 7.3 asks for.

/// How the columns of the levels share the units that make them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    Shared,
    Pipelined,
    Double,
}

/// A column as it is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Made {
    /// From 0.
    pub clock: u64,
    /// 1..=L; 0 where the input is accepted.
    pub level: u32,
    /// -1..=2^level M + 1.
    pub index: i64,
}

impl Schedule {
    pub const ALL: [Schedule; 3] = [Schedule::Shared, Schedule::Pipelined, Schedule::Double];

    /// Clocks for a strip of `quads` quads and `levels` levels, start-up included.
    pub fn clocks(self, quads: u64, levels: u32) -> u64 {
        let l = u64::from(levels);
        self.clocks_per_column(levels) * quads
            + match self {
                Schedule::Shared => 3 * l,
                Schedule::Pipelined => 2 * l + 3,
                Schedule::Double => 2 * l + 2,
            }
    }

    /// Clocks for each further quad of a strip.
    pub fn clocks_per_column(self, levels: u32) -> u64 {
        match self {
            Schedule::Shared => (1 << (levels + 1)) - 2,
            Schedule::Pipelined => 1 << levels,
            Schedule::Double => 1 << (levels - 1),
        }
    }
}

/// Which column is made in which clock.
pub fn timeline(schedule: Schedule, quads: u64, levels: u32) -> Vec<Made> {
    if schedule == Schedule::Shared {
        let mut made = Vec::new();
        (-1..=quads as i64 + 1).for_each(|index| shared(0, index, levels, &mut made));
        return made;
    }
    let mut units = Units { levels, quads: quads as i64, made_in: vec![Vec::new(); levels as usize + 1] };
    let (mut timeline, mut clock) = (Vec::new(), 0);
    let finished = |units: &Units| units.next(levels) > units.last(levels);
    while !finished(&units) {
        // The finest level first: what it reads for the last time may be overwritten in this clock.
        for level in (0..=levels).rev() {
            let twice = schedule == Schedule::Double && level == levels && units.next(level) % 2 == 0;
            for _ in 0..=u32::from(twice) {
                if units.ready(level, clock) {
                    timeline.push(Made { clock, level, index: units.next(level) });
                    units.made_in[level as usize].push(clock);
                }
            }
        }
        clock += 1;
    }
    timeline
}

/// The order of the recursion, a column a clock.
fn shared(level: u32, index: i64, levels: u32, made: &mut Vec<Made>) {
    let mut make = |index: i64| {
        made.push(Made { clock: made.len() as u64, level: level + 1, index });
        shared(level + 1, index, levels, made);
    };
    if level < levels && index >= 1 {
        make(2 * (index - 1));
    }
    if level < levels && index >= 0 {
        make(2 * index - 1);
    }
}

/// One unit a level.
struct Units {
    levels: u32,
    quads: i64,
    /// By level: the clock in which each column was made, column -1 first.
    made_in: Vec<Vec<u64>>,
}

impl Units {
    fn next(&self, level: u32) -> i64 {
        self.made_in[level as usize].len() as i64 - 1
    }

    fn last(&self, level: u32) -> i64 {
        (self.quads << level) + 1
    }

    /// Whether a column exists and was made before this clock.
    fn readable(&self, level: u32, index: i64, clock: u64) -> bool {
        self.made_in[level as usize].get((index + 1) as usize).is_some_and(|&made| made < clock)
    }

    fn ready(&self, level: u32, clock: u64) -> bool {
        let index = self.next(level);
        // Vertex column 2c needs column c+1, face column 2c+1 too.
        let sources = level == 0 || self.readable(level - 1, index.div_euclid(2) + 1, clock);
        // Column i-3 is read for the last time by vertex column 2(i-2).
        let slot = level == self.levels || index < 2 || self.next(level + 1) > 2 * (index - 2);
        index <= self.last(level) && sources && slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formulas_are_what_the_clocks_add_up_to() {
        for (levels, quads) in (1..=7).flat_map(|levels| [1, 2, 3, 10, 33].map(|quads| (levels, quads))) {
            for schedule in Schedule::ALL {
                let timeline = timeline(schedule, quads, levels);
                let clocks = timeline.last().map_or(0, |made| made.clock + 1);
                assert_eq!(clocks, schedule.clocks(quads, levels), "{schedule:?} M = {quads} L = {levels}");
                for level in 1..=levels {
                    let order = timeline.iter().filter(|m| m.level == level).map(|m| m.index);
                    assert!(order.eq(-1..=((quads as i64) << level) + 1), "{schedule:?} level {level}");
                }
            }
        }
    }

    #[test]
    fn five_levels_as_in_the_thesis() {
        assert_eq!(Schedule::ALL.map(|schedule| schedule.clocks_per_column(5)), [62, 32, 16]);
    }

    #[test]
    fn no_column_is_made_before_its_sources() {
        for schedule in [Schedule::Pipelined, Schedule::Double] {
            let timeline = timeline(schedule, 4, 3);
            let when = |level: u32, index: i64| {
                timeline.iter().find(|m| (m.level, m.index) == (level, index)).unwrap().clock
            };
            for made in timeline.iter().filter(|m| m.level > 0) {
                let source = made.index.div_euclid(2);
                assert!(when(made.level - 1, source) < made.clock);
                assert!(when(made.level - 1, source + 1) < made.clock);
            }
        }
    }
}
