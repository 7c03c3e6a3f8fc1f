//! From real coordinates to the integers that the hardware sees.
//!
//! ```text
//! q = floor(x 2^f + 1/2)     in  -2^(i+f-1) .. 2^(i+f-1) - 1      for the format Qi.f
//! ```

use super::Mesh;
use crate::error::{Error, Result};
use crate::fixed::Format;
use glam::DVec3;

/// A mesh with coordinates in units of 2^-f.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantisedMesh {
    pub format: Format,
    /// Each within the range of the format.
    pub positions: Vec<[i64; 3]>,
    pub faces: Vec<Vec<u32>>,
    pub rounding: Rounding,
}

/// What quantising changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// How many coordinates are no multiples of the unit and were rounded.
    pub coordinates: usize,
    /// The largest change of a coordinate, at most half a unit.
    pub largest: f64,
}

impl Rounding {
    pub fn is_exact(self) -> bool {
        self.coordinates == 0
    }
}

/// The mesh in a fixed-point format, coordinates rounded half up.
///
/// # Errors
/// Names the first vertex with a coordinate outside the format, its place, and the format that holds it.
pub fn quantise(mesh: &Mesh, format: Format) -> Result<QuantisedMesh> {
    let mut rounding = Rounding::default();
    let mut positions = Vec::with_capacity(mesh.positions.len());
    for (v, position) in mesh.positions.iter().enumerate() {
        let mut point = [0; 3];
        for (q, (axis, x)) in point.iter_mut().zip(["x", "y", "z"].into_iter().zip(position.to_array())) {
            *q = format.quantise(x).ok_or_else(|| too_large(mesh, v as u32, axis, x, format))?;
            let change = (*q as f64 * format.lsb() - x).abs();
            rounding.coordinates += usize::from(change > 0.0);
            rounding.largest = rounding.largest.max(change);
        }
        positions.push(point);
    }
    Ok(QuantisedMesh { format, positions, faces: mesh.faces.clone(), rounding })
}

fn too_large(mesh: &Mesh, v: u32, axis: &str, x: f64, format: Format) -> Error {
    let range = format!("{} to {}", format.decimal(format.min()), format.decimal(format.max()));
    let what = format!(
        "the {axis} coordinate {x} of vertex {} does not fit {format}, which holds {range}",
        mesh.vertex_number(v)
    );
    // Wider in the integer bits first, so that no precision is lost; else fewer fraction bits.
    let wider = (format.integer + 1..=Format::WIDEST).find_map(|integer| {
        let fraction = format.fraction.min(Format::WIDEST - integer);
        Format::new(integer, fraction).filter(|&wider| holds(mesh, wider))
    });
    let help = match wider {
        Some(wider) => {
            format!("use {wider}, the smallest format that holds this mesh, or scale the mesh down")
        }
        None => format!("no format of {} bits holds this mesh: scale it down", Format::WIDEST),
    };
    Error::input(what).at(mesh.vertex_place(v)).help(help)
}

/// The format of `width` bits with the most fraction bits whose range holds the mesh.
///
/// # Errors
/// When no format of that width does: names the vertex that is furthest out.
pub fn widest_format(mesh: &Mesh, width: u32) -> Result<Format> {
    let mut formats = (1..=width).filter_map(|integer| Format::new(integer, width - integer));
    formats.clone().find(|&format| holds(mesh, format)).ok_or_else(|| {
        let Some(widest) = formats.next_back() else {
            let allowed = format!("coordinates have 2 to {} bits", Format::WIDEST);
            return Error::usage(format!("there is no format of {width} bits")).help(allowed);
        };
        match quantise(mesh, widest) {
            Err(error) => error,
            Ok(_) => Error::input(format!("no format of {width} bits holds this mesh")).at(mesh.place()),
        }
    })
}

fn holds(mesh: &Mesh, format: Format) -> bool {
    let fits = |p: DVec3| p.to_array().into_iter().all(|x| format.quantise(x).is_some());
    mesh.bounds().is_none_or(|(low, high)| fits(low) && fits(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(xs: &[f64]) -> Mesh {
        Mesh::new("m", xs.iter().map(|&x| DVec3::new(0.0, x, 0.0)).collect(), vec![vec![0, 1, 2]])
    }

    fn format(text: &str) -> Format {
        text.parse().unwrap()
    }

    #[test]
    fn rounding_is_half_up_and_reported() {
        let quantised = quantise(&mesh(&[0.5, -0.375, 0.3125]), format("Q2.2")).unwrap();
        let ys: Vec<i64> = quantised.positions.iter().map(|p| p[1]).collect();
        assert_eq!(ys, [2, -1, 1]);
        assert_eq!(quantised.rounding, Rounding { coordinates: 2, largest: 0.125 });
        assert!(quantise(&mesh(&[0.5, -0.25]), format("Q2.2")).unwrap().rounding.is_exact());
    }

    #[test]
    fn a_coordinate_outside_names_itself_and_the_format_that_holds_it() {
        let error = quantise(&mesh(&[0.0, -3.0, 5.0]), format("Q2.4")).unwrap_err();
        let what = "the y coordinate -3 of vertex 1 does not fit Q2.4, which holds -2 to 1.9375";
        assert_eq!(error.what, what);
        assert!(error.help.unwrap().contains("use Q4.4,"));
        let error = quantise(&mesh(&[0.0, 1e6]), format("Q2.24")).unwrap_err();
        assert!(error.help.unwrap().contains("use Q21.11,"));
        assert!(
            quantise(&mesh(&[1e300]), format("Q2.4")).unwrap_err().help.unwrap().contains("scale it down")
        );
    }

    #[test]
    fn the_widest_format_uses_the_true_range() {
        assert_eq!(widest_format(&mesh(&[-1.0, 0.99]), 24).unwrap(), format("Q1.23"));
        assert_eq!(widest_format(&mesh(&[-1.5, 0.5]), 24).unwrap(), format("Q2.22"));
        assert_eq!(widest_format(&mesh(&[-1.0, 1.0]), 24).unwrap(), format("Q2.22"));
        assert_eq!(widest_format(&mesh(&[1e9]), 24).unwrap_err().place.as_deref(), Some("m, vertex 0"));
        assert!(widest_format(&mesh(&[0.0]), 99).is_err());
    }
}
