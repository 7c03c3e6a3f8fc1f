//! Stalls: when the testbench holds back an input beat or refuses an output beat.
//!
//! ```text
//! none       1111111111111111...
//! random:50  1011001011100010...   by seed
//! bursts     1111100000011110...   runs of 1 to 64 clocks, by seed
//! one-in-4   0001000100010001...
//! ```
//!
//! Every pattern is expanded here to [`PATTERN`] clocks and travels to each simulator as data, indexed
//! by the clock since the release of reset: `$random` differs between simulators, this does not.

use crate::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Clocks after which a pattern starts over.
pub const PATTERN: usize = 4096;

/// A kind of stall, written on the command line as `none|random[:percent]|bursts|one-in-N`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stall {
    /// Never: a beat on every clock.
    #[default]
    None,
    /// This percentage of the clocks is stalled (1 to 99), each by its own throw of the dice.
    Random { percent: u32 },
    /// Free and stalled runs of 1 to 64 clocks in turn.
    Bursts,
    /// Pathological: one free clock in N (1 to 4096).
    OneIn(u32),
}

impl Stall {
    /// For each clock of the pattern, whether a beat may pass. At least one clock is always free.
    pub fn pattern(self, seed: u64) -> Vec<bool> {
        let mut dice = Xorshift::new(seed);
        let mut free: Vec<bool> = match self {
            Stall::None => vec![true; PATTERN],
            Stall::Random { percent } => {
                (0..PATTERN).map(|_| dice.below(100) >= u64::from(percent)).collect()
            }
            Stall::Bursts => {
                let mut runs = Vec::with_capacity(PATTERN + 64);
                while runs.len() < PATTERN {
                    let (state, length) = (dice.below(2) == 0, 1 + dice.below(64));
                    runs.extend((0..length).map(|_| state));
                }
                runs.truncate(PATTERN);
                runs
            }
            Stall::OneIn(n) => (1..=PATTERN as u32).map(|clock| clock % n.max(1) == 0).collect(),
        };
        free[PATTERN - 1] = true;
        free
    }
}

impl fmt::Display for Stall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stall::None => f.write_str("none"),
            Stall::Random { percent } => write!(f, "random:{percent}"),
            Stall::Bursts => f.write_str("bursts"),
            Stall::OneIn(n) => write!(f, "one-in-{n}"),
        }
    }
}

impl FromStr for Stall {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let number =
            |digits: &str, highest: u32| digits.parse().ok().filter(|number| (1..=highest).contains(number));
        let stall = match text {
            "none" => Some(Stall::None),
            "random" => Some(Stall::Random { percent: 50 }),
            "bursts" => Some(Stall::Bursts),
            _ => {
                let random = text.strip_prefix("random:").and_then(|digits| number(digits, 99));
                let one_in = text.strip_prefix("one-in-").and_then(|digits| number(digits, PATTERN as u32));
                random.map(|percent| Stall::Random { percent }).or(one_in.map(Stall::OneIn))
            }
        };
        stall.ok_or_else(|| {
            Error::usage(format!("no stall pattern is called '{text}'"))
                .help("use none, random, random:PERCENT (1 to 99), bursts, or one-in-N (1 to 4096)")
        })
    }
}

/// Marsaglia's 64-bit xorshift; the seed is spread first because the state must not be zero.
pub(super) struct Xorshift(u64);

impl Xorshift {
    pub fn new(seed: u64) -> Self {
        let spread = (seed ^ (seed >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut dice = Xorshift(spread ^ 0x2545_f491_4f6c_dd1d);
        if dice.0 == 0 {
            dice.0 = 1;
        }
        for _ in 0..8 {
            dice.next();
        }
        dice
    }
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    /// A number in `0..bound`, from the high half: its bits are the better ones.
    pub fn below(&mut self, bound: u64) -> u64 {
        ((self.next() >> 32) * bound) >> 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_form_reads_back() {
        for text in ["none", "random:30", "bursts", "one-in-17"] {
            assert_eq!(text.parse::<Stall>().unwrap().to_string(), text);
        }
        assert_eq!("random".parse(), Ok(Stall::Random { percent: 50 }));
    }

    #[test]
    fn patterns_that_would_never_let_a_beat_pass_are_refused() {
        for text in ["random:100", "one-in-0", "one-in-4097", "often", ""] {
            assert_eq!(text.parse::<Stall>().unwrap_err().exit_status(), 2, "{text}");
        }
    }

    #[test]
    fn random_stalls_about_the_percentage_asked_for() {
        let free = Stall::Random { percent: 30 }.pattern(7).iter().filter(|&&free| free).count();
        assert!((2700..3030).contains(&free), "{free} of 4096 clocks are free");
    }

    #[test]
    fn the_seed_changes_the_pattern_and_nothing_else_does() {
        for stall in [Stall::Random { percent: 50 }, Stall::Bursts] {
            assert_eq!(stall.pattern(3), stall.pattern(3));
            assert_ne!(stall.pattern(3), stall.pattern(4));
        }
    }

    #[test]
    fn one_in_n_frees_the_last_clock_of_each_n() {
        let free: Vec<_> = (0..PATTERN).filter(|&clock| Stall::OneIn(5).pattern(0)[clock]).collect();
        assert_eq!((free[0], free[1], free[2]), (4, 9, 14));
    }
}
