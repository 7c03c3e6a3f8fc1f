//! `shapes`: the built-in meshes.

use super::output::{self, Format, FormatArg};
use crate::error::Result;
use crate::mesh::{Mesh, Shape, Topology, shapes};
use crate::report::table::{Align, Table};
use serde_json::json;

/// List the built-in shapes
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  subdiv-rtl simulate --shape blob")]
pub struct Args {
    #[command(flatten)]
    pub format: FormatArg,
}

/// # Errors
/// Standard output that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let listed: Vec<(&Shape, Mesh)> = shapes().iter().map(|shape| (shape, shape.mesh())).collect();
    match args.format.format {
        Format::Text => {
            let mut table = Table::new(&[
                ("name", Align::Left),
                ("vertices", Align::Right),
                ("faces", Align::Right),
                ("what it is", Align::Left),
            ]);
            for (shape, mesh) in &listed {
                let (vertices, faces) = (mesh.positions.len().to_string(), mesh.faces.len().to_string());
                table.row([shape.name, &vertices, &faces, shape.description]);
            }
            output::print(&table.to_string())
        }
        Format::Json => {
            let object = |(shape, mesh): &(&Shape, Mesh)| {
                let topology = Topology::new(mesh)?;
                let valences: serde_json::Map<String, serde_json::Value> = topology
                    .valence_histogram()
                    .iter()
                    .map(|(valence, count)| (valence.to_string(), json!(count.interior + count.boundary)))
                    .collect();
                Ok(json!({
                    "name": shape.name,
                    "description": shape.description,
                    "vertices": mesh.positions.len(),
                    "faces": mesh.faces.len(),
                    "triangles_only": mesh.is_triangle_mesh(),
                    "genus": topology.genus(),
                    "valences": valences,
                }))
            };
            let shapes = listed.iter().map(object).collect::<Result<Vec<_>>>()?;
            output::print_object("shapes", 1, &json!({ "shapes": shapes }))
        }
    }
}
