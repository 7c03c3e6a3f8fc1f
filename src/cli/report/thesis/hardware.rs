//! The generated core: what it keeps, what it computes with, and how many clocks it takes.

use std::rc::Rc;

use serde::Serialize;

use crate::cosim::strip_bench::words;
use crate::cosim::{Clocked, Model, device};
use crate::error::{Error, Kind, Result};
use crate::hdl::Module;
use crate::hdl::inventory::{Operators, Stored, stored};
use crate::surface::catmull_clark::strips::records::{Column, Guard, Outside, StripRecords};

/// Vertices that a part of the core keeps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Storage {
    pub part: String,
    /// Strip vertices and the outside vertices of the face columns, uL and uR.
    pub columns: u64,
    /// Neighbours and diagonals of the fans.
    pub fans: u64,
    /// Of all three coordinates.
    pub bits: u64,
}

/// Clocks of a long regular strip at one column of input after the other, without stalls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clocks {
    /// For each further quad of the strip.
    pub per_column: f64,
    /// From the first word that goes in to the first column that comes out.
    pub start: u64,
}

/// The coordinate that stands for all three.
const AXIS: &str = "x";

/// By part: every register and memory word of one coordinate is a vertex.
pub fn storage(core: &Rc<Module>) -> Vec<Storage> {
    let mut parts: Vec<Storage> = vec![];
    for kept in stored(core) {
        let Some(name) = part(&kept) else { continue };
        let at = parts.iter().position(|p| p.part == name).unwrap_or_else(|| {
            parts.push(Storage { part: name, ..Storage::default() });
            parts.len() - 1
        });
        let part = &mut parts[at];
        match is_fan(&kept.name) {
            true => part.fans += u64::from(kept.depth),
            false => part.columns += u64::from(kept.depth),
        }
        part.bits += 3 * kept.bits();
    }
    parts.sort_by_key(|part| part.part == "output");
    parts
}

/// The part that a register belongs to, if it holds the chosen coordinate: a level's window, or the output.
fn part(kept: &Stored) -> Option<String> {
    let is_axis = |name: &str| name.split('_').any(|word| word == AXIS);
    match kept.instance.split_once('.') {
        None => (kept.instance.is_empty() && is_axis(&kept.name)).then(|| "output".into()),
        Some((engine, window)) => is_axis(engine).then(|| window.replace("window_", "level ")),
    }
}

/// `middle_top_a_3`, `top_x_2`: a neighbour or a diagonal with its number. The only outside vertex of valence 4
/// is in uL and uR, so the whole fan is on top.
fn is_fan(name: &str) -> bool {
    let words: Vec<&str> = name.split('_').collect();
    words.windows(2).any(|pair| ["a", "x"].contains(&pair[0]) && pair[1].parse::<u32>().is_ok())
}

/// One coordinate of the finest level, in a core with a unit for each level.
pub fn operators(core: &Rc<Module>, levels: u32) -> Result<Operators> {
    let name = format!("engine_{}_{AXIS}", levels - 1);
    let unit = core.instances.iter().find(|instance| instance.name == name);
    let missing = || Error::usage(format!("{} has no instance {name}", core.name));
    Ok(Operators::of(&unit.ok_or_else(missing)?.module))
}

/// Quads of the strips whose difference counts: the start is over long before the shorter one ends.
const LENGTHS: [usize; 2] = [12, 20];

pub fn clocks(core: &Rc<Module>, levels: u32) -> Result<Clocks> {
    let [(start, short), (_, long)] =
        [clocks_of(core, levels, LENGTHS[0])?, clocks_of(core, levels, LENGTHS[1])?];
    Ok(Clocks { per_column: (long - short) as f64 / (LENGTHS[1] - LENGTHS[0]) as f64, start })
}

/// The clocks in which the first and the last column of a closed regular strip come out; the first word goes in at
/// clock 0.
fn clocks_of(core: &Rc<Module>, levels: u32, quads: usize) -> Result<(u64, u64)> {
    let dut = device(core, &[], None);
    let hidden = || Error::usage("a strip without guards");
    let input = words(&dut.input, levels, &regular_strip(quads)).ok_or_else(hidden)?;
    let mut model = Model::new(core)?;
    model.reset();
    let (mut waiting, mut first) = (input.iter().peekable(), None);
    // Every level makes its columns one by one at worst, and every word takes a clock.
    let patience = (quads as u64 + 8) << (levels + 2) | 1 << 12;
    for clock in 0..patience {
        let seen = model.clock(waiting.peek().copied(), true);
        if seen.input_ready {
            waiting.next();
        }
        if let Some(beat) = seen.output {
            let first = *first.get_or_insert(clock);
            if beat.last {
                return Ok((first, clock));
            }
        }
    }
    Err(Error::new(Kind::Mismatch, format!("a strip of {quads} quads takes more than {patience} clocks")))
}

/// A strip around a torus: every vertex has valence 4.
fn regular_strip(quads: usize) -> StripRecords<[i64; 3]> {
    let point = |column: usize, row: i64| [(column % quads) as i64, row, 0];
    let outside = |p: [i64; 3]| Outside { valence: 4, fan: vec![p], left: p, right: p, gap: None };
    let column = |c: usize| Column {
        vertices: [point(c, 1), point(c, 2)],
        outside: [point(c, 0), point(c, 3)].map(outside),
    };
    let guard =
        |c: usize| Some(Guard { vertices: [point(c, 1), point(c, 2)], outside: [point(c, 0), point(c, 3)] });
    StripRecords {
        closed: true,
        columns: (0..=quads).map(column).collect(),
        guards: [guard(quads - 1), guard(1)],
    }
}
