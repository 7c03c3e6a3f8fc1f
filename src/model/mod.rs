//! The bit-exact reference of every core, in plain integers, written from the mathematics.

pub mod loop_fd_clocks;
