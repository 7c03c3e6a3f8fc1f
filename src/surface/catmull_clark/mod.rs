pub mod control;
pub mod error_bound;
pub mod fine_grid;
pub mod masks;
pub mod numbers;
pub mod quad_mesh;
pub mod table;
