//! A push button as a signal of one clock: brought to the clock, and quiet for a while before it counts.

use std::rc::Rc;

use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

/// Input: `pin`, 1 while pressed, of no clock. Output: `pressed`, 1 for one clock when the pin has been 1 for
/// 2^`log_quiet` clocks on end, again after it has been 0.
pub fn build(log_quiet: u32) -> Result<Rc<Module>> {
    let m = Builder::new("button");
    m.purpose(format!("One clock of `pressed` when the pin has been 1 for 2^{log_quiet} clocks on end."));
    let pin = m.input("pin", Word::bit());
    let meta = m.register_reset("meta", Word::bit(), 0);
    let level = m.register_reset("level", Word::bit(), 0);
    m.always(&meta, &pin);
    m.always(&level, &meta);

    let most = (1i128 << log_quiet) - 1;
    let quiet = m.register_reset("quiet", Word::range(0, most), 0);
    let full = m.wire("full", m.is(&quiet, most));
    m.on(&!&level, &quiet, m.constant(0, quiet.word()));
    m.on(&!&full, &quiet, m.wrap(&quiet + 1, quiet.word()));
    let held = m.register_reset("held", Word::bit(), 0);
    m.always(&held, &full);
    m.output("pressed", m.wire("pressed", &full & !&held));
    m.finish()
}
