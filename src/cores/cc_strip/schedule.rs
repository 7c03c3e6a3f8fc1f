//! Which unit makes the columns of which levels, and how many rows of them in a clock.
//!
//! ```text
//!   shared      [0 1 2 3 4]             2^(L+1) - 2 clocks for each column that comes in
//!   pipelined   [0] [1] [2] [3] [4]     2^L
//!   double      [0] [1] [2] [3] [4 4]   2^(L-1): the finest unit makes a vertex and a face column at once
//!   folded      [0 1 2 3] [4]           2^L: the coarse levels have as much to do as the finest
//! ```
//!
//! Level l is the one whose columns come in; the unit makes columns of level l + 1. A unit of q cells makes
//! 2q + 1 rows in a clock, of which the last belongs to the next slice but for the last slice. Source: Hall,
//! sections 6.3 and 7.3.

use std::fmt;
use std::ops::RangeInclusive;

/// How the columns of the levels share the units that make them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// One unit for all levels.
    Shared,
    /// A unit for each level, or for all that idle otherwise where it is folded.
    Pipelined,
    /// The same, and the finest unit makes two columns at once.
    Double,
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Schedule::Shared => "shared",
            Schedule::Pipelined => "pipelined",
            Schedule::Double => "double",
        })
    }
}

/// The levels that one unit serves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    pub levels: RangeInclusive<u32>,
    /// Cells between source rows that the unit works on in a clock.
    pub cells: u32,
    /// The unit makes a vertex column and the face column behind it in the same clock.
    pub double: bool,
    /// Its ends are walked around (see [`super::Parameters::walked`]).
    pub walked: bool,
    /// It serves one coordinate after the other (see [`super::Parameters::in_turn`]).
    pub in_turn: bool,
}

impl Group {
    pub fn coarsest(&self) -> u32 {
        *self.levels.start()
    }

    pub fn finest(&self) -> u32 {
        *self.levels.end()
    }

    /// Clocks for a column made from one of a level.
    pub fn slices(&self, level: u32) -> u32 {
        ((1 << level) / self.cells).max(1)
    }

    /// The most clocks for a column.
    pub fn most_slices(&self) -> u32 {
        self.slices(self.finest())
    }

    /// Rows that leave in a clock.
    pub fn lanes(&self) -> usize {
        2 * self.cells as usize + 1
    }
}

/// The groups of a schedule, coarse levels first.
pub fn groups(schedule: Schedule, folded: bool, levels: u32, rows_per_clock: Option<u32>) -> Vec<Group> {
    // The finest levels that have a unit of their own; those below share one.
    let alone = match (schedule, folded) {
        (Schedule::Shared, _) => 0,
        (_, false) => levels,
        (Schedule::Pipelined, true) => 1,
        // Two columns a clock: the level before the finest makes one a clock, and all before it as many.
        (Schedule::Double, true) => 2,
    };
    let together = levels.saturating_sub(alone);
    let mut ranges: Vec<RangeInclusive<u32>> = vec![];
    if together > 0 {
        ranges.push(0..=together - 1);
    }
    ranges.extend((together..levels).map(|level| level..=level));
    let group = |levels_here: RangeInclusive<u32>| {
        let finest = *levels_here.end();
        let whole = 1 << finest;
        Group {
            levels: levels_here,
            cells: rows_per_clock.map_or(whole, |rows| (rows / 2).clamp(1, whole)),
            double: schedule == Schedule::Double && finest + 1 == levels,
            walked: false,
            in_turn: false,
        }
    };
    ranges.into_iter().map(group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(schedule: Schedule, folded: bool, levels: u32) -> Vec<RangeInclusive<u32>> {
        groups(schedule, folded, levels, None).into_iter().map(|group| group.levels).collect()
    }

    #[test]
    fn every_level_has_one_unit() {
        for levels in 1..=7 {
            for schedule in [Schedule::Shared, Schedule::Pipelined, Schedule::Double] {
                for folded in [false, true] {
                    let served: Vec<u32> = ranges(schedule, folded, levels).into_iter().flatten().collect();
                    assert_eq!(served, (0..levels).collect::<Vec<_>>(), "{schedule} {folded}");
                }
            }
        }
    }

    #[test]
    fn five_levels() {
        assert_eq!(ranges(Schedule::Shared, false, 5), [0..=4]);
        assert_eq!(ranges(Schedule::Pipelined, true, 5), [0..=3, 4..=4]);
        assert_eq!(ranges(Schedule::Double, true, 5), [0..=2, 3..=3, 4..=4]);
        assert_eq!(ranges(Schedule::Pipelined, false, 2), [0..=0, 1..=1]);
    }

    /// A folded unit is never asked for more columns than it has clocks.
    #[test]
    fn folding_costs_no_clock() {
        for (levels, schedule, clocks) in (1..=7u32).flat_map(|levels| {
            [(levels, Schedule::Pipelined, 1u32 << levels), (levels, Schedule::Double, 1 << (levels - 1))]
        }) {
            for group in groups(schedule, true, levels, None) {
                let columns: u32 = group.levels.clone().map(|level| 2 << level).sum();
                let columns = if group.double { columns / 2 } else { columns };
                assert!(columns <= clocks, "{schedule} {levels}: {columns} columns in {clocks} clocks");
            }
        }
    }

    #[test]
    fn parts_of_columns() {
        let groups = groups(Schedule::Pipelined, false, 4, Some(4));
        let sizes: Vec<_> = groups.iter().map(|g| (g.cells, g.most_slices(), g.lanes())).collect();
        assert_eq!(sizes, [(1, 1, 3), (2, 1, 5), (2, 2, 5), (2, 4, 5)]);
    }
}
