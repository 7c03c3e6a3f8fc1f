//! The output: the column of the level that the strip asks for, rounded, kept until the consumer has taken it.
//!
//! ```text
//! group 0 ──┐
//! group 1 ──┼─► aligned to the finest level's binary point ──► rounded ──► register ──► m_axis
//! ...     ──┘
//! ```
//!
//! Guards are not seen. In the exact format a column of level l has 6 (L - l) fraction bits fewer than one of
//! the finest level L.

use super::Parameters;
use super::engine::Outgoing;
use super::schedule::Group;
use crate::cores::loop_fd::AXES;
use crate::hdl::{Builder, Placed, Signal, Word};

/// What a group can put out.
pub struct Offer<'a> {
    pub group: &'a Group,
    pub control: &'a Placed,
    /// By axis.
    pub columns: &'a [Outgoing; 3],
    /// The face column behind it.
    pub second: Option<&'a [Outgoing; 3]>,
}

pub struct Output<'a> {
    pub m: &'a Builder,
    pub parameters: Parameters,
    pub offers: Vec<Offer<'a>>,
    /// The level of the strip.
    pub level: Signal,
    pub consumer: Signal,
}

impl Output<'_> {
    /// Builds the output stream; returns whether it has room.
    pub fn build(&self) -> Signal {
        let m = self.m;
        let levels = self.parameters.levels;
        let is: Vec<Signal> =
            (1..=levels).map(|l| m.wire(format!("is_level_{l}"), m.is(&self.level, l.into()))).collect();
        let lanes = self.offers.iter().map(|offer| offer.group.lanes()).max().unwrap_or(0);
        let double = self.offers.iter().any(|offer| offer.second.is_some());

        let full = m.register_reset("full", Word::bit(), 0);
        let free = m.wire("free", !&full | &self.consumer);
        let moves = self.any_group(|offer| offer.control.out("out_output"));
        let guard = self.of_group(&is, |offer| match offer.group.double {
            // Both guards' columns lie beyond what it makes.
            true => m.bit(false),
            false => offer.control.out("out_first") | offer.control.out("out_last"),
        });
        let keep = m.wire("keep", &moves & !&guard);
        m.on(&keep, &full, m.bit(true));
        m.on(&self.consumer, &full, m.bit(false));

        let ends = self.of_group(&is, |offer| offer.control.out("out_ends"));
        let ending = self.of_group(&is, |offer| offer.control.out("out_ending"));
        let held = |name: &str, value: &Signal| {
            let register = m.register(name, Word::bit());
            m.on(&keep, &register, value);
            register
        };
        let last = held("strip_end", &m.wire("ends_strip", &ending & &ends));
        let sliced = self.offers.iter().any(|offer| offer.group.most_slices() > 1);

        let (mut places, mut kept): (Vec<(String, Signal)>, Vec<Signal>) = (vec![], vec![]);
        let columns = if double { &["", "next_"][..] } else { &[""][..] };
        for (second, prefix) in columns.iter().enumerate() {
            for row in 0..lanes {
                let present = self.present(&is, row, second == 1, &ends, &ending);
                let name = format!("{prefix}row{row}");
                kept.push(match present {
                    Some(present) => held(&format!("{name}_present"), &present),
                    None => m.bit(true),
                });
                for (axis, name_of_axis) in AXES.iter().enumerate() {
                    let position = self.position(&is, row, axis, second == 1);
                    let register =
                        m.register(format!("{name}_{name_of_axis}_kept"), self.parameters.output_word());
                    m.on(&keep, &register, m.wrap(&position, self.parameters.output_word()));
                    places.push((format!("{name}_{name_of_axis}"), register));
                }
            }
        }

        let width = self.parameters.output_word().width().next_multiple_of(8);
        let bytes = 3 * width as usize / 8;
        let rows: Vec<(String, Signal)> = kept
            .iter()
            .enumerate()
            .map(|(lane, bit)| (format!("lane{lane}"), m.concat(&vec![bit; bytes])))
            .collect();
        let rows: Vec<(&str, &Signal)> = rows.iter().map(|(n, s)| (n.as_str(), s)).collect();
        let places: Vec<(&str, &Signal)> = places.iter().map(|(n, s)| (n.as_str(), s)).collect();
        m.output_bus("m_axis_tdata", width, &places);
        m.output_bus("m_axis_tkeep", bytes as u32, &rows);
        if sliced {
            m.output("m_axis_tuser", held("column_end", &ends));
        }
        m.output("m_axis_tlast", &last);
        m.output("m_axis_tvalid", &full);
        free
    }

    fn any_group(&self, of: impl Fn(&Offer) -> Signal) -> Signal {
        let signals: Vec<Signal> = self.offers.iter().map(of).collect();
        match signals.as_slice() {
            [one] => one.clone(),
            _ => self.m.any(&signals.iter().collect::<Vec<_>>()),
        }
    }

    /// What the group says that puts out at the level of the strip.
    fn of_group(&self, is: &[Signal], of: impl Fn(&Offer) -> Signal) -> Signal {
        let mut chosen: Option<Signal> = None;
        for offer in &self.offers {
            let here: Vec<&Signal> = offer.group.levels.clone().map(|level| &is[level as usize]).collect();
            let here = if here.len() == 1 { here[0].clone() } else { self.m.any(&here) };
            chosen = Some(match chosen {
                Some(other) => self.m.select(&here, of(offer), &other),
                None => of(offer),
            });
        }
        // There is a group at least.
        chosen.unwrap_or_else(|| self.m.bit(false))
    }

    /// The offer at a level of the strip, and how many cells of its unit that level uses.
    fn offer(&self, level: u32) -> Option<(&Offer<'_>, u32)> {
        let source = level - 1;
        let offer = self.offers.iter().find(|offer| offer.group.levels.contains(&source))?;
        Some((offer, (1 << source) / offer.group.slices(source)))
    }

    /// Whether a row of a beat is there; nothing where it always is.
    fn present(
        &self,
        is: &[Signal],
        row: usize,
        second: bool,
        ends: &Signal,
        ending: &Signal,
    ) -> Option<Signal> {
        let m = self.m;
        let mut always = true;
        let mut cases: Vec<Signal> = vec![];
        for level in 1..=self.parameters.levels {
            let Some((offer, cells)) = self.offer(level) else { continue };
            let is = &is[level as usize - 1];
            let sliced = offer.group.slices(level - 1) > 1;
            let inner = row < 2 * cells as usize;
            let last = row == 2 * cells as usize;
            if (!inner && !last) || (second && offer.second.is_none()) {
                always = false;
                continue;
            }
            let mut case = is.clone();
            // The last row of a slice belongs to the next one; the column behind the last is a guard.
            if last && sliced {
                (case, always) = (&case & ends, false);
            }
            if second {
                (case, always) = (&case & !ending, false);
            }
            cases.push(case);
        }
        match cases.as_slice() {
            _ if always => None,
            [] => Some(m.bit(false)),
            [one] => Some(one.clone()),
            _ => Some(m.any(&cases.iter().collect::<Vec<_>>())),
        }
    }

    /// A row, rounded to the output's fraction.
    fn position(&self, is: &[Signal], row: usize, axis: usize, second: bool) -> Signal {
        let (m, p) = (self.m, self.parameters);
        let finest = p.word(p.levels);
        let mut chosen: Option<Signal> = None;
        for level in (1..=p.levels).rev() {
            let Some((offer, cells)) = self.offer(level) else { continue };
            let columns = if second { offer.second } else { Some(offer.columns) };
            let Some(columns) = columns.filter(|_| row <= 2 * cells as usize) else { continue };
            // The number of a column of this level, which its unit has been proved to make.
            let number = m.wrap(&columns[axis].rows[row], p.word(level));
            let aligned = m.signal(&number << (p.extra_fraction(p.levels) - p.extra_fraction(level)));
            let aligned = m.rescale(&aligned, finest.fraction);
            chosen = Some(match chosen {
                Some(other) => m.select(&is[level as usize - 1], &aligned, &other),
                None => aligned,
            });
        }
        // Every row belongs to the finest level that has it.
        let chosen = chosen.unwrap_or_else(|| m.constant(0, finest));
        m.round(&chosen, finest.fraction as u32 - p.output_fraction, p.rounding)
    }
}
