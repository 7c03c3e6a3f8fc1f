//! What a reduced format of the forward differences costs and what it guarantees, exactly.
//!
//! ```text
//!   bound    how far a vertex can be from the exact one, as a dyadic number, for every format and mode
//!   search   the cheapest format whose bound meets a target
//!   live     how large a difference can be where a vertex depends on it: the integer bits of its register
//!   worst    control points whose start-up errors all push one vertex the same way
//! ```
//!
//! After Bischoff, Kobbelt, Seidel 2000, section 3.4, who argue by floating point; the bounds here are derived
//! for fixed point and hold for all control points.

pub mod bound;
pub mod dyadic;
pub mod live;
pub mod search;
pub mod worst;

pub use bound::{FormatError, at_vertex, of_patch, total_lsb};
pub use dyadic::Dyadic;
pub use search::{cheapest_progressive, cheapest_uniform};
