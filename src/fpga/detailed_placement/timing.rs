//! Arrival times, slacks, and what each arc may take.
//!
//! ```text
//!   slack  = required - arrival - delay
//!   budget = delay (routing of the longest path through the arc + its slack) / routing of that path
//! ```
//!
//! So every wire of a path that is too long is asked for the same share of what the path is to lose; but none for
//! less than [`SHORTEST`], about what a wire to the next tile takes.

use super::delays::{clock_to_output, setup, through};
use super::design::{Arc, Design};

/// Of wires no longer than this, no less is asked.
const SHORTEST: f32 = 0.6;

/// What an analysis found.
#[derive(Clone, Debug, Default)]
pub struct Analysis {
    /// The longest path.
    pub longest: f32,
    /// Arcs on paths longer than the target, those of the longest first.
    pub late: Vec<u32>,
}

/// Of every net: when it arrives, and how much of that are wires.
struct Arrivals {
    at: Vec<f32>,
    wires: Vec<f32>,
}

impl Design {
    fn arrivals(&self, delay: &dyn Fn(&Arc) -> f32) -> Arrivals {
        let mut at = vec![f32::NEG_INFINITY; self.nets.len()];
        let mut wires = vec![0.0; self.nets.len()];
        for &number in &self.order {
            let net = &self.nets[number as usize];
            if net.ignored {
                continue;
            }
            let cell = &self.cells[net.driver as usize];
            let number = number as usize;
            if let Some(start) = clock_to_output(cell.kind, net.from_array) {
                at[number] = start;
                continue;
            }
            for pin in cell.pins.iter().filter(|pin| !pin.drives()) {
                let Some(within) = through(cell, pin.port, net.port) else { continue };
                let delay = delay(&self.arcs[pin.arc as usize]);
                let arrival = at[pin.net as usize] + delay + within;
                if arrival > at[number] {
                    (at[number], wires[number]) = (arrival, wires[pin.net as usize] + delay);
                }
            }
        }
        Arrivals { at, wires }
    }

    /// The longest path if every wire were short.
    pub fn reach(&self) -> f32 {
        let shortest = |arc: &Arc| if arc.free { 0.0 } else { SHORTEST };
        let at = self.arrivals(&shortest).at;
        let ends = self.arcs.iter().filter_map(|arc| {
            let setup = setup(&self.cells[arc.to as usize], arc.port)?;
            Some(at[arc.net as usize] + shortest(arc) + setup)
        });
        ends.fold(0.0, f32::max)
    }

    /// Sets the budgets for a target.
    pub fn analyse(&mut self, target: f32) -> Analysis {
        let Arrivals { at, wires } = self.arrivals(&|arc| self.delay(arc));
        let mut found = Analysis::default();
        // Of every net: until when it must be there, and the wires behind it on the path that says so.
        let mut required = vec![(f32::INFINITY, 0.0f32); self.nets.len()];
        let mut late = vec![];
        for position in (0..self.order.len()).rev() {
            let number = self.order[position] as usize;
            let net = &self.nets[number];
            if net.ignored {
                continue;
            }
            let mut first = (f32::INFINITY, 0.0f32);
            for at_arc in 0..net.arcs.len() {
                let arc_number = self.nets[number].arcs[at_arc];
                let arc = &self.arcs[arc_number as usize];
                let delay = self.delay(arc);
                let cell = &self.cells[arc.to as usize];
                let mut needed = (f32::INFINITY, 0.0f32);
                if let Some(setup) = setup(cell, arc.port) {
                    needed = (target - setup - delay, delay);
                    found.longest = found.longest.max(at[number] + delay + setup);
                }
                for out in cell.pins.iter().filter(|pin| pin.drives()) {
                    let Some(within) = through(cell, arc.port, self.nets[out.net as usize].port) else {
                        continue;
                    };
                    let (behind, behind_wires) = required[out.net as usize];
                    if behind - within - delay < needed.0 {
                        needed = (behind - within - delay, delay + behind_wires);
                    }
                }
                if needed.0 < first.0 {
                    first = needed;
                }
                let (slack, routing) = (needed.0 - at[number], wires[number] + needed.1);
                let free = arc.free || !slack.is_finite();
                self.arcs[arc_number as usize].budget = match free {
                    true => f32::INFINITY,
                    false => (delay * (routing + slack) / routing).max(SHORTEST),
                };
                if !free && slack < 0.0 && delay > SHORTEST {
                    late.push((slack, arc_number));
                }
            }
            required[number] = first;
        }
        late.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.late = late.into_iter().map(|(_, arc)| arc).collect();
        found
    }
}
