//! Results on standard output: text for people, or one JSON object for programs.
//!
//! A reader that closes the pipe (`subdiv-rtl shapes | head -1`) has seen enough; that is no error. A full disk is.

use crate::error::{Error, Result};
use serde::Serialize;
use std::io::{self, Write};

/// How a result is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// For people
    #[default]
    Text,
    /// One JSON object, for programs
    Json,
}

/// The option `--format`, for every subcommand that has a result.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct FormatArg {
    /// How to write the result; an error is written as JSON too
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub format: Format,
}

/// Prints text; its colours are taken away unless a terminal shows them.
///
/// # Errors
/// `Input` when the output cannot be written, as on a full disk.
pub fn print(text: &str) -> Result<()> {
    let mut stream = anstream::stdout().lock();
    judge(stream.write_all(text.as_bytes()).and_then(|()| stream.flush()))
}

/// Prints bytes as they are.
///
/// # Errors
/// As [`print()`].
pub fn print_bytes(bytes: &[u8]) -> Result<()> {
    let mut stream = io::stdout().lock();
    judge(stream.write_all(bytes).and_then(|()| stream.flush()))
}

/// Prints one JSON object that begins with its schema, `subdiv-rtl/NAME/VERSION`.
///
/// # Errors
/// As [`print()`].
pub fn print_object(name: &str, version: u32, fields: &impl Serialize) -> Result<()> {
    print_bytes(object(name, version, fields)?.as_bytes())
}

/// The text that [`print_object`] prints.
///
/// # Errors
/// `Input` when the fields are no object with text as keys.
pub fn object(name: &str, version: u32, fields: &impl Serialize) -> Result<String> {
    #[derive(Serialize)]
    struct Document<'a, T> {
        schema: String,
        #[serde(flatten)]
        fields: &'a T,
    }
    let schema = format!("subdiv-rtl/{name}/{version}");
    let text = serde_json::to_string_pretty(&Document { schema, fields })
        .map_err(|error| Error::input(format!("the result cannot be written as JSON: {error}")))?;
    Ok(text + "\n")
}

fn judge(written: io::Result<()>) -> Result<()> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::input(format!("the result cannot be written: {error}")).at("standard output"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_begins_with_its_schema_and_keeps_the_order() {
        #[derive(Serialize)]
        struct Fields {
            zebra: u32,
            apple: &'static str,
        }
        let text = object("shapes", 1, &Fields { zebra: 1, apple: "red" }).unwrap();
        assert_eq!(
            text,
            "{\n  \"schema\": \"subdiv-rtl/shapes/1\",\n  \"zebra\": 1,\n  \"apple\": \"red\"\n}\n"
        );
    }

    #[test]
    fn a_closed_pipe_is_no_error_and_a_full_disk_is() {
        assert!(judge(Err(io::ErrorKind::BrokenPipe.into())).is_ok());
        assert_eq!(judge(Err(io::ErrorKind::StorageFull.into())).unwrap_err().exit_status(), 3);
    }
}
