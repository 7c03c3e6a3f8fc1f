//! What a core costs: counted from its graph, and estimated from the counts by [`crate::fpga::estimate`].

use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::fpga::Device;
use crate::fpga::estimate::estimate;
use crate::hdl::{Counts, Module};

/// What a core is estimated on.
const DEVICE: &str = "ecp5-85k";

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
    /// # Errors
    /// A combinational loop.
    pub fn of(core: &Rc<Module>) -> Result<Cost> {
        let counts = Counts::of(core);
        let estimate = estimate(core, Device::named(DEVICE)?)?;
        Ok(Cost {
            register_bits: counts.register_bits,
            engine_bits: engine_bits(core).unwrap_or(counts.register_bits),
            adder_bits: counts.adder_bits,
            multiplexer_bits: counts.multiplexer_bits,
            memory_bits: counts.memory_bits,
            multipliers: counts.multipliers,
            luts: estimate.as_ref().map_or(0, |estimate| estimate.luts),
            dsps: estimate.as_ref().map_or(0, |estimate| estimate.dsps),
            clock_mhz: estimate.map_or(0.0, |estimate| estimate.clock_mhz),
        })
    }
}

/// Register bits of the instances that are engines; nothing where there are none.
fn engine_bits(core: &Module) -> Option<u64> {
    let engines = core.instances.iter().filter(|instance| instance.name.starts_with("engine_"));
    engines.map(|engine| Counts::of(&engine.module).register_bits).reduce(|sum, bits| sum + bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn counts_and_estimate_stand_side_by_side() {
        let of = |bits: u32| {
            let m = Builder::new("adder");
            let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(bits)));
            m.output("y", m.pipe("y", &a + &b));
            Cost::of(&m.finish().unwrap()).unwrap()
        };
        let (narrow, wide) = (of(15), of(63));
        assert_eq!((narrow.adder_bits, narrow.register_bits, wide.adder_bits), (16, 16, 64));
        assert!(narrow.luts > 0 && narrow.luts < wide.luts && narrow.clock_mhz > wide.clock_mhz);
    }
}
