//! The mathematics of the surfaces, in exact numbers.
//!
//! ```text
//!                  loop_masks, table (cosine)       the rules and the weights of irregular vertices
//!                             |
//!   control_mesh --> cmesh --> subdivide, regular (arithmetic: exact or f64) --> hierarchy --> packets
//!        |                                                                                       |
//!        |           basis: masks of all samples       forward, register_bounds: the engine      v
//!        |                                                                         a core or its model
//!        v                                                                                       |
//!   fine_grid (names of the fine vertices) ------------------------------------> assembly <------+
//!        |                                                                          |
//!        +--> refinement --> limit_oracle: the true positions, by another route ----+--> error in units
//!                            error_bound: what is proven about it
//!                            precision: the same for formats with fewer bits, and which is the cheapest
//! ```

pub mod arithmetic;
pub mod assembly;
pub mod basis;
pub mod catmull_clark;
pub mod cmesh;
pub mod control_mesh;
pub mod cosine;
pub mod error_bound;
pub mod exact;
pub mod fine_grid;
pub mod forward;
pub mod hierarchy;
pub mod limit_oracle;
pub mod loop_masks;
pub mod packets;
pub mod precision;
mod refinement;
pub mod register_bounds;
pub mod regular;
pub mod subdivide;
pub mod table;
pub mod word;
