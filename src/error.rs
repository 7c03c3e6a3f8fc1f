//! The one error type of the program: what went wrong, where, and how to mend it.
//!
//! ```text
//! error: edge 3-7 belongs to three faces        <- what
//!   at bunny.obj:412                            <- where
//!   help: split the mesh so that ...            <- how to mend it
//! ```

use std::fmt;

/// What kind of mistake it was; the number is the exit status of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Hardware and reference disagree.
    Mismatch = 1,
    /// The command line or the configuration asks for something that does not exist.
    Usage = 2,
    /// A mesh, a number or a file that cannot be used.
    Input = 3,
    /// An external tool is not installed.
    ToolMissing = 4,
    /// An external tool was started and failed.
    ToolFailed = 5,
}

/// One message for the user, as data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    pub kind: Kind,
    pub what: String,
    pub place: Option<String>,
    pub help: Option<String>,
}

pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub fn new(kind: Kind, what: impl Into<String>) -> Self {
        Error { kind, what: what.into(), place: None, help: None }
    }
    pub fn input(what: impl Into<String>) -> Self {
        Self::new(Kind::Input, what)
    }
    pub fn usage(what: impl Into<String>) -> Self {
        Self::new(Kind::Usage, what)
    }
    /// Where it happened: a file with its line, a signal with the source line that built it.
    pub fn at(mut self, place: impl fmt::Display) -> Self {
        self.place = Some(place.to_string());
        self
    }
    /// How the user mends it.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
    pub fn exit_status(&self) -> u8 {
        self.kind as u8
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        if let Some(place) = &self.place {
            write!(f, "\n  at {place}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
