//! The control of one lane without its data: when it steps to the next strip, and when rows are sent.

use super::lane_clocks::{Lanes, Told};

/// The state between clocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct SingleControl {
    lanes: Lanes,
    /// A patch is in the outer differences; so many pairs has the strip that comes next.
    owned: bool,
    pairs: u64,
    /// The outer differences may step to it; they have none, and may take the next patch.
    prepared: bool,
    vacant: bool,
    /// All strips of the patch have been started, which is not told yet.
    drained: bool,
    /// The clock from which on the outer differences may turn again.
    turned: u64,
    running: bool,
    /// Buffered: the next pass is the one that fills the buffer; this one is, and sends nothing.
    first: bool,
    fills: bool,
    /// Rows to come in this strip, behind the one that is sent.
    rows: u64,
}

impl SingleControl {
    pub fn new(lanes: Lanes) -> SingleControl {
        SingleControl {
            lanes,
            owned: false,
            pairs: 0,
            prepared: false,
            vacant: false,
            drained: false,
            turned: 0,
            running: false,
            first: false,
            fills: false,
            rows: 0,
        }
    }

    pub fn issues(&self, has_room: bool) -> bool {
        self.running && has_room && !self.fills
    }

    pub fn clock(&mut self, now: u64, has_room: bool, waiting: Option<u32>) -> Told {
        let SingleControl { lanes, owned, pairs, prepared, vacant, drained, running, rows, .. } = *self;
        let load = waiting.filter(|_| vacant);
        let free = !running || (has_room && rows == 0);
        let fire = prepared && free;
        let last = pairs == 1 && !self.first;
        let drains = fire && last;
        let released = if lanes.waits { load.is_some() } else { drained && vacant };
        let turning = now < self.turned;

        self.prepared = owned && !turning && !fire;
        self.vacant = !owned && !turning && load.is_none();
        self.drained = drains || (drained && !released);
        self.owned = load.is_some() || (owned && !drains);
        if free {
            self.running = prepared;
        }
        if fire {
            // The pass that fills the buffer has the rows of the first strip.
            (self.rows, self.pairs) = (pairs, pairs - u64::from(!self.first));
            (self.fills, self.first) = (self.first, false);
        } else if running && has_room && rows > 0 {
            self.rows -= 1;
        }
        if let Some(level) = load {
            self.pairs = 1 << level;
            self.first = lanes.buffered;
        }
        if fire || (lanes.waits && load.is_some()) {
            // What is decided from the end of the turn comes a clock behind it.
            self.turned = now + u64::from(lanes.digits.max(2)) - 1;
        }
        Told { taken: load.is_some(), released }
    }
}
