//! Pipelining to a target: of the forms of a core, the first one that is estimated to reach a clock.
//!
//! ```text
//!   whole ─► chunks of 64 bits ─► 48 ─► ... ─► 4            each form faster and longer on its way than the one before
//!                                  └── the first that the delay model of the device finds fast enough
//! ```

use std::rc::Rc;

use super::device::Device;
use super::estimate::{Estimate, estimate};
use crate::error::{Error, Result};
use crate::hdl::Module;

/// A clock on a device.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    pub device: &'static Device,
    pub mhz: f64,
}

/// Bits of a chunk, none for whole numbers, the longest carry first.
pub const CHUNKS: [Option<u32>; 15] = [
    None,
    Some(64),
    Some(48),
    Some(40),
    Some(32),
    Some(28),
    Some(24),
    Some(20),
    Some(18),
    Some(15),
    Some(12),
    Some(10),
    Some(8),
    Some(6),
    Some(4),
];

/// The first form that reaches the goal, its core and its estimate.
///
/// # Errors
/// `Usage` where no form reaches the goal, with the fastest one, and for a device that no core was measured on; a core
/// that cannot be built.
pub fn first_fast_enough<F: Copy>(
    goal: Goal,
    forms: impl IntoIterator<Item = F>,
    build: impl Fn(F) -> Result<Rc<Module>>,
    describe: impl Fn(F) -> String,
) -> Result<(F, Rc<Module>, Estimate)> {
    let Goal { device, mhz } = goal;
    let mut fastest: Option<(F, Estimate)> = None;
    for form in forms {
        let core = build(form)?;
        let Some(found) = estimate(&core, device)? else {
            return Err(Error::usage(format!(
                "no core was measured on {}, so that no clock can be estimated",
                device.name
            ))
            .help("leave out --clock, or aim for an ECP5, iCE40 or Gowin device"));
        };
        if found.clock_mhz >= mhz {
            return Ok((form, core, found));
        }
        if fastest.as_ref().is_none_or(|(_, other)| found.clock_mhz > other.clock_mhz) {
            fastest = Some((form, found));
        }
    }
    let why = format!("no form of this core reaches {mhz} MHz on {}", device.name);
    Err(match fastest {
        Some((form, found)) => {
            let form = describe(form);
            Error::usage(format!("{why}: the fastest, {form}, is estimated at {:.0} MHz", found.clock_mhz))
                .help(format!("aim for --clock {:.0}MHz or less, or take {form}", found.clock_mhz.floor()))
        }
        None => Error::usage(why).help("leave out --clock"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hdl::skew::{SkewedPorts, skew};
    use crate::hdl::{Builder, Word};

    fn adder(chunk: Option<u32>) -> Result<Rc<Module>> {
        let m = Builder::new("adder");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::modular(64)));
        m.output("y", m.pipe("y", m.wrap(&a + &b, Word::modular(64))));
        let whole = m.finish()?;
        chunk.map_or(Ok(whole.clone()), |chunk| skew(&whole, chunk, SkewedPorts::default()))
    }

    fn aimed(mhz: f64) -> Result<(Option<u32>, Estimate)> {
        let goal = Goal { device: Device::named("ecp5-85k").unwrap(), mhz };
        let (chunk, _, found) = first_fast_enough(goal, CHUNKS, adder, |chunk| format!("{chunk:?}"))?;
        Ok((chunk, found))
    }

    #[test]
    fn a_higher_clock_asks_for_narrower_chunks_and_one_beyond_all_is_refused() {
        let whole = aimed(1.0).unwrap();
        assert_eq!(whole.0, None);
        let (chunk, found) = aimed(whole.1.clock_mhz + 20.0).unwrap();
        assert!(chunk.is_some_and(|chunk| chunk < 64) && found.clock_mhz >= whole.1.clock_mhz + 20.0);
        let refused = aimed(4000.0).unwrap_err();
        assert_eq!(refused.exit_status(), 2);
        assert!(refused.to_string().contains("the fastest"), "{refused}");
    }
}
