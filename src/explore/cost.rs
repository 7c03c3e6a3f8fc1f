//! What a core costs: counted from its graph, and estimated from the counts.
//!
//! ```text
//!   LUT    = adder bits + multiplexer bits + operand bits of comparisons / 2 + memory bits / 16 (small ones)
//!   DSP    = ceil(a/18) ceil(b/18) for every multiplier of a by b bits
//!   clock  = 1 / (2.54 ns + 0.0255 ns * bits of the longest carry chain)
//! ```
//!
//! A LUT has four inputs: one bit of an adder with its carry, one of a two-to-one multiplexer, two of a
//! comparison, or 16 bits of memory. The delay is a line through carry chains of 8, 16 and 64 bits that were
//! placed on an ECP5-85F of speed grade 8 (365, 340 and 240 MHz). This is the one place to calibrate.

use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::hdl::{Cell, Counts, Module};

/// Delay of a path through no carry, and of each bit of carry, in nanoseconds.
const CLOCK: (f64, f64) = (2.54, 0.0255);

/// Memories up to this depth are made of LUTs, deeper ones are block RAM.
const LUT_MEMORY_DEPTH: u32 = 64;

/// Operand bits of one multiplier block.
const DSP_BITS: u32 = 18;

/// The figures of a core, all its axes together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Counted.
    pub register_bits: u64,
    /// Those of the difference engines alone, which every further lane needs again, where start-up and streams can be
    /// shared; of a core without engines all of them.
    pub engine_bits: u64,
    pub adder_bits: u64,
    pub multiplexer_bits: u64,
    pub memory_bits: u64,
    pub multipliers: u64,
    /// Estimated.
    pub luts: u64,
    pub dsps: u64,
    pub clock_mhz: f64,
}

impl Cost {
    pub fn of(core: &Rc<Module>) -> Cost {
        let counts = Counts::of(core);
        let more = More::of(core);
        let delay = CLOCK.0 + CLOCK.1 * f64::from(more.longest_carry);
        Cost {
            register_bits: counts.register_bits,
            engine_bits: engine_bits(core).unwrap_or(counts.register_bits),
            adder_bits: counts.adder_bits,
            multiplexer_bits: counts.multiplexer_bits,
            memory_bits: counts.memory_bits,
            multipliers: counts.multipliers,
            luts: counts.adder_bits
                + counts.multiplexer_bits
                + more.compared_bits.div_ceil(2)
                + more.lut_memory_bits.div_ceil(16),
            dsps: more.dsps,
            // A tenth of a megahertz is far below what the model knows.
            clock_mhz: (1e4 / delay).round() / 10.0,
        }
    }
}

/// Register bits of the instances that are engines; nothing where there are none.
fn engine_bits(core: &Module) -> Option<u64> {
    let engines = core.instances.iter().filter(|instance| instance.name.starts_with("engine_"));
    engines.map(|engine| Counts::of(&engine.module).register_bits).reduce(|sum, bits| sum + bits)
}

/// What the estimate needs beyond the counts.
#[derive(Clone, Copy, Default)]
struct More {
    longest_carry: u32,
    compared_bits: u64,
    lut_memory_bits: u64,
    dsps: u64,
}

impl More {
    fn of(module: &Rc<Module>) -> More {
        let mut more = More::default();
        let width = |id| module.node(id).word.width();
        for node in &module.nodes {
            match &node.cell {
                Cell::Sum { terms, constant } if terms.len() + usize::from(*constant != 0) > 1 => {
                    more.longest_carry = more.longest_carry.max(node.word.width());
                }
                Cell::Compare { left, right, .. } => {
                    more.compared_bits += u64::from(width(*left).max(width(*right)));
                }
                Cell::Product { left, right } => {
                    let blocks = |id| u64::from(width(id).div_ceil(DSP_BITS));
                    more.dsps += blocks(*left) * blocks(*right);
                }
                _ => {}
            }
        }
        for memory in module.memories.iter().filter(|memory| memory.depth <= LUT_MEMORY_DEPTH) {
            more.lut_memory_bits += u64::from(memory.depth) * u64::from(memory.word.width());
        }
        for instance in &module.instances {
            let inner = More::of(&instance.module);
            more.longest_carry = more.longest_carry.max(inner.longest_carry);
            more.compared_bits += inner.compared_bits;
            more.lut_memory_bits += inner.lut_memory_bits;
            more.dsps += inner.dsps;
        }
        more
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn an_adder_costs_its_bits_and_delays_by_its_carry() {
        let of = |bits: u32| {
            let m = Builder::new("adder");
            let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(bits)));
            m.output("y", m.pipe("y", &a + &b));
            Cost::of(&m.finish().unwrap())
        };
        let (narrow, wide) = (of(15), of(63));
        assert_eq!((narrow.luts, narrow.register_bits, wide.luts), (16, 16, 64));
        // What was placed: 340 and 240 MHz.
        assert!((narrow.clock_mhz - 340.0).abs() < 4.0 && (wide.clock_mhz - 240.0).abs() < 4.0);
    }
}
