//! `report thesis`: the formulas of Hall's chapter 6, as printed, corrected, and measured on the generated core.
//!
//! ```text
//! surface: thesis ───► printed, corrected ─┐
//! hardware, meshes ─► measured ───────────┴─► text or JSON
//! ```

mod hardware;
mod measure;
mod meshes;
mod text;

use super::super::output::{self, Format, FormatArg};
use crate::cli::progress::Progress;
use crate::error::Result;
use crate::surface::catmull_clark::thesis::{Figure, figures};
use measure::Measured;
use serde_json::json;

/// Hall's formulas for storage, time and operators: as printed, corrected, and measured
///
/// The thesis counts vertices, clocks and gates of a design on paper (chapter 6). This prints its formulas, what they
/// should say, and what the generated core has: its registers and operators counted one by one, its clocks counted in
/// the built-in simulator, the words that are sent counted on meshes. A vertex is three coordinates; operators are
/// those of one coordinate.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  subdiv-rtl report thesis --level 5 --max-valence 10")]
pub struct Args {
    /// The finest level, l in the thesis
    #[arg(long, value_name = "L", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=7))]
    level: u32,

    /// The largest valence, V_dmax in the thesis
    #[arg(long, value_name = "D", default_value_t = 10, value_parser = clap::value_parser!(u32).range(4..=16))]
    max_valence: u32,

    #[command(flatten)]
    pub format: FormatArg,
}

/// # Errors
/// Those of building the core; standard output that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let shown = Progress::waiting("building, counting and running the core");
    let measured = Measured::new(args.level, args.max_valence)?;
    drop(shown);
    let figures = figures(args.level, args.max_valence);
    match args.format.format {
        Format::Text => output::print(&text::text(args.level, args.max_valence, &figures, &measured)),
        Format::Json => output::print_object("report-thesis", 1, &object(args, &figures, &measured)),
    }
}

fn object(args: &Args, figures: &[Figure], measured: &Measured) -> serde_json::Value {
    let figure = |figure: &Figure| {
        json!({
            "name": figure.name,
            "source": figure.source,
            "unit": figure.unit,
            "printed": figure.printed,
            "corrected": figure.corrected,
            "measured": measured.of(figure.quantity),
            "note": figure.note,
        })
    };
    json!({
        "level": args.level,
        "max_valence": args.max_valence,
        "figures": figures.iter().map(figure).collect::<Vec<_>>(),
        "storage": measured.storage,
        "operators": measured.operators,
        "clocks": measured.clocks,
        "meshes": measured.meshes,
    })
}
