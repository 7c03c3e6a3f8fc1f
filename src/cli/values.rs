//! Values that several subcommands take.

use crate::cores::loop_fd::RegisterForm;
use crate::error::{Error, Result};
use crate::fixed::{Fractions, Precision, Reduced, Rounding};
use clap::ValueEnum;
use std::fmt;

/// How many registers a coordinate of the forward-difference engine has; what goes out is the same, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Registers {
    /// All 15 differences and two running columns, as published
    #[value(name = "23")]
    Published,
    /// Without the difference that is always zero
    #[value(name = "22")]
    WithoutZero,
    /// Also without the two fourth differences that are twice another one
    #[default]
    #[value(name = "20")]
    WithoutDoubles,
    /// The second column as its distance from the first
    #[value(name = "19")]
    Distance,
}

impl Registers {
    pub fn count(self) -> u32 {
        match self {
            Registers::Published => 23,
            Registers::WithoutZero => 22,
            Registers::WithoutDoubles => 20,
            Registers::Distance => 19,
        }
    }

    /// The same as the core knows it.
    pub fn form(self) -> RegisterForm {
        match self {
            Registers::Published => RegisterForm::Published23,
            Registers::WithoutZero => RegisterForm::WithoutZero22,
            Registers::WithoutDoubles => RegisterForm::Minimal20,
            Registers::Distance => RegisterForm::Relative19,
        }
    }

    pub fn from_count(count: i64) -> Option<Self> {
        Self::value_variants().iter().copied().find(|form| i64::from(form.count()) == count)
    }
}

impl fmt::Display for Registers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.count())
    }
}

/// How the forward-difference engine keeps its numbers: exactly, if nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::Args)]
pub struct Numbers {
    /// Keep the differences with N fraction bits below the unit of the coordinates [default: exact numbers]
    #[arg(long, value_name = "N", conflicts_with = "fractions", value_parser = clap::value_parser!(u32).range(0..=Fractions::MOST as i64))]
    pub fraction: Option<u32>,

    /// Fraction bits of the differences of each order, which do not fall: F0,F1,F2,F3,F4
    #[arg(long, value_name = "F0,..,F4")]
    pub fractions: Option<Fractions>,

    /// How differences are rounded: half-up, half-even, floor or truncate [default: half-up]
    #[arg(long, value_name = "MODE")]
    pub rounding: Option<Rounding>,

    /// Put a vertex that rounding moved out of the output format back to its end, in place of one more bit
    #[arg(long)]
    pub saturate: bool,
}

impl Numbers {
    /// # Errors
    /// `Usage` for a rounding mode or saturation of exact numbers, and for both kinds of fractions.
    pub fn precision(self) -> Result<Precision> {
        let fractions = match (self.fraction, self.fractions) {
            (Some(_), Some(_)) => {
                return Err(Error::usage("both one fraction and one for each order")
                    .help("give --fraction or --fractions"));
            }
            (Some(bits), None) => Some(Fractions::uniform(bits)?),
            (None, each) => each,
        };
        let Some(fractions) = fractions else {
            if self.rounding.is_some() || self.saturate {
                return Err(Error::usage("exact differences are neither rounded nor saturated")
                    .help("give --fraction N, for example --fraction 17"));
            }
            return Ok(Precision::Exact);
        };
        let rounding = self.rounding.unwrap_or(Rounding::HalfUp);
        Ok(Precision::Reduced(Reduced { fractions, rounding, saturate: self.saturate }))
    }
}

/// The finest level of which any core can be made.
pub const FINEST_LEVEL: u32 = 10;
/// The level up to which a core is made when nothing is said.
pub const USUAL_MAX_LEVEL: u32 = 8;

/// `300`, `300MHz`: a clock in MHz.
///
/// # Errors
/// Anything else.
pub fn clock(text: &str) -> Result<f64> {
    let number = text.trim().strip_suffix("MHz").unwrap_or(text).trim().parse::<f64>();
    match number {
        Ok(mhz) if (1.0..=5000.0).contains(&mhz) => Ok(mhz),
        _ => Err(Error::usage(format!("'{text}' is no clock")).help("write megahertz, for example 300MHz")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_register_form_is_its_count() {
        for form in Registers::value_variants() {
            let name = form.to_possible_value().unwrap().get_name().to_string();
            assert_eq!(name, form.to_string());
            assert_eq!(Registers::from_count(form.count().into()), Some(*form));
        }
        assert_eq!(Registers::from_count(21), None);
    }

    #[test]
    fn numbers_are_exact_unless_fractions_are_given() {
        let none = Numbers::default();
        assert_eq!(none.precision().unwrap(), Precision::Exact);
        assert!(Numbers { saturate: true, ..none }.precision().is_err());
        assert!(Numbers { rounding: Some(Rounding::Floor), ..none }.precision().is_err());
        let uniform = Fractions::uniform(17).ok();
        let reduced = Numbers { fraction: Some(17), rounding: Some(Rounding::HalfEven), ..none };
        assert_eq!(reduced.precision().unwrap().to_string(), "17 half-even");
        assert!(Numbers { fractions: uniform, ..reduced }.precision().is_err());
    }
}
