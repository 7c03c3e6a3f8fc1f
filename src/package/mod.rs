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

pub mod cc_strip;
pub mod loop_fd;
mod manifest;

use std::path::{Path, PathBuf};

use std::rc::Rc;

use askama::Template;
use serde_json::Value;

use crate::cosim::{Beat, Dut, testbench, testbench_name, write_beats};
use crate::error::{Error, Kind, Result};
use crate::files::write_whole;
use crate::fpga::Device;
use crate::fpga::estimate::{Estimate, estimate};
use crate::hdl::ports::ports;
use crate::hdl::{Counts, Module};

pub use manifest::Manifest;

/// Everything that is written, by path within the folder.
#[derive(Clone, Debug)]
pub struct Package {
    pub top: String,
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// What the core will be on the first of [`ESTIMATED`]; nothing for what is more than a core.
    pub estimate: Option<Estimate>,
    /// Clocks, from what to what.
    pub latency: Option<(u64, &'static str)>,
}

/// The devices that a core is estimated on.
const ESTIMATED: [&str; 3] = ["ecp5-85k", "ice40-hx8k", "gowin-gw2a18"];

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

/// What the package of one core has that others have not.
struct Draft<'a> {
    /// As on the command line.
    core: &'static str,
    /// One line for the core file.
    purpose: &'a str,
    command: String,
    parameters: Value,
    streams: Value,
    latency: Value,
    /// Of these clocks, what a user asks for first: how many, from what to what.
    first: (u64, &'static str),
    initiation_interval: Value,
    proofs: Value,
    /// The vectors that come with the testbench.
    input: &'a [Beat],
    expected: &'a [Beat],
}

/// All files of a core.
fn assemble(module: &Rc<Module>, dut: &Dut, draft: Draft) -> Result<Package> {
    let (version, command, top) = (env!("CARGO_PKG_VERSION"), draft.command, dut.top.clone());
    let mut files: Vec<(PathBuf, Vec<u8>)> = vec![];
    let mut sources = vec![];
    for (name, text) in &dut.files {
        sources.push(format!("rtl/{name}"));
        files.push((format!("rtl/{name}").into(), text.clone().into_bytes()));
    }
    let bench = testbench_name(dut);
    let bench_file = format!("testbench/{bench}.v");
    files.push((PathBuf::from(&bench_file), testbench(dut)?.into_bytes()));
    files.push(("testbench/input.hex".into(), write_beats(&dut.input, draft.input)));
    files.push(("testbench/expected.hex".into(), write_beats(&dut.output, draft.expected)));
    let vector = |path, name| Vector { path, name };
    let fusesoc = FuseSoc {
        top: &top,
        purpose: draft.purpose,
        version,
        command: &command,
        sources: &sources,
        testbench: &bench_file,
        bench: &bench,
        vectors: vec![
            vector("testbench/input.hex", "input.hex"),
            vector("testbench/expected.hex", "expected.hex"),
        ],
    };
    files.push((format!("{top}.core").into(), print(&fusesoc)?));
    let list = FileList { top: &top, version, command: &command, sources: &sources };
    files.push((format!("{top}.f").into(), print(&list)?));

    let hash = |(path, bytes): &(PathBuf, Vec<u8>)| {
        (path.to_string_lossy().replace('\\', "/"), blake3::hash(bytes).to_hex().to_string())
    };
    let estimates = ESTIMATED.map(|name| estimate(module, Device::named(name)?));
    let estimates: Vec<Estimate> =
        estimates.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let manifest = Manifest {
        schema: "subdiv-rtl/manifest/1",
        core: draft.core,
        top: top.clone(),
        generator: format!("subdiv-rtl {version}"),
        command: command.clone(),
        parameters: draft.parameters,
        ports: ports(module),
        streams: draft.streams,
        latency: draft.latency,
        initiation_interval: draft.initiation_interval,
        counts: Counts::of(module),
        estimates: estimates.clone(),
        proofs: draft.proofs,
        names: manifest::names(module),
        hashes: files.iter().map(hash).collect(),
    };
    let json = serde_json::to_string_pretty(&manifest)
        .map_err(|e| Error::new(Kind::ToolFailed, format!("the manifest cannot be written: {e}")))?;
    files.push(("manifest.json".into(), format!("{json}\n").into_bytes()));
    Ok(Package { top, files, estimate: estimates.into_iter().next(), latency: Some(draft.first) })
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
