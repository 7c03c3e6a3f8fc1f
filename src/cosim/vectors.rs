//! Vectors as text: hexadecimal, one beat a line, fields apart by a space, a final newline.
//!
//! ```text
//! [clock] [tlast] [tuser] [tkeep] tdata       fields in brackets only where they exist
//! 1 2 00ffffff 0000...01a3
//! ```
//!
//! The clock stands in the file of received beats only. A `tdata` of more than [`FIELD`] bits is cut
//! into several fields, highest first (see `workarounds::verilator_8192_bit_arguments`).

use super::beat::{bit, words};
use super::workarounds::FIELD_BITS as FIELD;
use super::{Beat, Port};
use crate::{Error, Kind, Result};

/// The beats as lines for the testbench.
pub fn write_beats(port: &Port, beats: &[Beat]) -> Vec<u8> {
    let mut text = Vec::with_capacity(beats.len() * (port.data as usize / 4 + 32));
    for beat in beats {
        if port.last {
            text.extend([b'0' + u8::from(beat.last), b' ']);
        }
        if port.user > 0 {
            push_hex(&mut text, &[beat.user], port.user);
            text.push(b' ');
        }
        if port.keep {
            push_hex(&mut text, &beat.keep, port.keep_bits());
            text.push(b' ');
        }
        for (lsb, width) in data_fields(port) {
            push_hex(&mut text, &beat.data[lsb as usize / 64..], width);
            text.push(b' ');
        }
        text.pop();
        text.push(b'\n');
    }
    text
}

/// Both stall patterns, one hexadecimal digit a clock: bit 0 offers an input beat, bit 1 is `tready`.
pub fn write_stalls(offer: &[bool], ready: &[bool]) -> Vec<u8> {
    let digit = |(&offer, &ready)| b'0' + u8::from(offer) + 2 * u8::from(ready);
    offer.iter().zip(ready).flat_map(|both| [digit(both), b'\n']).collect()
}

/// Reads back what a testbench received: for each beat its clock and its bits. Unknown bits (`x`, `z`)
/// read as 0; the testbench itself reports them.
pub(super) fn read_received(port: &Port, text: &[u8]) -> Result<Vec<(u64, Beat)>> {
    let mut received = Vec::with_capacity(text.len() / (port.data as usize / 4 + 16));
    let lines = text.split(|&byte| byte == b'\n').filter(|line| !line.is_empty());
    for (number, line) in lines.enumerate() {
        received.push(read_line(port, line).ok_or_else(|| {
            Error::new(Kind::ToolFailed, "the simulator wrote a beat that cannot be read").at(format!(
                "received.hex:{}: {}",
                number + 1,
                String::from_utf8_lossy(line)
            ))
        })?);
    }
    Ok(received)
}

fn read_line(port: &Port, line: &[u8]) -> Option<(u64, Beat)> {
    let mut fields = line.split(|&byte| byte == b' ');
    let mut next = |bits: u32| -> Option<Vec<u64>> {
        let mut value = vec![0; words(bits)];
        read_hex(fields.next()?, &mut value)?;
        Some(value)
    };
    let clock = next(64)?[0];
    let last = port.last && next(1)?[0] == 1;
    let user = if port.user > 0 { next(port.user)?[0] } else { 0 };
    let keep = if port.keep { next(port.keep_bits())? } else { Vec::new() };
    let mut data = vec![0; words(port.data)];
    for (lsb, width) in data_fields(port) {
        let start = lsb as usize / 64;
        data[start..start + words(width)].copy_from_slice(&next(width)?);
    }
    fields.next().is_none().then_some((clock, Beat { data, keep, user, last }))
}

/// Lowest bit and width of each field of `tdata`, highest field first.
pub(super) fn data_fields(port: &Port) -> impl Iterator<Item = (u32, u32)> {
    let bits = port.data;
    (0..bits.div_ceil(FIELD)).rev().map(move |at| (at * FIELD, FIELD.min(bits - at * FIELD)))
}

fn push_hex(text: &mut Vec<u8>, words: &[u64], bits: u32) {
    for digit in (0..bits.div_ceil(4)).rev() {
        let nibble = words[digit as usize / 16] >> (digit % 16 * 4) & 15;
        text.push(b"0123456789abcdef"[nibble as usize]);
    }
}

/// Fills the words from digits, right-aligned; `None` for a strange digit or too many of them.
fn read_hex(digits: &[u8], words: &mut [u64]) -> Option<()> {
    if digits.is_empty() || digits.len() > words.len() * 16 {
        return None;
    }
    for (chunk, word) in digits.rchunks(16).zip(words) {
        for &digit in chunk {
            let value = match digit {
                b'0'..=b'9' => digit - b'0',
                b'a'..=b'f' => digit - b'a' + 10,
                b'A'..=b'F' => digit - b'A' + 10,
                b'x' | b'X' | b'z' | b'Z' => 0,
                _ => return None,
            };
            *word = *word << 4 | u64::from(value);
        }
    }
    Some(())
}

/// The bits `lsb .. lsb + width` as hexadecimal digits, for messages.
pub(super) fn hex(words: &[u64], lsb: u32, width: u32) -> String {
    let nibble = |digit: u32| {
        (0..4.min(width - digit * 4)).map(|at| u32::from(bit(words, lsb + digit * 4 + at)) << at).sum::<u32>()
    };
    let digits = (0..width.div_ceil(4)).rev();
    digits.map(|digit| char::from_digit(nibble(digit), 16).unwrap_or('?')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(port: &Port, beat: Beat) {
        let line = write_beats(port, std::slice::from_ref(&beat));
        let text = [b"2a ", line.as_slice()].concat();
        assert_eq!(read_received(port, &text).unwrap(), vec![(0x2a, beat)]);
    }

    #[test]
    fn a_beat_with_all_signals_reads_back() {
        let port = Port::of_lanes([("x", 72), ("y", 24)]).with_keep().with_user(3).with_last();
        let mut beat = port.beat_of(&[-5, 77]);
        (beat.user, beat.last) = (5, true);
        port.drop_lane(&mut beat, 1);
        assert_eq!(write_beats(&port, &[beat.clone()]), b"1 5 1ff 00004dfffffffffffffffffb\n");
        round_trip(&port, beat);
    }

    #[test]
    fn a_beat_wider_than_a_field_reads_back() {
        let port = Port { data: 2 * FIELD + 100, ..Port::default() };
        let mut beat = port.beat();
        beat.data.iter_mut().zip(1..).for_each(|(word, at)| *word = at * 0x0123_4567);
        beat.data.last_mut().iter_mut().for_each(|word| **word &= (1 << 36) - 1);
        assert_eq!(data_fields(&port).count(), 3);
        round_trip(&port, beat);
    }

    #[test]
    fn unknown_digits_are_read_and_strange_ones_refused() {
        let port = Port { data: 16, ..Port::default() };
        assert_eq!(read_received(&port, b"0 xx1Z\n").unwrap()[0].1.data, [0x10]);
        for text in ["0 12g4\n", "0\n", "0 1234 5\n", "0 12345678123456781\n"] {
            assert!(read_received(&port, text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn messages_show_exactly_the_bits_of_a_lane() {
        assert_eq!(hex(&[0xf00d_0000_0000_0000, 0x1_2345], 60, 10), "05f");
    }
}
