//! The cores that were placed and routed, and the constants that were fitted to them: `calibration.toml`.

use serde::{Deserialize, Serialize};

use super::fit::minimise;
use super::{Features, Load};
use crate::error::{Error, Kind, Result};
use crate::fpga::device::{Device, Family};

const FILE: &str = include_str!("calibration.toml");

/// The file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    pub family: Vec<Constants>,
    pub point: Vec<Point>,
}

/// The constants of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// As in the names of its devices: `ecp5`.
    pub name: String,
    /// Flip-flops for a bit of register.
    pub flip_flops: f64,
    /// LUTs for a bit of each kind.
    pub luts: Load,
    pub clock: Clock,
}

/// Nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// From a register to a register, through nothing.
    pub base: f64,
    /// Of an adder and the way to it, without its carry.
    pub adder: f64,
    /// Of a LUT and the way to it.
    pub gate: f64,
    /// Of a bit of carry.
    pub carry: f64,
    pub multiplier: f64,
    /// For every doubling of the bits that a bit of control steers.
    pub fan_out: f64,
    /// For the width of a square of a thousand LUTs and flip-flops.
    pub size: f64,
}

/// One core on one device, as `synth` measured it with seed 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub device: String,
    /// Behind `subdiv-rtl synth`.
    pub core: String,
    /// The clock that was asked for.
    pub target_mhz: f64,
    pub luts: u64,
    pub flip_flops: u64,
    pub mhz: f64,
}

/// What is known of a family before anything is measured: the cells of the ECP5.
const FIRST: Constants = Constants {
    name: String::new(),
    flip_flops: 1.0,
    luts: Load {
        adder: 1.0,
        further: 2.0,
        gates: 1.0,
        folded: 0.2,
        absorbed: 0.0,
        memory: 1.0,
        delay: 0.0,
        product: 0.0,
    },
    clock: Clock {
        base: 1.3,
        adder: 0.8,
        gate: 0.4,
        carry: 0.025,
        multiplier: 5.0,
        fan_out: 0.05,
        size: 0.1,
    },
};

impl Calibration {
    /// The one that the program was built with.
    ///
    /// # Errors
    /// None that a user can cause.
    pub fn built_in() -> Result<Calibration> {
        toml::from_str(FILE).map_err(|error| {
            Error::new(Kind::ToolFailed, format!("the calibration cannot be read: {}", error.message()))
        })
    }

    pub fn constants(&self, family: Family) -> Option<&Constants> {
        self.family.iter().find(|constants| constants.name == family.name())
    }

    /// Fits the constants of every family that has points, given what was counted in the core of each point.
    pub fn fit(&mut self, features: &[Features]) {
        let mut known = FIRST;
        for family in [Family::Ecp5, Family::Ice40, Family::Gowin, Family::Nexus] {
            let measured: Vec<Measured> = features
                .iter()
                .zip(&self.point)
                .filter_map(|(core, point)| Some((core, point, Device::named(&point.device).ok()?)))
                .filter(|(_, _, device)| device.family == family)
                .collect();
            if measured.is_empty() {
                continue;
            }
            let first = Constants { luts: first(family, known.luts), ..known.clone() };
            let fitted = Constants { name: family.name().into(), ..fitted(&first, &measured) };
            self.family.retain(|constants| constants.name != fitted.name);
            self.family.push(fitted.clone());
            // The others are like the ECP5, as far as they do not say otherwise.
            if family == Family::Ecp5 {
                known = fitted;
            }
        }
    }

    /// The file anew.
    ///
    /// # Errors
    /// None that a user can cause.
    pub fn text(&self) -> Result<String> {
        let body = toml::to_string(self).map_err(|error| {
            Error::new(Kind::ToolFailed, format!("the calibration cannot be written: {error}"))
        })?;
        Ok(format!(
            "# Cores that were placed and routed (see 'point'), and the constants that are fitted to them.\n\
             # Measured and written anew by: cargo test --release --test suite calibration:: -- --ignored measured_anew\n\n{body}"
        ))
    }
}

/// How little a constant may leave what is known without a reason: few points do not decide all of them.
const TRUST: f64 = 1e-3;

/// What is counted in a core, what was measured, and on what.
type Measured<'a> = (&'a Features, &'a Point, &'static Device);

/// What is known of a family from its cells, beside what is known of the ECP5.
fn first(family: Family, ecp5: Load) -> Load {
    match family {
        Family::Ecp5 | Family::Nexus => ecp5,
        // A register takes a place of its own where no LUT is before it, and nothing goes into the cells of adders.
        Family::Ice40 => Load { folded: 1.0, absorbed: 1.0, delay: 1.0, product: 1.0, ..ecp5 },
        Family::Gowin => Load { folded: 1.0, absorbed: 1.0, delay: 1.0, ..ecp5 },
    }
}

fn fitted(known: &Constants, measured: &[Measured]) -> Constants {
    // Twice the square at a tenth, and more and more beyond: no core is to be far off.
    let weight = |estimate: f64, found: f64| {
        let square = (estimate / found - 1.0).powi(2);
        square * (1.0 + square / 0.01)
    };
    let stays = |values: &[f64], known: &[f64]| -> f64 {
        values.iter().zip(known).map(|(value, known)| TRUST * ((value - known) / (known + 0.1)).powi(2)).sum()
    };
    let first = known.luts.values();
    let luts = minimise(&first, |values| {
        let Ok(values) = <[f64; 8]>::try_from(values) else { return f64::INFINITY };
        let constants = Constants { luts: Load::of(values), ..known.clone() };
        let errors = measured
            .iter()
            .map(|(core, point, device)| weight(constants.luts(core, device), point.luts as f64));
        errors.sum::<f64>() + stays(&values, &first)
    });
    let registers = minimise(&[known.flip_flops], |values| {
        let of = |core: &Features| values[0] * core.register_bits as f64;
        measured.iter().map(|(core, point, _)| weight(of(core), point.flip_flops as f64)).sum()
    });
    let rounded = |value: f64| (value * 1e4).round() / 1e4;
    let luts = <[f64; 8]>::try_from(luts).map_or(known.luts, |values| Load::of(values.map(rounded)));
    // The clock depends on the area.
    let sized = Constants { flip_flops: rounded(registers[0]), luts, ..known.clone() };
    let Clock { base, adder, gate, carry, multiplier, fan_out, size } = known.clock;
    let first = [base, adder, gate, carry, multiplier, fan_out, size];
    let named = |values: &[f64]| match *values {
        [base, adder, gate, carry, multiplier, fan_out, size] => {
            Clock { base, adder, gate, carry, multiplier, fan_out, size }
        }
        _ => known.clock,
    };
    let clock = minimise(&first, |values| {
        let constants = Constants { clock: named(values), ..sized.clone() };
        let delays = measured
            .iter()
            .map(|(core, point, device)| weight(1e3 / constants.delay_ns(core, device), point.mhz));
        delays.sum::<f64>() + stays(values, &first)
    });
    Constants { clock: named(&clock.into_iter().map(rounded).collect::<Vec<_>>()), ..sized }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fpga::estimate::Path;

    #[test]
    fn constants_are_found_again_from_what_they_make() {
        let features = |adder: f64, gates: f64, adders: f64, carry: f64| Features {
            load: Load { adder, gates, ..Load::default() },
            register_bits: adder as u64,
            paths: vec![Path { adders, carry, ..Path::default() }],
            ..Features::default()
        };
        let cores = [
            features(1000.0, 200.0, 1.0, 10.0),
            features(3000.0, 2500.0, 3.0, 60.0),
            features(500.0, 900.0, 2.0, 20.0),
            features(4000.0, 100.0, 5.0, 40.0),
        ];
        let truth = Constants {
            luts: Load { adder: 1.2, gates: 0.7, ..FIRST.luts },
            clock: Clock { base: 1.0, adder: 0.6, carry: 0.04, ..FIRST.clock },
            flip_flops: 0.9,
            ..FIRST
        };
        let device = Device::named("ecp5-85k").unwrap();
        let point = |core: &Features| {
            let made = truth.estimate(core, device);
            let (luts, flip_flops, mhz) = (made.luts, made.flip_flops, made.clock_mhz);
            Point {
                device: device.name.into(),
                core: String::new(),
                target_mhz: 400.0,
                luts,
                flip_flops,
                mhz,
            }
        };
        let mut calibration = Calibration { family: vec![], point: cores.iter().map(point).collect() };
        calibration.fit(&cores);
        let found = calibration.constants(Family::Ecp5).unwrap();
        for (core, point) in cores.iter().zip(&calibration.point) {
            let made = found.estimate(core, device);
            assert!((made.luts as f64 / point.luts as f64 - 1.0).abs() < 0.02, "{found:?}");
            assert!((made.clock_mhz / point.mhz - 1.0).abs() < 0.02, "{found:?}");
            assert!(made.flip_flops.abs_diff(point.flip_flops) < 5, "{found:?}");
        }
    }
}
