//! The buffer of a registered `cc-strip`, as its protocol sees it: what is sent comes there later, and is counted later
//! still.

use std::collections::VecDeque;

/// A buffer behind a pipeline of known depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Clocks from the control of level l to the buffer, for l = 1, 2, ...
    pub delays: [u32; 7],
    pub words: u32,
    /// Words of the short one behind a deep one: there a word stands between the memory and the output, and may wait
    /// beside that.
    pub near: Option<u32>,
}

/// Clocks from a deep buffer into the short one.
const FETCHES: usize = 2;

/// Clocks by which what is issued into a deep buffer counts later.
pub(super) const COUNTS_LATE: usize = 3;

/// Free places at which no more is sent.
const RESERVE: u32 = 3;

/// What is in a buffer and on its way there.
pub(super) struct Buffered {
    way: VecDeque<bool>,
    stored: u32,
    words: u32,
    unasked: u32,
    behind: Behind,
    free: u32,
    /// What is issued into a deep one counts later, and what is taken from there a clock later.
    seen: Option<[bool; COUNTS_LATE]>,
    returned: Option<[bool; 1]>,
    issued: bool,
    taken: bool,
    pub(super) room: bool,
    pub(super) empty: bool,
}

/// What is behind the memory of a buffer.
enum Behind {
    /// A word may stand at the output.
    Output {
        standing: bool,
    },
    /// One between, and no word waits beside the output (`spare`).
    Middle {
        middle: bool,
        spare: bool,
        standing: bool,
    },
    Near(Box<Buffered>),
}

impl Behind {
    fn standing(&self) -> bool {
        match self {
            Behind::Output { standing } | Behind::Middle { standing, .. } => *standing,
            Behind::Near(near) => near.standing(),
        }
    }

    /// Whether a word is taken from the memory, which has one or none.
    fn clock(&mut self, some: bool, ready: bool) -> bool {
        match self {
            Behind::Output { standing } => {
                let take = some && (!*standing || ready);
                *standing = take || (*standing && !ready);
                take
            }
            Behind::Middle { middle, spare, standing } => {
                let (take, free) = (some && (!*middle || *spare), !*standing || ready);
                if free {
                    *standing = *middle || !*spare;
                }
                (*spare, *middle) = (free || (*spare && !*middle), take || (*middle && !*spare));
                take
            }
            Behind::Near(near) => {
                let take = some && near.room;
                near.clock(take, ready);
                take
            }
        }
    }
}

/// What was as many clocks ago as there are registers, if there are any.
fn late<const CLOCKS: usize>(registers: &mut Option<[bool; CLOCKS]>, now: bool) -> bool {
    registers.as_mut().map_or(now, |was| {
        was.rotate_right(1);
        std::mem::replace(&mut was[0], now)
    })
}

impl Buffered {
    /// So many slices of a column are sent without being asked about.
    pub(super) fn new(Buffer { words, near, .. }: Buffer, unasked: u32) -> Buffered {
        let behind = match near {
            None => Behind::Output { standing: false },
            Some(words) => {
                let middle = Behind::Middle { middle: false, spare: true, standing: false };
                let mut near = Buffered::before(middle, words, 0);
                near.way = vec![false; FETCHES].into();
                Behind::Near(Box::new(near))
            }
        };
        let (seen, returned) = (near.map(|_| [false; COUNTS_LATE]), near.map(|_| [false]));
        Buffered { seen, returned, ..Buffered::before(behind, words, unasked) }
    }

    fn before(behind: Behind, words: u32, unasked: u32) -> Buffered {
        Buffered {
            way: VecDeque::new(),
            stored: 0,
            words,
            unasked,
            behind,
            free: words,
            seen: None,
            returned: None,
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

    /// Whether a word stands at the output.
    pub(super) fn standing(&self) -> bool {
        self.behind.standing()
    }

    pub(super) fn clock(&mut self, issue: bool, ready: bool) {
        let take = self.behind.clock(self.stored > 0, ready);
        self.way.push_front(issue);
        let push = self.way.pop_back().unwrap_or(false);
        self.stored = self.stored + u32::from(push) - u32::from(take);
        let (issue, take) = (late(&mut self.seen, issue), late(&mut self.returned, take));
        self.room = self.free > RESERVE + self.unasked;
        self.empty = self.free == self.words && !self.issued && !issue;
        self.free = self.free + u32::from(self.taken) - u32::from(self.issued);
        (self.issued, self.taken) = (issue, take);
    }
}
