//! Gathers the 12 control points of a patch and hands them over one axis per clock.
//!
//! ```text
//! clock     0 .. 11        12      13      14
//!           points 0..11   x       y       z          tready is low in 12 and 13
//! ```

use std::rc::Rc;

use super::{AXES, LEVEL_BITS, Parameters};
use crate::error::Result;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

/// Inputs: the stream, and `slot_free`: the engines can keep another patch. Outputs: `ready`; `p0` .. `p11`
/// of one axis with `strobe`, `axis` and `level`, a clock after they are chosen.
pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("patch_loader");
    m.purpose("Gathers the 12 control points of a patch, then hands over x, y and z in three clocks.");
    let valid = m.input("valid", Word::bit());
    let last = m.input("last", Word::bit());
    let user = m.input("level_in", Word::unsigned(LEVEL_BITS));
    let points = AXES.map(|axis| m.input(format!("point_{axis}"), parameters.point()));
    let slot_free = m.input("slot_free", Word::bit());

    // full: 12 points are here. axis: the one being handed over.
    let full = m.register_reset("full", Word::bit(), 0);
    let axis = m.register_reset("axis", Word::range(0, 2), 0);
    let started = m.wire("started", !m.is(&axis, 0));
    let strobe = m.wire("strobe_now", &full & &(&started | &slot_free));
    let leaving = m.wire("leaving", &strobe & m.is(&axis, 2));
    let next_axis = m.wrap(&axis + 1, Word::unsigned(2));
    m.on(&leaving, &axis, m.constant(0, axis.word()));
    m.on(&strobe, &axis, m.wrap(&next_axis, axis.word()));

    // A patch may arrive while the last axis of the one before leaves.
    let ready = m.wire("ready", !&full | &leaving);
    let accept = m.wire("accept", &valid & &ready);

    // 0 .. 11: the number of points here; 12: too many, skip to the end of the packet.
    let count = m.register_reset("count", Word::range(0, 12), 0);
    let overlong = m.is(&count, 12);
    let counted = m.wrap(&count + 1, count.word());
    m.on(&(&accept & &last), &count, m.constant(0, count.word()));
    m.on(&(&accept & !&overlong), &count, &counted);
    let known = m.compare(
        Relation::LessOrEqual,
        &user,
        m.constant(parameters.max_level.into(), Word::range(0, parameters.max_level.into())),
    );
    let known = if parameters.max_level + 1 == 1 << LEVEL_BITS { m.bit(true) } else { known };
    let known = if parameters.min_level == 0 {
        known
    } else {
        let lowest = m.constant(parameters.min_level.into(), Word::range(0, parameters.min_level.into()));
        &known & m.compare(Relation::LessOrEqual, &lowest, &user)
    };
    let complete = m.all(&[&accept, &last, &m.is(&count, 11), &known]);
    m.on(&complete, &full, m.bit(true));
    m.on(&leaving, &full, m.bit(false));

    let level = m.register("level_kept", parameters.level());
    m.on(&complete, &level, m.wrap(&user, parameters.level()));

    let banks = [0, 1, 2].map(|i| bank(&m, AXES[i], &points[i], &accept));
    let (first, second) = (m.is(&axis, 0), m.is(&axis, 1));
    let [x, y, z] = banks;
    for (index, ((x, y), z)) in x.iter().zip(&y).zip(&z).enumerate() {
        let chosen = m.select(&first, x, m.select(&second, y, z));
        let p = m.pipe(format!("p{index}"), &chosen);
        m.output(format!("p{index}"), &p);
    }
    m.output("strobe", m.pipe_reset("strobe", &strobe, 0));
    m.output("axis_out", m.pipe("axis_out", &axis));
    m.output("level", m.pipe("level", &level));
    m.output("ready", &ready);
    // The slot is taken from the first axis on.
    m.output("begins", m.wire("begins", &strobe & &first));
    m.finish()
}

/// A shift register: after 12 points, the first of them is `.._0`.
fn bank(m: &Builder, axis: &str, point: &Signal, accept: &Signal) -> Vec<Signal> {
    let bank: Vec<Signal> = (0..12).map(|i| m.register(format!("{axis}_{i}"), point.word())).collect();
    for (index, register) in bank.iter().enumerate() {
        m.on(accept, register, bank.get(index + 1).unwrap_or(point));
    }
    bank
}
