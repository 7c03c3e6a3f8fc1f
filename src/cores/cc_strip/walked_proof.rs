//! The part of the proof that a walk around the ends of a column makes: the fans, which leave by themselves.

use super::proof::{Statement, VARIABLES};
use super::ring_walk::{Times, strobe_endings, strobes};
use crate::error::{Error, Kind, Result};
use crate::fixed::Form;
use crate::hdl::linear::Value;
use crate::hdl::{LinearForms, Simulator};

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
        let ending = endings.get(self.axis.unwrap_or(0)).cloned().unwrap_or_default();
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
}
