//! A workflow for Snakemake: a job a shard, then one that merges.
//!
//! ```text
//!   plan.jsonl ─► shard 1 ─► points/1.jsonl ─┐
//!              ─► shard 2 ─► points/2.jsonl ─┼─► merge ─► points.jsonl
//!              ─► ...                        ┘
//! ```
//!
//! Snakemake removes the output of a job that was killed, so a shard works on a file beside it, which is not
//! declared: started again, it goes on where it was.

use askama::Template;

use crate::error::{Error, Kind, Result};

/// What the workflow runs.
#[derive(Clone, Debug, Template)]
#[template(path = "Snakefile.smk")]
pub struct Workflow<'a> {
    pub version: &'a str,
    /// The program, as the shell finds it.
    pub program: &'a str,
    pub plan: &'a str,
    pub shards: u32,
    /// Cores that one shard uses.
    pub threads: u32,
    pub synthesise: bool,
    pub output: &'a str,
}

impl Workflow<'_> {
    /// The Snakefile.
    ///
    /// # Errors
    /// None that a user can cause: the template cannot be printed.
    pub fn text(&self) -> Result<String> {
        let text = self
            .render()
            .map_err(|e| Error::new(Kind::ToolFailed, format!("the Snakefile cannot be printed: {e}")))?;
        Ok(format!("{}\n", text.trim_end()))
    }
}

/// Whether a name can stand in the workflow as it is: nothing in it that Python, Snakemake or a shell reads.
pub fn plain(name: &str) -> bool {
    let fine = |c: char| c.is_alphanumeric() || "._-/+@:".contains(c);
    !name.is_empty() && !name.starts_with('-') && name.chars().all(fine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_workflow_has_a_job_for_each_shard_and_one_that_merges() {
        let workflow = Workflow {
            version: "1.2.3",
            program: "subdiv-rtl",
            plan: "plan.jsonl",
            shards: 8,
            threads: 2,
            synthesise: true,
            output: "points.jsonl",
        };
        let text = workflow.text().unwrap();
        assert!(text.contains("SHARDS = 8") && text.contains("--shard {wildcards.shard}/{SHARDS}"), "{text}");
        assert!(text.contains(" --synth") && text.contains("explore merge"));
    }

    #[test]
    fn names_that_a_shell_would_read_are_refused() {
        assert!(plain("plans/plan-1.jsonl"));
        for bad in ["", "a b", "$(x)", "a;b", "{x}", "-x", "a'b", "a\"b"] {
            assert!(!plain(bad), "{bad}");
        }
    }
}
