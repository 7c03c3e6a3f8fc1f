//! The window of the finest level before the finishing stage: a column is finished when the one behind it is
//! there.
//!
//! ```text
//! column ──► next ──► middle ──► previous        later column: the middle one is to be finished
//!                       └──► finishing stage ──► m_axis
//! ```
//!
//! A strip of level l fills the rows 0 .. 2^l. Until the stage is empty, the level does not change.

use super::VALENCE_BITS;
use super::fan::End;
use super::finish::{self, AXES, Finished, finish};
use super::output::{Offer, Output, Standing, Vertex};
use super::view::{EndView, View};
use super::window::{self, Columns, Producer, outside_places};
use crate::error::Result;
use crate::hdl::{Placed, Signal, Word};

impl Output<'_> {
    /// The columns finished; whether there is room for one more, and whether the stage is empty.
    pub(super) fn finished(
        &self,
        parameters: finish::Parameters,
        consumer: &Signal,
    ) -> Result<(Standing, Signal, Signal)> {
        let (m, p) = (self.m, self.parameters);
        let arrives = m.wire("column_arrives", self.moves());
        let flag = |name: &'static str| self.of_group(move |offer: &Offer| offer.control.out(name));
        let (first, guard) = (flag("out_first"), flag("out_last"));
        let fans = self.of_group(|offer| !offer.control.out("face"));

        let pending = m.register_reset("pending", Word::bit(), 0);
        let filled = m.register_reset("filled", Word::bit(), 0);
        let ends = m.register_reset("ends", Word::bit(), 0);
        let advance = m.forward("advance", Word::bit());
        let later = m.wire("column_completes", m.all(&[&arrives, &!&first, &filled]));
        m.on(&(&arrives & &first), &filled, m.bit(false));
        m.on(&arrives, &filled, m.bit(true));
        m.on(&later, &pending, m.bit(true));
        m.on(&advance, &pending, m.bit(false));
        m.on(&arrives, &ends, &guard);
        let valences = [0, 1].map(|end| {
            let name = End::BOTH[end].name();
            let arriving = flag(["out_top_valence", "out_bottom_valence"][end]);
            let stage = |stage: &str, value: &Signal| {
                let register = m.register(format!("{name}_{stage}_valence"), Word::unsigned(VALENCE_BITS));
                m.on(&arrives, &register, value);
                register
            };
            let next = stage("next", &arriving);
            stage("middle", &next)
        });

        let unit =
            window::build(p, p.levels, Producer::Slices { cells: 1 << (p.levels - 1), slices: 1 }, false)?;
        let place = |axis: usize| -> Placed {
            let mut inputs = vec![
                ("shift".to_string(), arrives.clone()),
                ("write_0".into(), arrives.clone()),
                ("fans".into(), fans.clone()),
            ];
            for row in 0..p.rows(p.levels) {
                let of =
                    move |offer: &Offer<'_>| -> Option<Signal> { offer.columns[axis].rows.get(row).cloned() };
                inputs.push((format!("row_{row}"), self.arriving(row, of)));
            }
            for (at, name) in outside_places(p).into_iter().enumerate() {
                let of = move |offer: &Offer<'_>| -> Option<Signal> {
                    Some(offer.columns[axis].outside[at].clone())
                };
                inputs.push((name, self.arriving(0, of)));
            }
            let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
            m.instance(&format!("finest_window_{}", AXES[axis]), &unit, &inputs)
        };
        let windows = [0, 1, 2].map(place);
        let views = [0, 1, 2].map(|axis| self.view(&Columns::new(p, p.levels, &windows[axis]), &valences));
        let [x, y, z] = &views;
        let Finished { positions, normals, latency } = finish(m, &parameters, [x, y, z], &advance)?;

        // What goes beside the numbers.
        let (mut valid, mut last) = (pending.clone(), ends);
        let mut all = vec![pending.clone()];
        for stage in 1..=latency {
            let register = m.register_reset(format!("finishing_{stage}"), Word::bit(), 0);
            m.on(&advance, &register, &valid);
            let end = m.register(format!("strip_end_{stage}"), Word::bit());
            m.on(&advance, &end, &last);
            all.push(register.clone());
            (valid, last) = (register, end);
        }
        let moves_on = m.wire("moves_on", !&valid | consumer);
        m.drive(&advance, &moves_on);
        let ready = m.wire("window_free", !&pending | &moves_on);
        let empty = m.wire("stage_empty", !m.any(&all.iter().collect::<Vec<_>>()));

        let present: Vec<Option<Signal>> = (0..p.rows(p.levels)).map(|row| self.row_is_there(row)).collect();
        let mut vertices = vec![];
        for (prefix, column) in [("row", positions), ("normal", normals)] {
            for (row, coordinates) in column.into_iter().enumerate() {
                vertices.push(Vertex {
                    name: format!("{prefix}{row}"),
                    coordinates,
                    present: present[row].clone(),
                });
            }
        }
        let last_row = p.longitudinal.map(|_| self.last_row());
        Ok((Standing { vertices, last, column_end: None, valid, last_row }, ready, empty))
    }

    /// A vertex that arrives, in the word of the finest level.
    fn arriving(&self, row: usize, of: impl Fn(&Offer<'_>) -> Option<Signal>) -> Signal {
        let signals: Vec<Option<Signal>> = self.offers.iter().map(&of).collect();
        let index = |offer: &Offer<'_>| self.offers.iter().position(|o| std::ptr::eq(o.group, offer.group));
        let aligned = self.aligned(row, |offer| signals[index(offer)?].as_ref());
        let word = self.parameters.word(self.parameters.levels);
        if aligned.word() == word { aligned } else { self.m.wrap(&aligned, word) }
    }

    /// Whether the strip has a row at its level; nothing where it has at every level.
    fn row_is_there(&self, row: usize) -> Option<Signal> {
        let levels: Vec<&Signal> =
            (1u32..).zip(&self.is).filter(|(level, _)| row <= 1 << level).map(|(_, is)| is).collect();
        (levels.len() < self.is.len()).then(|| match levels.as_slice() {
            [one] => (*one).clone(),
            _ => self.m.any(&levels),
        })
    }

    fn view(&self, columns: &Columns, valences: &[Signal; 2]) -> View {
        let (m, levels) = (self.m, self.parameters.levels);
        let count = columns.rows();
        let stages = [0, 1, 2].map(|column| -> Vec<Signal> {
            (0..count as i64).filter_map(|row| columns.row(column, row)).collect()
        });
        let is_bottom = (0..count)
            .map(|row| match (row.is_power_of_two() && row > 1, levels) {
                (true, 1) => m.bit(true),
                (true, _) => self.is[row.ilog2() as usize - 1].clone(),
                _ => m.bit(false),
            })
            .collect();
        // The bottom of the strip at its level, so many rows inward.
        let bottom = |column: usize, inward: usize| {
            let mut chosen = stages[column][count - 1 - inward].clone();
            for level in 1..levels {
                let row = (1usize << level) - inward;
                chosen = m.select(&self.is[level as usize - 1], &stages[column][row], &chosen);
            }
            chosen
        };
        let ends = [0, 1].map(|at| {
            let end = End::BOTH[at];
            let ring = columns.fan(end);
            let row = |inward: usize| {
                [0, 1, 2].map(|column| match end {
                    End::Top => stages[column][inward].clone(),
                    End::Bottom => bottom(column, inward),
                })
            };
            EndView {
                outer: row(0),
                inner: row(1),
                before: columns.outside(0, end, "right"),
                after: columns.outside(2, end, "left"),
                neighbours: ring.iter().step_by(2).cloned().collect(),
                diagonals: ring.iter().skip(1).step_by(2).cloned().collect(),
                valence: valences[at].clone(),
            }
        });
        View { rows: stages, is_bottom, ends }
    }
}
