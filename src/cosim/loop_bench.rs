//! A mesh through a `loop-fd`: what goes in, what must come out, and the surface put together again.
//!
//! ```text
//! control mesh ─► patches (host levels of the hierarchy) ─► packets ─► core ─► beats ─► fine mesh
//!                                                  └──────► model ───────────► expected beats
//! ```

use std::rc::Rc;

use super::beat::{Beat, Port};
use super::core;
use super::dut::{Dut, Latency, Stimulus};
use super::loop_traffic::Traffic;
pub use super::loop_traffic::extra_fraction;
use crate::cores::loop_fd::{AHEAD, HOP, LATER, Parameters, startup_depth};
use crate::error::{Error, Result};
use crate::hdl::skew::LEAD;
use crate::hdl::{Instance, Module, verilog};
use crate::model::lane_clocks::Lanes;
use crate::model::loop_fd_clocks;
use crate::surface::assembly::Assembly;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::fine_grid::FineGrid;
use crate::surface::hierarchy::{Counts, Patch};
use crate::surface::packets;
use crate::surface::table::Table;

/// Beats are kept for every simulator, at some 250 bytes each.
const MOST_BEATS: u64 = 1 << 25;

/// The stimulus of one mesh at one level, and the way back.
pub struct LoopBench {
    /// What goes in and what must come out; whoever runs it takes them.
    pub input: Vec<Beat>,
    pub expected: Vec<Beat>,
    pub counts: Counts,
    /// The patches without their points, in the order of the packets.
    patches: Vec<Patch<()>>,
    /// The index of each patch's first output beat.
    starts: Vec<u64>,
    output: Port,
    /// Strips at once.
    lanes: u64,
}

impl LoopBench {
    /// # Errors
    /// A level above the core's maximum, coordinates that do not fit, a mesh too large to be kept.
    pub fn new(
        core: &Rc<Module>,
        parameters: Parameters,
        mesh: &ControlMesh,
        level: u32,
    ) -> Result<LoopBench> {
        let beats = mesh.triangles().len() as u64 * depths(core).beats(level);
        if beats > MOST_BEATS {
            return Err(Error::input(format!(
                "{beats} pairs of vertices are more than can be kept and compared"
            ))
            .help(format!("choose a lower level; {MOST_BEATS} pairs are the most")));
        }
        let width = parameters.coordinates.width();
        let traffic = Traffic::new(core, parameters)?;
        let table = Table::for_width(width)?;
        let mut bench = LoopBench {
            input: vec![],
            expected: vec![],
            counts: Counts::default(),
            patches: vec![],
            starts: vec![],
            output: traffic.output.clone(),
            lanes: parameters.lanes.unwrap_or(1).into(),
        };
        let (mut failure, mut coarse) = (None, None);
        bench.counts = packets::patches(mesh, level, parameters.max_level, &table, |patch| {
            bench.input.extend(traffic.packet(patch.level, &patch.points));
            bench.starts.push(bench.expected.len() as u64);
            bench.patches.push(Patch {
                face: patch.face,
                kind: patch.kind,
                class: patch.class,
                level: patch.level,
                corners: patch.corners,
                points: [(); 12],
            });
            if patch.level < parameters.min_level {
                coarse = Some(patch.level);
            }
            if let Err(error) = traffic.answer(patch.level, &patch.points, &mut bench.expected) {
                failure.get_or_insert(error);
            }
        })?;
        if let Some(level) = coarse {
            return Err(Error::input(format!(
                "the mesh has irregular vertices: patches of level {level} lie around them"
            ))
            .help("lower --min-level to 0, or take a mesh whose vertices have valence 6 (4 at a boundary)"));
        }
        failure.map_or(Ok(bench), Err)
    }

    /// The levels of the packets, in order.
    pub fn levels(&self) -> Vec<u32> {
        self.patches.iter().map(|patch| patch.level).collect()
    }

    /// The clocks the core must take under the stalls of a stimulus.
    pub fn clocks(&self, core: &Module, stimulus: &Stimulus) -> loop_fd_clocks::Clocks {
        loop_fd_clocks::run(
            &self.levels(),
            depths(core),
            &stimulus.offer_pattern(),
            &stimulus.ready_pattern(),
        )
    }

    /// An output beat in the user's terms.
    pub fn locate(&self, beat: u64) -> String {
        let index = self.starts.partition_point(|&start| start <= beat);
        let Some(patch) = index.checked_sub(1).and_then(|i| self.patches.get(i)) else {
            return format!("beat {beat}");
        };
        let (strip, row) = self.place(index - 1, beat);
        format!(
            "patch {} (triangle {}, level {}), strip {strip}, row {row}",
            index - 1,
            patch.face,
            patch.level
        )
    }

    /// The first strip and the row of a beat of a patch: strip i has 2^level - i + 1 rows.
    fn place(&self, patch: usize, beat: u64) -> (u64, u64) {
        let (steps, mut row) = (1u64 << self.patches[patch].level, beat - self.starts[patch]);
        for strip in (0..steps).step_by(self.lanes as usize) {
            let beats = steps - strip + 1;
            if row < beats {
                return (strip, row);
            }
            row -= beats;
        }
        (steps, row)
    }

    /// The fine triangles in the order of the packets, as vertices of the grid, each with the depth of its
    /// patch in the hierarchy and the number of the patch.
    pub fn triangles(&self, grid: &FineGrid) -> (Vec<[u32; 3]>, Vec<(u8, u32)>) {
        let (mut triangles, mut owners) = (vec![], vec![]);
        for (number, patch) in self.patches.iter().enumerate() {
            let steps = patch.steps();
            let vertex = |i: i32, j: i32| {
                let [u, v] = patch.lattice(i, j);
                grid.vertex(patch.face as usize, u as usize, v as usize) as u32
            };
            for (i, j) in (0..steps).flat_map(|i| (0..steps - i).map(move |j| (i, j))) {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < steps {
                    triangles.push([vertex(i, j + 1), vertex(i + 1, j), vertex(i + 1, j + 1)]);
                }
            }
            let depth = grid.level() - patch.level;
            owners.resize(triangles.len(), (depth as u8, number as u32));
        }
        (triangles, owners)
    }

    /// The fine mesh that the hardware drew.
    pub fn assemble<'a>(
        &self,
        mesh: &'a ControlMesh,
        level: u32,
        received: &[(u64, Beat)],
    ) -> Result<Assembly<'a>> {
        let mut assembly = Assembly::new(FineGrid::new(mesh, level)?);
        let mut beats = received.iter().map(|(_, beat)| beat);
        for patch in &self.patches {
            let steps = patch.steps() as usize;
            let lanes = self.lanes as usize;
            let rows = |strip: usize| (0..=steps - strip).map(move |row| (strip, row));
            for (strip, row) in (0..steps).step_by(lanes).flat_map(rows) {
                let Some(beat) = beats.next() else { return Ok(assembly) };
                let vertex =
                    |first: usize| [0, 1, 2].map(|axis| self.output.number(beat, first + axis) as i64);
                for k in (0..=lanes).take_while(|k| strip + k + row <= steps) {
                    assembly.put(patch, strip + k, row, vertex(3 * k));
                }
            }
        }
        Ok(assembly)
    }
}

/// The depths that the core declares.
pub fn depths(core: &Module) -> loop_fd_clocks::Depths {
    let instance = |name: &str| core.instances.iter().find(|i| i.name == name);
    let declared = |name: &str| declared(core, name);
    let lanes = declared("lanes").map(|count| Lanes {
        count,
        digits: declared("digits").unwrap_or(1),
        waits: declared("waiting_patches") == Some(1),
        buffered: instance("buffer").is_some(),
    });
    let engine = instance(if lanes.is_some() { "columns_x" } else { "engine_x" });
    // One lane sends its columns on their way after the outer differences.
    let way = lanes.map_or(0, |lanes| HOP + if lanes.count == 1 { LATER } else { 0 });
    let depth_of = |i: &Instance| Some(i.module.latency(i.module.outputs.first()?));
    let buffer = instance("buffer").and_then(depth_of).map_or(0, |depth| depth - AHEAD);
    let rounder = engine.and_then(depth_of).unwrap_or(0) + way + buffer;
    let fifo = instance("output_fifo").and_then(|i| i.module.memories.first()).map_or(1, |m| m.depth);
    // A patch is there with its last digit; the first one comes a clock behind the pulse that announces it.
    let startup = match lanes.map_or(1, |lanes| lanes.digits) {
        1 => startup_depth(core),
        digits => startup_depth(core) + digits - 1 - LEAD,
    };
    loop_fd_clocks::Depths { startup, rounder, fifo, lanes }
}

/// From the last point of the first patch, of this level, to the first vertex.
pub fn latency(core: &Module, level: u32) -> u64 {
    loop_fd_clocks::run(&[level], depths(core), &[true], &[true]).latency
}

/// The core as a device under test, with the latency that its testbench asserts. Buffered columns fill their memory first,
/// which takes longer the finer the patch is: of patches of several levels nothing is asserted but all clocks together.
pub fn device(core: &Rc<Module>, files: &[verilog::SourceFile]) -> Dut {
    let level = |name: &str| declared(core, name).unwrap_or(0);
    let (coarsest, finest) = (level("min_level"), level("max_level"));
    let known = coarsest == finest || depths(core).lanes.is_none_or(|lanes| !lanes.buffered);
    let latency = known.then(|| Latency { beat: 11, clocks: latency(core, coarsest) });
    core::device(core, files, latency)
}

/// A number that the core has among its parameters.
fn declared(core: &Module, name: &str) -> Option<u32> {
    core.parameters.iter().find(|(parameter, _)| parameter == name)?.1.parse().ok()
}
