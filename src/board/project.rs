//! The files of a project, as templates print them.
//!
//! ```text
//! ulx3s/  README.md  Makefile  manifest.json  ulx3s.lpf      pins and tools
//!   rtl/board_top.v                                          PLL, reset, pins
//!   rtl/*.v                                                  mesh_board and all below it
//!   simulation/                                              testbench, expected.hex, the quick modules
//! ```

use std::path::PathBuf;

use askama::Template;
use serde_json::json;

use super::boards::{Board, Family, Pins};
use super::clock::{Pll, mega};
use super::simulate::Received;
use super::{Design, Pace};
use crate::cores::board::serial_sink::Header;
use crate::error::{Error, Kind, Result};
use crate::hdl::verilog;
use crate::package::Package;

/// What the templates show.
struct Page<'a> {
    version: &'static str,
    command: &'a str,
    name: &'static str,
    title: &'static str,
    ecp5: bool,
    device: &'static str,
    loader: &'static str,
    serial: &'static str,
    pins: Pins,
    button_low: bool,
    leds_low: bool,
    pll: Pll,
    /// In MHz.
    oscillator: f64,
    clock: f64,
    baud: u32,
    sources: &'a [String],
    quick: &'a [String],
    mesh: &'a str,
    level: u32,
    coordinates: String,
    points: usize,
    patches: usize,
    blocks: u64,
    beats: usize,
    bytes: usize,
    seconds: String,
    header: Header,
    clocks_per_bit: u32,
    button_clocks: u64,
}

/// One template over the same page.
macro_rules! template {
    ($name:ident, $path:literal) => {
        #[derive(Template)]
        #[template(path = $path, escape = "none")]
        struct $name<'a> {
            page: &'a Page<'a>,
        }
    };
}
template!(Ecp5Top, "board/ecp5_top.v");
template!(GowinTop, "board/gowin_top.v");
template!(Lpf, "board/pins.lpf");
template!(Cst, "board/pins.cst");
template!(Make, "board/Makefile.mk");
template!(Readme, "board/README.md");
template!(Testbench, "board_testbench.v");

fn print(template: &impl Template) -> Result<Vec<u8>> {
    let text = template
        .render()
        .map_err(|e| Error::new(Kind::ToolFailed, format!("a template cannot be printed: {e}")))?;
    Ok(format!("{}\n", text.trim_end()).into_bytes())
}

/// The command that writes exactly these files.
fn command(design: &Design) -> String {
    let s = &design.settings;
    format!(
        "subdiv-rtl generate board {} --core loop-fd {} --level {} --coordinates {} --baud {} --clock {} --device {}",
        s.board.name,
        s.mesh,
        s.level,
        s.parameters.coordinates,
        s.baud,
        mega(s.clock.into()),
        s.device.name
    )
}

/// All files. `checked` is what the check of the design received, if it was made.
///
/// # Errors
/// A core that cannot be built.
pub fn project(design: &Design, checked: Option<&Received>) -> Result<Package> {
    let command = command(design);
    let real = verilog::print(&design.top(design.pace)?, &command)?;
    let quick = verilog::print(&design.top(Pace::QUICK)?, &command)?;
    let mut files: Vec<(PathBuf, Vec<u8>)> = vec![];
    let mut quick_names = vec![];
    for file in quick.iter().filter(|file| !real.iter().any(|other| other.text == file.text)) {
        quick_names.push(file.name.clone());
        files.push((format!("simulation/{}", file.name).into(), file.text.clone().into_bytes()));
    }
    let mut sources: Vec<String> = real.iter().map(|file| file.name.clone()).collect();
    sources.push("board_top.v".into());
    files.extend(real.into_iter().map(|file| (format!("rtl/{}", file.name).into(), file.text.into_bytes())));

    let expected = design.expected();
    let page = page(design, &command, &sources, &quick_names, expected.len());
    let page = &page;
    let Board { name, family, .. } = *design.settings.board;
    let (top, pins) = match family {
        Family::Ecp5 => (print(&Ecp5Top { page })?, (format!("{name}.lpf"), print(&Lpf { page })?)),
        Family::Gowin => (print(&GowinTop { page })?, (format!("{name}.cst"), print(&Cst { page })?)),
    };
    let hex: String = expected.iter().map(|byte| format!("{byte:02x}\n")).collect();
    files.push(("rtl/board_top.v".into(), top));
    files.push((pins.0.into(), pins.1));
    files.push(("Makefile".into(), print(&Make { page })?));
    files.push(("README.md".into(), print(&Readme { page })?));
    files.push(("simulation/board_testbench.v".into(), print(&Testbench { page })?));
    files.push(("simulation/expected.hex".into(), hex.into_bytes()));
    files.push(("manifest.json".into(), manifest(design, page, checked, &files)?));
    files.sort();
    Ok(Package { top: "board_top".into(), files, estimate: None, latency: None })
}

fn page<'a>(
    design: &'a Design,
    command: &'a str,
    sources: &'a [String],
    quick: &'a [String],
    bytes: usize,
) -> Page<'a> {
    let settings = &design.settings;
    let board = settings.board;
    let frame = &design.contents.frame;
    Page {
        version: env!("CARGO_PKG_VERSION"),
        command,
        name: board.name,
        title: board.title,
        ecp5: board.family == Family::Ecp5,
        device: settings.device.nextpnr,
        loader: board.loader,
        serial: board.serial,
        pins: board.pins,
        button_low: board.button_low,
        leds_low: board.leds_low,
        pll: design.pll,
        oscillator: mega(board.oscillator.into()),
        clock: mega(settings.clock.into()),
        baud: settings.baud,
        sources,
        quick,
        mesh: settings.mesh.trim_start_matches("--shape "),
        level: settings.level,
        coordinates: settings.parameters.coordinates.to_string(),
        points: design.contents.patches.points.len(),
        patches: design.contents.patches.levels.len(),
        blocks: design.blocks,
        beats: frame.beats.len(),
        bytes,
        seconds: format!("{:.2}", bytes as f64 * 10.0 / f64::from(settings.baud)),
        header: frame.header,
        clocks_per_bit: Pace::QUICK.clocks_per_bit,
        button_clocks: Pace::QUICK.press(),
    }
}

fn manifest(
    design: &Design,
    page: &Page,
    checked: Option<&Received>,
    files: &[(PathBuf, Vec<u8>)],
) -> Result<Vec<u8>> {
    let settings = &design.settings;
    let hashes: serde_json::Map<_, _> = files
        .iter()
        .map(|(path, bytes)| {
            (path.to_string_lossy().replace('\\', "/"), blake3::hash(bytes).to_hex().as_str().into())
        })
        .collect();
    let Pll { input, feedback, output } = design.pll;
    let check = match checked {
        Some(received) => json!({
            "core": "proved by linear forms",
            "top": "simulated with a receiver at its line; every byte received equals the reference",
            "bytes_received": received.bytes.len(),
            "clocks_per_bit": Pace::QUICK.clocks_per_bit,
            "clocks": received.clocks,
        }),
        None => json!("not run"),
    };
    let object = json!({
        "schema": "subdiv-rtl/board/1",
        "generator": format!("subdiv-rtl {}", page.version),
        "command": page.command,
        "board": page.name,
        "device": settings.device.name,
        "core": "loop-fd",
        "mesh": page.mesh,
        "level": page.level,
        "coordinates": page.coordinates,
        "clock_mhz": page.clock,
        "pll": { "input": input, "feedback": feedback, "output": output },
        "baud": page.baud,
        "clocks_per_bit": design.pace.clocks_per_bit,
        "control_points": page.points,
        "patches": page.patches,
        "block_rams_at_most": page.blocks,
        "beats": page.beats,
        "frame_bytes": page.bytes,
        "check": check,
        "hashes": hashes,
    });
    let text = serde_json::to_string_pretty(&object)
        .map_err(|e| Error::new(Kind::ToolFailed, format!("the manifest cannot be written: {e}")))?;
    Ok(format!("{text}\n").into_bytes())
}
