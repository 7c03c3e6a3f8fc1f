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
use crate::cores::cc_strip::{Parameters, Precision, build};
use crate::error::Result;
use crate::fixed::Format;
use crate::hdl::inventory::Operators;
use crate::surface::catmull_clark::thesis::Quantity;

/// Everything that was counted.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// How the levels share their units in the core that was measured.
    pub schedule: &'static str,
    pub storage: Vec<Storage>,
    /// Of one coordinate.
    pub operators: Operators,
    pub clocks: Clocks,
    pub meshes: Vec<OnMesh>,
}

impl Measured {
    /// # Errors
    /// A core that does not exist.
    pub fn new(levels: u32, max_valence: u32) -> Result<Measured> {
        let coordinates = Format { integer: 12, fraction: 12 };
        let parameters = Parameters {
            coordinates,
            output_fraction: coordinates.fraction,
            levels,
            max_valence,
            precision: Precision::Guard(4),
            table_bits: coordinates.width() + 13,
        };
        let core = build(parameters)?;
        Ok(Measured {
            schedule: "pipelined",
            storage: storage(&core),
            operators: operators(&core, levels)?,
            clocks: clocks(&core, levels)?,
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
        let of = |schedule| (self.schedule == schedule).then_some(self.clocks.per_column);
        match quantity {
            Quantity::WordsWithFans => self.meshes.last().map(|mesh| mesh.words),
            Quantity::Windows => Some(self.storage.iter().map(|s| s.columns).sum::<u64>() as f64),
            Quantity::Fans => Some(self.storage.iter().map(|s| s.fans).sum::<u64>() as f64),
            Quantity::Storage => Some(self.vertices() as f64),
            Quantity::Bytes => Some(self.storage.iter().map(|s| s.bits).sum::<u64>() as f64 / 8.0),
            Quantity::ClocksShared => of("shared"),
            Quantity::ClocksPipelined => of("pipelined"),
            Quantity::ClocksDouble => of("double"),
            Quantity::StartUp => Some(self.clocks.start as f64),
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
    fn the_clocks_of_one_unit_a_level_are_those_of_the_formula() {
        for levels in 2..=4 {
            let measured = Measured::new(levels, 6).unwrap();
            assert_eq!(
                measured.of(Quantity::ClocksPipelined),
                Some(f64::from(1 << levels)),
                "level {levels}"
            );
            assert_eq!(measured.of(Quantity::ClocksShared), None);
        }
        // Four words a column come in one by one: the host is the slower one at level 1.
        assert_eq!(Measured::new(1, 4).unwrap().clocks.per_column, 4.0);
    }

    #[test]
    fn what_is_kept_is_counted_once_for_all_coordinates() {
        let (levels, valence) = (3, 10);
        let measured = Measured::new(levels, valence).unwrap();
        let part = |name: &str| measured.storage.iter().find(|p| p.part == name).unwrap().clone();
        // Two vertices with uL and uR, and d-3 neighbours and d-4 diagonals on either side.
        let input = part("input");
        assert_eq!((input.columns, input.fans), (6, 2 * (7 + 6)));
        assert_eq!(input.bits, 3 * 24 * (6 + 26));
        assert_eq!((part("output").columns, part("output").fans), (9, 0));
        assert!(part("level 0").columns >= 3 * 2 && part("level 2").columns >= 3 * 5);
        let columns: u64 = measured.storage.iter().map(|p| p.columns).sum();
        assert_eq!(measured.of(Quantity::Windows), Some(columns as f64));
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
