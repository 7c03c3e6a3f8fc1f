//! A mesh comes in, hardware that provably evaluates its subdivision surface goes out.
//!
//! ```text
//! mesh file ─► mesh ─► surface (patches, strips) ─► words in ─┐
//!                                                             ▼
//!    cores (described in hdl) ─► Verilog + testbench ─► Verilator │ Icarus ─► words out
//!         │  │                                                                   │
//!         │  └────────────── built-in simulator ─────────────────────► words out │
//!         └─► proof by linear forms                                              │
//!    model (plain integers, written from the mathematics) ─────────► words expected
//!                                                                                │
//!                                                  compare bit for bit ◄─────────┘
//!                                                             │
//!                           fine mesh, error against the exact limit, pictures; which bits it needs
//! ```
//!
//! | room | what lives there | uses |
//! |---|---|---|
//! | [`error`], [`files`], `parallel` | the one error type; files written whole or not at all; every core at work | nothing |
//! | [`mesh`] | indexed meshes, adjacency, readers and writers, built-in shapes | `fixed` formats |
//! | [`fixed`] | formats, rounding, exact ranges, exact linear forms | nothing |
//! | [`surface`] | masks, patches, hierarchy, oracles, in exact numbers | `mesh`, `fixed` |
//! | [`model`] | the bit-exact reference of every core, in plain integers | `fixed`, constants of `surface` |
//! | [`hdl`] | the language: cells, builder, simulator, prover, Verilog printer | `fixed` |
//! | [`cores`] | the hardware, one unit a file | `hdl`, `fixed`, constants of `surface` |
//! | [`cosim`] | stimulus, drivers of every simulator, comparison, verdict | all above |
//! | [`fpga`] | synthesis, place and route, their reports, estimates | `hdl`, running tools as `cosim` does |
//! | [`package`] | a core as files: Verilog, testbench, FuseSoC, manifest | all above |
//! | [`board`] | a core with a mesh on a board: contents, frame, clock, project | all above |
//! | [`explore`] | sweeps over number formats, their bounds and costs, the Pareto front | all above |
//! | [`report`] | tables and pictures | plain data |
//! | [`cli`] | one file for each subcommand | all above |
//!
//! `model` never uses `hdl` or `cores`, and those never use `model`: both sides are written from the same
//! mathematics by different means, so that a mistake in one shows. Tests guard that.

pub mod board;
pub mod cli;
pub mod cores;
pub mod cosim;
pub mod error;
pub mod explore;
pub mod files;
pub mod fixed;
pub mod fpga;
pub mod hdl;
pub mod mesh;
pub mod model;
pub mod package;
mod parallel;
pub mod report;
pub mod surface;

pub use error::{Error, Kind, Result};
