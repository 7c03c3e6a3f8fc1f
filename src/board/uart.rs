//! A receiver of a serial line, clock by clock, as the chip at the other end is one.

/// Start bit, eight data bits with the lowest first, stop bit; sampled in the middle of each bit.
#[derive(Clone, Debug)]
pub struct Receiver {
    clocks_per_bit: u32,
    /// Clocks to the next sample, and the bits sampled; nothing while the line rests.
    sampling: Option<(u32, u32)>,
    byte: u8,
    /// Bytes whose stop bit was 0.
    pub broken: u64,
}

impl Receiver {
    pub fn new(clocks_per_bit: u32) -> Self {
        Receiver { clocks_per_bit, sampling: None, byte: 0, broken: 0 }
    }

    /// The line in this clock; gives the byte whose stop bit has just been sampled.
    pub fn clock(&mut self, line: bool) -> Option<u8> {
        let (wait, bits) = match self.sampling {
            None if line => return None,
            None => (self.clocks_per_bit / 2, 0),
            Some(state) => state,
        };
        if wait > 0 {
            self.sampling = Some((wait - 1, bits));
            return None;
        }
        self.sampling = Some((self.clocks_per_bit - 1, bits + 1));
        match bits {
            // A start bit that is gone at its middle was noise.
            0 if line => self.sampling = None,
            0 => self.byte = 0,
            1..=8 => self.byte |= u8::from(line) << (bits - 1),
            _ => {
                self.sampling = None;
                self.broken += u64::from(!line);
                return line.then_some(self.byte);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_with_and_without_a_pause() {
        for (clocks, pause) in [(2, 0), (4, 0), (5, 3), (434, 1)] {
            let mut receiver = Receiver::new(clocks);
            let bytes = [0x00u8, 0xff, 0x55, 0xa3];
            let mut received = vec![];
            for byte in bytes {
                let frame = 0x200 | u32::from(byte) << 1;
                let levels = (0..10).flat_map(|bit| vec![frame >> bit & 1 == 1; clocks as usize]);
                let levels = levels.chain(vec![true; pause]);
                received.extend(levels.filter_map(|line| receiver.clock(line)));
            }
            assert_eq!((received, receiver.broken), (bytes.to_vec(), 0), "{clocks} clocks a bit");
        }
    }

    #[test]
    fn a_stop_bit_of_zero_is_counted() {
        let mut receiver = Receiver::new(4);
        let received = (0..40).find_map(|_| receiver.clock(false));
        assert_eq!((received, receiver.broken), (None, 1));
    }
}
