//! The file of results: a line a point, appended as points come, whole after any kill.
//!
//! ```text
//!   {...}\n  {...}\n  {...}\n  {..            a line without its end was torn by a kill
//!                              └─► cut off when the file is opened again; its point is evaluated once more
//! ```
//!
//! A line is written by one call at the end of the file, so what stands before it is never touched.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::record::{Record, line, read};
use crate::error::{Error, Result};

/// An open file of results.
pub struct Journal {
    file: File,
    path: PathBuf,
    known: BTreeMap<String, Record>,
    torn: bool,
}

impl Journal {
    /// Opens or makes the file, reads what it holds and cuts off a torn last line.
    ///
    /// # Errors
    /// A file that cannot be read or written; a whole line that is no result, with its number.
    pub fn open(path: &Path) -> Result<Journal> {
        let failed = |error: io::Error| {
            Error::input(format!("cannot open the results: {error}"))
                .at(path.display())
                .help("check that its folder exists and can be written to")
        };
        let mut options = OpenOptions::new();
        let mut file = options.read(true).append(true).create(true).open(path).map_err(failed)?;
        let mut bytes = vec![];
        file.read_to_end(&mut bytes).map_err(failed)?;
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        let torn = whole < bytes.len();
        if torn {
            file.set_len(whole as u64).map_err(failed)?;
            file.seek(SeekFrom::End(0)).map_err(failed)?;
        }
        let text = std::str::from_utf8(&bytes[..whole])
            .map_err(|_| Error::input("this is no file of results").at(path.display()))?;
        let mut known = BTreeMap::new();
        for record in read::<Record>(text, &path.display().to_string())? {
            known.insert(record.point.key.clone(), record);
        }
        Ok(Journal { file, path: path.to_owned(), known, torn })
    }

    /// The result of a point that the file held when it was opened.
    pub fn known(&self, key: &str) -> Option<&Record> {
        self.known.get(key)
    }

    /// Whether a last line was cut off.
    pub fn was_torn(&self) -> bool {
        self.torn
    }

    /// Appends one result.
    ///
    /// # Errors
    /// A file that cannot be written, as on a full disk.
    pub fn append(&mut self, record: &Record) -> Result<()> {
        let text = line(record)?;
        self.file.write_all(text.as_bytes()).and_then(|()| self.file.flush()).map_err(|error| {
            Error::input(format!("cannot write the results: {error}"))
                .at(self.path.display())
                .help("make room and start again with the same file: nothing is done twice")
        })
    }
}
