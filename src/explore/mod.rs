//! Which bits does a surface need? Sweeps over number formats, with proven bounds and counted hardware.
//!
//! ```text
//!   Axes ─► points ─► Evaluator ─► Record: bound, measured error, worst case, cracks, cost, command
//!             │           │           └─► Journal (a line a point, resumable) ─► merge ─► Pareto front
//!             └─ Shard    └─ Stage: what the points of one mesh, format and level share
//! ```
//!
//! A [`point::Point`] is a design measured on a mesh, named by the hash of all its parameters. What a point means
//! for each core stands in [`loop_fd`] and [`cc_strip`]; what it costs in [`cost`].

pub mod axes;
pub mod cc_strip;
pub mod cost;
pub mod evaluate;
pub mod figures;
pub mod journal;
pub mod loop_fd;
pub mod merge;
pub mod meshes;
pub mod pareto;
pub mod point;
pub mod ranges;
pub mod record;
pub mod run;
pub mod search;
pub mod shard;
pub mod snakemake;
pub mod synth;
pub mod tally;
