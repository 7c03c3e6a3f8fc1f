//! Values that several subcommands take.

use crate::cores::loop_fd::RegisterForm;
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

/// The finest level of which any core can be made.
pub const FINEST_LEVEL: u32 = 10;
/// The level up to which a core is made when nothing is said.
pub const USUAL_MAX_LEVEL: u32 = 8;

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
}
