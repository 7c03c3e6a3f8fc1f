//! What a placement costs.
//!
//! ```text
//!   late arcs    10 (e + 2 e^2)                                   e: nanoseconds over the budget
//!   nets         0.01 (width + 1.3 height + 4 for each tile that it enters)
//!   tiles        0.01 (wires - 18)^2                              of cells in it
//!   blocks       0.001 (36 (wires of a tile - 14))^2              of 6 by 6 tiles
//! ```
//!
//! Wires upwards are the first to be used up. Without the cost of tiles entered, readers of one net scatter, and the
//! router does not end.

use super::design::Design;

const LATE: f32 = 10.0;
const LATE_SQUARED: f32 = 20.0;
const TILE: f32 = 0.01;
const HEIGHT: f32 = 1.3;
const ENTERED: f32 = 4.0;
const FULL: f32 = 0.01;
const WIRES_OF_A_TILE: i32 = 18;
const FULL_BLOCK: f32 = 0.001;
const WIRES_IN_A_BLOCK: f32 = 14.0;
const TILES_OF_A_BLOCK: f32 = 36.0;

/// Nets with more readers are everywhere.
const MOST_READERS: usize = 64;

/// Marks what was counted already.
#[derive(Clone, Debug)]
pub struct Marks {
    nets: Vec<u32>,
    arcs: Vec<u32>,
    now: u32,
}

impl Marks {
    pub fn new(design: &Design) -> Marks {
        Marks { nets: vec![0; design.nets.len()], arcs: vec![0; design.arcs.len()], now: 0 }
    }
}

impl Design {
    /// Of an arc that takes longer than it may.
    pub fn lateness(&self, arc: u32) -> f32 {
        let arc = &self.arcs[arc as usize];
        let over = self.delay(arc) - arc.budget;
        if over > 0.0 { over * (LATE + LATE_SQUARED * over) } else { 0.0 }
    }

    /// The outermost tiles of a net's other cells, along both axes.
    pub fn edges(&self, net: u32, but: u32) -> Option<[[i16; 2]; 2]> {
        let net = &self.nets[net as usize];
        if net.ignored || net.arcs.len() > MOST_READERS {
            return None;
        }
        let cells = net.arcs.iter().map(|&arc| self.arcs[arc as usize].to).chain([net.driver]);
        let places = cells.filter(|&cell| cell != but).map(|cell| {
            let cell = &self.cells[cell as usize];
            [[cell.x; 2], [cell.y; 2]]
        });
        places.reduce(|[[l, r], [b, t]], [[x, _], [y, _]]| [[l.min(x), r.max(x)], [b.min(y), t.max(y)]])
    }

    /// Of the wires of a net.
    pub fn wires(&self, net: u32) -> f32 {
        let net = &self.nets[net as usize];
        let readers = net.arcs.len();
        if net.ignored || readers == 0 || readers > MOST_READERS {
            return 0.0;
        }
        let from = &self.cells[net.driver as usize];
        let key = |x: i16, y: i16| (x as u32) << 16 | u32::from(y as u16);
        let own = key(from.x, from.y);
        let (mut left, mut right, mut low, mut high) = (from.x, from.x, from.y, from.y);
        let mut tiles = [own; MOST_READERS];
        for (tile, &arc) in tiles.iter_mut().zip(&net.arcs) {
            let to = &self.cells[self.arcs[arc as usize].to as usize];
            (left, right) = (left.min(to.x), right.max(to.x));
            (low, high) = (low.min(to.y), high.max(to.y));
            *tile = key(to.x, to.y);
        }
        let tiles = &mut tiles[..readers];
        let entered = match readers {
            1 => usize::from(tiles[0] != own),
            _ => {
                tiles.sort_unstable();
                (0..readers).filter(|&at| tiles[at] != own && (at == 0 || tiles[at - 1] != tiles[at])).count()
            }
        };
        TILE * (f32::from(right - left) + HEIGHT * f32::from(high - low) + ENTERED * entered as f32)
    }

    /// Of all that cells that move have to do with.
    pub fn around(&self, cells: &[u32], marks: &mut Marks) -> f32 {
        marks.now += 1;
        let now = marks.now;
        let mut sum = 0.0;
        for &cell in cells {
            for pin in &self.cells[cell as usize].pins {
                let net = &self.nets[pin.net as usize];
                if net.ignored {
                    continue;
                }
                if std::mem::replace(&mut marks.nets[pin.net as usize], now) != now {
                    sum += self.wires(pin.net);
                }
                let own = [pin.arc];
                let arcs = if pin.drives() { &net.arcs[..] } else { &own };
                for &arc in arcs {
                    if std::mem::replace(&mut marks.arcs[arc as usize], now) != now {
                        sum += self.lateness(arc);
                    }
                }
            }
        }
        sum
    }

    /// Of what is in two tiles, and in their blocks.
    pub fn fullness(&self, a: usize, b: usize) -> f32 {
        let tile = |tile: usize| {
            let wires: i32 = self.in_tile(tile).map(|cell| i32::from(self.cells[cell as usize].load)).sum();
            let over = (wires - WIRES_OF_A_TILE).max(0);
            FULL * (over * over) as f32
        };
        let (blocks, tiles) = ([self.slots.block(a), self.slots.block(b)], tile(a) + tile(b));
        let block = |block: usize| {
            let over = TILES_OF_A_BLOCK * (self.slots.load_of_block(block) - WIRES_IN_A_BLOCK).max(0.0);
            FULL_BLOCK * over * over
        };
        tiles + block(blocks[0]) + if blocks[0] == blocks[1] { 0.0 } else { block(blocks[1]) }
    }
}
