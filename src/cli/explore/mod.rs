//! `explore MESH...`: which number format does a surface need, and what does it cost?
//!
//! ```text
//! options ─► sweep or search ─► points ─► run (resumed from -o) ─► results ─► table, SVG, page, JSON, advice
//! ```
//!
//! The subcommands plan, run and merge do the same over several machines; `emit` writes a workflow of them.

mod jobs;
mod options;
mod show;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use self::options::{PriceName, Varying};
use super::output::{self, Format, FormatArg};
use super::progress::Progress;
use crate::error::{Error, Kind, Result};
use crate::explore::evaluate::Evaluator;
use crate::explore::journal::Journal;
use crate::explore::pareto::{Candidate, Price, candidates, recommend};
use crate::explore::point::Point;
use crate::explore::record::Record;
use crate::explore::run::{available_threads, run as run_points};
use crate::explore::shard::Shard;
use crate::explore::{search, synth};
use crate::files::write_whole;

/// Find the number format that a surface needs: proven bounds, measured errors and cost, side by side
///
/// Sweeps over formats, or searches for the cheapest one that meets a target. Each design is bounded by proof, measured
/// on the meshes against the exact surface and on control points made to be the worst, and its core is built and
/// counted.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    job: Option<jobs::Job>,

    #[command(flatten)]
    varying: Varying,

    #[command(flatten)]
    work: Work,

    #[command(flatten)]
    wanted: Wanted,

    #[command(flatten)]
    format: FormatArg,
}

/// How the points are evaluated.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Evaluation")]
struct Work {
    /// Append each result to this file as it comes; what it holds already is not done again
    #[arg(short, long, value_name = "POINTS.jsonl")]
    output: Option<PathBuf>,

    /// Only part k of n, to be merged later
    #[arg(long, value_name = "k/n")]
    shard: Option<Shard>,

    /// Threads [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,

    /// Place and route each core on an ECP5-85F as well, or count its cells where there is no nextpnr; slow
    #[arg(long)]
    synth: bool,
}

/// What is made of the results.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Results")]
struct Wanted {
    /// The error that the format must be proved to keep; without named formats the program searches for them
    #[arg(long, value_name = "LSB", value_parser = options::target)]
    target_error: Option<f64>,

    /// Print one line: the cheapest design that meets the target [default target: 1lsb]
    #[arg(long)]
    recommend: bool,

    /// What cheap means
    #[arg(long, value_enum, value_name = "PRICE", default_value_t)]
    by: PriceName,

    /// Draw error against cost
    #[arg(long, value_name = "FRONT.svg")]
    svg: Option<PathBuf>,

    /// Write one page with plots and a table to sort
    #[arg(long, value_name = "PAGE.html")]
    html: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl explore --shape blob --target-error 1lsb --recommend
  subdiv-rtl explore --shape blob --fraction 4..24 --exact --html page.html
  subdiv-rtl explore bunny.obj --level 3..6 --fraction 8..28 -o points.jsonl
  subdiv-rtl explore --shape blob-quads --level 3 --guard 0..6 --table 12..24

Over several machines:
  subdiv-rtl explore plan --shape blob --fraction 4..24 --level 3..6 -o plan.jsonl
  subdiv-rtl explore run plan.jsonl --shard 1/8 -o 1.jsonl
  subdiv-rtl explore merge *.jsonl -o points.jsonl
  subdiv-rtl explore emit snakemake plan.jsonl --shards 8 -o Snakefile";

/// Everything that an exploration has found.
pub struct Found {
    pub meshes: Vec<String>,
    pub records: Vec<Record>,
    pub candidates: Vec<Candidate>,
    pub price: Price,
    /// Results that were there before.
    pub known: usize,
    pub skipped: usize,
    pub reason: Option<Error>,
    /// The cheapest design that meets the target, and the target.
    pub recommended: Option<(Candidate, f64)>,
}

impl Args {
    pub fn format(&self) -> Format {
        self.job.as_ref().map_or(self.format.format, jobs::Job::format)
    }
}

/// Runs the subcommand.
///
/// # Errors
/// Those of the meshes and the sweep; `Mismatch` when a measured error exceeds its proven bound.
pub fn run(args: &Args) -> Result<()> {
    if let Some(job) = &args.job {
        return jobs::run(job);
    }
    if args.work.synth {
        synth::check()?;
    }
    let subjects = args.varying.subjects()?;
    let (axes, wanted) = (args.varying.axes(), &args.wanted);
    let meshes: Vec<String> = subjects.iter().map(|subject| subject.name.name.clone()).collect();
    let evaluator = Evaluator::new(subjects.clone(), args.work.synth);
    let target = wanted.target_error.or(wanted.recommend.then_some(1.0));
    let (points, skipped, reason) = match target {
        Some(target) if !args.varying.formats_are_named() => {
            let _shown = Progress::waiting("searching for formats");
            (search::points(&evaluator, &axes, &subjects, target)?, 0, None)
        }
        _ => {
            let sweep = axes.sweep(&subjects)?;
            (sweep.points, sweep.skipped, sweep.reason)
        }
    };
    let (records, known) = evaluate(&evaluator, &points, &args.work)?;
    let price = wanted.by.price();
    let all = candidates(&records, price);
    let recommended = match target {
        // Part of a plan has no answer.
        Some(target) if args.work.shard.is_none() => Some((recommend(&all, target, price)?.clone(), target)),
        _ => None,
    };
    let found = Found { meshes, records, candidates: all, price, known, skipped, reason, recommended };
    files(&found, wanted)?;
    match (args.format.format, wanted.recommend, &found.recommended) {
        (Format::Json, ..) => output::print_object("explore", 1, &object(&found))?,
        (Format::Text, true, Some((candidate, target))) => {
            output::print(&format!("{}\n", show::advice(candidate, price, *target)))?;
        }
        _ => output::print(&show::text(&found))?,
    }
    judge(&found.records)
}

/// All points of the shard, with progress; how many were known before.
fn evaluate(evaluator: &Evaluator, points: &[Point], work: &Work) -> Result<(Vec<Record>, usize)> {
    let own = |point: &&Point| work.shard.is_none_or(|shard| shard.holds(&point.key()));
    let points: Vec<Point> = points.iter().filter(own).cloned().collect();
    let mut journal = work.output.as_deref().map(Journal::open).transpose()?;
    let known = match &journal {
        None => 0,
        Some(journal) => points.iter().filter(|point| journal.known(&point.key()).is_some()).count(),
    };
    let threads = work.threads.map_or_else(available_threads, |threads| threads as usize);
    let shown = Progress::counting("evaluating", points.len() as u64);
    shown.advance(known as u64);
    let records = run_points(evaluator, &points, journal.as_mut(), threads, |_| shown.advance(1))?;
    Ok((records, known))
}

/// A measured error above its proven bound is a fault of the program or of the hardware: it must show.
fn judge(records: &[Record]) -> Result<()> {
    match records.iter().find(|record| !record.within_bound()) {
        None => Ok(()),
        Some(record) => {
            let what = format!(
                "the error of {} is {} units, above its proven bound of {}",
                record.label(),
                record.worst(),
                record.bound_lsb
            );
            Err(Error::new(Kind::Mismatch, what).at(&record.point.mesh.name))
        }
    }
}

fn files(found: &Found, wanted: &Wanted) -> Result<()> {
    if let Some(path) = &wanted.svg {
        write_whole(path, show::plot(found, found.price).svg()?)?;
    }
    if let Some(path) = &wanted.html {
        write_whole(path, show::page(found)?)?;
    }
    Ok(())
}

fn object(found: &Found) -> Value {
    let candidate = |candidate: &Candidate| {
        json!({
            "design": candidate.record.label(),
            "bound_lsb": candidate.bound_lsb,
            "error_lsb": candidate.error_lsb,
            "worst_case_lsb": candidate.worst_case_lsb,
            "cracks": candidate.cracks,
            "register_bits": candidate.register_bits,
            "engine_bits": candidate.engine_bits,
            "luts": candidate.luts,
            "clock_mhz": candidate.clock_mhz,
            "command": candidate.record.command,
        })
    };
    let front = found.candidates.iter().filter(|c| c.on_front).map(candidate);
    json!({
        "meshes": found.meshes,
        "price": found.price.to_string(),
        "skipped": found.skipped,
        "skipped_because": found.reason.as_ref().map(|error| error.what.clone()),
        "recommended": found.recommended.as_ref().map(|(c, target)| {
            let mut object = candidate(c);
            object["target_lsb"] = json!(target);
            object
        }),
        "front": front.collect::<Vec<_>>(),
        "points": found.records,
    })
}

/// The text of a file, or the reason why there is none.
fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|error| {
        Error::input(format!("cannot read the file: {error}")).at(path.display()).help("check its name")
    })
}
