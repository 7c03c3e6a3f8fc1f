//! A control mesh evaluated on a board: the units around `loop-fd`, down to the pin of a serial line.
//!
//! ```text
//!              ┌───────────────────────── mesh_evaluator ─────────────────────────┐
//!              │ ┌──────────────┐  control   ┌─────────┐  vertices   ┌──────────┐ │ vertex   ┌──────┐
//! start ──────►│ │ patch_source │──────────► │ loop_fd │───────────► │ numbers  │ │────────► │ sink │──► pins
//!              │ │ (block RAM)  │  points    └─────────┘  of strips  │ patches  │ │ stream   └──────┘
//!              │ └──────────────┘                                    └──────────┘ │
//!              └──────────────────────────────────────────────────────────────────┘
//! ```
//!
//! **The vertex stream** ([`VertexStream`]) is what any sink takes: two vertices of a strip a beat, in the
//! order of `loop-fd`, between plain `valid` and `ready`. A beat moves at an edge where both are 1; `valid`
//! never waits for `ready`, and a beat stands still until it is taken.
//!
//! | signal | meaning |
//! |---|---|
//! | `left_x`, `left_y`, `left_z` | p(i,j), signed, in units of the output format |
//! | `right_x`, `right_y`, `right_z` | p(i+1,j); meaningless where `pair` is 0 |
//! | `pair` | 1: two vertices; 0: the left one alone, which ends a strip |
//! | `strip_end` | last beat of a strip |
//! | `patch_start`, `patch_end` | first and last beat of a patch |
//! | `mesh_start`, `mesh_end` | first and last beat of the mesh |
//!
//! **A sink** is a module with the stream as inputs `vertex_...` and the outputs `ready` and `busy`. What other
//! ports it has are its own affair: [`top`] leads them to the outside under their names. The one here is
//! [`serial_sink`], a frame with a checksum over a UART; a video output that keeps a frame buffer would take its
//! place without a change to anything else.

mod button;
mod crc32;
mod evaluator;
mod patch_source;
pub mod serial_sink;
pub mod top;
mod uart_transmitter;

use crate::hdl::{Builder, Signal, Word};

use super::loop_fd::{AXES, Parameters};

pub use evaluator::build as evaluator;
pub use uart_transmitter::{FEWEST_CLOCKS, MOST_CLOCKS, build as uart_transmitter};

/// A mesh as the patch source keeps it: the distinct control points once, and twelve of them for each patch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Patches {
    /// Control points, each with the fraction bits of its level, modulo the width of the core.
    pub points: Vec<[i128; 3]>,
    /// The level of each patch.
    pub levels: Vec<u32>,
    /// Twelve indices into `points` for each patch, in the order of `loop-fd`.
    pub corners: Vec<[u32; 12]>,
}

/// The flags of a beat, in the order in which they are declared.
pub const FLAGS: [&str; 6] = ["pair", "strip_end", "patch_start", "patch_end", "mesh_start", "mesh_end"];

/// The signals of one beat; the other table of this page says what they mean.
pub struct VertexStream {
    /// Left x, y, z, then right x, y, z.
    pub coordinates: Vec<Signal>,
    /// In the order of [`FLAGS`].
    pub flags: Vec<Signal>,
    pub valid: Signal,
}

/// `left_x` .. `right_z`.
pub fn coordinate_names() -> Vec<String> {
    ["left", "right"].iter().flat_map(|side| AXES.map(|axis| format!("{side}_{axis}"))).collect()
}

impl VertexStream {
    /// The input ports of a sink.
    #[track_caller]
    pub fn inputs(m: &Builder, parameters: Parameters) -> VertexStream {
        let word = coordinate(parameters);
        VertexStream {
            coordinates: coordinate_names().iter().map(|n| m.input(format!("vertex_{n}"), word)).collect(),
            flags: FLAGS.iter().map(|name| m.input(format!("vertex_{name}"), Word::bit())).collect(),
            valid: m.input("vertex_valid", Word::bit()),
        }
    }

    /// The flag of this name.
    pub fn flag(&self, name: &str) -> &Signal {
        // The names are those of this module, never a user's; a wrong one shows in the first test.
        &self.flags[FLAGS.iter().position(|flag| *flag == name).unwrap_or(0)]
    }

    /// Names and signals, as an instance takes them.
    pub fn ports(&self) -> Vec<(String, Signal)> {
        let names = coordinate_names().into_iter().chain(FLAGS.map(String::from));
        let signals = self.coordinates.iter().chain(&self.flags).cloned();
        let mut ports: Vec<_> = names.zip(signals).collect();
        ports.push(("valid".into(), self.valid.clone()));
        ports.into_iter().map(|(name, signal)| (format!("vertex_{name}"), signal)).collect()
    }
}

/// A coordinate of a vertex.
pub fn coordinate(parameters: Parameters) -> Word {
    Word::from(parameters.output_range()).fraction(parameters.output_fraction as i32)
}
