//! What all simulators share: where programs are sought, where things are kept, how long to wait.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// How external tools are run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Folders where programs are sought, as in `PATH`; `None` means the `PATH` of this process.
    pub path: Option<OsString>,
    /// Folder of the compiled simulators; `None` means `SUBDIV_RTL_CACHE`, or `subdiv-rtl` in the
    /// user's cache folder.
    pub cache: Option<PathBuf>,
    /// Folder in which each simulator leaves its work (in a folder of its own name); `None` means a
    /// temporary folder that is removed.
    pub keep: Option<PathBuf>,
    /// A compiler or simulator that takes longer is stopped.
    pub timeout: Duration,
    /// Measure line and toggle coverage (the Verilator harness only; slower).
    pub coverage: bool,
    /// Compile fast what runs once and is large, such as a netlist (the Verilator harness only; it runs slower).
    pub compile_fast: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let timeout = Duration::from_secs(600);
        Settings { path: None, cache: None, keep: None, timeout, coverage: false, compile_fast: false }
    }
}
