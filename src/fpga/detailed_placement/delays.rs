//! What wires and cells take, in nanoseconds: ECP5, speed grade 8.
//!
//! ```text
//!   wire = 0.35 + 1.1 (along dx + along dy) + 0.25 into a LUT + 0.015 for each reader
//!   within a tile: 0.45
//! ```
//!
//! The table is that of 16 000 wires from register to register, of a routed design of 70 000 cells, by the tiles between
//! them; a tenth more than there, for those of other designs.

use super::design::{Cell, Kind, Port};

/// By the tiles along one axis.
const ALONG: [f32; 21] = [
    0.0, 0.20, 0.22, 0.37, 0.42, 0.46, 0.48, 0.50, 0.53, 0.64, 0.71, 0.75, 0.78, 0.84, 0.87, 0.90, 0.92,
    0.95, 0.97, 1.0, 1.02,
];
/// For each tile further.
const FURTHER: f32 = 0.04;
const WITHIN: f32 = 0.35;
const SHARE: f32 = 1.1;
/// Into the inputs of a LUT, a carry or a RAM, and into those in the tile of the driver.
const INTO_LUT: f32 = 0.25;
const INTO_NEXT: f32 = 0.1;
/// For each reader, and the number beyond which more do not count.
const READER: f32 = 0.015;
const MOST_READERS: usize = 40;

fn along(tiles: i32) -> f32 {
    let tiles = tiles.unsigned_abs() as usize;
    let last = ALONG.len() - 1;
    ALONG[tiles.min(last)] + FURTHER * tiles.saturating_sub(last) as f32
}

/// From one tile to another, to a cell of a kind, of a net with so many readers.
pub fn wire(dx: i32, dy: i32, to: Kind, readers: usize) -> f32 {
    let here = dx == 0 && dy == 0;
    let into = match to {
        _ if here => INTO_NEXT,
        Kind::Register => 0.0,
        _ => INTO_LUT,
    };
    let shared = if here { 0.0 } else { READER * readers.min(MOST_READERS) as f32 };
    WITHIN + SHARE * (along(dx) + along(dy)) + into + shared
}

/// From an input of a cell to an output, where there is a way.
pub fn through(cell: &Cell, from: Port, to: Port) -> Option<f32> {
    use Port::{A, B, C, D, F, F1, Fci, Fco, Fxa, Fxb, M, Ofx};
    let upper = cell.slot % 2 == 1;
    match (cell.kind, from, to) {
        (Kind::Lut | Kind::Wide | Kind::Ram | Kind::Carry, A | B | C | D, F) => Some(0.18),
        (Kind::Wide, A | B | C | D, Ofx) => Some(0.3),
        (Kind::Wide, M | Fxa | Fxb | F1, Ofx) => Some(0.2),
        (Kind::Carry, A | B | C | D, Fco) => Some(0.355),
        (Kind::Multiplier, _, _) => Some(3.066),
        (Kind::Carry, Fci, F) => Some(if upper { 0.293 } else { 0.328 }),
        (Kind::Carry, Fci, Fco) => Some(if upper { 0.0 } else { 0.056 }),
        _ => None,
    }
}

/// From the clock to the outputs.
pub fn clock_to_output(kind: Kind, from_array: bool) -> Option<f32> {
    match kind {
        Kind::Register => Some(0.395),
        // Without the register: no design of ours was measured, the number is a guess on the safe side.
        Kind::BlockRam => Some(if from_array { 4.2 } else { 0.6 }),
        _ => None,
    }
}

/// Before the clock, where a path ends at that port.
pub fn setup(cell: &Cell, port: Port) -> Option<f32> {
    match (cell.kind, port) {
        (Kind::Register, Port::Lsr) => Some(0.287),
        (Kind::Register | Kind::RamWrite, _) | (Kind::Ram, Port::Wre) => Some(0.0),
        (Kind::BlockRam, _) => Some(0.15),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wire_takes_longer_the_further_it_goes_and_the_more_read_it() {
        let plain = |dx, dy| wire(dx, dy, Kind::Register, 1);
        for tiles in 0..90 {
            assert!(plain(tiles, 0) < plain(tiles + 1, 0) && plain(-tiles, 3) == plain(tiles, -3));
        }
        assert!(wire(5, 5, Kind::Register, 9) > plain(5, 5));
        assert_eq!(wire(5, 5, Kind::Register, 40), wire(5, 5, Kind::Register, 400));
        assert!(wire(5, 5, Kind::Lut, 1) > plain(5, 5));
    }
}
