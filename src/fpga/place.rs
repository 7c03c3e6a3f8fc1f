//! Place and route, by nextpnr.
//!
//! The clock is that of a real design with four pins. Out of context, as nextpnr can also place, clocks would not go
//! over the global net.
//!
//! ```text
//!   ECP5     nextpnr places ─► cells are moved (see detailed_placement) ─► nextpnr routes
//!   others   nextpnr places and routes
//! ```

use std::path::Path;

use super::cache::Cache;
use super::detailed_placement;
use super::device::{Device, Family};
use super::ram_pins;
use super::run::{Progress, Stage, run_within};
use super::synthesis::Synthesised;
use super::timing::Timing;
use super::tools::Tool;
use crate::cosim::{Settings, hash};
use crate::error::{Error, Kind, Result};

/// One of the runs that differ in their luck.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    pub seed: u32,
    /// The clock that is asked for.
    pub target_mhz: f64,
}

/// Places and routes; the same netlist, seed and version give the same result.
///
/// # Errors
/// `ToolFailed`, with the last lines of what nextpnr said: often that the device is full.
pub fn place(
    design: &Synthesised,
    device: &Device,
    how: Run,
    placer: &Tool,
    settings: &Settings,
    cache: &Cache,
    progress: Progress,
) -> Result<Timing> {
    let words = arguments(device, how, design.netlist.size());
    let netlist = ram_pins::open_high(&design.netlist).text()?;
    let said = words.join(" ");
    let pins = device.pins.map(constraints);
    let parts = [("nextpnr", placer.version.as_str()), ("arguments", said.as_str())].into_iter();
    let moved = if device.family == Family::Ecp5 { detailed_placement::VERSION } else { "no" };
    let parts = parts.chain([("detailed placement", moved)]);
    let parts =
        parts.chain(pins.iter().map(|pins| ("pins", pins.as_str()))).chain([("netlist", netlist.as_str())]);
    let hash = hash(parts);
    if let Some(text) = cache.find("placed", &hash) {
        return Timing::parse(&text);
    }
    let failed = |what: String| Error::new(Kind::ToolFailed, what);
    let folder = tempfile::tempdir().map_err(|e| failed(format!("no temporary folder: {e}")))?;
    std::fs::write(folder.path().join(NETLIST), &netlist)
        .map_err(|e| failed(format!("cannot write the netlist: {e}")))?;
    if let Some(pins) = &pins {
        std::fs::write(folder.path().join(PINS), pins)
            .map_err(|e| failed(format!("cannot write the pins: {e}")))?;
    }
    let nextpnr = Nextpnr { program: &placer.program, words, folder: folder.path(), settings, progress };
    match device.family {
        Family::Ecp5 => nextpnr.with_moves(how.target_mhz, design.netlist.size() >= MANY_CELLS)?,
        _ => drop(nextpnr.run(Stage::Placement, None, &["--json", NETLIST])?),
    }
    let text = std::fs::read(folder.path().join("report.json"))
        .map_err(|e| failed(format!("nextpnr left no report: {e}")))?;
    let timing = Timing::parse(&text)?;
    cache.keep("placed", &hash, &text)?;
    Ok(timing)
}

/// The program with the arguments of all its runs.
struct Nextpnr<'a> {
    program: &'a str,
    words: Vec<String>,
    folder: &'a Path,
    settings: &'a Settings,
    progress: Progress<'a>,
}

impl Nextpnr<'_> {
    /// Whether it came to its end with so many iterations of the router.
    fn run(&self, stage: Stage, iterations: Option<u32>, more: &[&str]) -> Result<bool> {
        let words = self.words.iter().map(String::as_str);
        let line: Vec<String> =
            [self.program].into_iter().chain(words).chain(more.iter().copied()).map(String::from).collect();
        run_within(iterations, &line, self.folder, stage, self.settings, self.progress)
    }

    /// Places, moves cells and routes.
    fn with_moves(&self, target_mhz: f64, large: bool) -> Result<()> {
        let failed = |what: String| Error::new(Kind::ToolFailed, what);
        self.run(Stage::Placement, None, &PLACE)?;
        (self.progress)(Stage::DetailedPlacement);
        let placed = std::fs::read(self.folder.join(PLACED))
            .map_err(|e| failed(format!("nextpnr left no placement: {e}")))?;
        let (refined, _) = detailed_placement::refine(&placed, TARGET * 1e3 / target_mhz as f32)?;
        std::fs::write(self.folder.join(REFINED), refined)
            .map_err(|e| failed(format!("cannot write the placement: {e}")))?;
        let others = [&ROUTE[..], &[OTHER_WEIGHTS]].concat();
        if !(large && self.run(Stage::Routing, Some(MOST_ITERATIONS), &others)?) {
            self.run(Stage::Routing, None, &ROUTE)?;
        }
        Ok(())
    }
}

const NETLIST: &str = "netlist.json";
const PLACED: &str = "placed.json";
const REFINED: &str = "refined.json";

/// Where cells are moved between placement and routing, nextpnr runs twice.
const PLACE: [&str; 5] = ["--json", NETLIST, "--no-route", "--write", PLACED];
const ROUTE: [&str; 4] = ["--json", REFINED, "--no-pack", "--no-place"];

/// The share of the period that the moves aim at: routing makes it longer.
const TARGET: f32 = 0.93;

/// The file of the pins.
const PINS: &str = "pins.cst";

/// Where the ports of the harness are.
fn constraints(pins: [&str; 4]) -> String {
    let ports = ["clock", "reset_n", "shift_in", "data_out"];
    ports.iter().zip(pins).map(|(port, pin)| format!("IO_LOC \"{port}\" {pin};\n")).collect()
}

/// The placer does best when it weighs the critical nets heavily: of one core, 195 MHz become 253. More weight, another
/// clock asked for and the other placers gain nothing.
const ECP5: [&str; 3] = ["--lpf-allow-unconstrained", "--placer-heap-timingweight", "80"];

/// Of designs with so many cells the first router need not end: of one of 55,000 it still had open arcs after 40 minutes,
/// which the second one closes in four. That one's other weights detour less, of one placement 198 MHz in place of 175,
/// but need not end either: 350 iterations are usual.
const MANY_CELLS: usize = 40_000;
const SECOND_ROUTER: [&str; 2] = ["--router", "router2"];
const OTHER_WEIGHTS: &str = "--router2-alt-weights";
const MOST_ITERATIONS: u32 = 700;

/// All arguments of nextpnr, for so many cells.
fn arguments(device: &Device, Run { seed, target_mhz }: Run, cells: usize) -> Vec<String> {
    let mut words: Vec<String> = device.arguments.iter().map(|word| word.to_string()).collect();
    let more = ["--report", "report.json", "--timing-allow-fail"];
    words.extend(more.map(String::from));
    words.extend(["--freq".into(), target_mhz.to_string(), "--seed".into(), seed.to_string()]);
    match device.family {
        Family::Ecp5 => {
            words.extend(ECP5.map(String::from));
            words.extend(SECOND_ROUTER.iter().filter(|_| cells >= MANY_CELLS).map(|word| word.to_string()));
        }
        Family::Ice40 => words.push("--pcf-allow-unconstrained".into()),
        Family::Gowin => words.extend(["--vopt".into(), format!("cst={PINS}")]),
        Family::Nexus => {}
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_large_design_takes_the_second_router() {
        let device = Device::named("ecp5-85k").unwrap();
        let run = Run { seed: 1, target_mhz: 300.0 };
        let router = |cells| arguments(device, run, cells).contains(&"router2".to_string());
        assert!(!router(MANY_CELLS - 1) && router(MANY_CELLS));
    }
}
