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

/// A family of FPGAs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FamilyName {
    /// Lattice ECP5
    Ecp5,
    /// Lattice iCE40, as the HX8K
    Ice40,
    /// Gowin, as the GW2A-18
    Gowin,
    /// Lattice Nexus, as the LIFCL-40
    Nexus,
}

impl FamilyName {
    /// The device whose synthesis is used.
    pub fn device(self) -> &'static str {
        match self {
            FamilyName::Ecp5 => "ecp5-85k",
            FamilyName::Ice40 => "ice40-hx8k",
            FamilyName::Gowin => "gowin-gw2a18",
            FamilyName::Nexus => "lifcl-40",
        }
    }
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
