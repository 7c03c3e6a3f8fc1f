//! Linear forms known while building: a signal as an integer combination of earlier ones.
//!
//! They make masks cheap. `a + 2b + c - a` ranges over what `2b + c` ranges over, and a convex mask of
//! many terms needs the bits of the mask, not one more bit for every adder.

use std::collections::BTreeMap;

use super::cell::NodeId;
use crate::fixed::Range;

/// `constant + sum of coefficient * atom`; atoms are nodes that are not sums themselves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticForm {
    pub terms: BTreeMap<NodeId, i128>,
    pub constant: i128,
}

impl StaticForm {
    /// Longer forms fall back to interval arithmetic.
    const LONGEST: usize = 128;

    pub fn atom(id: NodeId) -> Self {
        StaticForm { terms: BTreeMap::from([(id, 1)]), constant: 0 }
    }

    /// Adds `coefficient * other`; nothing where the numbers or the length get out of hand.
    pub fn add(mut self, coefficient: i128, other: &StaticForm) -> Option<Self> {
        self.constant = self.constant.checked_add(coefficient.checked_mul(other.constant)?)?;
        for (&atom, &weight) in &other.terms {
            let sum = self.terms.entry(atom).or_insert(0);
            *sum = sum.checked_add(coefficient.checked_mul(weight)?)?;
            if *sum == 0 {
                self.terms.remove(&atom);
            }
        }
        (self.terms.len() <= Self::LONGEST).then_some(self)
    }

    /// The exact range over all values of the atoms.
    pub fn range(&self, atom: impl Fn(NodeId) -> Range) -> Range {
        self.terms.iter().fold(Range::point(self.constant), |sum, (&id, &weight)| sum + atom(id) * weight)
    }
}
