//! Detailed placement for the ECP5: what the placer has put somewhere moves until the paths are short.
//!
//! ```text
//!   nextpnr places ─► cells, nets, slots ─► delays and slacks ─► moves ─► ... ─► the same netlist, other places ─► nextpnr routes
//!                                             ▲                    │
//!                                             └─── once a pass ◄───┘
//! ```
//!
//! The placer takes 76 ps for each tile that a wire is long, twice what its own router then needs. So it pulls together
//! what need not be, and where it is dense, wires detour. Here the delays are those of [routed wires](delays), and the
//! [cost] counts, beside the paths that are too long, the wires and how full the tiles are.
//!
//! Besides the places, only one thing changes: a reader of a register may read another one [that always holds the
//! same](copies). That nothing else does, [`same`] shows of every placement that leaves here.
//!
//! The same placement gives the same one back: the moves are tried in an order that a generator of fixed seed says,
//! and there are as many as the design has cells.

mod chains;
mod copies;
mod cost;
mod delays;
mod design;
mod flocks;
mod legal;
mod moves;
mod read;
mod same;
mod search;
mod slots;
#[cfg(test)]
mod tests;
mod timing;
mod write;

use serde_json::Value;

use crate::error::{Error, Kind, Result};
use search::Search;

/// Another one wherever the same placement comes to another one, or is routed otherwise.
pub const VERSION: &str = "4";

/// What came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Refined {
    /// The longest path before and after, in nanoseconds, as [`delays`] say.
    pub longest_before_ns: f64,
    pub longest_after_ns: f64,
    /// Readers that read another copy of their register.
    pub dealt_readers: u64,
}

/// Moves the cells of a placed design; it is the text of nextpnr's `--write`. No path is asked to be shorter than the
/// longest one can be.
///
/// # Errors
/// `ToolFailed` for what is no placed design of an ECP5.
pub fn refine(text: &[u8], target_ns: f32) -> Result<(Vec<u8>, Refined)> {
    let failed = |what: String| Error::new(Kind::ToolFailed, format!("the placed design: {what}"));
    let mut placed: Value = serde_json::from_slice(text).map_err(|e| failed(e.to_string()))?;
    let mut search = Search::new(read::design(&placed).map_err(failed)?);
    let refined = search.run(target_ns.max(search.design.reach()));
    search.design.check().map_err(failed)?;
    let before = read::design(&placed).map_err(failed)?;
    let dealt_readers = write::into(&mut placed, &search.design, &before);
    same::proved(&before, &read::design(&placed).map_err(failed)?).map_err(failed)?;
    let text = serde_json::to_vec(&placed).map_err(|e| failed(e.to_string()))?;
    Ok((text, Refined { dealt_readers, ..refined }))
}
