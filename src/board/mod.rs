//! A mesh and a core on a board: a whole project, from block RAM to the pins.
//!
//! ```text
//! mesh ─► contents (points, patches) ─► cores::board (evaluator, sink, top) ─┬─► Verilog, constraints, Makefile
//!              └──────► reference ──────────► frame ──► bytes ──┐            └─► built-in simulator + receiver
//!                                                              compare ◄─────────────────┘
//! ```
//!
//! Boards are data ([`boards`]); the few files that are not described in the language (wrapper with PLL and pins,
//! constraints, Makefile, README) are templates in `rtl-templates/board/`.

pub mod boards;
pub mod clock;
pub mod contents;
pub mod frame;
pub mod memory;
mod project;
pub mod simulate;
pub mod uart;

use std::rc::Rc;

use boards::{Board, Device};
use clock::Pll;
use contents::Contents;
use simulate::{Received, Session};

use crate::cores::board::{evaluator, serial_sink, top};
use crate::cores::loop_fd::{self, Parameters, proof};
use crate::error::{Error, Kind, Result};
use crate::hdl::{Flat, Module};
use crate::surface::control_mesh::ControlMesh;

pub use project::project;

/// What the user asks for.
#[derive(Clone, Debug)]
pub struct Settings {
    pub board: &'static Board,
    pub device: &'static Device,
    pub parameters: Parameters,
    /// At which the mesh is evaluated.
    pub level: u32,
    pub baud: u32,
    /// Of the core, in Hz.
    pub clock: u32,
    /// The mesh as on the command line: a file, or `--shape NAME`.
    pub mesh: String,
}

/// A mesh on a board, checked to fit.
#[derive(Clone, Debug)]
pub struct Design {
    pub settings: Settings,
    pub pll: Pll,
    pub contents: Contents,
    /// Block RAMs that the mesh takes at most.
    pub blocks: u64,
    /// The pace of the hardware.
    pub pace: Pace,
}

/// Bytes of a frame that the check waits for, some seconds.
const CHECKED: usize = 100_000;

/// How long what is measured in time lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    pub clocks_per_bit: u32,
    /// The button counts when it has been down for 2^this clocks.
    pub log_quiet: u32,
}

impl Pace {
    /// So short that a simulation is quick.
    pub const QUICK: Pace = Pace { clocks_per_bit: 4, log_quiet: 4 };

    /// Clocks that the button is held in a simulation.
    pub fn press(self) -> u64 {
        (1 << self.log_quiet) + 8
    }
}

impl Design {
    /// # Errors
    /// A clock or baud rate that cannot be made, a mesh that does not fit the core or the device.
    pub fn new(settings: Settings, mesh: &ControlMesh) -> Result<Design> {
        let Settings { board, device, parameters, level, baud, clock, .. } = settings;
        let pll = clock::pll(board.family, board.oscillator, clock)?;
        let clocks_per_bit = clock::clocks_per_bit(clock, baud)?;
        let contents = contents::contents(parameters, mesh, level)?;
        let blocks = memory::check(board, device, parameters, &contents.patches)?;
        // Some five milliseconds, longer than a button bounces.
        let log_quiet = (clock / 200).ilog2();
        Ok(Design { settings, pll, contents, blocks, pace: Pace { clocks_per_bit, log_quiet } })
    }

    /// All of the hardware but the board's wrapper.
    ///
    /// # Errors
    /// A core that cannot be built.
    pub fn top(&self, pace: Pace) -> Result<Rc<Module>> {
        let parameters = self.settings.parameters;
        let evaluator = evaluator(parameters, &self.contents.patches)?;
        let sink = serial_sink::build(parameters, self.contents.frame.header, pace.clocks_per_bit)?;
        top::build(&evaluator, &sink, pace.log_quiet)
    }

    /// The bytes that must come over the line, each time.
    pub fn expected(&self) -> Vec<u8> {
        frame::encode(&self.contents.frame)
    }

    /// Proves the core, runs the top at the quick pace, and compares what came with the reference: the whole
    /// frame, or the first 100,000 bytes of a longer one.
    ///
    /// # Errors
    /// `Mismatch` for a refuted proof, or bytes that differ.
    pub fn check(&self) -> Result<Received> {
        let parameters = self.settings.parameters;
        proof::prove(&loop_fd::build(parameters)?, parameters)?;
        let frame = self.expected();
        let expected = &frame[..frame.len().min(CHECKED)];
        let received = Session {
            top: &Flat::new(&self.top(Pace::QUICK)?)?,
            clocks_per_bit: Pace::QUICK.clocks_per_bit,
            pressed: &[],
            bytes: expected.len(),
            to_the_end: expected.len() == frame.len(),
            disturb: &|_, line| line,
        }
        .run()?;
        if received.broken > 0 || received.bytes != expected {
            let differ = received.bytes.iter().zip(expected).position(|(got, want)| got != want);
            let at = differ.unwrap_or(received.bytes.len().min(expected.len()));
            return Err(Error::new(
                Kind::Mismatch,
                format!("the line differs from the reference at byte {at}"),
            )
            .help("the hardware is wrong; nothing was written"));
        }
        Ok(received)
    }
}
