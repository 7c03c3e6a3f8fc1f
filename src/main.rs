//! The program `subdiv-rtl`; all of it is in the library, where tests reach it.

use std::process::ExitCode;

fn main() -> ExitCode {
    subdiv_rtl::cli::main()
}
