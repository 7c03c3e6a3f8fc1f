//! Bytes onto a serial line: one start bit, eight data bits, the lowest first, one stop bit.
//!
//! ```text
//! txd  ‾‾‾\_____/ b0 X b1 X ... X b7 /‾‾‾‾‾‾
//!          start                      stop       each bit `clocks_per_bit` clocks long
//! ```

use std::rc::Rc;

use crate::error::{Error, Result};
use crate::hdl::{Builder, Module, Word};

/// The fewest and the most clocks of a bit.
pub const FEWEST_CLOCKS: u32 = 2;
pub const MOST_CLOCKS: u32 = 1 << 20;

/// Start bit, data, stop bit.
const FRAME: u32 = 10;

/// Inputs: `byte_in` and `valid`. Outputs: `ready`; `txd`, 1 at rest.
///
/// # Errors
/// A bit shorter than two clocks or longer than 2^20.
pub fn build(clocks_per_bit: u32) -> Result<Rc<Module>> {
    if !(FEWEST_CLOCKS..=MOST_CLOCKS).contains(&clocks_per_bit) {
        return Err(Error::usage(format!("a serial line with {clocks_per_bit} clocks a bit")).help(format!(
            "a bit lasts {FEWEST_CLOCKS} to {MOST_CLOCKS} clocks: change the baud rate or the clock"
        )));
    }
    let m = Builder::new("uart_transmitter");
    m.purpose("Bytes onto a serial line: start bit, eight data bits with the lowest first, stop bit.");
    m.parameter("clocks_per_bit", clocks_per_bit);
    let byte = m.input("byte_in", Word::unsigned(8));
    let valid = m.input("valid", Word::bit());

    let line = m.register_reset("line", Word::unsigned(FRAME), (1 << FRAME) - 1);
    let bits_left = m.register_reset("bits_left", Word::range(0, FRAME.into()), 0);
    let last_clock = i128::from(clocks_per_bit) - 1;
    let clocks_left = m.register_reset("clocks_left", Word::range(0, last_clock), 0);
    let ready = m.wire("ready", m.is(&bits_left, 0));
    let load = m.wire("load", &valid & &ready);
    let next_bit = m.wire("next_bit", !&ready & m.is(&clocks_left, 0));

    let [low, high] = [false, true].map(|bit| m.bit(bit));
    let whole_bit = m.constant(last_clock, clocks_left.word());
    m.on(&load, &line, m.concat(&[&high, &byte, &low]));
    m.on(&next_bit, &line, m.concat(&[&high, &m.slice(&line, 1, FRAME - 1)]));
    m.on(&load, &bits_left, m.constant(FRAME.into(), bits_left.word()));
    m.on(&next_bit, &bits_left, m.wrap(&bits_left - 1, bits_left.word()));
    m.on(&(&load | &next_bit), &clocks_left, &whole_bit);
    m.on(&!&ready, &clocks_left, m.wrap(&clocks_left - 1, clocks_left.word()));

    m.output("ready", &ready);
    m.output("txd", m.slice(&line, 0, 1));
    m.finish()
}
