//! LUTs, flip-flops and clock of a core on a device, at once and without tools.
//!
//! ```text
//!   LUT    = adder bits a + LUTs of gates g + ...           counted in the core (Features)
//!   delay  = base + max over paths (adders + gates + carry + multipliers) + log2(fan-out) + sqrt(cells)
//!                  └── each times a constant of the family, fitted to cores that were placed and routed (calibration)
//! ```
//!
//! `cargo test --release --test suite calibration:: -- --ignored measured_anew` measures all cores of the table anew and
//! fits the constants; `fitted_anew` only fits.

pub mod calibration;
mod cover;
mod features;
mod fit;
mod folds;
mod function;
mod gates;
mod kept;
mod paths;
mod sums;

use std::rc::Rc;

use serde::{Deserialize, Serialize};

pub use calibration::{Calibration, Constants, Point};
pub use features::Features;
pub use paths::Path;

use super::device::{Device, Family};
use super::fan_out::MOST_READERS;
use crate::error::Result;
use crate::hdl::Module;

/// Bits of each kind in a core, or what one of them costs in LUTs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Where two operands meet; an order between numbers is an adder too.
    pub adder: f64,
    /// For each operand beyond the second.
    pub further: f64,
    /// LUTs of gates.
    pub gates: f64,
    /// Choices behind an adder, which some families have room for in the adder's cell.
    pub folded: f64,
    /// Gates before an adder, for which the same holds.
    pub absorbed: f64,
    /// Bits by sixteen words of memory, four at a time.
    pub memory: f64,
    /// Registers that are fed by registers.
    pub delay: f64,
    /// Products of operand bits.
    pub product: f64,
}

impl Load {
    pub(super) fn values(&self) -> [f64; 8] {
        [
            self.adder,
            self.further,
            self.gates,
            self.folded,
            self.absorbed,
            self.memory,
            self.delay,
            self.product,
        ]
    }

    pub(super) fn of([adder, further, gates, folded, absorbed, memory, delay, product]: [f64; 8]) -> Load {
        Load { adder, further, gates, folded, absorbed, memory, delay, product }
    }
}

/// What a core will be on a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub device: String,
    pub luts: u64,
    pub flip_flops: u64,
    pub dsps: u64,
    pub clock_mhz: f64,
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Estimate { device, luts, flip_flops, clock_mhz, .. } = self;
        write!(f, "{luts} LUT, {flip_flops} FF, {clock_mhz:.0} MHz on {device}")
    }
}

/// Estimates a core; nothing for a family that no core was measured on.
///
/// # Errors
/// A combinational loop.
pub fn estimate(core: &Rc<Module>, device: &Device) -> Result<Option<Estimate>> {
    let calibration = Calibration::built_in()?;
    let Some(constants) = calibration.constants(device.family) else { return Ok(None) };
    Ok(Some(constants.estimate(&Features::of(core)?, device)))
}

impl Constants {
    /// What the constants say of a core.
    pub fn estimate(&self, features: &Features, device: &Device) -> Estimate {
        Estimate {
            device: device.name.into(),
            luts: self.luts(features, device).round() as u64,
            flip_flops: (self.flip_flops * features.register_bits as f64).round() as u64,
            dsps: if device.holds.dsps > 0 { features.dsps } else { 0 },
            // A tenth of a megahertz is far below what the model knows.
            clock_mhz: (1e4 / self.delay_ns(features, device)).round() / 10.0,
        }
    }

    pub(super) fn luts(&self, features: &Features, device: &Device) -> f64 {
        // Multipliers have their blocks where the device has any.
        let product = if device.holds.dsps > 0 { 0.0 } else { features.load.product };
        let load = Load { product, ..features.load };
        self.luts.values().iter().zip(load.values()).map(|(cost, bits)| cost * bits).sum()
    }

    /// Nanoseconds of the slowest path.
    pub(super) fn delay_ns(&self, features: &Features, device: &Device) -> f64 {
        let clock = &self.clock;
        let one = |path: &Path| {
            clock.adder * path.adders
                + clock.gate * path.gates
                + clock.carry * path.carry
                + clock.multiplier * path.multipliers
        };
        let slowest = features.paths.iter().map(one).fold(0.0, f64::max);
        // Registers are copied so that none has more readers.
        let most = if device.family == Family::Ecp5 { MOST_READERS as u64 } else { u64::MAX };
        let fan_out = features.fan_out.clamp(1, most) as f64;
        // Ways are as long as the square is wide that the core fills.
        let cells = self.luts(features, device) + self.flip_flops * features.register_bits as f64;
        clock.base + slowest + clock.fan_out * fan_out.log2() + clock.size * (cells / 1000.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::{Builder, Word};

    #[test]
    fn a_wider_adder_is_larger_and_slower() {
        let of = |bits: u32| {
            let m = Builder::new("adder");
            let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(bits)));
            m.output("y", m.pipe("y", &a + &b));
            estimate(&m.finish().unwrap(), Device::named("ecp5-85k").unwrap()).unwrap().unwrap()
        };
        let (narrow, wide) = (of(15), of(63));
        assert!(narrow.luts * 3 < wide.luts && narrow.clock_mhz > wide.clock_mhz + 10.0);
        assert!(narrow.to_string().ends_with("MHz on ecp5-85k"), "{narrow}");
    }
}
