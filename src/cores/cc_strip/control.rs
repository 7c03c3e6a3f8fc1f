//! The control of one level: a window of three columns, and which column leaves.
//!
//! ```text
//! column c arrives      c = -1   nothing leaves
//!                       c =  0   the face column -1
//!                       c >= 1   the vertex column 2 (c - 1), then the face column 2 c - 1
//! ```
//!
//! So the next level receives exactly the columns -1 .. 2 M + 1 of the finer strip, in order.

use std::rc::Rc;

use super::VALENCE_BITS;
use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

/// Inputs: the column that is offered (`valid`, `first`, `last`, its valences) and `out_ready`. Outputs:
/// `ready`, `arrive` (the window moves), `face` (which column leaves), the valences of the middle column, and
/// the column that leaves (`out_valid`, `out_first`, `out_last`, `ending`, its valences).
pub fn build() -> Result<Rc<Module>> {
    let m = Builder::new("level_control");
    m.purpose("Moves the window of a level and says which of its two columns leaves.");
    let [valid, first, last, out_ready] =
        ["valid", "first", "last", "out_ready"].map(|n| m.input(n, Word::bit()));
    let valence = Word::unsigned(VALENCE_BITS);
    let valences = ["top", "bottom"].map(|end| m.input(format!("{end}_valence"), valence));

    let [vertex, face] = ["vertex", "face"].map(|n| m.register_reset(n, Word::bit(), 0));
    let leaves = m.wire("out_valid", &vertex | &face);
    let gone = m.wire("gone", &leaves & &out_ready);
    let ready = m.wire("ready", !&leaves | (&face & &out_ready));
    let arrive = m.wire("arrive", &valid & &ready);

    // How many columns of the strip are here: none or one (0), two (1), three (2).
    let age = m.register_reset("age", Word::range(0, 2), 0);
    let second = m.wire("second", m.all(&[&arrive, &!&first, &m.is(&age, 0)]));
    let later = m.wire("later", m.all(&[&arrive, &!&first, &!m.is(&age, 0)]));
    m.on(&(&arrive & &first), &age, m.constant(0, age.word()));
    m.on(&second, &age, m.constant(1, age.word()));
    m.on(&later, &age, m.constant(2, age.word()));

    m.on(&later, &vertex, m.bit(true));
    m.on(&gone, &vertex, m.bit(false));
    m.on(&(&vertex & &out_ready), &face, m.bit(true));
    m.on(&second, &face, m.bit(true));
    m.on(&gone, &face, m.bit(false));

    let ends = m.register_reset("ends", Word::bit(), 0);
    m.on(&arrive, &ends, &last);
    for (end, incoming) in ["top", "bottom"].iter().zip(&valences) {
        let next = m.register(format!("{end}_next"), valence);
        let middle = m.register(format!("{end}_middle"), valence);
        m.on(&arrive, &next, incoming);
        m.on(&arrive, &middle, &next);
        m.output(format!("{end}_degree"), &middle);
        let regular = m.constant(4, valence);
        m.output(format!("{end}_out"), m.wire(format!("{end}_out"), m.select(&face, &regular, &middle)));
    }
    m.output("ready", &ready);
    m.output("arrive", &arrive);
    m.output("is_face", &face);
    m.output("out_valid", &leaves);
    m.output("out_first", m.wire("out_first", &face & m.is(&age, 1)));
    m.output("out_last", m.wire("out_last", &face & &ends));
    m.output("ending", m.wire("ending", &vertex & &ends));
    m.finish()
}
