//! A mesh comes in, hardware that provably evaluates its subdivision surface goes out.

pub mod cli;
pub mod cores;
pub mod cosim;
pub mod error;
pub mod files;
pub mod fixed;
pub mod hdl;
pub mod mesh;
pub mod model;
pub mod report;
pub mod surface;

pub use error::{Error, Kind, Result};
