//! The longest paths from registers to registers, through LUTs, carry and multipliers.

use std::collections::{BTreeMap, BTreeSet};

use super::cover::Reads;
use super::function::Function;
use super::gates::{Gates, Leaf};
use super::kept::Kept;
use super::sums::Adder;
use crate::hdl::{Cell, Flat, NodeId};

/// A path between registers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// Adders in a row.
    pub adders: f64,
    /// LUTs of gates in a row.
    pub gates: f64,
    /// Bits of the longest carry chain on it.
    pub carry: f64,
    pub multipliers: f64,
}

impl Path {
    fn within(&self, other: &Path) -> bool {
        self.adders <= other.adders
            && self.gates <= other.gates
            && self.carry <= other.carry
            && self.multipliers <= other.multipliers
    }

    fn through(&self, step: &Path) -> Path {
        Path {
            adders: self.adders + step.adders,
            gates: self.gates + step.gates,
            carry: self.carry.max(step.carry),
            multipliers: self.multipliers + step.multipliers,
        }
    }
}

const GATE: Path = Path { adders: 0.0, gates: 1.0, carry: 0.0, multipliers: 0.0 };

/// Those that no other one exceeds in all respects.
pub(super) fn longest(
    flat: &Flat,
    kept: &Kept,
    gates: &Gates,
    reads: &BTreeMap<NodeId, Reads>,
    outside: &BTreeSet<Function>,
) -> Vec<Path> {
    let mut arrivals = Arrivals { at: Vec::with_capacity(gates.leaves.len()) };
    let mut nodes: BTreeMap<NodeId, Vec<Path>> = BTreeMap::new();
    for leaf in &gates.leaves {
        let paths = match leaf {
            Leaf::Gate(function) => arrivals.behind([function].into_iter()),
            Leaf::Bit(id) => {
                if !nodes.contains_key(id) {
                    let paths = through(flat, kept, gates, reads, &arrivals, &nodes, *id);
                    nodes.insert(*id, paths);
                }
                nodes[id].clone()
            }
        };
        arrivals.at.push(paths);
    }
    let ends = flat.clocked.iter().filter_map(|id| reads.get(id)).flat_map(|reads| &reads.outside);
    arrivals.behind(ends.chain(outside))
}

/// The paths that end behind a node that is no gate.
fn through(
    flat: &Flat,
    kept: &Kept,
    gates: &Gates,
    reads: &BTreeMap<NodeId, Reads>,
    arrivals: &Arrivals,
    nodes: &BTreeMap<NodeId, Vec<Path>>,
    id: NodeId,
) -> Vec<Path> {
    let starts = flat.node(id).cell.combinational_inputs().is_empty();
    let Some(reads) = reads.get(&id).filter(|_| !starts) else { return vec![Path::default()] };
    // What a choice behind an adder takes instead also goes through the adder's cells.
    let sum = gates.folds.sum(id);
    let step = step(flat, kept, sum.unwrap_or(id));
    let mut longest = vec![];
    for path in arrivals.behind(reads.outside.iter()) {
        keep(&mut longest, path.through(&step));
    }
    for path in sum.iter().filter_map(|sum| nodes.get(sum)).flatten() {
        keep(&mut longest, *path);
    }
    longest
}

/// The paths to each leaf.
struct Arrivals {
    at: Vec<Vec<Path>>,
}

impl Arrivals {
    /// The longest paths through functions.
    fn behind<'f>(&self, functions: impl Iterator<Item = &'f Function>) -> Vec<Path> {
        let through: BTreeSet<(u32, bool)> = functions
            .flat_map(|function| function.leaves().iter().map(|leaf| (*leaf, function.is_gate())))
            .collect();
        let mut longest = vec![];
        for (leaf, gate) in through {
            for path in &self.at[leaf as usize] {
                keep(&mut longest, if gate { path.through(&GATE) } else { *path });
            }
        }
        longest
    }
}

/// Keeps a path unless another one exceeds it.
fn keep(longest: &mut Vec<Path>, path: Path) {
    if !longest.iter().any(|other| path.within(other)) {
        longest.retain(|other| !other.within(&path));
        longest.push(path);
    }
}

/// What a node that is no gate adds to a path.
fn step(flat: &Flat, kept: &Kept, id: NodeId) -> Path {
    let width = |id: &NodeId| f64::from(flat.node(*id).word.width());
    match &flat.node(id).cell {
        Cell::Sum { .. } => Adder::of(flat, kept, id).map_or(Path::default(), |adder| Path {
            adders: f64::from(adder.operands - 1),
            gates: 0.0,
            carry: f64::from(adder.bits),
            multipliers: 0.0,
        }),
        Cell::Compare { left, right, .. } => {
            Path { adders: 1.0, gates: 0.0, carry: width(left).max(width(right)), multipliers: 0.0 }
        }
        Cell::Product { .. } => Path { multipliers: 1.0, ..Path::default() },
        _ => Path::default(),
    }
}
