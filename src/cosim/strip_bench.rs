//! A strip of quads through a `cc-strip`: the words that go in, the columns that come out.
//!
//! ```text
//! column  =  top vertex, what lies outside of it, bottom vertex, what lies outside of it
//! strip   =  left guard, columns 0 .. M, right guard
//! ```

use std::rc::Rc;

use super::core::port;
use super::strip_lanes::Lanes;
use crate::cores::cc_strip::buffer::{LOG_NEAR, NEAR, WRITTEN};
use crate::cores::cc_strip::buffered::{LEAVES, rounding};
use crate::cores::cc_strip::control::WALKS;
use crate::cores::cc_strip::finish::Kind;
use crate::cores::cc_strip::sending::PERIOD;
use crate::cores::cc_strip::{Parameters, Precision, Role, Schedule};
use crate::cosim::{Beat, Port, Stimulus};
use crate::error::{Error, Result};
use crate::hdl::{Direction, Module};
use crate::model::cc_strip::{self as reference, CcStrip};
use crate::model::cc_strip_clocks;
use crate::surface::catmull_clark::assembly::QuadAssembly;
use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::numbers::Numbers;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::Rings;
use crate::surface::catmull_clark::strips::records::{Guard, Outside, StripRecords, records};
use crate::surface::catmull_clark::strips::statistics::Statistics;
use crate::surface::catmull_clark::strips::{Method, Strip, cut};

type Point = [i64; 3];

/// A quad mesh through a core: the words of all strips, and the columns that must come out.
pub struct StripBench {
    /// What goes in and what must come out; whoever runs it takes them.
    pub input: Vec<Beat>,
    pub expected: Vec<Beat>,
    pub statistics: Statistics,
    strips: Vec<Strip>,
    /// How often the strips are subdivided.
    level: u32,
    lanes: Lanes,
    output: Port,
    /// The strips as the protocol sees them.
    traffic: Vec<cc_strip_clocks::Strip>,
    core: Option<cc_strip_clocks::Core>,
}

impl StripBench {
    /// # Errors
    /// Numbers that the reference does not take, a valence above the core's, a strip without guards.
    pub fn new(
        core: &Rc<Module>,
        parameters: Parameters,
        level: u32,
        mesh: &QuadMesh,
        rings: &Rings,
    ) -> Result<StripBench> {
        let [input, output] =
            [("s_axis", Direction::Input), ("m_axis", Direction::Output)].map(|(n, d)| port(core, n, d));
        let reference = CcStrip::new(reference_parameters(parameters))?;
        let strips = cut(mesh, Method::Natural);
        let numbers: Vec<_> = strips.iter().map(|strip| records(mesh, rings, strip)).collect();
        let statistics = Statistics::of(mesh.vertex_count(), &strips, &numbers);
        let mut bench = StripBench {
            input: vec![],
            expected: vec![],
            statistics,
            strips,
            level,
            lanes: Lanes::new(parameters, level),
            output,
            traffic: vec![],
            core: parameters.longitudinal.is_none().then(|| protocol(core, parameters)),
        };
        for strip in numbers {
            let strip = strip.map(|&vertex| rings.positions()[vertex as usize]);
            let words = words(&input, level, &strip).ok_or_else(|| {
                Error::input("a strip ends at a boundary where no ghosts can stand")
                    .help("the core needs a column beyond each end of a strip")
            })?;
            bench.traffic.push(traffic(level, &words));
            bench.input.extend(words);
            bench.expected.extend(bench.lanes.beats(&bench.output, &reference.columns(level, &strip)?));
        }
        Ok(bench)
    }

    /// The clocks the core must take under the stalls of a stimulus; not known of row-major output.
    pub fn clocks(&self, stimulus: &Stimulus) -> Option<u64> {
        let (offer, ready) = (stimulus.offer_pattern(), stimulus.ready_pattern());
        self.core.map(|core| cc_strip_clocks::run(core, &self.traffic, &offer, &ready))
    }

    /// The strips that the mesh was cut into.
    pub fn strips(&self) -> &[Strip] {
        &self.strips
    }

    /// An output beat in the user's terms.
    pub fn locate(&self, beat: u64) -> String {
        let mut rest = beat as usize;
        for (index, strip) in self.strips.iter().enumerate() {
            let beats = self.lanes.of_strip((strip.len() << self.level) + 1);
            if let Some((_, column, row)) = beats.get(rest).and_then(|places| places.first()) {
                return format!("strip {index}, column {column}, from row {row}");
            }
            rest -= beats.len();
        }
        format!("beat {beat}")
    }

    /// The fine mesh that the hardware drew.
    ///
    /// # Errors
    /// A level that is too fine for any mesh.
    pub fn assemble<'a>(&self, mesh: &'a QuadMesh, received: &[(u64, Beat)]) -> Result<QuadAssembly<'a>> {
        let grid = QuadGrid::new(mesh, self.level)?;
        let mut assembly = QuadAssembly::new(QuadGrid::new(mesh, self.level)?);
        let mut beats = received.iter().map(|(_, beat)| beat);
        for strip in &self.strips {
            for places in self.lanes.of_strip((strip.len() << self.level) + 1) {
                let Some(beat) = beats.next() else { return Ok(assembly) };
                for (lane, column, row) in places {
                    let position = [0, 1, 2].map(|axis| self.output.number(beat, 3 * lane + axis) as i64);
                    assembly.put(strip.fine_vertex(&grid, column, row), position);
                }
            }
        }
        Ok(assembly)
    }
}

/// The core as its protocol sees it.
pub fn protocol(core: &Module, parameters: Parameters) -> cc_strip_clocks::Core {
    // A bit goes along with a column through every register of the finishing stage.
    let stages = core.nodes.iter().filter(|n| n.name.as_deref().is_some_and(|n| n.starts_with("finishing_")));
    cc_strip_clocks::Core {
        levels: parameters.levels,
        schedule: match parameters.schedule {
            Schedule::Shared => reference::schedule::Schedule::Shared,
            Schedule::Pipelined => reference::schedule::Schedule::Pipelined,
            Schedule::Double => reference::schedule::Schedule::Double,
        },
        folded: parameters.folded,
        rows_per_clock: parameters.rows_per_clock,
        finish: parameters.finish().map(|_| stages.count() as u32),
        buffer: buffer(core),
        walks: [0, 1, 2, 3, 4, 5, 6].map(|level| most(core, level, WALKS)),
        periods: [0, 1, 2, 3, 4, 5, 6].map(|level| match most(core, level, PERIOD) {
            0 => 0,
            last => last + 1,
        }),
    }
}

/// The most that a register of the control of a level counts to; 0 where there is none.
fn most(core: &Module, level: usize, register: &str) -> u32 {
    let name = format!("control_{level}");
    let control = core.instances.iter().find(|instance| instance.name == name);
    let count = control
        .and_then(|control| control.module.nodes.iter().find(|node| node.name.as_deref() == Some(register)));
    count.map_or(0, |count| count.word.range.max as u32)
}

/// The buffer of a registered core: its depth, and how far each level's data are behind their control.
fn buffer(core: &Module) -> Option<cc_strip_clocks::Buffer> {
    let placed = core.instances.iter().find(|instance| instance.name == "flags_buffer")?;
    let node = |name: &str| placed.module.nodes.iter().find(|node| node.name.as_deref() == Some(name));
    let deep = placed.module.instances.iter().any(|instance| instance.name == NEAR);
    let delay = |level: usize| {
        let name = format!("{LEAVES}{level}");
        let flag = core.nodes.iter().find(|node| node.name.as_deref() == Some(&name));
        flag.and_then(|flag| flag.time).map_or(0, |time| time + rounding(deep))
    };
    let delays = [1, 2, 3, 4, 5, 6, 7].map(delay);
    let words = node(WRITTEN)?.word.range.max as u32 + 1;
    Some(cc_strip_clocks::Buffer { delays, words, near: deep.then_some(1 << LOG_NEAR) })
}

/// The words of a strip, column by column.
pub fn traffic(level: u32, words: &[Beat]) -> cc_strip_clocks::Strip {
    let ends: Vec<usize> =
        (0..words.len()).filter(|&at| words[at].user >> 7 & 1 == 1).map(|at| at + 1).collect();
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let words = ends.iter().zip(starts).map(|(end, start)| (end - start) as u32).collect();
    cc_strip_clocks::Strip { level, words }
}

/// The reference of a core with these parameters.
pub fn reference_parameters(parameters: Parameters) -> reference::Parameters {
    reference::Parameters {
        max_levels: parameters.levels,
        max_valence: parameters.max_valence,
        numbers: match parameters.precision {
            Precision::Exact => Numbers::Exact,
            Precision::Guard(bits) => Numbers::Guard(bits),
        },
        table_bits: parameters.table_bits,
        extra_fraction: parameters.output_fraction as i32 - parameters.coordinates.fraction as i32,
        limit: parameters.limit,
        rounding: parameters.rounding,
        normals: parameters.normals.map(|n| reference::normals::Normals {
            kind: match n.kind {
                Kind::Faces => reference::normals::Kind::Faces,
                Kind::Limit => reference::normals::Kind::Limit,
            },
            extra_fraction: n.point_fraction as i32 - parameters.coordinates.fraction as i32,
            unit: n.unit,
        }),
        ..reference::Parameters::exact(parameters.coordinates.width())
    }
}

/// The words of a strip with guards at both ends, in the shape of the core's input port.
///
/// Nothing for a strip with rims: it has columns that no guard stands beside.
pub fn words(port: &Port, level: u32, strip: &StripRecords<Point>) -> Option<Vec<Beat>> {
    let [Some(left), Some(right)] = &strip.guards else { return None };
    let mut words = vec![];
    guard(port, left, Role::OutsideRight, &mut words);
    words[0].user |= u64::from(level) << 8;
    for column in &strip.columns {
        for (vertex, outside) in column.vertices.iter().zip(&column.outside) {
            words.push(word(port, Role::Vertex, outside.valence, vertex));
            words.extend(surroundings(port, outside));
        }
        end_column(&mut words);
    }
    guard(port, right, Role::OutsideLeft, &mut words);
    if let Some(last) = words.last_mut() {
        last.last = true;
    }
    Some(words)
}

/// The fan of a vertex; with valence 3, which has none, the outside vertices of the face columns beside it.
fn surroundings(port: &Port, outside: &Outside<Point>) -> Vec<Beat> {
    if outside.valence == 3 {
        let sides = [(Role::OutsideLeft, &outside.left), (Role::OutsideRight, &outside.right)];
        return sides.map(|(role, vertex)| word(port, role, 0, vertex)).to_vec();
    }
    outside.fan.iter().map(|vertex| word(port, Role::Fan, 0, vertex)).collect()
}

fn guard(port: &Port, guard: &Guard<Point>, side: Role, words: &mut Vec<Beat>) {
    for (vertex, outside) in guard.vertices.iter().zip(&guard.outside) {
        words.push(word(port, Role::Vertex, 4, vertex));
        words.push(word(port, side, 0, outside));
    }
    end_column(words);
}

fn end_column(words: &mut [Beat]) {
    if let Some(word) = words.last_mut() {
        word.user |= 1 << 7;
    }
}

fn word(port: &Port, role: Role, valence: u32, vertex: &Point) -> Beat {
    let mut beat = port.beat_of(&vertex.map(i128::from));
    beat.user = role as u64 | u64::from(valence) << 2;
    beat
}
