//! One beat of an AXI4-Stream and the shape of the port that carries it.
//!
//! ```text
//! tdata   | padding right.z | ... | padding left.y | padding left.x |   lanes, each padded to bytes
//! tkeep   |      1111       | ... |      1111      |      1111      |   one bit a byte of tdata
//! tuser, tlast
//! ```
//!
//! Bits are stored as 64-bit words, least significant first; bits above the width are zero.

use crate::{Error, Result};

/// One transfer of a stream; the widths are those of the [`Port`] it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Beat {
    /// `port.data` bits.
    pub data: Vec<u64>,
    /// One bit for each byte of `data`; empty where the port has no `tkeep`.
    pub keep: Vec<u64>,
    /// `port.user` bits.
    pub user: u64,
    /// `tlast`; false where the port has none.
    pub last: bool,
}

/// A named part of `tdata`, for messages: `left.x` is bits `lsb .. lsb + width`, a signed number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lane {
    pub name: String,
    /// Lowest bit in `tdata`.
    pub lsb: u32,
    /// Bits, the padding to whole bytes included: the padding is checked too.
    pub width: u32,
}

/// The shape of one stream; signals of width 0 do not exist in the hardware.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Port {
    /// Bits of `tdata`, at least 1; any width.
    pub data: u32,
    /// Whether there is a `tkeep`, one bit a byte of `tdata`; a byte not kept is not compared.
    pub keep: bool,
    /// Bits of `tuser`, 0 to 64.
    pub user: u32,
    /// Whether there is a `tlast`.
    pub last: bool,
    pub lanes: Vec<Lane>,
}

impl Port {
    /// A port with nothing but lanes, side by side from bit 0, each padded to whole bytes.
    pub fn of_lanes<S: Into<String>>(lanes: impl IntoIterator<Item = (S, u32)>) -> Self {
        let mut port = Port::default();
        for (name, bits) in lanes {
            let width = bits.div_ceil(8) * 8;
            port.lanes.push(Lane { name: name.into(), lsb: port.data, width });
            port.data += width;
        }
        port
    }
    pub fn with_keep(self) -> Self {
        Port { keep: true, ..self }
    }
    pub fn with_user(self, bits: u32) -> Self {
        Port { user: bits, ..self }
    }
    pub fn with_last(self) -> Self {
        Port { last: true, ..self }
    }

    /// Bits of `tkeep`, 0 where there is none.
    pub fn keep_bits(&self) -> u32 {
        if self.keep { self.data / 8 } else { 0 }
    }

    /// A beat of zeros with every byte kept.
    pub fn beat(&self) -> Beat {
        let mut keep = vec![u64::MAX; words(self.keep_bits())];
        trim(&mut keep, self.keep_bits());
        Beat { data: vec![0; words(self.data)], keep, user: 0, last: false }
    }

    /// A beat with one signed number for each lane, in the order of the lanes.
    /// Numbers wider than their lane keep their low bits; missing ones stay zero.
    pub fn beat_of(&self, numbers: &[i128]) -> Beat {
        let mut beat = self.beat();
        for (lane, &number) in self.lanes.iter().zip(numbers) {
            // Word by word: the 64-bit pieces of the number, each over at most two words of the beat.
            for piece in 0..lane.width.div_ceil(64) {
                let width = (lane.width - 64 * piece).min(64);
                let value = (number >> (64 * piece).min(127)) as u64 & (u64::MAX >> (64 - width));
                let at = lane.lsb + 64 * piece;
                let (word, shift) = (at as usize / 64, at % 64);
                beat.data[word] |= value << shift;
                if shift + width > 64 {
                    beat.data[word + 1] |= value >> (64 - shift);
                }
            }
        }
        beat
    }

    /// The signed number in a lane of at most 128 bits.
    pub fn number(&self, beat: &Beat, lane: usize) -> i128 {
        let Lane { lsb, width, .. } = self.lanes[lane];
        let word = |at: u32| beat.data.get(at as usize).copied().map_or(0, u128::from);
        let (first, shift) = (lsb / 64, lsb % 64);
        let low = (word(first) | word(first + 1) << 64) >> shift;
        let high = if shift == 0 { 0 } else { word(first + 2) << (128 - shift) };
        // Up to the top, then back with the sign.
        ((low | high) << (128 - width)) as i128 >> (128 - width)
    }

    /// Whether a bit of `tdata` is to be compared: its byte is kept.
    pub fn kept(&self, beat: &Beat, data_bit: u32) -> bool {
        !self.keep || bit(&beat.keep, data_bit / 8)
    }

    /// Marks the bytes of a lane as not kept.
    pub fn drop_lane(&self, beat: &mut Beat, lane: usize) {
        let Lane { lsb, width, .. } = self.lanes[lane];
        for byte in lsb / 8..(lsb + width) / 8 {
            set_bit(&mut beat.keep, byte, false);
        }
    }

    /// Whether a beat has this shape: as many words as needed, nothing above the width.
    pub(super) fn fits(&self, beat: &Beat) -> bool {
        let exact = |value: &[u64], bits: u32| {
            let above = if bits.is_multiple_of(64) { 0 } else { u64::MAX << (bits % 64) };
            value.len() == words(bits) && value.last().is_none_or(|&high| high & above == 0)
        };
        exact(&beat.data, self.data)
            && exact(&beat.keep, self.keep_bits())
            && (self.user == 64 || beat.user >> self.user == 0)
            && (self.last || !beat.last)
    }

    /// Refuses shapes that no testbench can drive.
    pub fn check(&self, name: &str) -> Result<()> {
        let wrong = |what: String| Err(Error::usage(what).at(format!("port {name}")));
        if self.data == 0 {
            return wrong("a stream needs at least one bit of tdata".into());
        }
        if self.user > 64 {
            return wrong(format!("tuser of {} bits: at most 64 are supported", self.user));
        }
        if self.keep && !self.data.is_multiple_of(8) {
            return wrong(format!("tkeep needs whole bytes, but tdata has {} bits", self.data));
        }
        match self.lanes.iter().find(|lane| lane.width == 0 || lane.lsb + lane.width > self.data) {
            Some(lane) => wrong(format!(
                "lane {} ({} bits from bit {}) does not fit in tdata of {} bits",
                lane.name, lane.width, lane.lsb, self.data
            )),
            None => Ok(()),
        }
    }
}

/// 64-bit words for so many bits.
pub(super) fn words(bits: u32) -> usize {
    bits.div_ceil(64) as usize
}

pub(super) fn bit(words: &[u64], at: u32) -> bool {
    words[at as usize / 64] >> (at % 64) & 1 == 1
}

pub(super) fn set_bit(words: &mut [u64], at: u32, one: bool) {
    let mask = 1 << (at % 64);
    let word = &mut words[at as usize / 64];
    *word = if one { *word | mask } else { *word & !mask };
}

/// Clears the bits above the width in the highest word.
fn trim(words: &mut [u64], bits: u32) {
    if let Some(high) = words.last_mut()
        && !bits.is_multiple_of(64)
    {
        *high &= (1 << (bits % 64)) - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_gives_back_its_signed_number() {
        let port = Port::of_lanes([("x", 28), ("y", 60), ("z", 5)]);
        let beat = port.beat_of(&[-3, 1 << 59, -16]);
        let numbers: Vec<_> = (0..3).map(|lane| port.number(&beat, lane)).collect();
        assert_eq!((port.data, numbers), (32 + 64 + 8, vec![-3, 1 << 59, -16]));
    }

    #[test]
    fn a_dropped_lane_is_not_kept() {
        let port = Port::of_lanes([("x", 16), ("y", 16)]).with_keep();
        let mut beat = port.beat();
        port.drop_lane(&mut beat, 1);
        assert_eq!((beat.keep[0], port.kept(&beat, 15), port.kept(&beat, 16)), (0b0011, true, false));
    }

    #[test]
    fn a_lane_outside_of_tdata_is_refused() {
        let mut port = Port::of_lanes([("x", 16)]);
        port.lanes[0].lsb = 1;
        assert!(port.check("output").unwrap_err().what.contains("lane x (16 bits from bit 1)"));
    }
}
