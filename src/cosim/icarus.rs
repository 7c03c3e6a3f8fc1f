//! How Icarus compiles a core with the emitted testbench.

use super::external::Recipe;
use super::{Dut, testbench};
use crate::Result;

/// The plusargs of the testbench choose the waveform: tracing needs no other build.
pub(super) fn recipe(dut: &Dut) -> Result<Recipe> {
    let name = testbench::testbench_name(dut);
    let file = format!("{name}.v");
    let mut compile = vec!["iverilog", "-g2005", "-o", "testbench.vvp", "-s", &name];
    compile.extend(dut.sources());
    compile.push(&file);
    Ok(Recipe {
        compile: compile.into_iter().map(String::from).collect(),
        bench: (file, testbench::testbench(dut)?),
        product: "testbench.vvp",
        run: &["vvp", "-n"],
    })
}
