//! The last step of a reduced format: a vertex loses the fraction bits that the output does not have.
//!
//! ```text
//! y = floor(D00 / 2^t + 1/2),   t = F_0 - f;   put back to the ends of the output format if asked for
//! ```
//!
//! The division by 12 * 16^R was done in the start-up, so there is none here.

use std::rc::Rc;

use super::{Parameters, words};
use crate::error::Result;
use crate::fixed::{Reduced, Rounding};
use crate::hdl::{Builder, Module, Word};

/// Inputs: `numerator`, D00, and `valid`, which says when it is a vertex; then it lies within the hull of
/// the control points and the error that the format makes, which is the claim to be proved. Output:
/// `rounded`.
pub fn build(parameters: Parameters, reduced: Reduced) -> Result<Rc<Module>> {
    let m = Builder::new("vertex_rounder");
    let dropped = parameters.last_dropped(reduced.fractions.of(0));
    let clamp = if reduced.saturate { ", saturated" } else { "" };
    m.purpose(format!("rounded = floor(numerator / 2^{dropped} + 1/2){clamp}"));
    m.parameter("result", parameters.output_range());
    let word = parameters.difference((0, 0));
    let numerator = m.input("numerator", word);
    let valid = m.input("valid", Word::bit());
    let claimed = Word::from(words::vertex_range(parameters, reduced)).fraction(word.fraction);
    let vertex = m.claim("vertex", &numerator, claimed, Some(&valid));
    let rounded = m.pipe("rounded_vertex", m.round(&vertex, dropped, Rounding::HalfUp));
    let rounded = match reduced.saturate {
        true => m.pipe("saturated_vertex", m.saturate(&rounded, parameters.output_range())),
        false => rounded,
    };
    m.output("rounded", &rounded);
    m.finish()
}
