//! Clock and baud rate of a board: the dividers of its PLL, and the clocks of a bit.
//!
//! ```text
//! ECP5     f = f_in * feedback / input,     VCO = f * output   within 400 .. 800 MHz,  f_in / input within 3.125 .. 400
//! Gowin    the same dividers,               VCO                within 500 .. 1250 MHz, f_in / input within 3 .. 500
//! ```
//!
//! Of the dividers that give the clock exactly, those with the VCO nearest to the middle of its range are taken.

use super::boards::Family;
use crate::cores::board::{FEWEST_CLOCKS, MOST_CLOCKS};
use crate::error::{Error, Result};

/// The dividers of a PLL with its output as feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pll {
    pub input: u32,
    pub feedback: u32,
    pub output: u32,
}

/// What a family's PLL can do; frequencies in Hz.
struct Limits {
    phase: (u64, u64),
    vco: (u64, u64),
    input: u32,
    feedback: u32,
    outputs: Vec<u32>,
}

fn limits(family: Family) -> Limits {
    match family {
        Family::Ecp5 => Limits {
            phase: (3_125_000, 400_000_000),
            vco: (400_000_000, 800_000_000),
            input: 128,
            feedback: 80,
            outputs: (1..=128).collect(),
        },
        Family::Gowin => Limits {
            phase: (3_000_000, 500_000_000),
            vco: (500_000_000, 1_250_000_000),
            input: 64,
            feedback: 64,
            outputs: vec![2, 4, 8, 16, 32, 48, 64, 80, 96, 112, 128],
        },
    }
}

/// The dividers that make `clock` of `oscillator`, both in Hz.
///
/// # Errors
/// `Usage` for a clock that the PLL cannot make, with the nearest one that it can.
pub fn pll(family: Family, oscillator: u32, clock: u32) -> Result<Pll> {
    let limits = limits(family);
    let (oscillator, clock) = (u64::from(oscillator), u64::from(clock));
    let middle = (limits.vco.0 + limits.vco.1) / 2;
    let (mut best, mut nearest) = (None, 0);
    for input in 1..=limits.input {
        let within = |f: u64, (low, high): (u64, u64)| (low..=high).contains(&f);
        if !within(oscillator / u64::from(input), limits.phase) {
            continue;
        }
        for (feedback, &output) in
            (1..=limits.feedback).flat_map(|f| limits.outputs.iter().map(move |o| (f, o)))
        {
            let product = oscillator * u64::from(feedback);
            let (made, vco) = (product / u64::from(input), product * u64::from(output) / u64::from(input));
            if !within(vco, limits.vco) {
                continue;
            }
            if made.abs_diff(clock) < clock.abs_diff(nearest) {
                nearest = made;
            }
            let far = vco.abs_diff(middle);
            if product == clock * u64::from(input) && best.is_none_or(|(least, _)| far < least) {
                best = Some((far, Pll { input, feedback, output }));
            }
        }
    }
    best.map(|(_, pll)| pll).ok_or_else(|| {
        Error::usage(format!("the PLL cannot make {} MHz of {} MHz", mega(clock), mega(oscillator)))
            .help(format!("the nearest clock that it can make is {} MHz", mega(nearest)))
    })
}

/// Hz in MHz.
pub fn mega(hertz: u64) -> f64 {
    hertz as f64 / 1e6
}

/// The clocks of a bit.
///
/// # Errors
/// `Usage` where no whole number of clocks comes within 2 % of the baud rate, which a receiver needs.
pub fn clocks_per_bit(clock: u32, baud: u32) -> Result<u32> {
    let clocks = (clock + baud / 2) / baud.max(1);
    let made = |clocks: u32| f64::from(clock) / f64::from(clocks.max(1));
    let error = (made(clocks) / f64::from(baud) - 1.0).abs();
    if !(FEWEST_CLOCKS..=MOST_CLOCKS).contains(&clocks) || error > 0.02 {
        let clock = mega(clock.into());
        return Err(Error::usage(format!(
            "{baud} baud at {clock} MHz: {clocks} clocks a bit make {:.0} baud, {:.1} % off",
            made(clocks),
            100.0 * error
        ))
        .help("choose another --baud or --clock; receivers stand 2 %"));
    }
    Ok(clocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What Project Trellis's ecppll prints for these clocks.
    #[test]
    fn ecp5_dividers_are_those_of_ecppll() {
        for (clock, input, feedback, output) in
            [(50, 1, 2, 12), (100, 1, 4, 6), (60, 5, 12, 10), (30, 5, 6, 20), (75, 1, 3, 8), (55, 5, 11, 11)]
        {
            let found = pll(Family::Ecp5, 25_000_000, clock * 1_000_000).unwrap();
            assert_eq!(found, Pll { input, feedback, output }, "{clock} MHz");
        }
    }

    #[test]
    fn gowin_dividers_make_the_clock() {
        let found = pll(Family::Gowin, 27_000_000, 54_000_000).unwrap();
        assert_eq!(found, Pll { input: 1, feedback: 2, output: 16 });
    }

    #[test]
    fn a_clock_that_cannot_be_made_names_the_nearest() {
        let error = pll(Family::Ecp5, 25_000_000, 48_000_000).unwrap_err();
        assert_eq!(error.what, "the PLL cannot make 48 MHz of 25 MHz");
        assert_eq!(error.exit_status(), 2);
        assert_eq!(error.help.clone().unwrap(), "the nearest clock that it can make is 46.875 MHz");
    }

    #[test]
    fn a_baud_rate_must_be_near_a_whole_number_of_clocks() {
        assert_eq!(clocks_per_bit(50_000_000, 115_200).unwrap(), 434);
        assert_eq!(clocks_per_bit(50_000_000, 1_000_000).unwrap(), 50);
        let error = clocks_per_bit(25_000_000, 3_000_000).unwrap_err();
        assert!(error.what.contains("8 clocks a bit make 3125000 baud, 4.2 % off"), "{error}");
    }
}
