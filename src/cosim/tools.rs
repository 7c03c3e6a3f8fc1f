//! The external tools: which there are, what for, which version, how to install them.
//!
//! ```text
//! verilator  5.006 or newer   the fast simulator              found 5.006
//! iverilog   11.0 or newer    the simulator that knows X      not found: sudo apt-get install iverilog
//! ```

use super::{Settings, process};
use crate::{Error, Kind, Result};
use std::ffi::OsString;
use std::fmt;
use std::path::PathBuf;

/// A version as the tool prints it, compared number by number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Version(String);

/// What `doctor` shows of one tool.
#[derive(Clone, Debug)]
pub struct ToolStatus {
    pub name: &'static str,
    pub purpose: &'static str,
    /// `None`: not installed; "unknown" where it does not tell.
    pub found: Option<Version>,
    /// The oldest version that works; `None`: any.
    pub minimum: Option<Version>,
    /// Whether something fails without it.
    pub required: bool,
    /// The exact line that installs it on this machine, where its package manager is known.
    pub install: Option<String>,
}

impl ToolStatus {
    /// Installed, and not too old.
    pub fn usable(&self) -> bool {
        self.found
            .as_ref()
            .is_some_and(|found| self.minimum.as_ref().is_none_or(|minimum| !found.is_older_than(minimum)))
    }
}

struct Tool {
    name: &'static str,
    purpose: &'static str,
    minimum: Option<&'static str>,
    required: bool,
    question: &'static str,
    /// The package for each of [`MANAGERS`], in that order.
    packages: [&'static str; 5],
}

/// Package managers and their installing command; those with `true` need the administrator.
const MANAGERS: [(&str, &str, bool); 5] = [
    ("apt-get", "apt-get install", true),
    ("dnf", "dnf install", true),
    ("pacman", "pacman -S", true),
    ("brew", "brew install", false),
    ("zypper", "zypper install", true),
];

const TOOLS: [Tool; 7] = [
    Tool {
        name: "verilator",
        purpose: "simulates the Verilog fast, lints it, measures coverage",
        minimum: Some("5.006"),
        required: true,
        question: "--version",
        packages: ["verilator"; 5],
    },
    Tool {
        name: "g++",
        purpose: "compiles what Verilator makes of the Verilog",
        minimum: Some("10.0"),
        required: true,
        question: "--version",
        packages: ["g++", "gcc-c++", "gcc", "gcc", "gcc-c++"],
    },
    Tool {
        name: "make",
        purpose: "builds what Verilator makes of the Verilog",
        minimum: None,
        required: true,
        question: "--version",
        packages: ["make"; 5],
    },
    Tool {
        name: "iverilog",
        purpose: "compiles the Verilog for the simulator that knows unknown bits",
        minimum: Some("11.0"),
        required: true,
        question: "-V",
        packages: ["iverilog", "iverilog", "iverilog", "icarus-verilog", "iverilog"],
    },
    Tool {
        name: "vvp",
        purpose: "runs what iverilog compiled",
        minimum: Some("11.0"),
        required: true,
        question: "-V",
        packages: ["iverilog", "iverilog", "iverilog", "icarus-verilog", "iverilog"],
    },
    Tool {
        name: "yosys",
        purpose: "checks that the Verilog can be synthesized, counts cells",
        minimum: Some("0.23"),
        required: true,
        question: "-V",
        packages: ["yosys"; 5],
    },
    Tool {
        name: "gtkwave",
        purpose: "shows waveforms",
        minimum: None,
        required: false,
        question: "--version",
        packages: ["gtkwave"; 5],
    },
];

/// The state of every tool on this machine.
pub fn tools(settings: &Settings) -> Vec<ToolStatus> {
    let status = |tool: &Tool| ToolStatus {
        name: tool.name,
        purpose: tool.purpose,
        found: find(tool.name, settings)
            .map(|_| version(tool, settings).unwrap_or_else(|_| Version("unknown".into()))),
        minimum: tool.minimum.map(|text| Version(text.into())),
        required: tool.required,
        install: install_line(tool.name),
    };
    TOOLS.iter().map(status).collect()
}

/// The version of a tool, or why it cannot be used and the line that mends it.
pub(super) fn require(name: &str, settings: &Settings) -> Result<Version> {
    let tool = TOOLS.iter().find(|tool| tool.name == name).ok_or_else(|| missing(name))?;
    find(name, settings).ok_or_else(|| missing(name))?;
    let version = version(tool, settings)?;
    match tool.minimum.map(|text| Version(text.into())) {
        Some(minimum) if version.is_older_than(&minimum) => Err(Error {
            what: format!("{name} {version} is installed, but {minimum} or newer is needed"),
            ..missing(name)
        }),
        _ => Ok(version),
    }
}

fn version(tool: &Tool, settings: &Settings) -> Result<Version> {
    let answer = process::ask(&[tool.name.into(), tool.question.into()], settings)?;
    Version::within(&answer).ok_or_else(|| {
        let first = answer.lines().next().unwrap_or("nothing");
        Error::new(Kind::ToolFailed, format!("{} does not tell its version: {first}", tool.name))
    })
}

impl Version {
    /// The first word that looks like a version: digits, a point, digits (`v3.3`, `0.9+4081`, `12.2.0)`).
    pub(crate) fn within(text: &str) -> Option<Version> {
        text.split_whitespace().find_map(|word| {
            let word = word.strip_prefix('v').unwrap_or(word);
            let end = word.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(word.len());
            let digits = word[..end].trim_end_matches('.');
            let version = digits.starts_with(|c: char| c.is_ascii_digit()) && digits.contains('.');
            version.then(|| Version(digits.into()))
        })
    }
    fn numbers(&self) -> Vec<u64> {
        self.0.split('.').map(|part| part.parse().unwrap_or(0)).collect()
    }
    fn is_older_than(&self, other: &Version) -> bool {
        self.numbers() < other.numbers()
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Where a program lies.
pub(crate) fn find(name: &str, settings: &Settings) -> Option<PathBuf> {
    let path = settings.path.clone().or_else(|| std::env::var_os("PATH"));
    find_in(name, path?)
}

fn find_in(name: &str, path: OsString) -> Option<PathBuf> {
    let folders = std::env::split_paths(&path).filter(|folder| folder.is_absolute());
    folders.map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The error that says how to install a tool.
pub(super) fn missing(name: &str) -> Error {
    let error = Error::new(Kind::ToolMissing, format!("{name} is not installed"));
    match install_line(name) {
        Some(line) => error.help(line),
        None => error.help(format!("install {name} with your system's package manager")),
    }
}

/// The line for the package manager of this machine, whatever `Settings::path` says.
fn install_line(name: &str) -> Option<String> {
    let path = std::env::var_os("PATH")?;
    install_line_with(name, |program| find_in(program, path.clone()).is_some())
}

fn install_line_with(name: &str, is_there: impl Fn(&str) -> bool) -> Option<String> {
    let tool = TOOLS.iter().find(|tool| tool.name == name)?;
    let at = MANAGERS.iter().position(|(manager, ..)| is_there(manager))?;
    let (_, command, administrator) = MANAGERS[at];
    let sudo = if administrator && is_there("sudo") { "sudo " } else { "" };
    Some(format!("{sudo}{command} {}", tool.packages[at]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_found_in_what_tools_print() {
        let answers = [
            ("Verilator 5.006 2023-01-22 rev (Debian 5.006-3)", "5.006"),
            ("Icarus Verilog version 11.0 (stable) ()\n\nCopyright 1998-2020", "11.0"),
            ("Unable to get version from \"/usr/lib/ivl -V\"\nIcarus Verilog version 12.0 (s)", "12.0"),
            ("Yosys 0.9+4081 (git sha1 7ce)", "0.9"),
            ("g++ (Debian 12.2.0-14) 12.2.0", "12.2.0"),
            ("GTKWave Analyzer v3.3.104 (w)1999-2020", "3.3.104"),
        ];
        for (answer, version) in answers {
            assert_eq!(Version::within(answer).unwrap().to_string(), version);
        }
        assert_eq!(Version::within("no version here."), None);
    }

    #[test]
    fn versions_compare_by_number_not_by_letter() {
        let older = |a: &str, b: &str| Version(a.into()).is_older_than(&Version(b.into()));
        assert!(older("4.228", "5.006") && older("5.006", "5.018") && older("0.9", "0.23"));
        assert!(!older("5.006", "5.006") && !older("12.2.0", "10.0") && !older("11.0", "11.0"));
    }

    #[test]
    fn the_install_line_is_that_of_the_machine() {
        let on =
            |programs: &'static [&str], tool| install_line_with(tool, |program| programs.contains(&program));
        assert_eq!(on(&["apt-get", "sudo"], "verilator").unwrap(), "sudo apt-get install verilator");
        assert_eq!(on(&["apt-get"], "iverilog").unwrap(), "apt-get install iverilog");
        assert_eq!(on(&["brew", "sudo"], "iverilog").unwrap(), "brew install icarus-verilog");
        assert_eq!(on(&["zypper", "sudo"], "g++").unwrap(), "sudo zypper install gcc-c++");
        assert_eq!(on(&["sudo"], "yosys"), None);
    }

    #[test]
    fn a_tool_outside_of_the_path_is_missing() {
        let nowhere = Settings { path: Some("".into()), ..Settings::default() };
        assert!(tools(&nowhere).iter().all(|tool| !tool.usable()));
        assert_eq!(require("iverilog", &nowhere).unwrap_err().kind, Kind::ToolMissing);
    }
}
