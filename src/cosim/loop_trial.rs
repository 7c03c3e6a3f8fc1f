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
use crate::surface::basis;

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
            let levels = parameters.min_level..=parameters.max_level;
            let patch = twelve.filter(|_| levels.contains(level));
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

fn packets(parameters: Parameters, seed: u64) -> Vec<Packet> {
    let most = parameters.max_level;
    let mut dice = Dice { xorshift: Xorshift::new(seed), parameters, bounds: (0, 0) };
    let mut kinds: Vec<(u32, Kind)> = vec![];
    for level in parameters.min_level..=most {
        kinds.extend([Kind::Least, Kind::Greatest].map(|kind| (level, kind)));
        // Short patches come often: a vertex of theirs costs no more, and each one is rounded.
        let often = match level {
            0..=2 => 12,
            3 => 8,
            4 => 3,
            5 => 1,
            // Long ones come once.
            _ => {
                kinds.truncate(kinds.len() - 2);
                kinds.push((level, if level % 2 == 0 { Kind::Any } else { Kind::Extreme }));
                continue;
            }
        };
        let each = [Kind::Tie, Kind::Near, Kind::Any, Kind::Extreme];
        kinds.extend(
            (0..often)
                .flat_map(|_| each[..if level < 2 { 4 } else { 2 }].iter().copied())
                .map(|kind| (level, kind)),
        );
        kinds.extend([Kind::Any, Kind::Extreme].map(|kind| (level, kind)));
    }
    dice.shuffle(&mut kinds);
    let broken = broken(most);
    let mut packets = vec![];
    for (index, (level, kind)) in kinds.into_iter().enumerate() {
        packets.push(dice.packet(level, 12, kind));
        if index % 4 == 0 {
            let (level, count) = broken[index / 4 % broken.len()];
            packets.push(dice.packet(level, count, Kind::Any));
        }
    }
    // Every kind of broken packet right behind a short patch, and patches so short that they queue up.
    for (level, count) in broken {
        packets.push(dice.packet(0, 12, Kind::Any));
        packets.push(dice.packet(level, count, Kind::Extreme));
        packets.push(dice.limit_positions());
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

/// How the coordinates of a packet are chosen.
#[derive(Clone, Copy)]
enum Kind {
    /// Any number of the range.
    Any,
    /// The bounds of the range, a few next to them.
    Extreme,
    Least,
    Greatest,
    /// All of a packet close to a bound or to zero; how close differs over all powers of two.
    Near,
    /// A vertex that lies where rounding turns, or just below, so that the least error shows.
    Tie,
}

/// Makes random packets.
struct Dice {
    xorshift: Xorshift,
    parameters: Parameters,
    /// The least and the greatest coordinate of a control point.
    bounds: (i128, i128),
}

impl Dice {
    fn packet(&mut self, level: u32, count: usize, kind: Kind) -> Packet {
        // A control point of this level has 4 bits more for each level that it lies below the highest.
        let finer = 4 * self.parameters.max_level.saturating_sub(level);
        let coordinates = self.parameters.coordinates;
        self.bounds = (i128::from(coordinates.min()) << finer, i128::from(coordinates.max()) << finer);
        let mut points = vec![[0; 3]; count];
        for axis in 0..3 {
            let (base, spread) = self.near();
            for point in &mut points {
                point[axis] = match kind {
                    Kind::Any | Kind::Tie => self.any(),
                    Kind::Extreme => self.extreme(),
                    Kind::Least => self.bounds.0,
                    Kind::Greatest => self.bounds.1,
                    Kind::Near => (base + self.below(spread)).clamp(self.bounds.0, self.bounds.1),
                };
            }
            if matches!(kind, Kind::Tie) {
                self.tie(level, &mut points, axis);
            }
        }
        Packet { level, points }
    }

    /// Three vertices of the limit surface over 12 * 16^R, sent as a patch of level 0.
    fn limit_positions(&mut self) -> Packet {
        let coordinates = self.parameters.coordinates;
        let unit = 12i128 << (4 * self.parameters.max_level);
        self.bounds = (i128::from(coordinates.min()) * unit, i128::from(coordinates.max()) * unit);
        let mut points = vec![[0; 3]; 12];
        for corner in [0, 2, 10] {
            points[corner] = [(); 3].map(|()| self.extreme());
        }
        Packet { level: 0, points }
    }

    /// Moves one or two control points so that the numerator N of some vertex, of which
    /// floor(N / (3 * 2^s) + 1/2) is sent, is a half exactly, or one less.
    fn tie(&mut self, level: u32, points: &mut [[i128; 3]], axis: usize) {
        let steps = 1u64 << level;
        let i = self.xorshift.below(steps + 1);
        let j = self.xorshift.below(steps + 1 - i);
        let mask = basis::mask(level, i as u32, j as u32).map(i128::from);
        let numerator: i128 = mask.iter().zip(&*points).map(|(&m, p)| m * p[axis]).sum();
        let unit = 3i128 << self.parameters.shift();
        let missing = (unit / 2 - numerator).rem_euclid(unit) - self.below(2);
        let Some(first) = (0..12).filter(|&p| mask[p] > 0).min_by_key(|&p| mask[p]) else { return };
        // missing = weight of the first * its move + weight of the second * its move, up to whole units.
        let seconds = (0..12).filter(|&p| p != first && mask[p] % mask[first] != 0).chain([first]);
        for second in seconds {
            for other in 0..mask[first] {
                for missing in [missing, missing - unit] {
                    let rest = missing - mask[second] * other;
                    let mut moved = points.to_vec();
                    moved[second][axis] += other;
                    moved[first][axis] += rest.div_euclid(mask[first]);
                    let inside =
                        |p: usize| self.bounds.0 <= moved[p][axis] && moved[p][axis] <= self.bounds.1;
                    if rest % mask[first] == 0 && inside(first) && inside(second) {
                        points.copy_from_slice(&moved);
                        return;
                    }
                }
            }
        }
    }

    fn any(&mut self) -> i128 {
        self.bounds.0 + self.below(self.bounds.1 - self.bounds.0 + 1)
    }

    fn extreme(&mut self) -> i128 {
        let (min, max) = self.bounds;
        match self.xorshift.below(8) {
            0..=2 => min,
            3..=5 => max,
            6 => (min + 1).min(max),
            _ => -1,
        }
    }

    /// Where a packet lies, and in which part of the range its points differ.
    fn near(&mut self) -> (i128, i128) {
        let (min, max) = self.bounds;
        let spread = 1i128 << self.xorshift.below(u64::from((max - min).ilog2()) + 1);
        let base = [min, max - spread + 1, -spread / 2];
        (base[self.xorshift.below(3) as usize], spread)
    }

    /// A number in `0..bound`.
    fn below(&mut self, bound: i128) -> i128 {
        let wide = u128::from(self.xorshift.next()) << 64 | u128::from(self.xorshift.next());
        (wide % bound as u128) as i128
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
