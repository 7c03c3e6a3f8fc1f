//! `receive FILE`: the mesh that a board sends over its serial line.

use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

use serde::Serialize;

use super::output::{self, Format, FormatArg};
use super::progress::Progress;
use crate::board::frame;
use crate::error::{Error, Result};
use crate::mesh;

/// Read the mesh that a board sends, and check its checksum
///
/// Reads up to the end of the first whole frame. Set the line first: stty -F /dev/ttyUSB0 raw 115200
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What was received, a serial line as it comes, or - for standard input
    #[arg(value_name = "FILE|DEVICE")]
    pub from: PathBuf,

    /// Write the mesh: .obj, .ply or .stl
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub format: FormatArg,
}

#[derive(Serialize)]
struct Found {
    level: u8,
    coordinates: String,
    patches: u32,
    beats: u32,
    bytes: u32,
    vertices: usize,
    triangles: usize,
}

/// # Errors
/// A file that cannot be read or ends too early; a wrong checksum ([`crate::Kind::Mismatch`]).
pub fn run(args: &Args) -> Result<()> {
    let frame = frame::decode(&read(args)?)?;
    let mesh = frame.mesh();
    if let Some(path) = &args.output {
        mesh::write(path, &mesh)?;
    }
    let header = frame.header;
    let found = Found {
        level: header.level,
        coordinates: mesh.format.to_string(),
        patches: header.patches,
        beats: header.beats,
        bytes: header.length,
        vertices: mesh.positions.len(),
        triangles: mesh.faces.len(),
    };
    match args.format.format {
        Format::Json => output::print_object("receive", 1, &found),
        Format::Text => output::print(&format!(
            "level {}, {}: {} patches, {} vertices, {} triangles; {} bytes, checksum right\n",
            found.level, found.coordinates, found.patches, found.vertices, found.triangles, found.bytes
        )),
    }
}

/// The bytes of the first frame.
fn read(args: &Args) -> Result<Vec<u8>> {
    let place = args.from.display();
    let cannot = |error: io::Error| Error::input(format!("cannot read: {error}")).at(&place);
    let mut source: Box<dyn Read> = match args.from.to_str() {
        Some("-") => Box::new(io::stdin()),
        _ => Box::new(File::open(&args.from).map_err(cannot)?),
    };
    let _shown = Progress::waiting("receiving");
    let (mut received, mut piece) = (vec![], [0; 4096]);
    loop {
        if let Some(frame) = frame::find(&received).map_err(|error| error.at(&place))? {
            return Ok(frame.to_vec());
        }
        match source.read(&mut piece).map_err(cannot)? {
            0 => break,
            count => received.extend(&piece[..count]),
        }
    }
    Err(Error::input(format!("no whole frame in {} bytes", received.len()))
        .at(place)
        .help("receive until the end: the first bytes of a frame are SDV1, and they say how long it is"))
}
