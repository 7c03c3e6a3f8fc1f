//! Figure 17: the largest relative deviation by level, in floating and in fixed point.
//!
//! The reduced formats are, for each level, the cheapest ones that are proved to stay within one unit of the last place.

use super::{Files, control, csv, row};
use crate::error::Result;
use crate::explore::figures::deviation::fixed;
use crate::fixed::{Format, Precision, Reduced, Rounding};
use crate::mesh::Mesh;
use crate::model::float::{self, Half};
use crate::model::loop_fd::LoopFd;
use crate::report::plot::{Axis, Mark, Plot, Scale, Series};
use crate::surface::control_mesh::ControlMesh;
use crate::surface::precision::search::REGISTERS_20;
use crate::surface::precision::{Dyadic, cheapest_progressive, cheapest_uniform};

/// What is compared: its name in the legend, its format in full, its deviation.
type Measured = (&'static str, String, f64);

fn measure(control: &ControlMesh, format: Format, level: u32) -> Result<Vec<Measured>> {
    let core = LoopFd::new(format.width(), 0, level)?;
    let unit = format.lsb();
    let mut found = vec![
        ("float32", "single precision".to_string(), float::deviation::<f32>(control, level, unit).relative),
        ("float16", "half precision".to_string(), float::deviation::<Half>(control, level, unit).relative),
        ("exact fixed point", "exact".to_string(), fixed(control, level, &core)?),
    ];
    let uniform = cheapest_uniform(level, Dyadic::HALF, Rounding::HalfUp);
    let progressive = cheapest_progressive(level, Dyadic::HALF, Rounding::HalfUp, REGISTERS_20);
    for (name, fractions) in [("uniform, 1 lsb", uniform), ("progressive, 1 lsb", progressive)] {
        let Some(fractions) = fractions else { continue };
        let core = core.with_precision(Precision::Reduced(Reduced::new(fractions)))?;
        found.push((name, format!("F = {fractions}"), fixed(control, level, &core)?));
    }
    Ok(found)
}

pub fn files(meshes: &[Mesh], max_level: u32) -> Result<Files> {
    let mut rows =
        vec![row(["mesh", "level", "coordinates", "numbers", "format", "largest relative deviation"])];
    let mut worst: Vec<(&str, Vec<(f64, f64)>)> = vec![];
    for mesh in meshes {
        let (control, format) = control(mesh)?;
        for level in 1..=max_level {
            for (name, fractions, deviation) in measure(&control, format, level)? {
                let (at, width) = (level.to_string(), format.to_string());
                rows.push(row([&mesh.name, &at, &width, name, &fractions, &format!("{deviation:.4e}")]));
                let place = worst.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
                    worst.push((name, vec![]));
                    worst.len() - 1
                });
                // Half precision overflows where the differences of high order are large.
                if !deviation.is_finite() {
                    continue;
                }
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
