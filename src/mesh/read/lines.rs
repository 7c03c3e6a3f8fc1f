//! A text file line by line, with the line number at hand and no line longer than 64 KiB.
//!
//! ```text
//! while lines.advance()? { for token in lines.tokens() { lines.real(token)? } }
//!                                                        └─ an error says file:line by itself
//! ```

use crate::error::{Error, Result};
use std::io::{BufRead, Read};

/// The longest line in bytes; a longer one is no mesh, and reading on could fill the memory.
const LONGEST: usize = 64 << 10;

pub(super) struct Lines<R> {
    input: R,
    file: String,
    text: Vec<u8>,
    /// The line that `text` begins at, from 1.
    number: u64,
    read: u64,
}

/// The file could not be read to its end.
pub(super) fn broken(error: &std::io::Error) -> Error {
    Error::input(format!("reading failed: {error}")).help("check the file and the disk it is on")
}

impl<R: BufRead> Lines<R> {
    pub fn new(input: R, file: &str) -> Self {
        Lines { input, file: file.to_owned(), text: Vec::new(), number: 0, read: 0 }
    }

    /// Goes to the next line; false at the end of the file.
    pub fn advance(&mut self) -> Result<bool> {
        self.text.clear();
        self.number = self.read + 1;
        self.append()
    }

    /// The same where a backslash at the end of a line joins it with the next.
    pub fn advance_joined(&mut self) -> Result<bool> {
        let mut more = self.advance()?;
        let any = more;
        while more && self.text.ends_with(b"\\") {
            self.text.pop();
            more = self.append()?;
        }
        Ok(any)
    }

    fn append(&mut self) -> Result<bool> {
        let room = (LONGEST + 2).saturating_sub(self.text.len()) as u64;
        let taken = self.input.by_ref().take(room).read_until(b'\n', &mut self.text);
        let taken = taken.map_err(|error| broken(&error).at(self.here()))?;
        if taken == 0 && room > 0 {
            return Ok(false);
        }
        self.read += 1;
        let ended = self.text.pop_if(|byte| *byte == b'\n').is_some();
        self.text.pop_if(|byte| ended && *byte == b'\r');
        if self.text.len() > LONGEST {
            return Err(self
                .error(format!("a line is longer than {} KiB", LONGEST >> 10))
                .help("this is hardly a mesh; if it is one, write one element on each line"));
        }
        Ok(true)
    }

    /// The words of the line.
    pub fn tokens(&self) -> impl Iterator<Item = &[u8]> {
        self.text.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty())
    }

    pub fn text(&self) -> &[u8] {
        &self.text
    }

    pub fn number(&self) -> u64 {
        self.number
    }

    pub fn file(&self) -> &str {
        &self.file
    }

    /// What follows the current line, for files that go on in binary.
    pub fn into_input(self) -> R {
        self.input
    }

    pub fn here(&self) -> String {
        format!("{}:{}", self.file, self.number)
    }

    pub fn error(&self, what: impl Into<String>) -> Error {
        Error::input(what).at(self.here())
    }

    /// A finite number.
    pub fn real(&self, token: &[u8]) -> Result<f64> {
        let number = std::str::from_utf8(token).ok().and_then(|text| text.parse::<f64>().ok());
        match number {
            Some(number) if number.is_finite() => Ok(number),
            Some(_) => Err(self
                .error(format!("the coordinate '{}' is infinite or not a number", show(token)))
                .help("repair the vertex in the program that made the mesh")),
            None => Err(self
                .error(format!("'{}' is not a number", show(token)))
                .help("write coordinates as decimal numbers with a point, for example -0.25 or 1e-3")),
        }
    }

    /// The next three words as a point.
    pub fn point<'a>(&self, mut tokens: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3]> {
        let mut point = [0.0; 3];
        for coordinate in &mut point {
            let token = tokens.next().ok_or_else(|| {
                self.error("a vertex has fewer than three coordinates").help("write x, y and z on its line")
            })?;
            *coordinate = self.real(token)?;
        }
        Ok(point)
    }

    /// A whole number.
    pub fn integer(&self, token: &[u8]) -> Result<i64> {
        std::str::from_utf8(token).ok().and_then(|text| text.parse().ok()).ok_or_else(|| {
            self.error(format!("'{}' is not a whole number", show(token)))
                .help("counts and indices are whole numbers below 2^32")
        })
    }

    /// An index or a count of corners, from 0.
    pub fn index(&self, token: &[u8]) -> Result<u32> {
        let number = self.integer(token)?;
        u32::try_from(number).map_err(|_| {
            self.error(format!("{number} is no index of a vertex"))
                .help("indices count from 0, up to 2^32 - 1")
        })
    }
}

/// A word from a file, made fit for a message: readable, short, no control characters.
pub(super) fn show(token: &[u8]) -> String {
    let text = String::from_utf8_lossy(&token[..token.len().min(120)]);
    let short: String = text.chars().take(30).collect();
    let dots = if short.len() < token.len() { "..." } else { "" };
    format!("{}{dots}", short.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Lines<&[u8]> {
        Lines::new(text, "f")
    }

    #[test]
    fn both_line_endings_count() {
        let mut lines = lines(b"a b\r\n\nc");
        let mut seen = Vec::new();
        while lines.advance().unwrap() {
            seen.push((lines.here(), lines.tokens().count()));
        }
        assert_eq!(seen, [("f:1".into(), 2), ("f:2".into(), 0), ("f:3".into(), 1)]);
    }

    #[test]
    fn joined_lines_keep_the_number_of_the_first() {
        let mut lines = lines(b"a\\\nb \\\nc\nd");
        assert!(lines.advance_joined().unwrap());
        assert_eq!((lines.text(), lines.number()), (&b"ab c"[..], 1));
        assert!(lines.advance_joined().unwrap());
        assert_eq!((lines.text(), lines.number()), (&b"d"[..], 4));
    }

    #[test]
    fn a_line_may_be_64_kib_and_no_longer() {
        let mut text = vec![b'x'; LONGEST];
        text.extend(b"\r\n");
        assert!(lines(&text).advance().is_ok());
        text.insert(0, b'x');
        let error = lines(&text).advance().unwrap_err();
        assert_eq!(error.place.as_deref(), Some("f:1"));
    }

    #[test]
    fn an_endless_line_is_refused_without_reading_it() {
        struct Endless(u64);
        impl Read for Endless {
            fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
                self.0 += buffer.len() as u64;
                assert!(self.0 < 1 << 20, "reads on and on");
                buffer.fill(b'\\');
                Ok(buffer.len())
            }
        }
        assert!(Lines::new(std::io::BufReader::new(Endless(0)), "f").advance().is_err());
        assert!(Lines::new(std::io::BufReader::new(Endless(0)), "f").advance_joined().is_err());
    }

    #[test]
    fn joining_lines_does_not_lift_the_limit() {
        let text = b"v 0 0 0 \\\n".repeat(20_000);
        assert!(lines(&text).advance_joined().is_err());
    }

    #[test]
    fn numbers_are_finite() {
        let lines = lines(b"");
        assert_eq!(lines.real(b"-1.5e-3").unwrap(), -0.0015);
        for bad in ["nan", "-inf", "1e999", "0x1", "", "1,5", "1\u{7f}"] {
            assert!(lines.real(bad.as_bytes()).unwrap_err().help.is_some(), "{bad}");
        }
        assert!(lines.index(b"4294967296").is_err() && lines.index(b"-1").is_err());
    }

    #[test]
    fn words_are_shown_short_and_harmless() {
        assert_eq!(show(b"a\x1b[2J"), "a\\u{1b}[2J");
        assert!(show(&[0xff; 1000]).chars().count() < 40);
    }
}
