//! Catmull and Clark's surfaces and the quadstrips that bring them to the hardware.
//!
//! ```text
//!                    masks, table, numbers        the rules, the weights of irregular vertices, the formats
//!                              |                  error_bound: what is proven about them
//!                              |
//!   polygon mesh --control--> quad_mesh --strips--> Strip ──┐
//!                              |                            ├─ records --> a core or its model --> columns
//!            repeat, cut_along │ └───────rings─(boundary)───┘     └─ calls: the strips as the thesis sends them
//!                              |                                                               |
//!                         fine_grid (names of the fine vertices) --> assembly <----------------┘
//!                              |                                         |
//!                              +--> refinement --> oracle ---------------+--> error in units
//!
//!   winged   the thesis's software algorithm        thesis   its formulas, as printed and as they are
//! ```
//!
//! Source: Hall, "Efficient Subdivision Surface Evaluation" (the thesis), with the corrections that the items state.

pub mod assembly;
pub mod control;
pub mod error_bound;
pub mod fine_grid;
pub mod masks;
pub mod normal_oracle;
pub mod numbers;
pub mod oracle;
pub mod patches;
pub mod quad_mesh;
mod refinement;
pub mod repeat;
pub mod rings;
pub mod strips;
pub mod table;
pub mod thesis;
pub mod winged;
