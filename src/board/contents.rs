//! What a mesh puts into the memories of the patch source, and what must come out of the line.
//!
//! ```text
//! control mesh ─► packets (levels of the hierarchy) ─┬─► distinct points, twelve indices a packet    ROM
//!                                                    └─► reference of the core ─► frame ─► bytes     expected
//! ```

use std::collections::BTreeMap;

use super::frame::{self, Frame};
use crate::cores::board::Patches;
use crate::cores::board::serial_sink::{Header, coordinate_bytes};
use crate::cores::loop_fd::Parameters;
use crate::cosim::loop_bench::extra_fraction;
use crate::error::{Error, Result};
use crate::model::loop_fd::LoopFd;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::packets;
use crate::surface::table::Table;

/// Points, and beats, beyond which no device holds a mesh or nobody waits for it.
const MOST: usize = 1 << 20;

/// The memories and the frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents {
    pub patches: Patches,
    pub frame: Frame,
}

/// Evaluates the mesh at a level.
///
/// # Errors
/// A level above the core's, coordinates that do not fit, a mesh larger than any board holds.
pub fn contents(parameters: Parameters, mesh: &ControlMesh, level: u32) -> Result<Contents> {
    let width = parameters.coordinates.width();
    let model = LoopFd::new(width, extra_fraction(parameters), parameters.max_level)?
        .with_precision(parameters.precision)?;
    let triangles = mesh.triangles().len();
    let beats = triangles.saturating_mul(LoopFd::beat_count(level.min(packets::MAX_LEVEL)));
    if beats > MOST || triangles.saturating_mul(12) > MOST {
        return Err(Error::input(format!(
            "{triangles} triangles at level {level} are {beats} pairs of vertices"
        ))
        .help(format!("choose a lower level or a smaller mesh; {MOST} pairs are the most")));
    }
    let (mut patches, mut known, mut beats) = (Patches::default(), BTreeMap::new(), vec![]);
    let mut failure = None;
    packets::patches(mesh, level, parameters.max_level, &Table::for_width(width)?, |patch| {
        let index = patch.points.map(|point| {
            *known.entry(point).or_insert_with(|| {
                patches.points.push(point);
                patches.points.len() as u32 - 1
            })
        });
        patches.corners.push(index);
        patches.levels.push(patch.level);
        if let Err(error) = model.for_each_beat(patch.level, &patch.points, |beat| beats.push(beat)) {
            failure.get_or_insert(error);
        }
    })?;
    if let Some(error) = failure {
        return Err(error);
    }
    let pairs = beats.iter().filter(|beat| beat.right.is_some()).count();
    let bytes = coordinate_bytes(parameters);
    let length = frame::length(bytes as usize, beats.len(), pairs);
    let header = Header {
        integer: parameters.coordinates.integer as u8,
        fraction: parameters.output_fraction as u8,
        coordinate_bytes: bytes as u8,
        level: level as u8,
        patches: patches.levels.len() as u32,
        beats: beats.len() as u32,
        length: length as u32,
    };
    Ok(Contents { patches, frame: Frame { header, beats } })
}
