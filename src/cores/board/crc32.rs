//! The checksum of zlib, gzip and PNG (CRC-32, ISO 3309), one bit a clock, the lowest bit of a byte first.
//!
//! ```text
//! c = c / 2            where the lowest bits of c and of the byte agree
//! c = c / 2 xor 0xEDB88320      otherwise;      at first all ones, at last inverted
//! ```

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

const POLYNOMIAL: i128 = 0xEDB8_8320;

/// Inputs: `clear`; `byte`, taken where `valid` is 1 while it rests. Outputs: `idle`; `checksum` of all bytes since
/// it was cleared, right while `idle` is 1. A byte takes eight clocks.
pub fn build() -> Result<Rc<Module>> {
    let m = Builder::new("crc32");
    m.purpose("CRC-32 as in zlib, one bit a clock.");
    let [clear, valid] = ["clear", "valid"].map(|name| m.input(name, Word::bit()));
    let byte = m.input("byte_in", Word::unsigned(8));

    let all_ones = m.constant((1 << 32) - 1, Word::unsigned(32));
    let remainder = m.register_reset("remainder", Word::unsigned(32), (1 << 32) - 1);
    let rest = m.register("rest", Word::unsigned(8));
    let bits_left = m.register_reset("bits_left", Word::range(0, 8), 0);
    let idle = m.wire("idle", m.is(&bits_left, 0));
    let take = m.wire("take", &valid & &idle);
    let step = !&idle;

    let zero = m.bit(false);
    m.on(&take, &rest, &byte);
    m.on(&step, &rest, m.concat(&[&zero, &m.slice(&rest, 1, 7)]));
    m.on(&take, &bits_left, m.constant(8, Word::range(0, 8)));
    m.on(&step, &bits_left, m.wrap(&bits_left - 1, bits_left.word()));

    let differs = m.wire("differs", m.slice(&remainder, 0, 1) ^ m.slice(&rest, 0, 1));
    let halved = m.concat(&[&zero, &m.slice(&remainder, 1, 31)]);
    let flipped = &halved ^ &m.constant(POLYNOMIAL, Word::unsigned(32));
    m.on(&clear, &remainder, &all_ones);
    m.on(&step, &remainder, m.select(&differs, &flipped, &halved));

    m.output("idle", &idle);
    m.output("checksum", m.wire("checksum", !&remainder));
    m.finish()
}
