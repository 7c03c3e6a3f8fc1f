//! The whole top in the built-in simulator, with a receiver at its serial line.

use super::uart::Receiver;
use crate::error::{Error, Kind, Result};
use crate::hdl::{Flat, Integers, Simulator};

/// Clocks of reset.
const RESET: u64 = 4;

/// How the top is run.
pub struct Session<'a> {
    pub top: &'a Flat,
    pub clocks_per_bit: u32,
    /// Clocks, from the end of the reset, in which the button is down.
    pub pressed: &'a [std::ops::Range<u64>],
    /// Bytes to be received.
    pub bytes: usize,
    /// Whether to listen for bytes beyond them.
    pub to_the_end: bool,
    /// What the line does to each of its levels, by the number of the clock.
    pub disturb: &'a dyn Fn(u64, bool) -> bool,
}

/// What came over the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Received {
    pub bytes: Vec<u8>,
    /// Bytes without a stop bit.
    pub broken: u64,
    /// Clocks from the end of the reset to the last byte.
    pub clocks: u64,
    /// Clocks in which `led_busy` was lit, and `led_done`.
    pub lit: [u64; 2],
}

impl Session<'_> {
    /// Runs until the bytes are there and, if asked for, the line has been quiet for the time of four bytes more.
    /// Registers that no reset sets hold noise at first.
    ///
    /// # Errors
    /// `Mismatch` when nothing arrives for the time of a hundred bytes.
    pub fn run(&self) -> Result<Received> {
        let flat = self.top.clone();
        let port = |found: Option<_>, name: &str| {
            found
                .ok_or_else(|| Error::usage(format!("the top has no port {name}")).help("take a serial sink"))
        };
        let output = |name: &str| port(flat.output(name), name);
        let (button, txd) = (port(flat.input("button"), "button")?, output("txd")?);
        let leds = [output("led_busy")?, output("led_done")?];
        let mut simulator = Simulator::new(flat, Integers);
        simulator.scramble(1);
        simulator.set(button, 0);
        for _ in 0..RESET {
            simulator.settle();
            simulator.edge(true)?;
        }
        let byte_clocks = 11 * u64::from(self.clocks_per_bit);
        let mut receiver = Receiver::new(self.clocks_per_bit);
        let mut received = Received { bytes: vec![], broken: 0, clocks: 0, lit: [0; 2] };
        let mut patience = byte_clocks * 100;
        for clock in 0.. {
            simulator.set(button, self.pressed.iter().any(|time| time.contains(&clock)).into());
            simulator.settle();
            let line = (self.disturb)(clock, *simulator.get(txd) != 0);
            for (lit, led) in received.lit.iter_mut().zip(leds) {
                *lit += u64::from(*simulator.get(led) != 0);
            }
            if let Some(byte) = receiver.clock(line) {
                received.bytes.push(byte);
                received.clocks = clock + 1;
                patience = byte_clocks * 100;
            }
            let quiet = !self.to_the_end || clock > received.clocks + 4 * byte_clocks;
            if received.bytes.len() > self.bytes || (received.bytes.len() == self.bytes && quiet) {
                break;
            }
            patience -= 1;
            if patience == 0 {
                let what =
                    format!("the line fell silent after {} of {} bytes", received.bytes.len(), self.bytes);
                return Err(Error::new(Kind::Mismatch, what).at(format!("clock {clock}")));
            }
            simulator.edge(false)?;
        }
        received.broken = receiver.broken;
        Ok(received)
    }
}
