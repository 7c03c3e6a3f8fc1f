//! The control of lanes without their data: when the heads of the next strips are made, and when rows are sent.

use super::single_lane_clocks::SingleControl;

/// K neighbouring strips at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lanes {
    /// K.
    pub count: u32,
    /// Clocks of a step of the outer differences.
    pub digits: u32,
    /// Whether a patch may wait while another one runs.
    pub waits: bool,
    /// Whether a pass in front of the strips fills a buffer with the first column.
    pub buffered: bool,
}

impl Lanes {
    /// Beats of a patch of this level: of each K strips, a row more than the first one has pairs.
    pub fn beats(self, level: u32) -> u64 {
        let steps = 1u64 << level;
        (0..steps).step_by(self.count as usize).map(|strip| steps - strip + 1).sum()
    }
}

/// The control of one lane, or of several.
#[derive(Clone, Copy, Debug)]
pub(super) enum Control {
    One(SingleControl),
    Several(GroupControl),
}

/// What control tells in a clock.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Told {
    /// The waiting patch is taken.
    pub taken: bool,
    /// Another patch may come.
    pub released: bool,
}

impl Control {
    pub fn new(lanes: Lanes) -> Control {
        match lanes.count {
            1 => Control::One(SingleControl::new(lanes)),
            _ => Control::Several(GroupControl::new(lanes)),
        }
    }

    /// Whether a row is sent in this clock.
    pub fn issues(&self, has_room: bool) -> bool {
        match self {
            Control::One(control) => control.issues(has_room),
            Control::Several(control) => control.issues(has_room),
        }
    }

    /// One clock.
    pub fn clock(&mut self, now: u64, has_room: bool, waiting: Option<u32>) -> Told {
        match self {
            Control::One(control) => control.clock(now, has_room, waiting),
            Control::Several(control) => {
                let taken = control.clock(now, has_room, waiting);
                Told { taken, released: taken }
            }
        }
    }
}

/// The state between clocks, of several lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupControl {
    lanes: Lanes,
    /// A patch is in the outer differences; so many pairs has the first strip of the group that is prepared.
    owned: bool,
    pairs: u64,
    steps: u32,
    /// The clock from which on the outer differences may turn again.
    turned: u64,
    /// The next group is made, and known to be; so many pairs has its first strip.
    made: bool,
    prepared: bool,
    made_pairs: u64,
    running: bool,
    pairs_left: u64,
}

impl GroupControl {
    fn new(lanes: Lanes) -> GroupControl {
        GroupControl {
            lanes,
            owned: false,
            pairs: 0,
            steps: 0,
            turned: 0,
            made: false,
            prepared: false,
            made_pairs: 0,
            running: false,
            pairs_left: 0,
        }
    }

    fn issues(&self, has_room: bool) -> bool {
        self.running && has_room
    }

    /// One clock; whether the waiting patch is taken.
    fn clock(&mut self, now: u64, has_room: bool, waiting: Option<u32>) -> bool {
        let GroupControl { lanes, owned, made, .. } = *self;
        let turns = now >= self.turned;
        let load = waiting.filter(|_| !owned && turns);
        let advance = owned && !made && turns;
        let makes = advance && self.steps + 1 == lanes.count;
        let issue = self.issues(has_room);
        let ends = self.pairs_left == 0;
        let free = !self.running || (issue && ends);
        let fire = self.prepared && free;

        self.prepared = made && !fire;
        self.made = makes || (made && !fire);
        self.running = fire || !free;
        if fire {
            self.pairs_left = self.made_pairs;
        } else if issue && !ends {
            self.pairs_left -= 1;
        }
        if advance {
            self.steps = if makes { 0 } else { self.steps + 1 };
        }
        if makes {
            self.made_pairs = self.pairs;
            self.owned = self.pairs > lanes.count.into();
            self.pairs = self.pairs.saturating_sub(lanes.count.into());
        }
        if let Some(level) = load {
            (self.owned, self.pairs) = (true, 1 << level);
        }
        if load.is_some() || advance {
            self.turned = now + u64::from(lanes.digits);
        }
        load.is_some()
    }
}
