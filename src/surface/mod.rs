//! The mathematics of the surfaces, in exact numbers.

pub mod arithmetic;
pub mod assembly;
pub mod basis;
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
pub mod register_bounds;
pub mod regular;
pub mod subdivide;
pub mod table;
pub mod word;
