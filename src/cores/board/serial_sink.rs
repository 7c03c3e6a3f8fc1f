//! A sink of the vertex stream: the mesh as one frame of bytes on a serial line.
//!
//! ```text
//! header     20 bytes    see [`Header`]
//! beat       1 byte      flags: bit 0 pair, 1 strip end, 2 patch start, 3 patch end, 4 mesh start, 5 mesh end
//!            3 or 6 n    left x, y, z and, in a pair, right x, y, z: signed, n bytes each, the lowest first
//! ...
//! checksum   4 bytes     CRC-32 of all bytes before it, the lowest first
//! ```
//!
//! ```text
//! vertex stream ─► bytes waiting (a shift register) ──┬─► uart_transmitter ─► txd
//!                      ▲ header, beat, checksum       └─► crc32
//! ```
//!
//! The header goes out when a beat with `mesh_start` stands at the input; nothing else starts a frame. A beat is
//! taken when the bytes of the one before have left, so the line slows the core down and nothing is lost.

use std::rc::Rc;

use super::{VertexStream, coordinate, crc32, uart_transmitter};
use crate::cores::loop_fd::Parameters;
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// What the receiver must know to read the beats, and how many there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Integer bits of a coordinate with the sign, and fraction bits.
    pub integer: u8,
    pub fraction: u8,
    /// Bytes of a coordinate.
    pub coordinate_bytes: u8,
    /// The level at which the mesh is evaluated.
    pub level: u8,
    pub patches: u32,
    pub beats: u32,
    /// Bytes of the whole frame, header and checksum included.
    pub length: u32,
}

impl Header {
    pub const MAGIC: [u8; 4] = *b"SDV1";
    pub const BYTES: usize = 20;

    /// Magic, then the fields in their order, the lowest byte first.
    pub fn bytes(&self) -> [u8; Header::BYTES] {
        let small = [self.integer, self.fraction, self.coordinate_bytes, self.level];
        let counts = [self.patches, self.beats, self.length].map(u32::to_le_bytes);
        let parts = [&[Header::MAGIC, small][..], &counts].concat();
        let mut bytes = [0; Header::BYTES];
        bytes.iter_mut().zip(parts.concat()).for_each(|(byte, field)| *byte = field);
        bytes
    }
}

/// Inputs: those of the vertex stream. Outputs: `ready`, `busy` (a frame is on its way), `txd`.
///
/// # Errors
/// As the transmitter.
pub fn build(parameters: Parameters, header: Header, clocks_per_bit: u32) -> Result<Rc<Module>> {
    let m = Builder::new("serial_sink");
    m.purpose("The vertex stream as one frame of bytes on a serial line: header, beats, checksum.");
    m.parameter("header", header.bytes().map(|byte| format!("{byte:02x}")).join(" "));
    let stream = VertexStream::inputs(&m, parameters);
    let beat = beat_bytes(&m, parameters, &stream);
    let length = Header::BYTES.max(beat.len());

    let mut state = m.state_machine("frame", &["waiting", "beats", "checksum"]);
    let waiting: Vec<Signal> =
        (0..length).map(|i| m.register(format!("byte_{i}"), Word::unsigned(8))).collect();
    let left = m.register_reset("bytes_left", Word::range(0, length as i128), 0);
    let none_left = m.wire("none_left", m.is(&left, 0));

    let clear = m.forward("clear", Word::bit());
    let take = m.forward("take", Word::bit());
    let crc =
        m.instance("crc", &crc32::build()?, &[("clear", &clear), ("valid", &take), ("byte_in", &waiting[0])]);
    let settled = m.wire("settled", &none_left & crc.out("idle"));
    let offered = m.wire("offered", !&none_left & crc.out("idle"));
    let line = uart_transmitter::build(clocks_per_bit)?;
    let line = m.instance("serial_line", &line, &[("byte_in", &waiting[0]), ("valid", &offered)]);
    m.drive(&take, &offered & line.out("ready"));

    let begin = m.all(&[&state.is("waiting"), &settled, &stream.valid, stream.flag("mesh_start")]);
    let begin = m.wire("load_header", begin);
    m.drive(&clear, &begin);
    let load_beat = m.wire("load_beat", m.all(&[&state.is("beats"), &settled, &stream.valid]));
    let load_checksum = m.wire("load_checksum", state.is("checksum") & &settled);
    let mesh_end = stream.flag("mesh_end");
    state.go("waiting", &begin, "beats");
    state.go("beats", &(&load_beat & mesh_end), "checksum");
    state.go("checksum", &load_checksum, "waiting");

    let constant = |byte: u8| m.constant(byte.into(), Word::unsigned(8));
    let checksum = crc.out("checksum");
    for (index, byte) in waiting.iter().enumerate() {
        if let Some(&value) = header.bytes().get(index) {
            m.on(&begin, byte, constant(value));
        }
        if let Some(value) = beat.get(index) {
            m.on(&load_beat, byte, value);
        }
        if index < 4 {
            m.on(&load_checksum, byte, m.slice(&checksum, 8 * index as u32, 8));
        }
        let above = waiting.get(index + 1).cloned().unwrap_or_else(|| constant(0));
        m.on(&take, byte, &above);
    }
    let count = |bytes: usize| m.constant(bytes as i128, left.word());
    let pair = stream.flag("pair");
    m.on(&begin, &left, count(Header::BYTES));
    m.on(&load_beat, &left, m.select(pair, count(beat.len()), count(1 + beat.len() / 2)));
    m.on(&load_checksum, &left, count(4));
    m.on(&take, &left, m.wrap(&left - 1, left.word()));

    let resting = m.all(&[&state.is("waiting"), &none_left, &line.out("ready")]);
    m.output("ready", m.wire("ready", state.is("beats") & &settled));
    m.output("busy", m.wire("busy", !&resting));
    m.output("txd", line.out("txd"));
    state.finish();
    m.finish()
}

/// The flags and the coordinates, byte by byte.
fn beat_bytes(m: &Builder, parameters: Parameters, stream: &VertexStream) -> Vec<Signal> {
    let spare = m.constant(0, Word::unsigned(8 - super::FLAGS.len() as u32));
    let highest_first: Vec<&Signal> = [&spare].into_iter().chain(stream.flags.iter().rev()).collect();
    let mut bytes = vec![m.wire("flags", m.concat(&highest_first))];
    let lane = coordinate_bytes(parameters);
    for coordinate in &stream.coordinates {
        let name = coordinate.name().unwrap_or_default();
        let wide = m.wire(format!("{name}_bytes"), m.wrap(coordinate, Word::signed(8 * lane)));
        bytes.extend((0..lane).map(|byte| m.slice(&wide, 8 * byte, 8)));
    }
    bytes
}

/// Bytes of a coordinate on the line.
pub fn coordinate_bytes(parameters: Parameters) -> u32 {
    coordinate(parameters).width().div_ceil(8)
}
