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
    /// LUTs in a row, an adder being one.
    pub levels: f64,
    /// Bits of the longest carry chain on it.
    pub carry: f64,
    pub multipliers: f64,
}

impl Path {
    fn within(&self, other: &Path) -> bool {
        self.levels <= other.levels && self.carry <= other.carry && self.multipliers <= other.multipliers
    }

    fn through(&self, step: &Path) -> Path {
        Path {
            levels: self.levels + step.levels,
            carry: self.carry.max(step.carry),
            multipliers: self.multipliers + step.multipliers,
        }
    }
}

const GATE: Path = Path { levels: 1.0, carry: 0.0, multipliers: 0.0 };

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
            Leaf::Bit(id) => nodes
                .entry(*id)
                .or_insert_with(|| match reads.get(id) {
                    Some(reads) if !flat.node(*id).cell.combinational_inputs().is_empty() => {
                        let paths = arrivals.behind(reads.outside.iter());
                        paths.iter().map(|path| path.through(&step(flat, kept, *id))).collect()
                    }
                    _ => vec![Path::default()],
                })
                .clone(),
        };
        arrivals.at.push(paths);
    }
    let ends = flat.clocked.iter().filter_map(|id| reads.get(id)).flat_map(|reads| &reads.outside);
    arrivals.behind(ends.chain(outside))
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
            levels: f64::from(adder.operands - 1),
            carry: f64::from(adder.bits),
            multipliers: 0.0,
        }),
        Cell::Compare { left, right, .. } => {
            Path { levels: 1.0, carry: width(left).max(width(right)), multipliers: 0.0 }
        }
        Cell::Product { .. } => Path { levels: 0.0, carry: 0.0, multipliers: 1.0 },
        // A choice behind an adder is part of it.
        _ => Path::default(),
    }
}
