//! What options of `simulate` can be called.

use clap::ValueEnum;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Scheme {
    /// Triangles, after Charles Loop
    #[default]
    Loop,
    /// Quads in strips, after Catmull and Clark; other polygons become quads by one step
    CatmullClark,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum SimulatorName {
    /// Our own, which needs no tools
    Builtin,
    /// Verilator, the fastest
    Verilator,
    /// The emitted testbench in Verilator; slower, and not among 'all'
    VerilatorTestbench,
    /// Icarus Verilog, with the emitted testbench
    Icarus,
    /// All of them; it is an error when one is missing
    All,
    /// Those of them that are installed
    Installed,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    /// Nothing: porcelain
    #[default]
    Plain,
    /// The distance of each vertex from its exact place
    Error,
    /// The polynomial patches, by their depth around irregular vertices
    Patches,
    /// The strips that a quad mesh was cut into
    Strips,
}
