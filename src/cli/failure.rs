//! How the program says that something went wrong.
//!
//! ```text
//! error: edge 3-7 belongs to three faces
//!   at bunny.obj:412
//!   help: split the mesh so that every edge has at most two faces
//! ```
//!
//! That is for people, on standard error. Who asked for JSON finds the same in one object on standard output,
//! so that a program never has to read prose.

use super::output::{self, Format};
use crate::error::{Error, Kind};
use anstyle::{AnsiColor, Style};
use serde::Serialize;
use std::{io::Write, process::ExitCode};

/// Prints the error and gives the exit status.
pub fn report(error: &Error, format: Format) -> ExitCode {
    // Nobody is left to be told when standard error is closed.
    let _ = anstream::stderr().lock().write_all(text(error).as_bytes());
    if format == Format::Json {
        let _ = output::print_object("error", 1, &Failure::new(error));
    }
    ExitCode::from(error.exit_status())
}

fn text(error: &Error) -> String {
    let red = AnsiColor::Red.on_default().bold();
    let blue = AnsiColor::Blue.on_default().bold();
    let cyan = AnsiColor::Cyan.on_default().bold();
    let mut text = line("", red, "error:", &error.what);
    if let Some(place) = &error.place {
        text += &line("  ", blue, "at", place);
    }
    if let Some(help) = &error.help {
        text += &line("  ", cyan, "help:", help);
    }
    text
}

fn line(indent: &str, style: Style, label: &str, message: &str) -> String {
    format!("{indent}{style}{label}{style:#} {message}\n")
}

/// The same as data.
#[derive(Serialize)]
struct Failure<'a> {
    kind: &'static str,
    exit_status: u8,
    what: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<&'a str>,
}

impl<'a> Failure<'a> {
    fn new(error: &'a Error) -> Self {
        let kind = match error.kind {
            Kind::Mismatch => "mismatch",
            Kind::Usage => "usage",
            Kind::Input => "input",
            Kind::ToolMissing => "tool-missing",
            Kind::ToolFailed => "tool-failed",
        };
        Failure {
            kind,
            exit_status: error.exit_status(),
            what: &error.what,
            at: error.place.as_deref(),
            help: error.help.as_deref(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_read_three_lines_without_colours() {
        let error = Error::input("edge 3-7 belongs to three faces").at("bunny.obj:412").help("split it");
        let plain = anstream::adapter::strip_str(&text(&error)).to_string();
        assert_eq!(plain, format!("error: {error}\n"));
    }

    #[test]
    fn programs_read_one_object() {
        let error =
            Error::new(Kind::ToolMissing, "verilator is not installed").help("apt-get install verilator");
        assert_eq!(
            serde_json::to_string(&Failure::new(&error)).unwrap(),
            "{\"kind\":\"tool-missing\",\"exit_status\":4,\"what\":\"verilator is not installed\",\
             \"help\":\"apt-get install verilator\"}"
        );
    }
}
