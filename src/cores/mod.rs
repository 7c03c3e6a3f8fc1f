//! The hardware, described in [`hdl`](crate::hdl): one unit a file, named as the papers name it.

pub mod board;
pub mod cc_strip;
pub mod loop_fd;
pub mod rounder;
pub mod stream_fifo;
