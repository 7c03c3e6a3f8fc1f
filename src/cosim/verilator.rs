//! How Verilator compiles a core: with the C++ harness for speed, or with the emitted testbench.

use super::external::Recipe;
use super::{Dut, Settings, testbench};
use crate::Result;

/// What both ways share. Lint warnings are for `--lint-only`, not for a simulation.
const COMMON: [&str; 9] =
    ["--build", "-j", "0", "-O3", "-Wno-fatal", "--prefix", "Vdut", "-MAKEFLAGS", "OPT_FAST=-O2"];

/// The model with its harness. Verilator's own library is hardly used while the clock runs; compiling
/// it without optimization halves the time of a build.
pub(super) fn harness_recipe(dut: &Dut, trace: bool, settings: &Settings) -> Result<Recipe> {
    let mut compile = vec!["verilator", "--cc", "--exe", "--top-module", &dut.top];
    compile.extend(COMMON);
    compile.extend(["--x-assign", "fast", "--noassert", "-MAKEFLAGS", "OPT_GLOBAL=-O0"]);
    if trace {
        compile.push("--trace");
    }
    if settings.coverage {
        compile.extend(["--coverage-line", "--coverage-toggle"]);
    }
    // The counters of coverage make the model many times as large, and it runs once or twice.
    if settings.coverage || settings.compile_fast {
        compile.extend(["-MAKEFLAGS", "OPT_FAST=-O0"]);
    }
    compile.extend(dut.sources());
    compile.push("harness.cpp");
    Ok(Recipe {
        bench: ("harness.cpp".into(), testbench::harness(dut)?),
        compile: compile.into_iter().map(String::from).collect(),
        product: "obj_dir/Vdut",
        run: &[],
    })
}

/// The model with the emitted testbench; here the library reads and writes the vectors.
pub(super) fn testbench_recipe(dut: &Dut, trace: bool) -> Result<Recipe> {
    let name = testbench::testbench_name(dut);
    let file = format!("{name}.v");
    let mut compile = vec!["verilator", "--binary", "--timing", "--top-module", &name];
    compile.extend(COMMON);
    compile.extend(["-MAKEFLAGS", "OPT_GLOBAL=-O1"]);
    if trace {
        compile.push("--trace");
    }
    compile.extend(dut.sources());
    compile.push(&file);
    Ok(Recipe {
        compile: compile.into_iter().map(String::from).collect(),
        bench: (file, testbench::testbench(dut)?),
        product: "obj_dir/Vdut",
        run: &[],
    })
}
