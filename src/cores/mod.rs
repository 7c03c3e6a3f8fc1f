//! The hardware, described in `hdl`.
