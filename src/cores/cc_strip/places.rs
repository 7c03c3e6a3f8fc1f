//! Where a window keeps a vertex: a register, or, where coordinates take turns, a RAM with a word for each of them.
//!
//! ```text
//! axis ──► RAM ──► register ──► vertex, and the next column's place
//!   └─ a clock ──► RAM: what comes in, or moves on, of the same coordinate
//! ```

use super::sending::axis_word;
use crate::hdl::{Builder, MemoryHandle, Signal, Word};

/// Behind the name of a RAM that holds a place for all coordinates.
pub const BY_AXIS: &str = "_by_axis";

/// Coordinates that take turns.
pub const AXIS_COUNT: u32 = 3;

/// A place of a window.
pub enum Place {
    Register(Signal),
    /// The RAM, what is read of it, and where is written.
    Turns(MemoryHandle, Signal, Signal),
}

impl Place {
    pub fn value(&self) -> &Signal {
        match self {
            Place::Register(value) | Place::Turns(_, value, _) => value,
        }
    }

    /// The place takes the value where the strobe is 1.
    pub fn takes(&self, m: &Builder, strobe: &Signal, value: &Signal) {
        match self {
            Place::Register(register) => m.on(strobe, register, value),
            Place::Turns(ram, _, address) => ram.write(strobe, address, value),
        }
    }
}

/// Which coordinate is in turn.
pub struct Axes {
    read: Signal,
    written: Signal,
    /// Of the fan, which comes by itself.
    fan: Option<Signal>,
}

impl Axes {
    pub fn new(m: &Builder, level: u32) -> Axes {
        let read = m.input("axis", axis_word());
        let written = m.delay(&read, 1);
        let fan = (level > 0).then(|| m.input_at("fan_axis", axis_word(), 1));
        Axes { read, written, fan }
    }

    pub fn place(&self, m: &Builder, name: String, word: Word, is_fan: bool) -> Place {
        let ram = m.memory(&format!("{name}{BY_AXIS}"), AXIS_COUNT, word, vec![]).distributed();
        let value = ram.read(&name, &self.read, None);
        let written = self.fan.as_ref().filter(|_| is_fan).unwrap_or(&self.written);
        Place::Turns(ram, value, written.clone())
    }
}
