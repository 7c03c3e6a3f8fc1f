//! Place and route, by nextpnr.
//!
//! The clock is that of a real design with four pins. Out of context, as nextpnr can also place, clocks would not go
//! over the global net.
//!
//! ```text
//!   ECP5     nextpnr places ─┬► cells are moved (see detailed_placement) ─► nextpnr routes ─┬─► delays (see static_timing)
//!                            └────────── where that cannot be routed ─────► nextpnr routes ─┘
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
    let words = arguments(device, how);
    let netlist = ram_pins::open_high(&design.netlist).text()?;
    let said = words.join(" ");
    let pins = device.pins.map(constraints);
    let parts = [("nextpnr", placer.version.as_str()), ("arguments", said.as_str())].into_iter();
    let moved = if device.family == Family::Ecp5 { detailed_placement::VERSION } else { "no" };
    let parts = parts.chain([("detailed placement", moved)]);
    let parts =
        parts.chain(pins.iter().map(|pins| ("pins", pins.as_str()))).chain([("netlist", netlist.as_str())]);
    let hash = hash(parts);
    let kept = cache.find("timing", &hash).and_then(|text| serde_json::from_slice(&text).ok());
    if let Some(timing) = kept {
        return Ok(timing);
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
    let timing = match device.family {
        Family::Ecp5 => nextpnr.with_moves(how.target_mhz)?,
        _ => {
            nextpnr.run(Stage::Placement, None, &["--json", NETLIST])?;
            Timing::parse(&nextpnr.left("report", REPORT)?)?
        }
    };
    let text = serde_json::to_vec(&timing).map_err(|e| failed(e.to_string()))?;
    cache.keep("timing", &hash, &text)?;
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
    /// Whether it came to its end with so many iterations of the router for an arc.
    fn run(&self, stage: Stage, iterations_an_arc: Option<u64>, more: &[&str]) -> Result<bool> {
        let words = self.words.iter().map(String::as_str);
        let line: Vec<String> =
            [self.program].into_iter().chain(words).chain(more.iter().copied()).map(String::from).collect();
        run_within(iterations_an_arc, &line, self.folder, stage, self.settings, self.progress)
    }

    /// Places, moves cells and routes; what the paths take by the delays of their wires.
    fn with_moves(&self, target_mhz: f64) -> Result<Timing> {
        let failed = |what: String| Error::new(Kind::ToolFailed, what);
        self.run(Stage::Placement, None, &PLACE)?;
        (self.progress)(Stage::DetailedPlacement);
        let placed = self.left("placement", PLACED)?;
        let (refined, _) = detailed_placement::refine(&placed, TARGET * 1e3 / target_mhz as f32)?;
        std::fs::write(self.folder.join(REFINED), &refined)
            .map_err(|e| failed(format!("cannot write the placement: {e}")))?;
        let first = |netlist| self.run(Stage::Routing, Some(MOST_ITERATIONS_AN_ARC), &route(netlist));
        let routed = if first(REFINED)? {
            refined
        } else {
            // Where the device is full, cells lie less densely as the placer has left them.
            if !first(PLACED)? {
                self.run(Stage::Routing, None, &[&route(PLACED)[..], &SECOND_ROUTER].concat())?;
            }
            placed
        };
        let delays = String::from_utf8(self.left("delays", DELAYS)?)
            .map_err(|_| failed("the delays of nextpnr are no text".into()))?;
        Timing::parse(&self.left("report", REPORT)?)?.with_delays(&delays, &routed)
    }

    /// A file that it should have written.
    fn left(&self, what: &str, name: &str) -> Result<Vec<u8>> {
        std::fs::read(self.folder.join(name))
            .map_err(|e| Error::new(Kind::ToolFailed, format!("nextpnr left no {what}: {e}")))
    }
}

const NETLIST: &str = "netlist.json";
const PLACED: &str = "placed.json";
const REFINED: &str = "refined.json";
const DELAYS: &str = "delays.sdf";
const REPORT: &str = "report.json";

/// Where cells are moved between placement and routing, nextpnr runs twice.
const PLACE: [&str; 5] = ["--json", NETLIST, "--no-route", "--write", PLACED];
const fn route(netlist: &str) -> [&str; 6] {
    ["--json", netlist, "--no-pack", "--no-place", "--sdf", DELAYS]
}

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

/// The first router looks for the shortest way of every wire, the second one begins at whatever the net has near by:
/// of one placement of 70,000 cells 230 MHz in place of 197. But the first one need not end where wires are dense. That
/// design takes it 210,000 iterations, three minutes; of a device full of lanes whose cells were moved it had routed a
/// tenth after 128,000, and the second one stood still, too. As nextpnr had placed them, the first one took four minutes.
const MOST_ITERATIONS_AN_ARC: u64 = 2;
const SECOND_ROUTER: [&str; 2] = ["--router", "router2"];

/// The arguments of all runs.
fn arguments(device: &Device, Run { seed, target_mhz }: Run) -> Vec<String> {
    let mut words: Vec<String> = device.arguments.iter().map(|word| word.to_string()).collect();
    let more = ["--report", REPORT, "--timing-allow-fail"];
    words.extend(more.map(String::from));
    words.extend(["--freq".into(), target_mhz.to_string(), "--seed".into(), seed.to_string()]);
    match device.family {
        Family::Ecp5 => words.extend(ECP5.map(String::from)),
        Family::Ice40 => words.push("--pcf-allow-unconstrained".into()),
        Family::Gowin => words.extend(["--vopt".into(), format!("cst={PINS}")]),
        Family::Nexus => {}
    }
    words
}
