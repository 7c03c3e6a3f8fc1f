//! The buffer of a registered `cc-strip`, as its protocol sees it: what is sent comes there later, and is counted later
//! still.

use std::collections::VecDeque;

/// A buffer behind a pipeline of known depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Clocks from the control of level l to the buffer, for l = 1, 2, ...
    pub delays: [u32; 7],
    pub words: u32,
    /// A word stands between the memory and the output, and may wait beside that.
    pub middle: bool,
}

impl Buffer {
    /// Free places at which no more is sent.
    const RESERVE: u32 = 3;
}

/// What is in a buffer and on its way there.
pub(super) struct Buffered {
    way: VecDeque<bool>,
    stored: u32,
    middle: bool,
    /// No word waits beside the output.
    spare: bool,
    pub(super) standing: bool,
    free: u32,
    issued: bool,
    taken: bool,
    pub(super) room: bool,
    pub(super) empty: bool,
}

impl Buffered {
    pub(super) fn new(words: u32) -> Buffered {
        let way = VecDeque::new();
        Buffered {
            way,
            stored: 0,
            middle: false,
            spare: true,
            standing: false,
            free: words,
            issued: false,
            taken: false,
            room: true,
            empty: true,
        }
    }

    /// A strip of another level comes when nothing is on the way.
    pub(super) fn set_delay(&mut self, clocks: u32) {
        self.way = vec![false; clocks as usize].into();
    }

    pub(super) fn clock(
        &mut self,
        issue: bool,
        ready: bool,
        Buffer { words, middle, .. }: Buffer,
        unasked: u32,
    ) {
        let free = !self.standing || ready;
        let take = if middle {
            let take = self.stored > 0 && (!self.middle || self.spare);
            if free {
                self.standing = self.middle || !self.spare;
            }
            (self.spare, self.middle) =
                (free || (self.spare && !self.middle), take || (self.middle && !self.spare));
            take
        } else {
            let take = self.stored > 0 && free;
            self.standing = take || (self.standing && !ready);
            take
        };
        self.way.push_front(issue);
        let push = self.way.pop_back().unwrap_or(false);
        self.stored = self.stored + u32::from(push) - u32::from(take);
        self.room = self.free > Buffer::RESERVE + unasked;
        self.empty = self.free == words && !self.issued && !issue;
        self.free = self.free + u32::from(self.taken) - u32::from(self.issued);
        (self.issued, self.taken) = (issue, take);
    }
}
