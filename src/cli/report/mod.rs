//! `report`: what the papers say beside what is measured, one file for each report.

mod figures;
mod thesis;

use super::output::Format;
use crate::error::Result;
use clap::Subcommand;

/// Put what the papers say beside what is measured
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    report: Report,
}

#[derive(Debug, Subcommand)]
enum Report {
    Thesis(thesis::Args),
    Figures(figures::Args),
}

impl Args {
    /// How the result is written, and with it an error.
    pub fn format(&self) -> Format {
        match &self.report {
            Report::Thesis(args) => args.format.format,
            Report::Figures(args) => args.format.format,
        }
    }
}

/// # Errors
/// Those of the report.
pub fn run(args: &Args) -> Result<()> {
    match &args.report {
        Report::Thesis(args) => thesis::run(args),
        Report::Figures(args) => figures::run(args),
    }
}
