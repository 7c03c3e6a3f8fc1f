//! A core as its user receives it: Verilog, a testbench with vectors, a FuseSoC core file, a file list,
//! and one manifest that says what all of it is.
//!
//! ```text
//! loop-fd/
//!   manifest.json            ports, formats, latency, counts, proofs, hashes, names
//!   loop_fd.core  loop_fd.f  for FuseSoC; for tools that read file lists
//!   rtl/*.v                  one module a file
//!   testbench/               loop_fd_testbench.v, input.hex, expected.hex
//! ```

pub mod loop_fd;
mod manifest;

use std::path::{Path, PathBuf};

use askama::Template;

use crate::error::{Error, Kind, Result};
use crate::files::write_whole;

pub use manifest::Manifest;

/// Everything that is written, by path within the folder.
#[derive(Clone, Debug)]
pub struct Package {
    pub top: String,
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

#[derive(Template)]
#[template(path = "fusesoc.core")]
struct FuseSoc<'a> {
    top: &'a str,
    purpose: &'a str,
    version: &'a str,
    command: &'a str,
    sources: &'a [String],
    testbench: &'a str,
    bench: &'a str,
    vectors: Vec<Vector<'a>>,
}

/// A vector file: where it lies, and what the testbench calls it.
struct Vector<'a> {
    path: &'a str,
    name: &'a str,
}

#[derive(Template)]
#[template(path = "filelist.f")]
struct FileList<'a> {
    top: &'a str,
    version: &'a str,
    command: &'a str,
    sources: &'a [String],
}

fn print(template: &impl Template) -> Result<Vec<u8>> {
    let text = template
        .render()
        .map_err(|e| Error::new(Kind::ToolFailed, format!("a template cannot be printed: {e}")))?;
    Ok(format!("{}\n", text.trim_end()).into_bytes())
}

impl Package {
    /// Writes all files below `folder`. A folder that does not exist yet appears whole or not at all.
    ///
    /// # Errors
    /// A folder that holds other files, unless `force`; anything the file system refuses.
    pub fn write(&self, folder: &Path, force: bool) -> Result<()> {
        let strangers = strangers(folder, &self.files);
        if let (Some(stranger), false) = (strangers.first(), force) {
            return Err(Error::input(format!(
                "{} holds files that are no part of the core",
                folder.display()
            ))
            .at(stranger.display())
            .help("choose another folder with -o, or write beside them with --force"));
        }
        if folder.exists() {
            for (path, bytes) in &self.files {
                let path = folder.join(path);
                make_parent(&path)?;
                write_whole(&path, bytes)?;
            }
            return Ok(());
        }
        let parent = folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let refused = |e: std::io::Error| Error::input(format!("cannot write: {e}")).at(folder.display());
        std::fs::create_dir_all(parent).map_err(refused)?;
        let draft = tempfile::Builder::new().prefix(".subdiv-rtl-").tempdir_in(parent).map_err(refused)?;
        for (path, bytes) in &self.files {
            let path = draft.path().join(path);
            make_parent(&path)?;
            write_whole(&path, bytes)?;
        }
        std::fs::rename(draft.keep(), folder).map_err(refused)?;
        // A temporary folder is private; this one is the user's.
        share(folder).map_err(refused)
    }
}

#[cfg(unix)]
fn share(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn share(_: &Path) -> std::io::Result<()> {
    Ok(())
}

fn make_parent(path: &Path) -> Result<()> {
    let Some(parent) = path.parent() else { return Ok(()) };
    std::fs::create_dir_all(parent)
        .map_err(|e| Error::input(format!("cannot make the folder: {e}")).at(parent.display()))
}

/// What lies in the folder and is not about to be written anew.
fn strangers(folder: &Path, files: &[(PathBuf, Vec<u8>)]) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut strangers: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| PathBuf::from(entry.file_name()))
        .filter(|name| !files.iter().any(|(path, _)| path.starts_with(name)))
        .collect();
    strangers.sort();
    strangers.into_iter().map(|name| folder.join(name)).collect()
}
