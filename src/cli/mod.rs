//! The command line: one file per subcommand.
//!
//! ```text
//! arguments ─► Args ─► Settings (checked, merged with the configuration) ─► the subcommand's work
//!                                                                             │
//!               exit status ◄─ failure (standard error) ◄─ Error ◄────────────┤
//!                                       result (standard output) ◄────────────┘
//! ```
//!
//! Results go to standard output, everything else to standard error; progress only to a terminal. The exit
//! status is 0 when all is well, else the kind of the error (see [`crate::Kind`]).

mod aim;
pub mod board;
pub mod completions;
pub mod config;
pub mod doctor;
pub mod explore;
mod failure;
pub mod generate;
pub mod output;
pub mod progress;
pub mod receive;
pub mod report;
pub mod shapes;
pub mod simulate;
pub mod strip_options;
pub mod synth;
pub mod values;

use crate::error::{Kind, Result};
use clap::{
    Parser, Subcommand,
    builder::styling::{AnsiColor, Effects, Styles},
    error::ErrorKind,
};
use output::Format;
use std::process::ExitCode;

const HEADING: anstyle::Style = AnsiColor::Green.on_default().effects(Effects::BOLD);
const NAME: anstyle::Style = AnsiColor::Cyan.on_default().effects(Effects::BOLD);

/// The colours of the help, as cargo has them.
const STYLES: Styles = Styles::styled()
    .header(HEADING)
    .usage(HEADING)
    .literal(NAME)
    .placeholder(AnsiColor::Cyan.on_default())
    .error(AnsiColor::Red.on_default().effects(Effects::BOLD))
    .valid(NAME)
    .invalid(AnsiColor::Yellow.on_default().effects(Effects::BOLD));

const EXIT_STATUS: &str = "\
Exit status:
  0  all is well
  1  hardware and reference disagree
  2  the command line or the configuration asks for something that does not exist
  3  a mesh, a number or a file cannot be used
  4  an external tool is not installed
  5  an external tool failed";

/// From a mesh to verified hardware for its subdivision surface.
#[derive(Debug, Parser)]
#[command(name = "subdiv-rtl", version, styles = STYLES, after_help = EXIT_STATUS)]
#[command(max_term_width = 100, propagate_version = true, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,

    /// No progress on the terminal
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Simulate(Box<simulate::Args>),
    Generate(Box<generate::Args>),
    Synth(Box<synth::Args>),
    Explore(Box<explore::Args>),
    Receive(receive::Args),
    Report(report::Args),
    Shapes(shapes::Args),
    Doctor(doctor::Args),
    Completions(completions::Args),
}

impl Command {
    /// How the result is written, and with it an error.
    fn format(&self) -> Format {
        match self {
            Command::Simulate(args) => args.format.format,
            Command::Synth(args) => args.format(),
            Command::Explore(args) => args.format(),
            Command::Receive(args) => args.format.format,
            Command::Report(args) => args.format(),
            Command::Shapes(args) => args.format.format,
            Command::Doctor(args) => args.format.format,
            Command::Generate(_) | Command::Completions(_) => Format::Text,
        }
    }

    fn run(&self) -> Result<()> {
        match self {
            Command::Simulate(args) => simulate::run(args),
            Command::Generate(args) => generate::run(args),
            Command::Synth(args) => synth::run(args),
            Command::Explore(args) => explore::run(args),
            Command::Receive(args) => receive::run(args),
            Command::Report(args) => report::run(args),
            Command::Shapes(args) => shapes::run(args),
            Command::Doctor(args) => doctor::run(args),
            Command::Completions(args) => completions::run(args),
        }
    }
}

/// Runs the program on the arguments of this process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(message) => return explain(&message),
    };
    progress::set_quiet(cli.quiet);
    match cli.command.run() {
        Ok(()) => ExitCode::SUCCESS,
        // The result of a simulation says itself, as JSON, what differs.
        Err(error) if simulate::is_mismatch(&error) => failure::report(&error, Format::Text),
        Err(error) => failure::report(&error, cli.command.format()),
    }
}

/// Prints what clap has to say: help and version to standard output, mistakes to standard error. Nobody is left
/// to be told when that fails.
fn explain(message: &clap::Error) -> ExitCode {
    let _ = message.print();
    match message.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => ExitCode::SUCCESS,
        _ => ExitCode::from(Kind::Usage as u8),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
