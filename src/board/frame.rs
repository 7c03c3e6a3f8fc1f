//! The frame of a mesh on the serial line, written and read in software.
//!
//! ```text
//! beats of the reference ─► encode ─► bytes   what the hardware must send
//! bytes from the line    ─► decode ─► Frame ─► triangles
//! ```
//!
//! The layout is that of [`serial_sink`](crate::cores::board::serial_sink).

use std::collections::BTreeMap;

use crate::cores::board::serial_sink::Header;
use crate::error::{Error, Kind, Result};
use crate::fixed::Format;
use crate::mesh::FineMesh;
use crate::model::loop_fd::Beat;

/// Bytes of the checksum.
const CHECKSUM: usize = 4;

/// A frame whose checksum is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    pub header: Header,
    pub beats: Vec<Beat>,
}

/// CRC-32 as in zlib, byte by byte from a table.
pub fn crc32(bytes: &[u8]) -> u32 {
    let entry =
        |index: u32| (0..8).fold(index, |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 });
    let table: Vec<u32> = (0..256).map(entry).collect();
    !bytes.iter().fold(!0, |c, &byte| c >> 8 ^ table[usize::from(c as u8 ^ byte)])
}

/// Bytes of a frame of so many beats, of which so many are pairs.
pub fn length(coordinate_bytes: usize, beats: usize, pairs: usize) -> usize {
    Header::BYTES + beats * (1 + 3 * coordinate_bytes) + pairs * 3 * coordinate_bytes + CHECKSUM
}

/// The bytes of a frame.
pub fn encode(frame: &Frame) -> Vec<u8> {
    let mut bytes = frame.header.bytes().to_vec();
    let last = frame.beats.len().saturating_sub(1);
    for (index, beat) in frame.beats.iter().enumerate() {
        let flags = [
            beat.right.is_some(),
            beat.strip_end,
            beat.patch_start,
            beat.patch_end,
            index == 0,
            index == last,
        ];
        bytes.push((0..).zip(flags).map(|(bit, flag)| u8::from(flag) << bit).sum());
        for number in beat.left.into_iter().chain(beat.right.into_iter().flatten()) {
            bytes.extend(&number.to_le_bytes()[..usize::from(frame.header.coordinate_bytes)]);
        }
    }
    bytes.extend(crc32(&bytes).to_le_bytes());
    bytes
}

/// The bytes of the first frame, once all of them are there; what comes before its magic is skipped.
///
/// # Errors
/// `Mismatch` for a header that no frame has.
pub fn find(received: &[u8]) -> Result<Option<&[u8]>> {
    let Some(start) = received.windows(4).position(|four| four == Header::MAGIC) else { return Ok(None) };
    let rest = &received[start..];
    if rest.len() < Header::BYTES {
        return Ok(None);
    }
    let header = header(rest)?;
    Ok(rest.get(..header.length as usize))
}

/// Reads the header at the start of the bytes, of which there are enough.
fn header(bytes: &[u8]) -> Result<Header> {
    let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let header = Header {
        integer: bytes[4],
        fraction: bytes[5],
        coordinate_bytes: bytes[6],
        level: bytes[7],
        patches: word(8),
        beats: word(12),
        length: word(16),
    };
    let (size, beats) = (usize::from(header.coordinate_bytes), header.beats as usize);
    let lengths = length(size, beats, 0)..=length(size, beats, beats);
    let sound = (1..=8).contains(&size)
        && Format::new(header.integer.into(), header.fraction.into()).is_some()
        && lengths.contains(&(header.length as usize));
    if !sound {
        return Err(damaged("the header of the frame is damaged".into()));
    }
    Ok(header)
}

fn damaged(what: String) -> Error {
    Error::new(Kind::Mismatch, what)
        .help("send the mesh again; check the baud rate and the cable if it stays so")
}

/// Reads a whole frame.
///
/// # Errors
/// `Mismatch` where the checksum is wrong, or what it protects is no mesh.
pub fn decode(bytes: &[u8]) -> Result<Frame> {
    if bytes.len() < Header::BYTES + CHECKSUM {
        return Err(damaged(format!("a frame of {} bytes", bytes.len())));
    }
    let header = header(bytes)?;
    let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
    let (computed, sent) = (crc32(content), checksum.iter().rev().fold(0u32, |c, &b| c << 8 | u32::from(b)));
    if computed != sent {
        return Err(damaged(format!(
            "the checksum of the frame is {sent:08x}, that of its bytes {computed:08x}"
        )));
    }
    let size = usize::from(header.coordinate_bytes);
    let mut rest = &content[Header::BYTES..];
    let mut beats = Vec::with_capacity(header.beats as usize);
    while let Some((&flags, numbers)) = rest.split_first() {
        let flag = |bit: u8| flags >> bit & 1 == 1;
        let count = if flag(0) { 6 } else { 3 };
        let Some((numbers, after)) = numbers.split_at_checked(count * size) else { break };
        let numbers: Vec<i64> = numbers.chunks(size).map(number).collect();
        let vertex = |first: usize| [numbers[first], numbers[first + 1], numbers[first + 2]];
        let right = flag(0).then(|| vertex(3));
        let (strip_end, patch_start, patch_end) = (flag(1), flag(2), flag(3));
        beats.push(Beat { left: vertex(0), right, strip_end, patch_start, patch_end });
        rest = after;
    }
    if !rest.is_empty() || beats.len() != header.beats as usize {
        return Err(damaged(format!("{} beats in a frame of {}", beats.len(), header.beats)));
    }
    Ok(Frame { header, beats })
}

/// A signed number, the lowest byte first.
fn number(bytes: &[u8]) -> i64 {
    let unsigned = bytes.iter().rev().fold(0i64, |number, &byte| number << 8 | i64::from(byte));
    let spare = 64 - 8 * bytes.len() as u32;
    unsigned << spare >> spare
}

impl Frame {
    /// The strips as triangles; vertices at one place are one vertex.
    pub fn mesh(&self) -> FineMesh {
        let Header { integer, fraction, .. } = self.header;
        let format = Format { integer: integer.into(), fraction: fraction.into() };
        let mut mesh = FineMesh { format, positions: vec![], faces: vec![] };
        let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let mut index = |position: [i64; 3]| {
            *known.entry(position).or_insert_with(|| {
                mesh.positions.push(position);
                mesh.positions.len() as u32 - 1
            })
        };
        for strip in self.beats.split_inclusive(|beat| beat.strip_end) {
            for pair in strip.windows(2) {
                let Some(right) = pair[0].right else { continue };
                let (left, right, above) = (index(pair[0].left), index(right), index(pair[1].left));
                mesh.faces.push([left, right, above]);
                if let Some(right_above) = pair[1].right {
                    mesh.faces.push([above, right, index(right_above)]);
                }
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        let beat = |left, right, ends: [bool; 3]| Beat {
            left,
            right,
            strip_end: ends[0],
            patch_start: ends[1],
            patch_end: ends[2],
        };
        let beats = vec![
            beat([0, 0, -32768], Some([32767, 0, 0]), [false, true, false]),
            beat([0, -1, 0], None, [true, false, true]),
        ];
        let length = length(2, 2, 1) as u32;
        let counts = (1, 2, length);
        let (patches, beats_count, length) = counts;
        let header = Header {
            integer: 6,
            fraction: 10,
            coordinate_bytes: 2,
            level: 0,
            patches,
            beats: beats_count,
            length,
        };
        Frame { header, beats }
    }

    #[test]
    fn the_checksum_is_that_of_zlib() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn a_frame_comes_back_and_is_found_among_noise() {
        let bytes = encode(&frame());
        assert_eq!(bytes.len(), frame().header.length as usize);
        assert_eq!(decode(&bytes), Ok(frame()));
        let noisy = [b"SDV\0", &bytes[..], b"SDV1"].concat();
        assert_eq!(find(&noisy).unwrap(), Some(&bytes[..]));
        assert_eq!(find(&noisy[..noisy.len() - 5]).unwrap(), None);
        assert_eq!(frame().mesh().faces, [[0, 1, 2]]);
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let bytes = encode(&frame());
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            match find(&flipped) {
                // A magic that is none, or a length beyond what was received.
                Ok(None) => continue,
                Ok(Some(frame)) => assert_eq!(decode(frame).unwrap_err().exit_status(), 1, "bit {bit}"),
                Err(error) => assert_eq!(error.exit_status(), 1, "bit {bit}"),
            }
        }
    }
}
