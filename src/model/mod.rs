//! The bit-exact reference of every core, in plain integers, written from the mathematics.
//!
//! ```text
//!   packets of surface::packets --> loop_fd (one core)  --> beats, bit for bit those of the hardware
//!   strip records of surface     --> cc_strip (one core) --> columns, bit for bit those of the hardware
//!   control mesh --> render (host and core in one go)   --> rounded positions, patch by patch
//!   mesh, level  --> sweep (prepared once)              --> error and cracks of one format after the other
//!                --> float (the published algorithm)    --> deviation in single and half precision
//! ```
//!
//! Nothing here uses `hdl` or `cores`, and those use nothing from here, so that a mistake in one shows.

pub mod cc_strip;
mod cc_strip_buffer;
pub mod cc_strip_clocks;
mod cc_strip_levels;
pub mod float;
pub mod lane_clocks;
pub mod loop_fd;
pub mod loop_fd_clocks;
pub mod render;
mod single_lane_clocks;
pub mod sweep;
