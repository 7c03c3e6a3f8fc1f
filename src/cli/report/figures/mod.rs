//! `report figures`: the measured figures of the paper (Bischoff, Kobbelt, Seidel 2000), as SVG with the numbers
//! as CSV beside.
//!
//! ```text
//!   figure-16   operations per triangle by level             counted while the mesh is evaluated
//!   figure-17   largest relative deviation by level          float32, uniform, progressive and exact fixed point
//!   figure-18   reflection lines at levels 3, 3 and 7        without, with and without interpolated normals
//! ```

mod deviation;
mod operations;
mod reflection;

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::cli::output::{self, Format, FormatArg};
use crate::cli::progress::Progress;
use crate::error::{Error, Result};
use crate::files::write_whole;
use crate::mesh::{self, Mesh};

/// Measure the figures of the paper again: operations, deviation, reflection lines
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A mesh in place of the built-in blob, beside tetrahedron and torus
    #[arg(value_name = "MESH")]
    mesh: Option<PathBuf>,

    /// Which figures
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', default_value = "16,17,18")]
    #[arg(value_parser = clap::value_parser!(u32).range(16..=18))]
    only: Vec<u32>,

    /// The finest level of figures 16 and 17
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10))]
    max_level: u32,

    /// The folder to write to
    #[arg(short, long, value_name = "DIR", default_value = "figures")]
    output: PathBuf,

    #[command(flatten)]
    pub format: FormatArg,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl report figures
  subdiv-rtl report figures bunny.obj --only 16,18 -o bunny";

/// The files of a figure: name and content.
type Files = Vec<(String, Vec<u8>)>;

/// # Errors
/// A mesh that cannot be used, a folder that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let third = match &args.mesh {
        None => mesh::shape("blob")?,
        Some(path) => mesh::read(path)?,
    };
    third.triangles()?;
    let meshes = [mesh::shape("tetrahedron")?, mesh::shape("torus")?, third];
    let mut written = vec![];
    let mut figures = args.only.clone();
    figures.sort_unstable();
    figures.dedup();
    for figure in figures {
        let _shown = Progress::waiting(format!("measuring figure {figure}"));
        let files = match figure {
            16 => operations::files(&meshes, args.max_level)?,
            17 => deviation::files(&meshes, args.max_level)?,
            _ => reflection::files(&meshes[2])?,
        };
        written.extend(write(&args.output, files)?);
    }
    match args.format.format {
        Format::Json => output::print_object("report-figures", 1, &json!({ "files": written })),
        Format::Text => output::print(&written.iter().map(|file| format!("{file}\n")).collect::<String>()),
    }
}

fn write(folder: &Path, files: Files) -> Result<Vec<String>> {
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::input(format!("cannot make the folder: {e}")).at(folder.display()))?;
    let mut written = vec![];
    for (name, bytes) in files {
        let path = folder.join(name);
        write_whole(&path, bytes)?;
        written.push(path.display().to_string());
    }
    Ok(written)
}

/// Rows of a CSV file, the headings first.
fn csv(rows: &[Vec<String>]) -> Vec<u8> {
    let quoted = |cell: &String| match cell.contains([',', '"', '\n']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.clone(),
    };
    let line = |row: &Vec<String>| row.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n";
    rows.iter().map(line).collect::<String>().into_bytes()
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(String::from).to_vec()
}

/// The control mesh at the widest fraction that fits in 24 bits.
fn control(mesh: &Mesh) -> Result<(crate::surface::control_mesh::ControlMesh, crate::fixed::Format)> {
    let format = mesh::widest_format(mesh, 24)?;
    let positions = mesh::quantise(mesh, format)?.positions;
    Ok((crate::surface::control_mesh::ControlMesh::new(positions, mesh.triangles()?)?, format))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_are_quoted() {
        assert_eq!(csv(&[row(["a,b", "1"]), row(["\"c\"", "2"])]), b"\"a,b\",1\n\"\"\"c\"\"\",2\n");
    }
}
