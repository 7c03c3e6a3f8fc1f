//! The unit of a registered core: one row filter for both columns, one fan unit for both ends.
//!
//! ```text
//! rows ──► row filter ───────────────────────────────────► rows
//! top end    ──┐ top in one clock,                ┌──────► row 0, left and right of it
//! bottom end ──┴ bottom in another ──► fan unit ──┴──────► last row, left and right of it
//! ```
//!
//! A column in slices has its top in the first of them and its bottom in the last. Of a whole one the top is looked
//! at in the clock in which the vertex column leaves, the bottom in the one behind it: there the face column waits
//! at least, and the window stands.

use super::columns::row_names;
use super::engine::{Outgoing, Unit, equals};
use super::fan::{self, End, Replaced};
use super::fan_registered;
use super::row_filter;
use super::view::EndView;
use super::wait::Waits;
use crate::error::Result;
use crate::hdl::Signal;

impl Unit<'_> {
    /// The column that leaves, all of one clock.
    pub(super) fn registered(&self, face: &Signal, valences: [Signal; 2]) -> Result<Outgoing> {
        let (m, p, cells) = (self.m, self.parameters, self.cells());
        let waits = Waits::new(m, p);
        let filter = row_filter::build(p, self.level(), cells, self.sliced())?;
        let mut inputs = vec![("face".to_string(), face.clone())];
        let seen = |row: &str| row != "below" && (row != "above" || self.sliced());
        for (side, rows) in [("old", self.sums(true)), ("s", self.sums(false))] {
            let rows = rows.into_iter().filter(|(row, _)| side == "s" || seen(row));
            inputs.extend(rows.map(|(row, signal)| (format!("{side}_{row}"), signal)));
        }
        for (row, at) in row_names(cells).iter().zip(-1..).filter(|(row, _)| self.sliced() || seen(row)) {
            inputs.extend(self.row(1, at).map(|signal| (format!("column_{row}"), signal)));
        }
        let inputs: Vec<(&str, &Signal)> = inputs
            .iter()
            .filter(|(name, _)| filter.input(name).is_some())
            .map(|(name, signal)| (name.as_str(), signal))
            .collect();
        let rows = m.instance("row_filter", &filter, &inputs);

        // Which end the fan unit looks at.
        let last_slice = equals(m, self.slice, (1 << self.slice.len()) - 1);
        let at_bottom = last_slice.unwrap_or_else(|| face.clone());
        let [top, bottom] = [0, 1].map(|at| self.end(End::BOTH[at], valences[at].clone()));
        let view = self.either(&at_bottom, &top, &bottom);
        let placed = fan::place(m, p, &fan_registered::build(p, self.level())?, "fan", &view);
        let placed = placed.together(&waits);
        let (top, bottom) = match self.sliced() {
            true => (placed.each(Signal::clone), placed),
            false => (
                placed.each(|signal| m.pipe("top", signal)),
                placed.each(|signal| m.restart(signal, signal.time().unwrap_or(0) + 1)),
            ),
        };

        // The rows wait for the fan unit.
        let names =
            (0..=2 * cells).map(|u| format!("row_{u}")).chain(["face_above".into(), "face_below".into()]);
        let made: Vec<(String, Signal)> = names.map(|name| (name.clone(), rows.out(&name))).collect();
        let ready = [&top, &bottom].into_iter().filter_map(Replaced::time).max().unwrap_or(0);
        let mut rows = waits.until("row_slot", &made, ready);
        let below = rows.remove(made.len() - 1);
        let above = rows.remove(made.len() - 2);

        let first_slice = equals(m, self.slice, 0);
        let mut out = vec![];
        for (u, row) in (0..).zip(&rows) {
            let name = format!("column_row_{u}");
            out.push(match (u, &first_slice) {
                (0, Some(first)) => {
                    let replaced = first & &!face;
                    m.pipe(name, m.select(&replaced, &top.vertex, row))
                }
                (0, None) => m.pipe(name, m.select(face, row, &top.vertex)),
                _ if u == 2 * cells => m.pipe(name, m.select(face, row, &bottom.vertex)),
                _ => m.pipe(name, row),
            });
        }
        let outside = |end: Replaced, name: &str, point: Signal| {
            let beside = |side: &str, vertex: &Signal| {
                m.pipe(format!("{name}_beside_{side}"), m.select(face, &point, vertex))
            };
            // A face column brings no fan.
            [vec![beside("left", &end.left), beside("right", &end.right)], end.fan].concat()
        };
        let outside = [outside(top, "top", above), outside(bottom, "bottom", below)];
        let outside = outside.concat();
        let time = out.iter().chain(&outside).filter_map(Signal::time).max().unwrap_or(0);
        let together = |signals: Vec<Signal>| signals.iter().map(|s| m.at_time(s, time)).collect();
        Ok(Outgoing { rows: together(out), outside: together(outside) })
    }

    fn either(&self, at_bottom: &Signal, top: &EndView, bottom: &EndView) -> EndView {
        let m = self.m;
        let pick = |name: String, top: &Signal, bottom: &Signal| {
            m.pipe(format!("end_{name}"), m.select(at_bottom, bottom, top))
        };
        let three = |name: &str, top: &[Signal; 3], bottom: &[Signal; 3]| {
            [0, 1, 2].map(|column| pick(format!("{name}_{column}"), &top[column], &bottom[column]))
        };
        let list = |name: &str, top: &[Signal], bottom: &[Signal]| -> Vec<Signal> {
            let pairs = top.iter().zip(bottom).enumerate();
            pairs.map(|(i, (top, bottom))| pick(format!("{name}_{i}"), top, bottom)).collect()
        };
        EndView {
            outer: three("outer", &top.outer, &bottom.outer),
            inner: three("inner", &top.inner, &bottom.inner),
            before: pick("before".into(), &top.before, &bottom.before),
            after: pick("after".into(), &top.after, &bottom.after),
            neighbours: list("neighbour", &top.neighbours, &bottom.neighbours),
            diagonals: list("diagonal", &top.diagonals, &bottom.diagonals),
            valence: pick("valence".into(), &top.valence, &bottom.valence),
        }
    }
}
