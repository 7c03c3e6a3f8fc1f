//! What a design and meshes have of the quantities that the thesis counts on paper.
//!
//! | quantity | where from |
//! |---|---|
//! | vertices stored | registers and memories of one coordinate, with the instances they are in |
//! | operators | the cells of one coordinate of the finest level |
//! | clocks | a closed strip of valence 4 throughout in the built-in simulator, at two lengths |
//! | words sent, pointers | strips cut from meshes |

use serde::Serialize;

use super::hardware::{Clocks, Storage, clocks, operators, storage};
use super::meshes::{OnMesh, meshes};
use crate::cores::cc_strip::{Parameters, Precision, Schedule, build};
use crate::error::Result;
use crate::fixed::Format;
use crate::hdl::inventory::Operators;
use crate::surface::catmull_clark::thesis::Quantity;

/// Everything that was counted; storage and operators of a core with a unit for each level.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    pub storage: Vec<Storage>,
    /// Of one coordinate.
    pub operators: Operators,
    pub clocks: BySchedule,
    pub meshes: Vec<OnMesh>,
}

/// The clocks of a core of each schedule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BySchedule {
    pub shared: Clocks,
    pub pipelined: Clocks,
    pub double: Clocks,
}

impl Measured {
    /// # Errors
    /// A core that does not exist.
    pub fn new(levels: u32, max_valence: u32) -> Result<Measured> {
        let coordinates = Format { integer: 12, fraction: 12 };
        let core = |schedule| {
            let exact = Parameters::exact(coordinates, levels, max_valence);
            build(Parameters { schedule, precision: Precision::Guard(4), ..exact })
        };
        let pipelined = core(Schedule::Pipelined)?;
        Ok(Measured {
            storage: storage(&pipelined),
            operators: operators(&pipelined, levels)?,
            clocks: BySchedule {
                shared: clocks(&core(Schedule::Shared)?, levels)?,
                pipelined: clocks(&pipelined, levels)?,
                double: clocks(&core(Schedule::Double)?, levels)?,
            },
            meshes: meshes()?,
        })
    }

    /// The number of vertices that the core keeps.
    pub fn vertices(&self) -> u64 {
        self.storage.iter().map(|part| part.columns + part.fans).sum()
    }

    /// The measured number beside a figure of the thesis, where there is one.
    pub fn of(&self, quantity: Quantity) -> Option<f64> {
        let adders = |operands: u32| self.operators.adders.get(&operands).copied().unwrap_or(0) as f64;
        match quantity {
            Quantity::WordsWithFans => self.meshes.last().map(|mesh| mesh.words),
            Quantity::Windows => Some(self.storage.iter().map(|s| s.columns).sum::<u64>() as f64),
            Quantity::Fans => Some(self.storage.iter().map(|s| s.fans).sum::<u64>() as f64),
            Quantity::Storage => Some(self.vertices() as f64),
            Quantity::Bytes => Some(self.storage.iter().map(|s| s.bits).sum::<u64>() as f64 / 8.0),
            Quantity::ClocksShared => Some(self.clocks.shared.per_column),
            Quantity::ClocksPipelined => Some(self.clocks.pipelined.per_column),
            Quantity::ClocksDouble => Some(self.clocks.double.per_column),
            Quantity::StartUp => Some(self.clocks.pipelined.start as f64),
            Quantity::FourInputAdders => Some(adders(4)),
            Quantity::ThreeInputAdders => Some(adders(3)),
            Quantity::FanAdders => {
                Some(self.operators.adders.range(5..).map(|(_, count)| count).sum::<u64>() as f64)
            }
            // Every other multiplier takes its factor from a table.
            Quantity::MultipliersByThird => {
                Some(self.operators.multipliers as f64 - self.operators.tables.len() as f64)
            }
            Quantity::Multipliers => Some(self.operators.multipliers as f64),
            Quantity::Tables => Some(self.operators.tables.len() as f64),
            Quantity::TableEntries => self.operators.tables.first().map(|&entries| entries as f64),
            // Shifts are wiring, and the others are no property of a core.
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::catmull_clark::thesis;

    #[test]
    fn the_clocks_are_those_of_the_formulas() {
        let measured = Measured::new(5, 10).unwrap();
        let clocks = [Quantity::ClocksShared, Quantity::ClocksPipelined, Quantity::ClocksDouble];
        assert_eq!(clocks.map(|q| measured.of(q)), [62.0, 32.0, 16.0].map(Some));
    }

    #[test]
    fn what_is_kept_is_counted_once_for_all_coordinates() {
        let measured = Measured::new(5, 10).unwrap();
        let part = |name: &str| measured.storage.iter().find(|p| p.part == name).unwrap().clone();
        // Three columns of two vertices, five of uL and uR at each end, two fans of six pairs at each end.
        let first = part("level 0");
        assert_eq!((first.columns, first.fans), (3 * 2 + 2 * 5, 2 * 2 * 12));
        // The two rows of the previous column are sums, a bit more each.
        assert_eq!(first.bits, 3 * (24 * (16 + 48) + 2));
        assert_eq!((part("level 4").columns, part("level 4").fans), (3 * 17 + 2 * 5, 2 * 12));
        assert_eq!((part("output").columns, part("output").fans), (33, 0));
        assert_eq!(measured.vertices(), 335);
        let lean = thesis::lean_storage_vertices(5, 10) + thesis::lean_storage_extra(5);
        assert!(measured.vertices() <= lean, "{lean}");
    }

    #[test]
    fn the_irregular_vertices_take_two_multipliers_and_one_table_an_end() {
        for (valence, entries) in [(4, 2), (6, 4), (10, 8)] {
            let measured = Measured::new(2, valence).unwrap();
            assert_eq!(measured.operators.multipliers, thesis::operators(2, valence).multipliers);
            assert_eq!(measured.operators.tables, [entries; 2]);
        }
    }
}
