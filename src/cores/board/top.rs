//! Evaluator and sink put together; the board's wrapper adds clock, reset and pins.
//!
//! ```text
//! after reset, once ──┐  start   ┌───────────┐ vertex stream ┌──────┐
//! button ─► debounced ┴────────► │ evaluator │──────────────►│ sink │──► its own ports, led_busy
//!                                └───────────┘               └──────┘
//! ```

use std::rc::Rc;

use super::{FLAGS, VertexStream, button, coordinate_names};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// Inputs: `button`, 1 while pressed, and what the sink takes beside the stream. Outputs: `led_busy`; `led_done`,
/// 1 from the end of the first mesh on; what the sink gives beside `ready` and `busy`.
///
/// The mesh is evaluated once after the reset and again each time the button has been down for 2^`log_quiet`
/// clocks.
///
/// # Errors
/// A sink without the ports of the vertex stream.
pub fn build(evaluator: &Rc<Module>, sink: &Rc<Module>, log_quiet: u32) -> Result<Rc<Module>> {
    let m = Builder::new("mesh_board");
    m.purpose(
        "A mesh in block RAM, evaluated after reset and at each press of the button, and sent to the sink.",
    );
    let pin = m.input("button", Word::bit());
    let button = m.instance("button_input", &button::build(log_quiet)?, &[("pin", &pin)]);
    let fresh = m.register_reset("fresh", Word::bit(), 1);
    let sink_ready = m.forward("sink_ready", Word::bit());
    let sink_busy = m.forward("sink_busy", Word::bit());

    // A start while a mesh is under way is none: the evaluator ignores it, and so it must not wait for the sink.
    let start = m.wire("start", (&fresh | button.out("pressed")) & !&sink_busy);
    m.always(&fresh, m.bit(false));
    let evaluator = m.instance("evaluator", evaluator, &[("start", &start), ("ready", &sink_ready)]);
    let stream = VertexStream {
        coordinates: coordinate_names().iter().map(|name| evaluator.out(name)).collect(),
        flags: FLAGS.iter().map(|name| evaluator.out(name)).collect(),
        valid: evaluator.out("valid"),
    };

    let mut inputs: Vec<(String, Signal)> = stream.ports();
    for &id in &sink.inputs {
        let port = sink.node(id);
        let name = port.name.clone().unwrap_or_default();
        if !inputs.iter().any(|(known, _)| *known == name) {
            inputs.push((name.clone(), m.input(&name, port.word)));
        }
    }
    let inputs: Vec<_> = inputs.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
    let placed = m.instance("sink", sink, &inputs);
    m.drive(&sink_ready, placed.out("ready"));
    m.drive(&sink_busy, placed.out("busy"));

    let busy = m.wire("busy", evaluator.out("running") | &sink_busy);
    let was_busy = m.register_reset("was_busy", Word::bit(), 0);
    m.always(&was_busy, &busy);
    let done = m.register_reset("done", Word::bit(), 0);
    m.on(&(&was_busy & !&busy), &done, m.bit(true));
    m.output("led_busy", &busy);
    m.output("led_done", &done);
    for output in sink.outputs.iter().filter(|o| !["ready", "busy"].contains(&o.name.as_str())) {
        m.output(&output.name, placed.out(&output.name));
    }
    m.finish()
}
