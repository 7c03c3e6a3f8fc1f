//! `explore plan`, `run`, `merge` and `emit`: the same work over several machines.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Subcommand;
use serde_json::json;

use super::options::Varying;
use super::{Work, evaluate, judge, read_text};
use crate::cli::output::{self, Format, FormatArg};
use crate::error::{Error, Result};
use crate::explore::evaluate::Evaluator;
use crate::explore::merge::{complete, merge};
use crate::explore::meshes::Subject;
use crate::explore::point::Point;
use crate::explore::record::{Planned, Record, line, read};
use crate::explore::snakemake::{Workflow, plain};
use crate::explore::{axes, synth};
use crate::files::{write_whole, write_whole_with};

#[derive(Debug, Subcommand)]
pub enum Job {
    Plan(Box<Plan>),
    Run(Run),
    Merge(Merge),
    Emit(Emit),
}

/// Write the points of a sweep, to be evaluated elsewhere
#[derive(Debug, clap::Args)]
pub struct Plan {
    #[command(flatten)]
    varying: Varying,

    /// The file to write
    #[arg(short, long, value_name = "PLAN.jsonl", default_value = "plan.jsonl")]
    output: PathBuf,

    #[command(flatten)]
    format: FormatArg,
}

/// Evaluate the points of a plan, or a part of them
#[derive(Debug, clap::Args)]
pub struct Run {
    /// The plan
    #[arg(value_name = "PLAN.jsonl")]
    plan: PathBuf,

    #[command(flatten)]
    work: Work,

    #[command(flatten)]
    format: FormatArg,
}

/// Put the results of several parts together: sorted, every point once
#[derive(Debug, clap::Args)]
pub struct Merge {
    /// Files of results
    #[arg(required = true, value_name = "POINTS.jsonl")]
    parts: Vec<PathBuf>,

    /// Keep the points of this plan only, and refuse to finish without all of them
    #[arg(long, value_name = "PLAN.jsonl")]
    plan: Option<PathBuf>,

    /// The file to write
    #[arg(short, long, value_name = "POINTS.jsonl")]
    output: PathBuf,

    #[command(flatten)]
    format: FormatArg,
}

/// Write a workflow that runs the shards of a plan and merges them
#[derive(Debug, clap::Args)]
pub struct Emit {
    #[command(subcommand)]
    workflow: EmitWorkflow,
}

#[derive(Debug, Subcommand)]
enum EmitWorkflow {
    Snakemake(Snakemake),
}

/// A Snakefile: one job a shard, then one that merges
#[derive(Debug, clap::Args)]
pub struct Snakemake {
    /// The plan
    #[arg(value_name = "PLAN.jsonl", default_value = "plan.jsonl")]
    plan: PathBuf,

    /// How many jobs
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    shards: u32,

    /// Cores of each job
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: u32,

    /// Place and route the cores in each job
    #[arg(long)]
    synth: bool,

    /// The program as the jobs find it
    #[arg(long, value_name = "PATH", default_value = "subdiv-rtl")]
    program: String,

    /// Where the workflow writes all points
    #[arg(long, value_name = "POINTS.jsonl", default_value = "points.jsonl")]
    points: String,

    /// The file to write
    #[arg(short, long, value_name = "FILE", default_value = "Snakefile")]
    output: PathBuf,
}

impl Job {
    pub fn format(&self) -> Format {
        match self {
            Job::Plan(plan) => plan.format.format,
            Job::Run(run) => run.format.format,
            Job::Merge(merge) => merge.format.format,
            Job::Emit(_) => Format::Text,
        }
    }
}

/// # Errors
/// Those of the job.
pub fn run(job: &Job) -> Result<()> {
    match job {
        Job::Plan(job) => plan(job),
        Job::Run(job) => evaluate_plan(job),
        Job::Merge(job) => merge_parts(job),
        Job::Emit(Emit { workflow: EmitWorkflow::Snakemake(job) }) => emit(job),
    }
}

fn plan(job: &Plan) -> Result<()> {
    let (_, sweep) = job.varying.sweep()?;
    write_lines(&job.output, sweep.points.iter().map(Planned::from))?;
    let (count, file) = (sweep.points.len(), job.output.display().to_string());
    match job.format.format {
        Format::Json => {
            let reason = sweep.reason.map(|error| error.what);
            let object =
                json!({ "points": count, "skipped": sweep.skipped, "skipped_because": reason, "file": file });
            output::print_object("explore-plan", 1, &object)
        }
        Format::Text => {
            let skipped = match (sweep.skipped, sweep.reason) {
                (0, _) => String::new(),
                (n, None) => format!(", {n} combinations skipped"),
                (n, Some(reason)) => format!(", {n} combinations skipped (the first: {})", reason.what),
            };
            output::print(&format!("{file}: {count} points{skipped}\n"))
        }
    }
}

fn evaluate_plan(job: &Run) -> Result<()> {
    if job.work.synth {
        synth::check()?;
    }
    let points = points_of(&job.plan)?;
    let mut subjects: BTreeMap<String, Subject> = BTreeMap::new();
    let own = |point: &Point| job.work.shard.is_none_or(|shard| shard.holds(&point.key()));
    for point in points.iter().filter(|point| own(point)) {
        if !subjects.contains_key(&point.mesh.hash) {
            subjects.insert(point.mesh.hash.clone(), Subject::reload(&point.mesh)?);
        }
    }
    let evaluator = Evaluator::new(subjects.into_values().collect(), job.work.synth);
    let (records, known) = evaluate(&evaluator, &points, &job.work)?;
    let file = job.work.output.as_ref().map(|path| path.display().to_string());
    match (job.format.format, file) {
        (Format::Json, _) => {
            output::print_object("explore-run", 1, &json!({ "known": known, "points": records }))?
        }
        (Format::Text, Some(file)) => {
            output::print(&format!("{file}: {} points, {known} of them known before\n", records.len()))?;
        }
        (Format::Text, None) => records.iter().try_for_each(|record| output::print(&line(record)?))?,
    }
    judge(&records)
}

/// The points of a plan, each checked.
fn points_of(path: &std::path::Path) -> Result<Vec<Point>> {
    let place = path.display().to_string();
    let planned: Vec<Planned> = read(&read_text(path)?, &place)?;
    let mut points = vec![];
    for planned in planned {
        let point = planned.point().map_err(|error| error.at(&place))?;
        axes::check(&point.design).map_err(|error| error.at(format!("{place}, {}", planned.key)))?;
        points.push(point);
    }
    Ok(points)
}

fn merge_parts(job: &Merge) -> Result<()> {
    let mut lists = vec![];
    for path in &job.parts {
        let place = path.display().to_string();
        lists.push((place.clone(), read::<Record>(&read_text(path)?, &place)?));
    }
    let mut records = merge(lists)?;
    if let Some(path) = &job.plan {
        let plan: Vec<Planned> = read(&read_text(path)?, &path.display().to_string())?;
        complete(&records, &plan)?;
        let keys: std::collections::BTreeSet<&str> = plan.iter().map(|point| point.key.as_str()).collect();
        records.retain(|record| keys.contains(record.point.key.as_str()));
    }
    write_lines(&job.output, records.iter())?;
    let (count, parts) = (records.len(), job.parts.len());
    let file = job.output.display().to_string();
    match job.format.format {
        Format::Json => {
            output::print_object(
                "explore-merge",
                1,
                &json!({ "points": count, "parts": parts, "file": file }),
            )?;
        }
        Format::Text => output::print(&format!("{file}: {count} points of {parts} parts\n"))?,
    }
    judge(&records)
}

fn emit(job: &Snakemake) -> Result<()> {
    let plan = job.plan.display().to_string();
    for name in [&job.program, &plan, &job.points] {
        if !plain(name) {
            return Err(Error::usage(format!("'{name}' cannot stand in a Snakefile as it is"))
                .help("use names of letters, digits and the signs . _ - + / @ :"));
        }
    }
    let workflow = Workflow {
        version: env!("CARGO_PKG_VERSION"),
        program: &job.program,
        plan: &plan,
        shards: job.shards,
        threads: job.threads,
        synthesise: job.synth,
        output: &job.points,
    };
    write_whole(&job.output, workflow.text()?)?;
    output::print(&format!("{}\n", job.output.display()))
}

fn write_lines<T: serde::Serialize>(path: &std::path::Path, lines: impl Iterator<Item = T>) -> Result<()> {
    let text = lines.map(|value| line(&value)).collect::<Result<String>>()?;
    write_whole_with(path, |file| file.write_all(text.as_bytes()))
}
