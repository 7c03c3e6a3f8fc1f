//! `generate board NAME`: a mesh and a core on a board, as a project that makes a bitstream.

use std::path::PathBuf;

use super::progress::Progress;
use crate::board::boards::{self, Board};
use crate::board::{self, Design};
use crate::cores::loop_fd::{Parameters, RegisterForm};
use crate::error::{Error, Result};
use crate::fixed::Format;
use crate::mesh::{self, Topology};
use crate::package::Package;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::table::MAX_VALENCE;
use clap::ValueEnum;

/// A mesh on a board: block RAM, core, serial line, PLL, pins and Makefile
///
/// The hardware evaluates the mesh after reset and at each press of the button, and sends the vertices over the serial
/// line with a checksum; 'subdiv-rtl receive' reads them. Before anything is written the core is proved, and the whole
/// is simulated with a receiver at its line.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// ulx3s or tang-nano-20k
    #[arg(value_name = "NAME", value_parser = boards::board)]
    pub board: &'static Board,

    /// The core that evaluates the mesh
    #[arg(long, value_enum, value_name = "CORE", default_value_t)]
    pub core: Core,

    /// The control mesh: OBJ, OFF, PLY, STL or SGI Inventor
    #[arg(long, value_name = "FILE", conflicts_with = "shape")]
    pub mesh: Option<PathBuf>,

    /// A built-in shape in place of a mesh; 'subdiv-rtl shapes' lists them
    #[arg(long, value_name = "NAME")]
    pub shape: Option<String>,

    /// How often each edge is halved
    #[arg(short, long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=7))]
    pub level: u32,

    /// Format of the coordinates [default: the finest that holds the mesh in 16 bits on the ULX3S, 10 on the Tang Nano]
    #[arg(long, value_name = "Qi.f")]
    pub coordinates: Option<Format>,

    /// Bits a second on the line
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(9_600..=3_000_000))]
    pub baud: u32,

    /// Clock of the core, by the PLL [default: 50 on the ULX3S, 54 on the Tang Nano]
    #[arg(long, value_name = "MHZ", value_parser = clap::value_parser!(u32).range(1..=400))]
    pub clock: Option<u32>,

    /// The device on the board; the ULX3S comes with 85f, 45f, 25f or 12f [default: 85f]
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,

    /// Write without the proof of the core and the simulation of the whole; the manifest says so
    #[arg(long)]
    pub no_check: bool,

    /// Write into a folder that holds other files too
    #[arg(long)]
    pub force: bool,

    /// The folder to write to [default: the name of the board]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl generate board ulx3s --shape octahedron --level 3 && make -C ulx3s
  subdiv-rtl generate board ulx3s --mesh bunny.obj --baud 1000000 --device 25f -o bunny
  subdiv-rtl generate board tang-nano-20k --shape tetrahedron --coordinates Q4.4 --level 1";

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Core {
    /// Loop surfaces by forward differences
    #[default]
    LoopFd,
}

impl Args {
    pub fn folder(&self) -> PathBuf {
        self.output.clone().unwrap_or_else(|| self.board.name.into())
    }

    /// The project in memory.
    ///
    /// # Errors
    /// A mesh that cannot be used or does not fit, a clock or baud rate that cannot be made, a check that fails.
    pub fn package(&self) -> Result<Package> {
        let (mesh, name) = match (&self.mesh, &self.shape) {
            (Some(file), _) => (mesh::read(file)?, format!("--mesh {}", file.display())),
            (None, Some(shape)) => (mesh::shape(shape)?, format!("--shape {shape}")),
            (None, None) => {
                return Err(Error::usage("a board without a mesh").help("give --mesh FILE, or --shape NAME"));
            }
        };
        mesh.triangles()?;
        Topology::new(&mesh)?.check_valences(&mesh, 3..=MAX_VALENCE as u32, 2..=MAX_VALENCE as u32)?;
        let coordinates = match self.coordinates {
            Some(format) => format,
            None => mesh::widest_format(&mesh, self.board.width)?,
        };
        let quantised = mesh::quantise(&mesh, coordinates)?;
        let control = ControlMesh::new(quantised.positions, mesh.triangles()?)?;
        let settings = board::Settings {
            board: self.board,
            device: self.board.device(self.device.as_deref())?,
            parameters: Parameters::new(
                coordinates,
                coordinates.fraction,
                self.level,
                RegisterForm::Minimal20,
            )?,
            level: self.level,
            baud: self.baud,
            clock: self.clock.map_or(self.board.clock, |mega| mega * 1_000_000),
            mesh: name,
        };
        let design = Design::new(settings, &control)?;
        let _shown = Progress::waiting(if self.no_check { "building" } else { "proving and simulating" });
        let checked = if self.no_check { None } else { Some(design.check()?) };
        board::project(&design, checked.as_ref())
    }
}
