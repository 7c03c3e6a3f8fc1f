//! The output of a registered core: the columns of the level that the strip asks for, rounded, into a buffer.
//!
//! ```text
//! level 1 ──┐ each so many clocks behind its control
//! level 2 ──┼─► aligned ──► rounded ──► buffer ──► m_axis
//! ...     ──┘
//! ```
//!
//! The level changes only when nothing is on its way, so the levels may differ in their delays.

use super::buffer;
use super::engine::Outgoing;
use super::output::{Offer, Output, Standing, Vertex};
use super::wait::Waits;
use crate::cores::loop_fd::AXES;
use crate::error::Result;
use crate::fixed::Rounding;
use crate::hdl::{Placed, Signal, Word};

/// The flag that goes with what leaves from a level, by its name; its clock is the delay of the data.
pub const LEAVES: &str = "leaves_at_level_";

/// Clocks by which what a level issues counts later where ends are walked around.
pub const COUNTS_LATE: u32 = 3;

/// Clocks from the last adder of a level into the buffer: one more where ends are walked around, behind the choice among
/// levels.
pub fn rounding(walked: bool) -> u32 {
    3 + u32::from(walked)
}

/// Words of the buffer for data so many clocks behind their control: what is on its way, and some that wait.
pub fn log_depth(delay: u32) -> u32 {
    (delay + 12).next_power_of_two().ilog2()
}

impl<'a> Output<'a> {
    /// The stream behind the buffer; whether there is room for one more column, and whether nothing is on its way.
    pub(super) fn buffered(&self, consumer: &Signal) -> Result<(Standing, Signal, Signal)> {
        let m = self.m;
        let any = |signals: Vec<Signal>| match signals.as_slice() {
            [one] => one.clone(),
            _ => m.any(&signals.iter().collect::<Vec<_>>()),
        };
        let lanes = self.offers.iter().map(|offer| offer.group.lanes()).max().unwrap_or(0);
        let walked = self.parameters.walked();
        let rounding = rounding(walked);
        // The levels lie far apart: a register before the choice among them.
        let time = |offer: &Offer| offer.columns[0].rows[0].time().unwrap_or(0) + u32::from(walked);
        let delay = self.offers.iter().map(time).max().unwrap_or(0);
        let here = |signal: &Signal| m.restart(signal, 0);
        // Where ends are walked around, the levels lie far apart: registers behind what they say, and behind what comes
        // of it, so that it counts later.
        let late = |name: String, signal: &Signal| match walked {
            true => m.pipe_reset(name, signal, 0),
            false => signal.clone(),
        };
        let seen: Vec<Signal> = (1..)
            .zip(&self.offers)
            .map(|(level, offer)| {
                let of = |out: &str| late(format!("{out}_of_level_{level}"), &offer.control.out(out));
                m.signal(of("out_output") & !(of("out_first") | of("out_last")))
            })
            .collect();
        let counts = (1..).zip(&seen).map(|(level, seen)| late(format!("issued_at_level_{level}"), seen));
        let issue = here(&late("issued_late".into(), &m.wire("issue", any(counts.collect()))));

        // From here on the flag beside it says when a column is there.
        let waits = Waits::new(m, self.parameters);
        let of_level = |name: &str, of: &dyn Fn(&Offer) -> Signal| {
            let flags = self.offers.iter().zip(1..).map(|(offer, level)| {
                let flag = [(format!("{name}{level}"), of(offer))];
                let flag = waits.until(&format!("{name}{level}_slot"), &flag, time(offer)).remove(0);
                &self.is[level - 1] & &here(&m.wire(format!("{name}{level}"), &flag))
            });
            any(flags.collect())
        };
        // Whether there is one must be known from the first clock on.
        let leaves = self.offers.iter().zip(&seen).zip(1..).map(|((offer, seen), level)| {
            let known = time(offer) - u32::from(walked);
            let flag = m.delay_reset(&m.wire(format!("issue_{level}"), seen), known, 0);
            &self.is[level - 1] & &here(&m.wire(format!("{LEAVES}{level}"), &flag))
        });
        let push = m.wire("column_leaves", any(leaves.collect()));
        let stage =
            |name: &str, signal: Signal| if walked { m.pipe(name, signal) } else { m.wire(name, signal) };
        let ends = stage("column_ends", of_level("ends_at_level_", &|offer| offer.control.out("out_ends")));
        let ending =
            stage("column_is_last", of_level("last_at_level_", &|offer| offer.control.out("out_ending")));
        let columns: Vec<[Outgoing; 3]> = self
            .offers
            .iter()
            .map(|offer| {
                let level = offer.group.finest() + 1;
                let nearer = |axis: usize, (u, row): (usize, &Signal)| match walked {
                    true => here(&m.pipe(format!("row{u}_{}_of_level_{level}", AXES[axis]), row)),
                    false => here(row),
                };
                let rows = |axis: usize| -> Vec<Signal> {
                    offer.columns[axis].rows.iter().enumerate().map(|row| nearer(axis, row)).collect()
                };
                // In turn, all coordinates come the same way.
                let first = rows(0);
                [0, 1, 2].map(|axis| Outgoing {
                    rows: if axis == 0 || offer.group.in_turn { first.clone() } else { rows(axis) },
                    outside: vec![],
                })
            })
            .collect();
        let index = |offer: &Offer| self.offers.iter().position(|o| std::ptr::eq(o.group, offer.group));
        let sliced = self.offers.iter().any(|offer| offer.group.most_slices() > 1);
        // A column that has begun to leave is not stopped.
        let most = self.offers.iter().map(|offer| offer.group.most_slices()).max().unwrap_or(0);
        let unasked = if walked { most + COUNTS_LATE } else { 0 };
        let log_depth = log_depth(delay + rounding + unasked);

        // A FIFO for the flags and one for each coordinate of each row, all with a `push` of their own.
        let push = m.delay_reset(&push, rounding - 2, 0);
        let fifo = |name: &str, push: &Signal, lanes: &[(&str, Signal)]| -> Result<Placed> {
            let shapes: Vec<(&str, Word)> =
                lanes.iter().map(|(lane, signal)| (*lane, signal.word())).collect();
            let kind = match (name, lanes.len()) {
                ("flags", _) => "flags",
                (_, 1) => "coordinate",
                _ => "coordinate_or_not",
            };
            let unit = buffer::row(&format!("{kind}_buffer"), log_depth, self.parameters.walked(), &shapes)?;
            let mut inputs = vec![
                ("push".to_string(), here(&m.unmerged(m.pipe_reset(format!("push_{name}"), push, 0)))),
                ("ready".into(), consumer.clone()),
            ];
            for (lane, signal) in lanes {
                inputs.push((format!("in_{lane}"), here(&m.at_time(signal, rounding))));
            }
            let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
            Ok(m.instance(&format!("{name}_buffer"), &unit, &inputs))
        };
        let push_row = |name: &str| m.unmerged(m.pipe_reset(format!("push_of_{name}"), &push, 0));
        let mut flags = vec![("strip_end", m.wire("ends_strip", &ending & &ends))];
        flags.extend(sliced.then(|| ("column_end", ends.clone())));
        let flags = fifo("flags", &push_row("flags"), &flags)?;
        // The flags lie far from the levels.
        let taken = match walked {
            true => here(&m.pipe_reset("taken_late", flags.out("take"), 0)),
            false => flags.out("take"),
        };
        let credits =
            m.instance("room", &buffer::credits(log_depth, unasked)?, &[("issue", &issue), ("take", &taken)]);
        // Where coordinates take turns, x and y wait for z.
        let coarse = &self.is[..self.parameters.axes_in_turn as usize];
        let takes_turns = match coarse {
            [] => m.bit(false),
            _ => {
                let turns = m.copy("strip_takes_turns", m.any(&coarse.iter().collect::<Vec<_>>()));
                m.restart(&m.copy("takes_turns", &turns), 0)
            }
        };
        let period = self.offers.iter().map(|offer| offer.period).max().unwrap_or(0);
        let together = |name: &str, signal: Signal, axis: usize| {
            let now = signal.time().unwrap_or(0);
            let until = now + (2 - axis as u32) * period;
            m.restart(&waits.until(&format!("{name}_slot"), &[(name.to_string(), signal)], until)[0], now)
        };
        let mut vertices = vec![];
        for row in 0..lanes {
            let name = format!("row{row}");
            let push = push_row(&name);
            let mut into: Vec<(&str, Signal)> = vec![];
            for (axis, letter) in AXES.into_iter().enumerate() {
                let of = |in_turn: bool| {
                    let of = |offer: &Offer| {
                        columns[index(offer)?][axis].rows.get(row).filter(|_| offer.group.in_turn == in_turn)
                    };
                    let chosen = format!("{name}_{letter}_{}", if in_turn { "in_turn" } else { "at_once" });
                    let any = self.offers.iter().any(|offer| of(offer).is_some());
                    any.then(|| if walked { self.chosen(&chosen, row, of) } else { self.aligned(row, of) })
                };
                let aligned = match (of(true), of(false)) {
                    (Some(turns), Some(other)) => {
                        let turns = together(&format!("{name}_{letter}_of_turn"), turns, axis);
                        m.select(&takes_turns, &turns, &other)
                    }
                    (Some(turns), None) => together(&format!("{name}_{letter}_of_turn"), turns, axis),
                    (None, other) => other.unwrap_or_else(|| self.aligned(row, |_| None)),
                };
                let aligned = m.pipe(format!("{name}_{letter}_aligned"), &aligned);
                let drop = aligned.word().fraction - self.parameters.output_fraction as i32;
                let rounded = m.round(&aligned, drop as u32, Rounding::HalfUp);
                let rounded = m.wrap(&rounded, self.parameters.output_word());
                into.push((letter, m.pipe(format!("{name}_{letter}_rounded"), &rounded)));
            }
            let present = self.present(row, false, &ends, &ending);
            // Whether the row is there goes with its x.
            let present: Vec<(&str, Signal)> =
                present.map(|present| ("present", present)).into_iter().collect();
            let mut fifos = vec![];
            for (letter, coordinate) in into {
                let more = if fifos.is_empty() { &present[..] } else { &[] };
                let lanes = [&[(letter, coordinate)][..], more].concat();
                fifos.push(fifo(&format!("{name}_{letter}"), &push, &lanes)?);
            }
            vertices.push(Vertex {
                name,
                coordinates: [0, 1, 2].map(|axis| fifos[axis].out(&format!("out_{}", AXES[axis]))),
                present: (!present.is_empty()).then(|| fifos[0].out("out_present")),
            });
        }
        let standing = Standing {
            vertices,
            last: flags.out("out_strip_end"),
            column_end: sliced.then(|| flags.out("out_column_end")),
            valid: flags.out("valid"),
            last_row: None,
        };
        Ok((standing, credits.out("has_room"), credits.out("empty")))
    }

    /// A vertex of the level of the strip, the choice among two levels before that among the rest.
    fn chosen<'b>(
        &'b self,
        name: &str,
        row: usize,
        of: impl Fn(&'b Offer<'a>) -> Option<&'b Signal>,
    ) -> Signal {
        let m = self.m;
        // The level stands long before a column of it is here.
        let own =
            |of: String, is: &Signal, time: u32| m.restart(&m.copy(format!("{name}_is_{of}"), is), time);
        let is = |level: u32, time: u32| own(level.to_string(), &self.is[level as usize - 1], time);
        let levels = self.aligned_levels(row, of);
        let pairs = levels.chunks(2).map(|pair| match pair {
            [(_, finer), (level, coarser)] => {
                let chosen = m.select(&is(*level, finer.time().unwrap_or(0)), coarser, finer);
                m.pipe(format!("{name}_{level}"), &chosen)
            }
            _ => m.pipe(format!("{name}_{}", pair[0].0), &pair[0].1),
        });
        let mut pairs = levels.chunks(2).zip(pairs);
        let first = pairs.next().map(|(_, chosen)| chosen);
        let first = first.unwrap_or_else(|| m.constant(0, self.parameters.word(self.parameters.levels)));
        let rest = pairs.fold(first, |other, (pair, chosen)| {
            let here: Vec<&Signal> = pair.iter().map(|(level, _)| &self.is[*level as usize - 1]).collect();
            let of = format!("of_{}", pair[0].0);
            let here = m.copy(format!("{name}_comes_{of}"), m.any(&here));
            let here = own(of, &here, chosen.time().unwrap_or(0));
            m.select(&here, &chosen, &other)
        });
        m.pipe(name, &rest)
    }
}
