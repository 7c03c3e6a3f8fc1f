//! A cell flies with its readers: none of them could go alone without making its wires longer.

use super::design::Design;

/// Of nets with more readers nobody comes along.
const MOST_READERS: usize = 48;
/// Nets so small go with one of their cells.
const FEW: usize = 4;
/// A flock has no more cells.
const MOST: usize = 160;

impl Design {
    /// The cell and its readers, but for one; with `wide`, also what those read and who reads them, where that is little.
    pub fn flock(&self, cell: u32, but: u32, wide: bool) -> Vec<u32> {
        let mut flock = vec![cell];
        let add = |flock: &mut Vec<u32>, cell: u32| {
            if cell != but && flock.len() < MOST && !flock.contains(&cell) {
                flock.push(cell);
            }
        };
        let readers = |net: u32| self.nets[net as usize].arcs.iter().map(|&arc| self.arcs[arc as usize].to);
        for net in self.driven(cell as usize) {
            if self.nets[net as usize].arcs.len() <= MOST_READERS {
                readers(net).for_each(|reader| add(&mut flock, reader));
            }
        }
        for at in 0..if wide { flock.len() } else { 0 } {
            if at > 0 && self.is_fixed(flock[at]) {
                continue;
            }
            for pin in &self.cells[flock[at] as usize].pins {
                let net = &self.nets[pin.net as usize];
                if net.ignored || net.arcs.len() > FEW {
                    continue;
                }
                match pin.drives() {
                    true => readers(pin.net).for_each(|reader| add(&mut flock, reader)),
                    false => add(&mut flock, net.driver),
                }
            }
        }
        flock
    }
}
