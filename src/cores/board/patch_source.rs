//! A mesh in block RAM, read out as packets for `loop-fd`.
//!
//! ```text
//! beat ──► corners ROM ──► point index ──► x, y, z ROMs ──► s_axis of the core
//!          12 a patch                      distinct points
//! clock    0               1               2
//! ```
//!
//! Both reads advance together, whenever the beat at the output is taken or there is none.

use std::rc::Rc;

use super::Patches;
use crate::cores::loop_fd::{AXES, LEVEL_BITS, Parameters};
use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

/// Points of a packet.
const POINTS: i128 = 12;

/// Inputs: `start`, which begins the mesh while it rests, and `ready`. Outputs: `valid`, `last`, `level`, and
/// `point_x`, `point_y`, `point_z`.
pub fn build(parameters: Parameters, patches: &Patches) -> Result<Rc<Module>> {
    let m = Builder::new("patch_source");
    let (patch_count, beat_count) = (patches.levels.len() as i128, POINTS * patches.levels.len() as i128);
    m.purpose(format!(
        "{patch_count} patches in block RAM: {} distinct control points and",
        patches.points.len()
    ));
    m.purpose("twelve of them for each patch, sent as packets for loop_fd.");
    let [start, ready] = ["start", "ready"].map(|name| m.input(name, Word::bit()));

    let running = m.register_reset("running", Word::bit(), 0);
    let beat = m.register_reset("beat", Word::range(0, beat_count - 1), 0);
    let corner = m.register_reset("corner", Word::range(0, POINTS - 1), 0);
    let patch = m.register_reset("patch", Word::range(0, (patch_count - 1).max(1)), 0);
    let valid = m.register_reset("valid", Word::bit(), 0);
    let advance = m.wire("advance", !&valid | &ready);
    let issue = m.wire("issue", &running & &advance);
    let last_corner = m.wire("last_corner", m.is(&corner, POINTS - 1));
    let last_beat = m.wire("last_beat", m.is(&beat, beat_count - 1));

    m.on(&(&issue & &last_beat), &running, m.bit(false));
    m.on(&start, &running, m.bit(true));
    m.on(&(&issue & &last_beat), &beat, m.constant(0, beat.word()));
    m.on(&issue, &beat, m.wrap(&beat + 1, beat.word()));
    m.on(&(&issue & &last_corner), &corner, m.constant(0, corner.word()));
    m.on(&issue, &corner, m.wrap(&corner + 1, corner.word()));
    m.on(&(&issue & &last_beat), &patch, m.constant(0, patch.word()));
    m.on(&(&issue & &last_corner), &patch, m.wrap(&patch + 1, patch.word()));

    // A ROM of one word would have an address of no bits.
    let point_count = patches.points.len().max(2);
    let index_word = Word::range(0, point_count as i128 - 1);
    let indices = patches.corners.iter().flatten().map(|&index| index.into()).collect();
    let corners = m.memory("corners", beat_count as u32, index_word, indices);
    let index = m.restart(&corners.read("point_index", &beat, Some(&advance)), 0);
    let level_word = Word::range(0, parameters.max_level.into());
    let patch_depth = patch_count.max(2) as u32;
    let levels = m.memory("levels", patch_depth, level_word, padded(&patches.levels, patch_depth));
    let level_read = m.restart(&levels.read("level_read", &patch, Some(&advance)), 0);

    // What goes beside the two reads.
    let valid_index = m.register_reset("valid_index", Word::bit(), 0);
    m.on(&advance, &valid_index, &running);
    m.on(&advance, &valid, &valid_index);
    let [last_index, last] = ["last_index", "last"].map(|name| m.register_reset(name, Word::bit(), 0));
    m.on(&advance, &last_index, &last_corner);
    m.on(&advance, &last, &last_index);
    let level = m.register("level", level_word);
    m.on(&advance, &level, &level_read);

    let word = Word::modular(parameters.modulus());
    for (axis, name) in AXES.iter().enumerate() {
        let mut column: Vec<i128> = patches.points.iter().map(|p| word.range.wrap(p[axis])).collect();
        column.resize(point_count, 0);
        let rom = m.memory(&format!("points_{name}"), point_count as u32, word, column);
        let read = rom.read(&format!("point_{name}"), &index, Some(&advance));
        m.output(format!("point_{name}"), m.restart(&read, 0));
    }
    m.output("level", m.wrap(&level, Word::unsigned(LEVEL_BITS)));
    m.output("last", &last);
    m.output("valid", &valid);
    m.finish()
}

fn padded(levels: &[u32], depth: u32) -> Vec<i128> {
    let mut words: Vec<i128> = levels.iter().map(|&level| level.into()).collect();
    words.resize(depth as usize, 0);
    words
}
