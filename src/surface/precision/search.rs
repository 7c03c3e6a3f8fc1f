//! The cheapest format whose proven error meets a target.
//!
//! ```text
//!   cost = sum over orders of (registers of the order) * F_m      integer bits do not depend on the format
//! ```
//!
//! Progressive formats are searched whole, by branch and bound: the terms of the orders chosen so far are a
//! lower bound on the error, and their cost with the same fraction for all that follow one on the cost.
//! Candidates that pass the corner of the patch are checked on its whole hypotenuse.

use super::bound::{Terms, add_error, of_patch, start_error};
use super::{Dyadic, FormatError};
use crate::fixed::precision::HIGHEST_ORDER;
use crate::fixed::{Fractions, Reduced, Rounding};

/// Registers of one coordinate by order, without the waiting ones: 12 outer differences, two columns of 4.
pub const REGISTERS_20: [u32; HIGHEST_ORDER + 1] = [3, 4, 5, 6, 2];

/// Fraction bits of all registers of one coordinate.
pub fn cost(fractions: Fractions, registers: [u32; HIGHEST_ORDER + 1]) -> u32 {
    fractions.all().iter().zip(registers).map(|(f, count)| f * count).sum()
}

/// The least F for which no vertex of a patch of this level is off by more than `target` units of the
/// control coordinates before its final rounding; nothing if F would be above [`Fractions::MOST`].
pub fn cheapest_uniform(level: u32, target: Dyadic, rounding: Rounding) -> Option<Fractions> {
    let formats = (0..=Fractions::MOST).filter_map(|f| Fractions::uniform(f).ok());
    let mut meets = formats.filter(|&fractions| meets(fractions, rounding, level, target));
    meets.next()
}

/// The cheapest F_0 .. F_4 for the same, among them the uniform ones; the first in the order of F_0, F_1, ...
/// where several cost the same.
pub fn cheapest_progressive(
    level: u32,
    target: Dyadic,
    rounding: Rounding,
    registers: [u32; HIGHEST_ORDER + 1],
) -> Option<Fractions> {
    let uniform = cheapest_uniform(level, target, rounding)?;
    let n = 1u64 << level;
    let best = (cost(uniform, registers), uniform);
    let corner = Terms::of(n, 0);
    let mut search = Search { level, target, rounding, registers, corner, best };
    search.extend(&mut vec![]);
    Some(search.best.1)
}

fn meets(fractions: Fractions, rounding: Rounding, level: u32, target: Dyadic) -> bool {
    let format = Reduced { rounding, ..Reduced::new(fractions) };
    of_patch(format, level).largest() <= target
}

struct Search {
    level: u32,
    target: Dyadic,
    rounding: Rounding,
    registers: [u32; HIGHEST_ORDER + 1],
    corner: Terms,
    best: (u32, Fractions),
}

impl Search {
    /// Tries all formats that begin with these fractions.
    fn extend(&mut self, chosen: &mut Vec<u32>) {
        let order = chosen.len();
        for f in chosen.last().copied().unwrap_or(0)..=Fractions::MOST {
            chosen.push(f);
            // The same fraction for all that follow is the least they can have, and drops nothing.
            let mut bits = [f; HIGHEST_ORDER + 1];
            bits[..chosen.len()].copy_from_slice(chosen);
            let least = Fractions::new(bits).ok().filter(|&f| cost(f, self.registers) < self.best.0);
            let Some(fractions) = least else {
                chosen.pop();
                return;
            };
            if self.error_so_far(fractions, order).largest() <= self.target {
                if order < HIGHEST_ORDER {
                    self.extend(chosen);
                } else if meets(fractions, self.rounding, self.level, self.target) {
                    self.best = (cost(fractions, self.registers), fractions);
                }
            }
            chosen.pop();
        }
    }

    /// What the orders up to this one alone do at the corner.
    fn error_so_far(&self, fractions: Fractions, order: usize) -> FormatError {
        let (mut above, mut below) = (0, 0);
        let mut add = |count: u128, [up, down]: [u128; 2]| {
            above += count * up;
            below += count * down;
        };
        for m in 0..=order {
            add(self.corner.start[m], start_error(fractions, self.rounding, m));
        }
        for m in 0..order {
            let doubled = m == 3;
            let count = if doubled { self.corner.doubles } else { self.corner.adds[m] };
            let dropped = fractions.dropped(m).saturating_sub(u32::from(doubled));
            add(count, add_error(fractions, self.rounding, m, dropped));
        }
        let bits = fractions.of(HIGHEST_ORDER) + 1;
        FormatError { above: Dyadic::new(above, bits), below: Dyadic::new(below, bits) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIXTEENTH: Dyadic = Dyadic { numerator: 1, bits: 4 };

    #[test]
    fn the_least_uniform_fractions() {
        let half = [1, 2, 5, 8, 13, 17, 21, 25, 29, 33, 37];
        let sixteenth = [4, 5, 8, 11, 16, 20, 24, 28, 32, 36, 40];
        for (target, table) in [(Dyadic::HALF, half), (SIXTEENTH, sixteenth)] {
            for (level, expected) in (0..).zip(table) {
                let found = cheapest_uniform(level, target, Rounding::HalfUp).unwrap();
                assert_eq!(found.of(0), expected, "level {level}");
            }
        }
        // Directed roundings cost one bit more.
        for rounding in [Rounding::Floor, Rounding::Truncate] {
            assert_eq!(cheapest_uniform(5, Dyadic::HALF, rounding).unwrap().of(0), 18);
        }
    }

    /// Formats derived by hand from the formula, r = 1..10: the search must meet or beat them.
    fn by_hand(r: u32, sixteenth: bool) -> Fractions {
        let more = if sixteenth { 3 } else { 0 };
        let bits = match r {
            1 => [2; 5],
            2 => [4, 5, 5, 5, 5],
            3 => [5, 8, 8, 8, 11],
            4 => [7, 10, 12, 12, 15],
            5 => [7, 11, 15, 18, 18],
            r => [r + 2, 2 * r + 1, 3 * r, 4 * r - 2, 4 * r - 2],
        };
        Fractions::new(bits.map(|f| f + more)).unwrap()
    }

    #[test]
    fn the_search_beats_what_was_derived_by_hand() {
        for (target, sixteenth) in [(Dyadic::HALF, false), (SIXTEENTH, true)] {
            for r in 1..=10 {
                let hand = by_hand(r, sixteenth);
                let found = cheapest_progressive(r, target, Rounding::HalfUp, REGISTERS_20).unwrap();
                println!(
                    "r = {r}: {found} costs {}, by hand {hand} {} ({})",
                    cost(found, REGISTERS_20),
                    cost(hand, REGISTERS_20),
                    meets(hand, Rounding::HalfUp, r, target)
                );
                assert!(meets(found, Rounding::HalfUp, r, target));
                assert!(cost(found, REGISTERS_20) <= cost(hand, REGISTERS_20));
            }
        }
    }

    #[test]
    fn nothing_cheaper_exists_where_all_can_be_tried() {
        for (level, target) in [(1, Dyadic::HALF), (2, Dyadic::HALF), (2, SIXTEENTH)] {
            for rounding in Rounding::TOTAL {
                let found = cheapest_progressive(level, target, rounding, REGISTERS_20).unwrap();
                let most = 11;
                let mut least = u32::MAX;
                for code in 0..most * most * most * most * most {
                    let digit = |place: u32| code / u32::pow(most, place) % most;
                    let bits = [4, 3, 2, 1, 0].map(digit);
                    let Ok(fractions) = Fractions::new(bits) else { continue };
                    if cost(fractions, REGISTERS_20) < least && meets(fractions, rounding, level, target) {
                        least = cost(fractions, REGISTERS_20);
                    }
                }
                assert_eq!(cost(found, REGISTERS_20), least, "level {level}, {rounding}");
            }
        }
    }
}
