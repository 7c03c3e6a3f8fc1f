//! What a picture shows (plain data) and how it is made.

use crate::error::{Error, Result};
use glam::DVec3;

/// A surface to be drawn. Lengths are in any unit: the camera frames what it is given.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub positions: &'a [DVec3],
    /// Three positions each, counterclockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    pub normals: Normals<'a>,
    pub colouring: Colouring<'a>,
    /// Drawn as thin lines over the surface; what lies behind the surface is faint.
    pub control: Option<Wire<'a>>,
}

#[derive(Clone, Copy, Debug)]
pub enum Normals<'a> {
    /// The sum of the normals of the triangles around a vertex, weighted by their areas.
    Smooth,
    /// The normal of each triangle: every facet is seen.
    Flat,
    /// One for each position; they need no unit length.
    Given(&'a [DVec3]),
}

#[derive(Clone, Copy, Debug)]
pub enum Colouring<'a> {
    /// Porcelain outside, terracotta inside.
    Plain,
    /// A heat map of one number for each position.
    Values {
        values: &'a [f64],
        /// The numbers at the two ends of the map.
        range: [f64; 2],
        /// What the numbers are, in a few words with the unit: "error (lsb)".
        title: &'a str,
    },
    /// One patch for each triangle: the piecewise polynomial structure of a subdivision surface
    /// (Bischoff, Kobbelt, Seidel 2000, figure 6).
    Patches(&'a [Patch]),
    /// The number of a strip for each triangle: strips beside each other get different colours.
    Strips(&'a [u32]),
}

/// The polynomial patch that a triangle of the fine mesh belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Patch {
    /// 0 in a regular patch; around an irregular vertex the number of subdivisions until it became regular.
    pub depth: u8,
    /// Tells the patches apart: a line is drawn wherever it changes. Patches of one layer that follow each
    /// other get different shades.
    pub number: u32,
}

/// Straight edges between positions.
#[derive(Clone, Copy, Debug)]
pub struct Wire<'a> {
    pub positions: &'a [DVec3],
    pub edges: &'a [[u32; 2]],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// Soft light from large lamps on a matt body with a light glaze.
    Studio,
    /// A dark mirror under parallel lines of light (Bischoff, Kobbelt, Seidel 2000, figure 18): the lines are
    /// as smooth as the normals, one order less than the surface.
    ReflectionLines,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Z,
}

#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Pixels, 16 to 16384.
    pub width: usize,
    pub height: usize,
    pub finish: Finish,
    /// The axis that points up; without it the y axis, or for something clearly flat the axis it is flat along.
    pub up: Option<Axis>,
    /// Threads to work with; without it as many as the machine runs. The picture does not depend on it.
    pub threads: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Options { width: 1280, height: 960, finish: Finish::Studio, up: None, threads: None }
    }
}

impl Options {
    pub(super) fn check(&self) -> Result<()> {
        let sizes = 16..=16384;
        if sizes.contains(&self.width) && sizes.contains(&self.height) {
            return Ok(());
        }
        Err(Error::usage(format!("no picture has {} by {} pixels", self.width, self.height))
            .help("use 16 to 16384 pixels each way"))
    }
}

impl Scene<'_> {
    /// Refuses what cannot be drawn.
    ///
    /// # Errors
    /// `Input`: nothing to draw, an index without a position, a coordinate that is no number, or a list whose
    /// length does not fit the mesh.
    pub(super) fn check(&self) -> Result<()> {
        if self.triangles.is_empty() {
            return Err(
                Error::input("a picture of no triangles").help("give a mesh with at least one triangle")
            );
        }
        finite("position", self.positions)?;
        indices("triangle", self.triangles, self.positions.len())?;
        if let Some(wire) = &self.control {
            finite("control point", wire.positions)?;
            indices("control edge", wire.edges, wire.positions.len())?;
        }
        if let Normals::Given(normals) = self.normals {
            finite("normal", normals)?;
            same_length("normals", normals.len(), "positions", self.positions.len())?;
        }
        match self.colouring {
            Colouring::Plain => Ok(()),
            Colouring::Values { values, range, .. } => {
                same_length("values", values.len(), "positions", self.positions.len())?;
                if values.iter().chain(&range).all(|value| value.is_finite()) {
                    return Ok(());
                }
                Err(Error::input("a value of the heat map is no finite number"))
            }
            Colouring::Patches(patches) => {
                same_length("patches", patches.len(), "triangles", self.triangles.len())
            }
            Colouring::Strips(strips) => {
                same_length("strips", strips.len(), "triangles", self.triangles.len())
            }
        }
    }
}

fn finite(what: &str, points: &[DVec3]) -> Result<()> {
    match points.iter().position(|point| !point.is_finite()) {
        Some(index) => Err(Error::input(format!("{what} {index} is no finite number"))),
        None => Ok(()),
    }
}

fn indices<const N: usize>(what: &str, lists: &[[u32; N]], count: usize) -> Result<()> {
    match lists.iter().position(|list| list.iter().any(|&index| index as usize >= count)) {
        Some(at) => Err(Error::input(format!("{what} {at} names a point that does not exist"))),
        None => Ok(()),
    }
}

fn same_length(what: &str, count: usize, per: &str, wanted: usize) -> Result<()> {
    if count == wanted {
        return Ok(());
    }
    Err(Error::input(format!("{count} {what} for {wanted} {per}")))
}
