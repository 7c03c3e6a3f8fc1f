//! Hard packets for a `loop-fd`: control points over the whole range, at every level, between packets that
//! must be dropped whole. No mesh sends these; a core must stand them all the same.
//!
//! ```text
//! good, good, short, good, long, good, level too high, good, ...      in
//! beats of the good ones, as if the others had never been             out
//! ```

use super::beat::Beat;
use super::dut::Stimulus;
use super::loop_bench::depths;
use super::loop_traffic::Traffic;
use super::stall::Xorshift;
use crate::cores::loop_fd::{LEVEL_BITS, Parameters};
use crate::error::Result;
use crate::hdl::Module;
use crate::model::loop_fd_clocks::{self, Clocks};

/// Points of any number, with the level that `tuser` says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    pub level: u32,
    pub points: Vec<[i128; 3]>,
}

/// A list of packets with the answer to those that are patches.
pub struct LoopTrial {
    pub input: Vec<Beat>,
    pub expected: Vec<Beat>,
    packets: Vec<loop_fd_clocks::Packet>,
}

impl LoopTrial {
    /// The first packet must be a patch, as the latency of the core is measured from its twelfth beat.
    ///
    /// # Errors
    /// Parameters that the reference does not support.
    pub fn new(core: &Module, parameters: Parameters, packets: &[Packet]) -> Result<LoopTrial> {
        let traffic = Traffic::new(core, parameters)?;
        let mut trial = LoopTrial { input: vec![], expected: vec![], packets: vec![] };
        for Packet { level, points } in packets {
            trial.input.extend(traffic.packet(*level, points));
            let twelve: Option<&[_; 12]> = points.as_slice().try_into().ok();
            let patch = twelve.filter(|_| *level <= parameters.max_level);
            if let Some(points) = patch {
                traffic.answer(*level, points, &mut trial.expected)?;
            }
            let (points, level) = (points.len() as u32, patch.map(|_| *level));
            trial.packets.push(loop_fd_clocks::Packet { points, level });
        }
        Ok(trial)
    }

    /// Packets of every kind, chosen by the seed; every level of the core occurs.
    ///
    /// # Errors
    /// As [`LoopTrial::new`].
    pub fn random(core: &Module, parameters: Parameters, seed: u64) -> Result<LoopTrial> {
        LoopTrial::new(core, parameters, &packets(parameters, seed))
    }

    /// The clocks the core must take under the stalls of a stimulus.
    pub fn clocks(&self, core: &Module, stimulus: &Stimulus) -> Clocks {
        let (offer, ready) = (stimulus.offer_pattern(), stimulus.ready_pattern());
        loop_fd_clocks::run_packets(&self.packets, depths(core), &offer, &ready)
    }
}

/// How the coordinates of a packet are chosen.
const KINDS: [fn(&mut Dice) -> i128; 4] =
    [Dice::any, Dice::extreme, |dice| dice.bounds.0, |dice| dice.bounds.1];

/// Levels above this one occur once: their patches are long.
const CHEAP: u32 = 5;

fn packets(parameters: Parameters, seed: u64) -> Vec<Packet> {
    let most = parameters.max_level;
    let mut dice = Dice { xorshift: Xorshift::new(seed), bounds: (0, 0) };
    let mut packets = vec![];
    let broken = broken(most);
    let mut next_broken = broken.iter().cycle();
    let mut levels: Vec<(u32, usize)> =
        (0..=most).flat_map(|level| (0..KINDS.len()).map(move |kind| (level, kind))).collect();
    levels.retain(|&(level, kind)| level <= CHEAP || kind == level as usize % 2);
    dice.shuffle(&mut levels);
    for (level, kind) in levels {
        dice.bounds = bounds(parameters, level);
        packets.push(Packet { level, points: dice.points(12, KINDS[kind]) });
        if let Some(&(level, count)) = next_broken.next() {
            packets.push(Packet { level, points: dice.points(count, Dice::any) });
        }
    }
    // Every kind of broken packet right behind a short patch, and patches so short that they queue up.
    for (level, count) in broken {
        dice.bounds = bounds(parameters, 0);
        packets.push(Packet { level: 0, points: dice.points(12, Dice::any) });
        packets.push(Packet { level, points: dice.points(count, Dice::extreme) });
        packets.push(limit_positions(parameters, &mut dice));
    }
    packets
}

/// (level, number of points) of packets that a core of this maximum level drops.
fn broken(most: u32) -> Vec<(u32, usize)> {
    let highest = (1 << LEVEL_BITS) - 1;
    let lengths = [1, 11, 13, 5, 24, 12 + 16];
    let lengths = lengths.into_iter().enumerate().map(|(i, count)| (i as u32 % (most + 1), count));
    let levels = [most + 1, highest].into_iter().filter(|&level| level > most).map(|level| (level, 12));
    lengths.chain(levels).collect()
}

/// The least and the greatest coordinate of a control point of this level.
fn bounds(parameters: Parameters, level: u32) -> (i128, i128) {
    let finer = 4 * (parameters.max_level - level);
    let (min, max) = (parameters.coordinates.min(), parameters.coordinates.max());
    (i128::from(min) << finer, i128::from(max) << finer)
}

/// Three vertices of the limit surface over 12 * 16^R, sent as a patch of level 0.
fn limit_positions(parameters: Parameters, dice: &mut Dice) -> Packet {
    let (min, max) = bounds(parameters, 0);
    dice.bounds = (12 * min, 12 * max);
    let mut points = vec![[0; 3]; 12];
    for corner in [0, 2, 10] {
        points[corner] = [(); 3].map(|()| dice.extreme());
    }
    Packet { level: 0, points }
}

/// Random coordinates within bounds.
struct Dice {
    xorshift: Xorshift,
    bounds: (i128, i128),
}

impl Dice {
    fn any(&mut self) -> i128 {
        let (min, max) = self.bounds;
        let wide = u128::from(self.xorshift.next()) << 64 | u128::from(self.xorshift.next());
        min + (wide % (max - min + 1) as u128) as i128
    }

    /// One of the bounds, or a number next to one of them or to zero.
    fn extreme(&mut self) -> i128 {
        let (min, max) = self.bounds;
        match self.xorshift.below(8) {
            0..=2 => min,
            3..=5 => max,
            6 => (min + 1).min(max),
            _ => -1,
        }
    }

    fn points(&mut self, count: usize, coordinate: fn(&mut Dice) -> i128) -> Vec<[i128; 3]> {
        (0..count).map(|_| [(); 3].map(|()| coordinate(self))).collect()
    }

    fn shuffle<T>(&mut self, list: &mut [T]) {
        for at in (1..list.len()).rev() {
            list.swap(at, self.xorshift.below(at as u64 + 1) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cores::loop_fd::{RegisterForm, build};
    use crate::cosim::loop_bench::device;
    use crate::cosim::{Builtin, Model, Simulator, Stall};

    #[test]
    fn a_core_stands_hard_packets_under_every_stall() {
        let coordinates = "Q3.3".parse().unwrap();
        for max_level in [0, 2] {
            let parameters = Parameters::new(coordinates, 4, max_level, RegisterForm::Minimal20).unwrap();
            let core = build(parameters).unwrap();
            let trial = LoopTrial::random(&core, parameters, 5).unwrap();
            for (gaps, back_pressure) in [
                (Stall::None, Stall::None),
                (Stall::Bursts, Stall::OneIn(3)),
                (Stall::OneIn(5), Stall::Random { percent: 40 }),
            ] {
                let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
                let mut stimulus = Stimulus { gaps, back_pressure, seed: 3, ..stimulus };
                stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
                let outcome = Builtin::new(|| Model::new(&core)).run(&device(&core, &[]), &stimulus).unwrap();
                assert_eq!(outcome.failures, [], "R = {max_level}, {gaps}, {back_pressure}");
            }
        }
    }
}
