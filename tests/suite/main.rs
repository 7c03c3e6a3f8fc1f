//! All tests from outside, in one program: linked once, and no processor waits for the last test of a file.
//!
//! `cargo test --test suite netlist::` runs those of a file.

// What several files need.
mod board_design;
mod cc_meshes;
mod cc_stage;
mod core_trial;
mod cosim_stub;
mod hdl_designs;
mod noise;
mod surface_meshes;

mod board;
mod board_faults;
mod calibration;
mod cc_boundary;
mod cc_calls;
mod cc_core;
mod cc_finish;
mod cc_finish_faults;
mod cc_finish_printed;
mod cc_global;
mod cc_longitudinal;
mod cc_model;
mod cc_normals;
mod cc_render;
mod cc_strips;
mod cc_trial;
mod cc_winged;
mod chunks_core;
mod cli_basics;
#[cfg(unix)]
mod cli_install;
mod cli_jobs;
mod cli_report;
mod columns_core;
mod cosim_faults;
mod cosim_tools;
mod coverage;
mod equivalence;
mod explore_jobs;
mod explore_sweep;
mod faults;
mod formats_core;
mod hdl_corners;
mod hdl_fuzz;
mod hdl_language;
mod house;
mod lanes_core;
mod lint;
mod mesh_broken_files;
mod mesh_shared_files;
mod model_float;
mod model_formats;
mod model_loop_fd;
mod model_render;
mod netlist;
mod serial;
mod simulate_everything;
mod simulate_strips;
mod skew;
mod surface_accuracy;
mod surface_hierarchy;
mod sweep;
mod synth;
