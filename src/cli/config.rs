//! `--config FILE.toml`: defaults for the options of a subcommand.
//!
//! ```toml
//! coordinates = "Q12.12"
//! max-level = 8
//! ```
//!
//! The command line beats the file, the file beats what is built in. A mistake is told with file and line; so is a
//! key that nobody reads, since a misspelt key would otherwise be a silent default.

use crate::error::{Error, Kind, Result};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    str::FromStr,
};
use toml::de::{DeTable, DeValue};

/// A file of keys and values; what has been read is taken out of it.
#[derive(Debug)]
pub struct Config {
    file: PathBuf,
    known: &'static [&'static str],
    entries: BTreeMap<String, Entry>,
}

#[derive(Debug)]
struct Entry {
    line: usize,
    value: Value,
}

#[derive(Debug)]
enum Value {
    Text(String),
    Whole(i64),
    Truth(bool),
    Other,
}

impl Config {
    /// Reads a file that may have these keys and no others.
    ///
    /// # Errors
    /// `Input` when the file cannot be read or is no TOML, `Usage` when it has a key that is not known.
    pub fn read(file: &Path, known: &'static [&'static str]) -> Result<Self> {
        let text = fs::read_to_string(file).map_err(|error| {
            Error::input(format!("the configuration cannot be read: {error}")).at(file.display())
        })?;
        Self::parse(file, &text, known)
    }

    fn parse(file: &Path, text: &str, known: &'static [&'static str]) -> Result<Self> {
        let line_of = |offset: usize| 1 + text[..offset].matches('\n').count();
        let table = DeTable::parse(text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_of(span.start));
            let message = error.message().trim_end().replace('\n', ", ");
            Error::input(format!("no TOML: {message}"))
                .at(place(file, line))
                .help("write one 'key = value' a line, with text in quotation marks")
        })?;
        let mut entries = BTreeMap::new();
        for (key, value) in table.get_ref() {
            let (line, key) = (line_of(key.span().start), key.get_ref().to_string());
            if !known.contains(&key.as_str()) {
                return Err(Error::usage(format!("unknown key '{key}'"))
                    .at(place(file, line))
                    .help(format!("the keys are {}", known.join(", "))));
            }
            let value = match value.get_ref() {
                DeValue::String(text) => Value::Text(text.to_string()),
                DeValue::Boolean(truth) => Value::Truth(*truth),
                DeValue::Integer(number) => {
                    i64::from_str_radix(number.as_str(), number.radix()).map_or(Value::Other, Value::Whole)
                }
                _ => Value::Other,
            };
            entries.insert(key, Entry { line, value });
        }
        Ok(Config { file: file.to_path_buf(), known, entries })
    }

    /// Text that says something of type `T`.
    ///
    /// # Errors
    /// `Usage`, with file and line, when it is no text or `T` does not understand it. So do the others.
    pub fn text<T: FromStr<Err = Error>>(&self, key: &str) -> Result<Option<T>> {
        let text = self.get(key, "text in quotation marks", |value| match value {
            Value::Text(text) => Some(text.parse::<T>()),
            _ => None,
        })?;
        let Some((line, parsed)) = text else { return Ok(None) };
        match parsed {
            Ok(value) => Ok(Some(value)),
            Err(error) => Err(Error { kind: Kind::Usage, ..error }.at(place(&self.file, line))),
        }
    }

    /// A path, taken from the folder of the configuration when it is relative.
    pub fn path(&self, key: &str) -> Result<Option<PathBuf>> {
        let folder = self.file.parent().unwrap_or(Path::new(""));
        let path = self.get(key, "text in quotation marks", |value| match value {
            Value::Text(text) => Some(folder.join(text)),
            _ => None,
        })?;
        Ok(path.map(|(_, path)| path))
    }

    /// A whole number that `take` accepts; `wanted` says which ones those are.
    pub fn whole<T>(&self, key: &str, wanted: &str, take: impl Fn(i64) -> Option<T>) -> Result<Option<T>> {
        let number = self.get(key, wanted, |value| match value {
            Value::Whole(number) => take(*number),
            _ => None,
        })?;
        Ok(number.map(|(_, number)| number))
    }

    pub fn truth(&self, key: &str) -> Result<Option<bool>> {
        let truth = self.get(key, "true or false", |value| match value {
            Value::Truth(truth) => Some(*truth),
            _ => None,
        })?;
        Ok(truth.map(|(_, truth)| truth))
    }

    fn get<T>(
        &self,
        key: &str,
        wanted: &str,
        take: impl FnOnce(&Value) -> Option<T>,
    ) -> Result<Option<(usize, T)>> {
        debug_assert!(self.known.contains(&key), "{key} is not in the list of keys");
        let Some(entry) = self.entries.get(key) else { return Ok(None) };
        match take(&entry.value) {
            Some(value) => Ok(Some((entry.line, value))),
            None => Err(Error::usage(format!("'{key}' must be {wanted}")).at(place(&self.file, entry.line))),
        }
    }
}

fn place(file: &Path, line: usize) -> String {
    format!("{}:{line}", file.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Format;

    fn parse(text: &str) -> Result<Config> {
        Config::parse(Path::new("cores/loop.toml"), text, &["coordinates", "max-level", "proof", "output"])
    }

    #[test]
    fn values_have_their_types() {
        let config =
            parse("coordinates = \"Q3.5\"\nmax-level = 0x5\nproof = false\noutput = \"rtl\"").unwrap();
        assert_eq!(config.text("coordinates").unwrap(), Format::new(3, 5));
        assert_eq!(config.whole("max-level", "", Some).unwrap(), Some(5));
        assert_eq!(config.truth("proof").unwrap(), Some(false));
        assert_eq!(config.path("output").unwrap(), Some(PathBuf::from("cores/rtl")));
        assert_eq!(parse("").unwrap().truth("proof").unwrap(), None);
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_known_ones() {
        let error = parse("# a comment\nmax-levl = 3\n").unwrap_err();
        assert_eq!((error.what.as_str(), error.exit_status()), ("unknown key 'max-levl'", 2));
        assert_eq!(error.place.as_deref(), Some("cores/loop.toml:2"));
        assert_eq!(error.help.as_deref(), Some("the keys are coordinates, max-level, proof, output"));
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let config = parse("\ncoordinates = \"12.12\"\nproof = 1\n").unwrap();
        let place = |error: Error| (error.exit_status(), error.place.unwrap());
        assert_eq!(
            place(config.text::<Format>("coordinates").unwrap_err()),
            (2, "cores/loop.toml:2".to_string())
        );
        assert_eq!(place(config.truth("proof").unwrap_err()), (2, "cores/loop.toml:3".to_string()));
        assert_eq!(place(parse("proof = \n").unwrap_err()), (3, "cores/loop.toml:1".to_string()));
        assert_eq!(Config::read(Path::new("no/such/file.toml"), &[]).unwrap_err().exit_status(), 3);
    }
}
