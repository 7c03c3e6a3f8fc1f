//! AXI4-Stream ports by the book: `tvalid` never waits for `tready`, and a beat moves where both are 1.

use super::Word;
use super::builder::Builder;
use super::expression::Signal;

/// A stream that comes in: its signals, all of clock 0. Its `tready` is an output, see
/// [`Builder::stream_input`].
pub struct StreamInput {
    pub lanes: Vec<Signal>,
    pub user: Signal,
    pub last: Signal,
    pub valid: Signal,
}

/// A beat that goes out.
pub struct StreamBeat<'a> {
    pub lanes: &'a [(&'a str, &'a Signal)],
    /// One bit a byte of `tdata`.
    pub keep: &'a Signal,
    pub user: &'a Signal,
    pub last: &'a Signal,
    pub valid: &'a Signal,
}

impl Builder {
    /// The ports of an input stream: lanes of `room` bits, `user_bits` of `tuser`, and `tlast`. Its
    /// `<name>_tready` is left to [`Builder::output`].
    #[track_caller]
    pub fn stream_input(&self, name: &str, room: u32, lanes: &[(&str, Word)], user_bits: u32) -> StreamInput {
        let lanes = self.input_bus(&format!("{name}_tdata"), room, lanes);
        let user = self.input(format!("{name}_tuser"), Word::unsigned(user_bits));
        let [last, valid] = ["tlast", "tvalid"].map(|n| self.input(format!("{name}_{n}"), Word::bit()));
        StreamInput { lanes, user, last, valid }
    }

    /// The `tready` of an output stream.
    #[track_caller]
    pub fn stream_ready(&self, name: &str) -> Signal {
        self.input(format!("{name}_tready"), Word::bit())
    }

    /// The ports of an output stream, lanes of `room` bits.
    #[track_caller]
    pub fn stream_output(&self, name: &str, room: u32, beat: StreamBeat) {
        self.output_bus(&format!("{name}_tdata"), room, beat.lanes);
        self.output(format!("{name}_tkeep"), beat.keep);
        self.output(format!("{name}_tuser"), beat.user);
        self.output(format!("{name}_tlast"), beat.last);
        self.output(format!("{name}_tvalid"), beat.valid);
    }
}
