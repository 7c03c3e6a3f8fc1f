//! How many clocks a `loop-fd` takes, under any stalls: its protocol without its data.
//!
//! ```text
//! accept 12 points ─► hand over 3 axes ─► start-up ─► wait ─► load, start, 2 clocks ─► a beat a clock
//!                                                                 ─► rounders ─► FIFO ─► consumer
//! ```
//!
//! A core that computes the right values but needs other clocks than these is wrong. The depths of the
//! pipelines are what the core declares; everything else is the protocol's.

use super::lane_clocks::{Control, Lanes, Told};

/// The declared depths, in clocks or words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Depths {
    /// From the points at the start-up's input to the differences at its output.
    pub startup: u32,
    /// From the running differences to the rounded vertices.
    pub rounder: u32,
    /// Words of the output FIFO's memory; one of them always stays free.
    pub fifo: u32,
    /// Neighbouring strips at once.
    pub lanes: Option<Lanes>,
}

impl Depths {
    /// Beats of a patch of this level.
    pub fn beats(&self, level: u32) -> u64 {
        self.lanes.map_or_else(|| beats(level), |lanes| lanes.beats(level))
    }
}

/// One packet of the input stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Its beats, at least one.
    pub points: u32,
    /// The level of a packet of 12 points; none for a packet that is dropped whole.
    pub level: Option<u32>,
}

/// An input beat as the protocol sees it: whether it ends its packet, and the packet's level, if it is kept.
#[derive(Clone, Copy)]
struct Point {
    last: bool,
    level: Option<u32>,
}

/// What happened in one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// From the first clock after reset to the last output beat, both counted.
    pub total: u64,
    /// From the acceptance of the first patch's last point to the first valid output.
    pub latency: u64,
}

/// Beats of a patch of this level: 2^level strips of a pair a row and a single vertex.
pub fn beats(level: u32) -> u64 {
    let steps = 1u64 << level;
    steps * (steps + 3) / 2
}

/// Runs patches of the given levels. In clock c a waiting beat may be offered if `offer[c % len]`, and
/// then stays offered until it is accepted; the output is taken if `ready[c % len]`.
pub fn run(levels: &[u32], depths: Depths, offer: &[bool], ready: &[bool]) -> Clocks {
    let packets: Vec<Packet> =
        levels.iter().map(|&level| Packet { points: 12, level: Some(level) }).collect();
    run_packets(&packets, depths, offer, ready)
}

/// The same for packets of any kind. The clocks end with the last output beat.
pub fn run_packets(packets: &[Packet], depths: Depths, offer: &[bool], ready: &[bool]) -> Clocks {
    let lanes = depths.lanes.map(Control::new);
    let mut machine = Machine { depths, lanes, credits: depths.fifo - 1, ..Machine::default() };
    let wanted: u64 = packets.iter().filter_map(|packet| packet.level).map(|level| depths.beats(level)).sum();
    let mut points = packets.iter().flat_map(|packet| {
        (1..=packet.points).map(|point| Point { last: point == packet.points, level: packet.level })
    });
    let mut waiting = points.next();
    let (mut received, mut offering, mut clock) = (0, false, 0u64);
    let (mut first_packet, mut first_output) = (None, None);
    while received < wanted {
        let at = |pattern: &[bool]| pattern[clock as usize % pattern.len()];
        offering |= waiting.is_some() && at(offer);
        let (took, valid) = machine.clock(waiting.filter(|_| offering), at(ready));
        if took {
            if waiting.is_some_and(|point| point.last && point.level.is_some()) {
                first_packet.get_or_insert(clock);
            }
            waiting = points.next();
            offering = false;
        }
        if valid {
            first_output.get_or_insert(clock);
            received += u64::from(at(ready));
        }
        clock += 1;
    }
    let latency = first_output.zip(first_packet).map_or(0, |(output, packet)| output - packet);
    Clocks { total: clock, latency }
}

#[derive(Default)]
struct Machine {
    depths: Depths,
    now: u64,
    // Loader.
    /// Whether the stream waits for the verdict on a packet, or for the axes to leave.
    closed: bool,
    /// The beat accepted in the clock before, if it was a packet's last: its level, or none.
    beat: Option<Option<u32>>,
    full: bool,
    axis: u32,
    /// The clock from which on an axis may leave.
    turned: u64,
    loading_level: u32,
    // Between loader and engines.
    reserved: bool,
    /// The clock in which the last axis arrives, and its level.
    arriving: Option<(u64, u32)>,
    waiting: Option<u32>,
    // Strip control.
    starting: bool,
    running: bool,
    length: u64,
    pairs_left: u64,
    lanes: Option<Control>,
    /// What lanes have told in the clock before.
    told: Told,
    // Output.
    credits: u32,
    has_room: bool,
    /// Whether a row was decided on in the clock before, and what the FIFO's control knows of its words.
    issued: bool,
    /// Whether a word left the FIFO in the clock before, and in the one before that.
    takes: bool,
    returned: bool,
    filled: bool,
    /// A word stands behind the memory of the FIFO.
    stands: bool,
    /// Clocks in which words reach the FIFO, in order.
    in_flight: std::collections::VecDeque<u64>,
    stored: u32,
    valid: bool,
}

impl Default for Depths {
    fn default() -> Self {
        Depths { startup: 0, rounder: 0, fifo: 1, lanes: None }
    }
}

impl Machine {
    /// One clock; returns whether the offered point was accepted, and whether the output was valid.
    fn clock(&mut self, offered: Option<Point>, ready: bool) -> (bool, bool) {
        let digits = self.depths.lanes.map_or(1, |lanes| lanes.digits);
        let strobe = self.full && self.now >= self.turned && (self.axis > 0 || !self.reserved);
        let leaving = strobe && self.axis == 2;
        let accept = offered.filter(|_| !self.closed);

        let issue = match &self.lanes {
            Some(lanes) => lanes.issues(self.has_room),
            None => self.running && self.has_room,
        };
        let strip_end = self.pairs_left == 0;
        let finishing = issue && strip_end && self.length <= 1;
        let has_room = self.has_room;
        let mut told = Told::default();
        let load = match &mut self.lanes {
            Some(lanes) => {
                told = lanes.clock(self.now, has_room, self.waiting);
                self.waiting.filter(|_| told.taken)
            }
            None => self.waiting.filter(|_| finishing || !(self.running || self.starting)),
        };

        let valid = self.valid;
        let moves_on = !valid || ready;
        let take = self.filled && moves_on;

        // The edge. Output side:
        if moves_on {
            (self.stands, self.valid) = (self.filled, self.stands);
        }
        self.filled = self.stored > u32::from(take);
        self.stored -= u32::from(take);
        if self.in_flight.front() == Some(&self.now) {
            self.in_flight.pop_front();
            self.stored += 1;
        }
        if issue {
            self.in_flight.push_back(self.now + 1 + u64::from(self.depths.rounder));
        }
        self.has_room = self.credits > 2;
        self.credits = self.credits + u32::from(self.returned) - u32::from(self.issued);
        (self.returned, self.takes) = (self.takes, take);
        self.issued = issue;

        if self.lanes.is_none() {
            self.strips(issue, load);
        }
        // Lanes tell the loader a clock later, out of a register.
        let Told { taken, released } = match self.lanes {
            Some(_) => std::mem::replace(&mut self.told, told),
            None => Told { taken: load.is_some(), released: load.is_some() },
        };
        if taken {
            self.waiting = None;
        }

        // Hand-over:
        if let Some((_, level)) = self.arriving.filter(|(when, _)| *when == self.now) {
            self.waiting = Some(level);
            self.arriving = None;
        }
        if leaving {
            self.arriving = Some((self.now + 1 + u64::from(self.depths.startup), self.loading_level));
        }
        self.reserved = (strobe && self.axis == 0) || (self.reserved && !released);
        let opens = strobe && self.axis == if digits == 1 { 1 } else { 2 };
        if strobe {
            self.axis = (self.axis + 1) % 3;
            self.turned = self.now + u64::from(digits);
        }
        self.full &= !leaving;

        // Loader:
        self.closed &= !(opens || self.beat == Some(None));
        if let Some(Some(level)) = self.beat {
            (self.full, self.loading_level) = (true, level);
        }
        self.beat = None;
        if let Some(Point { level, last: true }) = accept {
            (self.closed, self.beat) = (true, Some(level));
        }
        self.now += 1;
        (accept.is_some(), valid)
    }

    /// The edge of the control of single strips.
    fn strips(&mut self, issue: bool, load: Option<u32>) {
        let strip_end = self.pairs_left == 0;
        let finishing = issue && strip_end && self.length <= 1;
        if issue && !strip_end {
            self.pairs_left -= 1;
        }
        if issue && strip_end && !finishing {
            self.length -= 1;
            self.pairs_left = self.length;
        }
        if self.starting {
            self.pairs_left = self.length;
        }
        self.running = self.starting || (self.running && !finishing);
        self.starting = load.is_some();
        if let Some(level) = load {
            self.length = 1 << level;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTHS: Depths = Depths { startup: 9, rounder: 7, fifo: 32, lanes: None };

    #[test]
    fn back_to_back_patches_of_level_4_keep_the_output_busy() {
        let ten = run(&[4; 10], DEPTHS, &[true], &[true]);
        let hundred = run(&[4; 100], DEPTHS, &[true], &[true]);
        let (beats, clocks) = (90 * beats(4), hundred.total - ten.total);
        assert!(beats as f64 / clocks as f64 >= 0.98, "{beats} beats in {clocks} clocks");
    }

    #[test]
    fn the_consumer_sets_the_pace() {
        let mut ready = vec![false; 5];
        ready[4] = true;
        let slow = run(&[3; 20], DEPTHS, &[true], &ready);
        assert!(slow.total >= 5 * 20 * beats(3));
        assert!(slow.total < 5 * 20 * beats(3) + 100);
    }

    #[test]
    fn a_dropped_packet_costs_the_clocks_of_its_points_and_of_the_verdict() {
        let good = Packet { points: 12, level: Some(2) };
        let clocks = |first: &[Packet]| run_packets(&[first, &[good]].concat(), DEPTHS, &[true], &[true]);
        let (alone, behind) = (clocks(&[]), clocks(&[Packet { points: 5, level: None }]));
        assert_eq!((behind.total, behind.latency), (alone.total + 6, alone.latency));
    }

    #[test]
    fn a_triangle_has_two_beats_a_strip_of_one() {
        assert_eq!([0, 1, 2, 4].map(beats), [2, 5, 14, 152]);
    }
}
