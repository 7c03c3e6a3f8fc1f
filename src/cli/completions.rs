//! `completions SHELL`: the script that lets a shell complete our commands.

use super::{Cli, output};
use crate::error::Result;
use clap::CommandFactory;
use clap_complete::Shell;

/// Print a script with which your shell completes commands and options
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The shell to write for
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl completions bash > ~/.local/share/bash-completion/completions/subdiv-rtl
  subdiv-rtl completions zsh > ~/.zfunc/_subdiv-rtl
  subdiv-rtl completions fish > ~/.config/fish/completions/subdiv-rtl.fish";

pub fn run(args: &Args) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "subdiv-rtl", &mut script);
    output::print_bytes(&script)
}
