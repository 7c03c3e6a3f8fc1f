//! Figure 17: the largest relative deviation by level, in floating and in fixed point.

use super::{Files, control, csv, row};
use crate::error::Result;
use crate::explore::figures::deviation::{fixed, floating};
use crate::mesh::Mesh;
use crate::model::loop_fd::LoopFd;
use crate::report::plot::{Axis, Mark, Plot, Scale, Series};

pub fn files(meshes: &[Mesh], max_level: u32) -> Result<Files> {
    let mut rows = vec![row(["mesh", "level", "numbers", "largest relative deviation"])];
    let mut worst: Vec<(String, Vec<(f64, f64)>)> = vec![];
    for mesh in meshes {
        let (control, format) = control(mesh)?;
        for level in 1..=max_level {
            let core = LoopFd::new(format.width(), 0, level)?;
            let found = [
                ("float32".to_string(), floating::<f32>(&control, level)?),
                (format!("exact, {} bits", format.width()), fixed(&control, level, &core)?),
            ];
            for (name, deviation) in found {
                rows.push(vec![mesh.name.clone(), level.to_string(), name.clone(), format!("{deviation:e}")]);
                let place = worst.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
                    worst.push((name, vec![]));
                    worst.len() - 1
                });
                // The largest over the meshes.
                let points = &mut worst[place].1;
                match points.iter_mut().find(|(at, _)| *at == f64::from(level)) {
                    Some((_, largest)) => *largest = largest.max(deviation),
                    None => points.push((f64::from(level), deviation)),
                }
            }
        }
    }
    let series = worst.into_iter().enumerate().map(|(colour, (name, points))| {
        Series::new(name, if colour == 0 { Mark::Dashed } else { Mark::Line }, points).colour(colour)
    });
    let names: Vec<&str> = meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let plot = Plot {
        title: format!("Largest relative deviation, {}", names.join(", ")),
        x: Axis::new("level", Scale::Linear),
        y: Axis::new("deviation of the position / its distance from the origin", Scale::Logarithmic),
        series: series.collect(),
    };
    Ok(vec![("figure-17.svg".into(), plot.svg()?.into_bytes()), ("figure-17.csv".into(), csv(&rows))])
}
