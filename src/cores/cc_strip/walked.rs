//! The unit of a registered core that sends columns in slices: one row filter, and one walk around both ends.
//!
//! ```text
//! slice ──► rows in turn ──► sums ──► row filter ──► wait ──► rows
//! walk  ──► ends, a neighbour a clock ──► ring walk ────┴──► first and last row, left and right; fans
//! ```
//!
//! What steers it comes a clock before what it steers, and every row has copies of it: a register reaches few cells in
//! a clock.

use super::columns::row_names;
use super::engine::{Outgoing, Unit, chosen_by, equals};
use super::fan::{self, End};
use super::ring_walk::{self, Walked, fan_outputs};
use super::row_filter;
use super::wait::Waits;
use super::window::STAGES;
use crate::error::Result;
use crate::hdl::{Placed, Signal};

impl Unit<'_> {
    /// The slice that leaves, all of one clock, and the fans that go with its column by the names of their ports.
    pub(super) fn walked(
        &self,
        face: &Signal,
        valences: [Signal; 2],
        walk: &Signal,
        axis: Option<&Signal>,
        reader: Option<&Placed>,
    ) -> Result<(Outgoing, Vec<(String, Signal)>)> {
        let (m, p, cells) = (self.m, self.parameters, self.cells());
        let outside = self.level() + 1 < p.levels;

        let unit = ring_walk::build(p, self.level())?;
        let mut inputs = vec![("walk".to_string(), walk.clone())];
        inputs.extend(axis.filter(|_| outside).map(|axis| ("axis".to_string(), axis.clone())));
        for (end, valence) in End::BOTH.iter().zip(valences) {
            let view = self.end(*end, valence);
            inputs.push((format!("{}_valence", end.name()), view.valence.clone()));
            let places = fan::names(p).into_iter().zip(fan::signals(&view));
            inputs.extend(places.map(|(place, signal)| (format!("{}_{place}", end.name()), signal)));
        }
        let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
        let placed = m.instance("ring_walk", &unit, &inputs);
        let ends = Walked::of(&placed, outside);
        let done = ends.ends[0][0].time().unwrap_or(0);

        // The rows in turn.
        let names = row_names(cells);
        let in_turn = |column| -> Vec<Option<Signal>> {
            names.iter().zip(-1..).map(|(name, at)| self.row_in_turn(column, name, at)).collect()
        };
        let rows = reader.map_or_else(|| [0, 1, 2].map(in_turn), |reader| self.rows_read(reader));
        let filter = row_filter::build(p, self.level(), cells, self.sliced())?;
        let mut inputs = vec![("face".to_string(), face.clone())];
        for (stage, rows) in STAGES.iter().zip(&rows) {
            let named = names.iter().zip(rows);
            inputs.extend(named.filter_map(|(name, row)| Some((format!("{stage}_{name}"), row.clone()?))));
        }
        let inputs: Vec<(&str, &Signal)> = inputs
            .iter()
            .filter(|(name, _)| filter.input(name).is_some())
            .map(|(name, signal)| (name.as_str(), signal))
            .collect();
        let made = m.instance("row_filter", &filter, &inputs);

        // The rows wait for the ends, and with them what says whose they are.
        let names: Vec<String> = (0..=2 * cells).map(|u| format!("row_{u}")).collect();
        let last = names.len() - 1;
        let all = |names: &[String]| -> Vec<(String, Signal)> {
            names.iter().map(|name| (name.clone(), made.out(name))).collect()
        };
        let waits = Waits::new(m, p);
        let inner = waits.until("row_slot", &all(&names[1..last]), done + 1);
        let mut outer = vec![names[0].clone(), names[last].clone()];
        if outside {
            outer.extend(["face_above".to_string(), "face_below".into()]);
        }
        let outer = waits.until("end_slot", &all(&outer), done);
        let first_slice = equals(m, self.slice, 0).unwrap_or_else(|| m.bit(true));
        let replaces = m.pipe("replaces_top", &first_slice & &!face);
        let flags = [("replaces_top".to_string(), replaces), ("is_face".into(), m.pipe("is_face", face))];
        let flags = waits.until("flag_slot", &flags, done - 1);
        let copy = |name: &str, flag: &Signal| m.copy(name, flag);

        let [top, bottom] = &ends.ends;
        let first = m.select(&copy("top_replaced", &flags[0]), &top[0], &outer[0]);
        let last = m.select(&copy("bottom_kept", &flags[1]), &outer[1], &bottom[0]);
        let [first, last] =
            [("column_top", first), ("column_bottom", last)].map(|(name, row)| m.pipe(name, row));
        let rows = [vec![first], inner, vec![last]].concat();
        let columns = Outgoing { rows, outside: vec![] };
        if !outside {
            return Ok((columns, vec![]));
        }
        let mut beside = vec![];
        for (at, end) in End::BOTH.iter().enumerate() {
            let point = &outer[2 + at];
            for (side, name) in ["left", "right"].iter().enumerate() {
                let name = format!("{}_beside_{name}", end.name());
                let on_face = copy(&format!("{name}_of_face"), &flags[1]);
                beside.push(m.pipe(name, m.select(&on_face, point, &ends.ends[at][1 + side])));
            }
        }
        let names = fan_outputs(p, self.level()).into_iter();
        let fans = names.map(|name| (name.clone(), m.restart(&placed.out(&name), done + 1))).collect();
        Ok((Outgoing { outside: beside, ..columns }, fans))
    }

    /// Binary digits of the slice that choose among its rows in a clock.
    const DIGITS_IN_A_CLOCK: usize = 2;

    /// Row `at` of a column, of the slice in turn: a clock later where there are slices to choose from, two where many.
    fn row_in_turn(&self, column: usize, name: &str, at: i64) -> Option<Signal> {
        let [columns] = self.columns else { return None };
        let slices = self.group.slices(columns.level);
        let rows: Vec<Option<Signal>> =
            (0..slices).map(|p| columns.row(column, i64::from(p * self.cells()) + at)).collect();
        if slices == 1 {
            return rows[0].clone();
        }
        let stage = STAGES[column];
        let digits: Vec<Signal> = self
            .slice
            .iter()
            .enumerate()
            .map(|(bit, digit)| self.m.copy(format!("{stage}_{name}_digit_{bit}"), digit))
            .collect();
        if digits.len() <= Self::DIGITS_IN_A_CLOCK {
            let chosen = chosen_by(self.m, &digits, rows)?;
            return Some(self.m.pipe(format!("{stage}_{name}"), &chosen));
        }
        let (first, rest) = digits.split_at(Self::DIGITS_IN_A_CLOCK);
        let of_first = rows.chunks(1 << first.len()).zip(0..).map(|(some, nth)| {
            let chosen = chosen_by(self.m, first, some.to_vec())?;
            Some(self.m.pipe(format!("{stage}_{name}_of_{nth}"), &chosen))
        });
        let of_first: Vec<Option<Signal>> = of_first.collect();
        let rest: Vec<Signal> = rest
            .iter()
            .zip(first.len()..)
            .map(|(digit, bit)| self.m.copy(format!("{stage}_{name}_digit_{bit}_later"), digit))
            .collect();
        let chosen = chosen_by(self.m, &rest, of_first)?;
        Some(self.m.pipe(format!("{stage}_{name}"), &chosen))
    }
}
