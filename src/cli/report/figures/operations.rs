//! Figure 16: operations per triangle by level.

use super::{Files, control, csv, row};
use crate::error::Result;
use crate::explore::figures::operations::{Operations, count};
use crate::mesh::Mesh;
use crate::report::plot::{Axis, Mark, Plot, Scale, Series};

pub fn files(meshes: &[Mesh], max_level: u32) -> Result<Files> {
    let mut rows = vec![row([
        "mesh",
        "level",
        "triangles",
        "operations",
        "per triangle",
        "operations with masks",
        "per triangle with masks",
    ])];
    let mut series = vec![];
    for (colour, mesh) in meshes.iter().enumerate() {
        let (control, _) = control(mesh)?;
        let counted: Vec<Operations> =
            (0..=max_level).map(|level| count(mesh, &control, level, |_, _, _, _| {})).collect();
        let share = |operations: u64, of: &Operations| operations as f64 / of.triangles as f64;
        for of in &counted {
            rows.push(vec![
                mesh.name.clone(),
                of.level.to_string(),
                of.triangles.to_string(),
                of.differences.to_string(),
                format!("{:.4}", share(of.differences, of)),
                of.with_masks.to_string(),
                format!("{:.4}", share(of.with_masks, of)),
            ]);
        }
        let points = |operations: fn(&Operations) -> u64| {
            counted.iter().map(|of| (f64::from(of.level), share(operations(of), of))).collect::<Vec<_>>()
        };
        let differences = points(|of| of.differences);
        series.push(Series::new(mesh.name.clone(), Mark::Line, differences).colour(colour));
        let name = format!("{} with masks", mesh.name);
        series.push(Series::new(name, Mark::Dashed, points(|of| of.with_masks)).colour(colour));
    }
    let plot = Plot {
        title: "Operations per triangle, counted".into(),
        x: Axis::new("level", Scale::Linear),
        y: Axis::new("vector operations per triangle", Scale::Linear),
        series,
    };
    Ok(vec![("figure-16.svg".into(), plot.svg()?.into_bytes()), ("figure-16.csv".into(), csv(&rows))])
}
