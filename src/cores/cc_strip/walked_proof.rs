//! What the proof of a walked core has beside the slices: the fans, which leave by themselves, and windows in RAMs.

use std::collections::BTreeMap;

use super::places::BY_AXIS;
use super::proof::{Statement, VARIABLES, Window, form};
use super::ring_walk::{Times, strobe_endings, strobes};
use super::row_reader::{self, BANK};
use super::window::{KEPT, STAGES};
use crate::error::{Error, Kind, Result};
use crate::fixed::Form;
use crate::hdl::linear::Value;
use crate::hdl::{LinearForms, NodeId, Simulator};

impl Statement<'_> {
    /// The walk around both ends, whose fans leave by themselves; the rest is kept for the slices. Returns how many
    /// vertices were compared.
    pub(super) fn walk(
        &self,
        simulator: &mut Simulator<LinearForms<VARIABLES>>,
        delay: u32,
        expected: &dyn Fn(&str) -> Option<Form<VARIABLES>>,
    ) -> Result<u64> {
        let Statement { parameters, level, valences, .. } = *self;
        let mut compared = 0;
        // Of the coordinate in turn.
        let endings = strobe_endings(parameters, level);
        let ending = endings.get(self.turn.unwrap_or(0)).cloned().unwrap_or_default();
        for clock in 0..delay + Times::of(parameters).clocks() {
            if let Some(id) = simulator.flat.input("walk") {
                simulator.set(id, Value::Integer(i128::from(clock == 0)));
            }
            simulator.settle();
            simulator.edge(false)?;
            simulator.settle();
            let out = |name: &str| simulator.flat.output(name).map(|id| *simulator.get(id));
            for strobe in strobes(parameters) {
                if out(&format!("out_{strobe}{ending}")) != Some(Value::Integer(1)) {
                    continue;
                }
                let (end, number) = strobe.split_once("_fan_").unwrap_or_default();
                for kind in ["a", "x"] {
                    let place = format!("{end}_{kind}_{number}");
                    let Some(expected) = expected(&place) else { continue };
                    match out(&format!("out_fan_{kind}")) {
                        Some(Value::Form(form)) if form.canonical() == expected => compared += 1,
                        _ => {
                            let place = format!("level {level}, valences {valences:?}, walk, {place}");
                            let what = "an entry of a fan is another function of the window";
                            return Err(Error::new(Kind::Mismatch, what).at(place));
                        }
                    }
                }
            }
        }
        let entries: u32 = valences.iter().map(|d| 2 * d.saturating_sub(4)).sum();
        if level + 1 < parameters.levels && compared != u64::from(entries) {
            let what = format!("{compared} entries of fans leave, not {entries}");
            return Err(Error::new(Kind::Mismatch, what).at(format!("level {level}, valences {valences:?}")));
        }
        Ok(compared)
    }

    /// The window where it is kept in RAMs: that of the coordinate in turn, while nothing is known of the others; or its
    /// rows in the banks of a row reader, the next column in the bank `turn`.
    pub(super) fn in_rams(
        &self,
        simulator: &mut Simulator<LinearForms<VARIABLES>>,
        registers: &BTreeMap<String, NodeId>,
        window: &Window,
        turn: usize,
    ) {
        let here = format!("window_{}.", self.level);
        for number in 0..simulator.flat.memories.len() {
            let name = &simulator.flat.memories[number].name;
            let place = name.strip_prefix(&here).and_then(|name| name.strip_suffix(BY_AXIS));
            let held = place.and_then(|name| window.register(name.trim_end_matches(KEPT), false));
            held.into_iter().for_each(|mask| simulator.set_word(number, turn, Value::Form(form(&mask))));
        }
        if let Some(&bank) = registers.get(&format!("row_reader.{BANK}")) {
            simulator.set(bank, Value::Integer(turn as i128));
        }
        let places = (0..STAGES.len()).flat_map(|column| [0, 1].map(|parity| (column, parity)));
        for (column, parity) in places {
            let bank = row_reader::bank_of(column, turn as u32);
            let name = format!("row_reader.{}", row_reader::ram(parity, bank));
            let Some(number) = simulator.flat.memories.iter().position(|memory| memory.name == name) else {
                continue;
            };
            for (address, row) in window.columns[column].iter().skip(parity).step_by(2).enumerate() {
                simulator.set_word(number, address, Value::Form(form(row)));
            }
        }
    }
}
