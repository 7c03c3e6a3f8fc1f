//! The files that a run is to write: what cannot be written is refused before any work.

use std::ffi::OsStr;
use std::path::Path;

use crate::error::{Error, Result};

/// Refuses a file in a folder that does not exist: better now than after the work.
pub fn in_a_folder(file: &Path) -> Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => Err(Error::usage("there is no such folder")
            .at(folder.display())
            .help(format!("make it (mkdir -p {}), or write elsewhere", folder.display()))),
        _ => Ok(()),
    }
}

/// Refuses a file whose ending says that it cannot be written.
pub fn named(file: Option<&Path>, what: &str, endings: &[&str]) -> Result<()> {
    let Some(file) = file else { return Ok(()) };
    let ending = file.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    if endings.contains(&ending.as_str()) {
        return Ok(());
    }
    let endings: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    Err(Error::usage(format!("no {what} is written to '{}'", file.display()))
        .help(format!("give a file that ends in {}", endings.join(" or "))))
}
