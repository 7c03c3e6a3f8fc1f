//! Gathers the words of a column: one register for each place, filled as the words say where they belong.

use std::rc::Rc;

use super::level::column_names;
use super::outside::End;
use super::{Parameters, Role, USER_BITS, VALENCE_BITS};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// Inputs: the stream (`valid`, `user`, `last`) and `taken` (level 0 takes the column). Outputs: `ready`,
/// one `write_..` for each place of a column, and the gathered column's `full`, `first`, `ending` and valences.
pub fn control(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("column_loader");
    m.purpose("Tells every word of the stream its place in the column, and when the column is complete.");
    let [valid, last, taken] = ["valid", "last", "taken"].map(|n| m.input(n, Word::bit()));
    let user = m.input("user", Word::unsigned(USER_BITS));
    let role = m.slice(&user, 0, 2);
    let valence = m.slice(&user, 2, VALENCE_BITS);
    let [complete, first] = [7, 8].map(|bit| m.slice(&user, bit, 1));

    let full = m.register_reset("full", Word::bit(), 0);
    let ready = m.wire("ready", !&full | &taken);
    let accept = m.wire("accept", &valid & &ready);
    let is =
        |r: Role| m.wire(format!("is_{}", format!("{r:?}").to_lowercase()), &accept & m.is(&role, r as i128));
    let [vertex, fan, left, right] = [Role::Vertex, Role::Fan, Role::OutsideLeft, Role::OutsideRight].map(is);
    let finished = m.wire("finished", &accept & &complete);
    m.on(&finished, &full, m.bit(true));
    m.on(&taken, &full, m.bit(false));

    // The end of the column that the words belong to: the first vertex is the top one.
    let at_bottom = m.register_reset("at_bottom", Word::bit(), 0);
    let begun = m.register_reset("begun", Word::bit(), 0);
    m.on(&finished, &begun, m.bit(false));
    m.on(&vertex, &begun, m.bit(true));
    m.on(&vertex, &at_bottom, &begun);
    let top_vertex = m.wire("top_vertex", &vertex & !&begun);
    let bottom_vertex = m.wire("bottom_vertex", &vertex & &begun);

    let places = 2 * parameters.outside_neighbours() - 1;
    let entry = Word::range(0, places as i128);
    let index = m.register_reset("index", entry, 0);
    m.on(&vertex, &index, m.constant(0, entry));
    m.on(&fan, &index, m.wrap(&index + 1, entry));

    m.output("write_row_0", &top_vertex);
    m.output("write_row_1", &bottom_vertex);
    for end in End::BOTH {
        let here = if end == End::Top { !&at_bottom } else { at_bottom.clone() };
        let here = m.wire(format!("at_{}", end.name()), &here);
        let write = |name: String, when: Signal| {
            m.output(
                format!("write_{}_{name}", end.name()),
                m.wire(format!("write_{}_{name}", end.name()), &here & when),
            );
        };
        // The first entry of a fan is also the outside vertex on the left, the last neighbour that on the right.
        write("left".into(), &left | (&fan & m.is(&index, 0)));
        let even = !m.slice(&index, 0, 1);
        write("right".into(), &right | (&fan & even));
        for place in 0..places {
            let name =
                if place % 2 == 0 { format!("a_{}", place / 2 + 1) } else { format!("x_{}", place / 2 + 2) };
            write(name, &fan & m.is(&index, place as i128));
        }
    }
    for (end, vertex) in [("top", &top_vertex), ("bottom", &bottom_vertex)] {
        let kept = m.register(format!("{end}_valence"), Word::unsigned(VALENCE_BITS));
        m.on(vertex, &kept, &valence);
        m.output(format!("{end}_valence"), &kept);
    }
    let [first_kept, last_kept] = ["first", "ending"].map(|n| m.register(n, Word::bit()));
    m.on(&finished, &first_kept, &first);
    m.on(&finished, &last_kept, &last);
    m.output("ready", &ready);
    m.output("full", &full);
    m.output("first", &first_kept);
    m.output("ending", &last_kept);
    m.finish()
}

/// One coordinate of the gathered column. Inputs: `word` and the `write_..`; outputs: the places.
pub fn column(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("column_registers");
    m.purpose("One coordinate of the column that is being gathered.");
    let word = m.input("word", parameters.input_word());
    for name in column_names(parameters, 0) {
        let write = m.input(format!("write_{name}"), Word::bit());
        let register = m.register(name.clone(), parameters.input_word());
        m.on(&write, &register, &word);
        m.output(name, &register);
    }
    m.finish()
}
