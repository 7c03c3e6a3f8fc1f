//! The folder in which one simulation happens: temporary, or kept where the user says.

use super::Settings;
use crate::{Error, Kind, Result};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Removed at the end unless the user wants it or it holds the log of a failure.
pub(super) enum Work {
    Temporary(TempDir),
    Kept(PathBuf),
}

impl Work {
    pub(super) fn open(settings: &Settings, name: &str) -> Result<Work> {
        let Some(keep) = &settings.keep else {
            let folder = tempfile::Builder::new().prefix("subdiv-rtl-").tempdir();
            let cannot = |error| Error::new(Kind::ToolFailed, format!("no temporary folder: {error}"));
            return folder.map(Work::Temporary).map_err(cannot);
        };
        let folder = keep.join(name);
        fs::create_dir_all(&folder).map_err(|error| cannot_write(&folder, error))?;
        // Commands run inside of it: a relative path would lead elsewhere.
        let folder = folder.canonicalize().map_err(|error| cannot_write(&folder, error))?;
        for old in ["commands.sh", "received.hex", "window.vcd", "coverage.dat"] {
            let _ = fs::remove_file(folder.join(old));
        }
        let _ = fs::remove_dir_all(folder.join("obj_dir"));
        Ok(Work::Kept(folder))
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Work::Temporary(folder) => folder.path(),
            Work::Kept(folder) => folder,
        }
    }

    pub(super) fn kept(&self) -> Option<PathBuf> {
        match self {
            Work::Temporary(_) => None,
            Work::Kept(folder) => Some(folder.clone()),
        }
    }

    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let file = self.path().join(name);
        fs::write(&file, bytes).map_err(|error| cannot_write(&file, error))
    }

    pub(super) fn read(&self, name: &str) -> Result<Vec<u8>> {
        let file = self.path().join(name);
        fs::read(&file).map_err(|error| {
            Error::new(Kind::ToolFailed, format!("the simulator left no {name}: {error}")).at(file.display())
        })
    }

    /// Notes a command so that the user can repeat it by hand.
    pub(super) fn note(&self, line: &[String]) -> Result<()> {
        let file = self.path().join("commands.sh");
        let quoted: Vec<_> = line.iter().map(|word| quote(word)).collect();
        let append = |line: String| {
            let mut commands = fs::OpenOptions::new().create(true).append(true).open(&file)?;
            commands.write_all(line.as_bytes())
        };
        append(quoted.join(" ") + "\n").map_err(|error| cannot_write(&file, error))
    }

    /// When a tool failed, its log outlives this run.
    pub(super) fn keep_on_failure<T>(self, result: Result<T>) -> Result<T> {
        if let (Err(error), Work::Temporary(folder)) = (&result, self)
            && error.kind == Kind::ToolFailed
        {
            let _ = folder.keep();
        }
        result
    }
}

fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+".contains(c);
    if word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

fn cannot_write(file: &Path, error: std::io::Error) -> Error {
    Error::new(Kind::Usage, format!("cannot write: {error}")).at(file.display())
}
