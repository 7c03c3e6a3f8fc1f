//! The output: the column of the level that the strip asks for, rounded, kept until the consumer has taken it.
//!
//! ```text
//! group 0 ──┐
//! group 1 ──┼─► aligned to the finest level's binary point ──► rounded ──► register ──► m_axis
//! ...     ──┘                                             └──► finishing stage ────────►
//! ```
//!
//! Guards are not seen. In the exact format a column of level l has 6 (L - l) fraction bits fewer than one of
//! the finest level L.

use super::Parameters;
use super::engine::Outgoing;
use super::longitudinal;
use super::schedule::Group;
use crate::cores::loop_fd::AXES;
use crate::error::Result;
use crate::fixed::Rounding;
use crate::hdl::{Builder, Placed, Signal, Word};

/// What a group can put out.
pub struct Offer<'a> {
    pub group: &'a Group,
    pub control: &'a Placed,
    /// Clocks from a coordinate to the next, where they take turns.
    pub period: u32,
    /// By axis.
    pub columns: &'a [Outgoing; 3],
    /// The face column behind it.
    pub second: Option<&'a [Outgoing; 3]>,
}

pub struct Output<'a> {
    pub m: &'a Builder,
    pub parameters: Parameters,
    pub offers: Vec<Offer<'a>>,
    /// Whether the strip is of level 1, 2, ...
    pub is: Vec<Signal>,
    pub consumer: Signal,
}

/// What stands at the output.
pub struct Standing {
    /// Positions, three an entry, then normals; whether each is there, where it is not always.
    pub vertices: Vec<Vertex>,
    pub last: Signal,
    /// The last slice of a column, where there are slices.
    pub column_end: Option<Signal>,
    pub valid: Signal,
    /// The number of the last row that is there.
    pub last_row: Option<Signal>,
}

pub struct Vertex {
    pub name: String,
    pub coordinates: [Signal; 3],
    pub present: Option<Signal>,
}

impl<'a> Output<'a> {
    pub fn new(
        m: &'a Builder,
        parameters: Parameters,
        offers: Vec<Offer<'a>>,
        level: &Signal,
        consumer: Signal,
    ) -> Output<'a> {
        let is = (1..=parameters.levels).map(|l| {
            let is = m.wire(format!("is_level_{l}"), m.is(level, l.into()));
            // It stands long before a column comes. The levels know the same, far from here.
            if parameters.walked() { m.restart(&m.copy(format!("for_level_{l}"), &is), 0) } else { is }
        });
        let is = is.collect();
        Output { m, parameters, offers, is, consumer }
    }

    /// Builds the output stream; returns whether it has room, and whether it waits for nothing.
    ///
    /// # Errors
    /// A finishing stage or a buffer that does not exist.
    pub fn build(&self) -> Result<[Signal; 2]> {
        let m = self.m;
        let Some(log_columns) = self.parameters.longitudinal else {
            let (standing, ready, idle) = self.standing(&self.consumer)?;
            self.stream(&standing);
            return Ok([ready, idle]);
        };
        let taken = m.forward("column_taken", Word::bit());
        let (standing, ready, idle) = self.standing(&taken)?;
        let unit = longitudinal::build(log_columns, self.parameters.levels, self.parameters.output_word())?;
        let mut inputs = vec![
            ("column_valid".to_string(), standing.valid),
            ("column_last".into(), standing.last),
            ("ready".into(), self.consumer.clone()),
        ];
        inputs.extend(standing.last_row.map(|row| ("last_row".to_string(), row)));
        for (k, vertex) in standing.vertices.iter().enumerate() {
            for (axis, coordinate) in AXES.iter().zip(&vertex.coordinates) {
                inputs.push((format!("row_{k}_{axis}"), coordinate.clone()));
            }
        }
        let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), s)).collect();
        let rows = m.instance("longitudinal", &unit, &inputs);
        m.drive(&taken, m.wire("column_goes", rows.out("column_ready")));
        let width = self.parameters.output_word().width().next_multiple_of(8);
        let vertex = AXES.map(|axis| rows.out(axis));
        let lanes: Vec<(&str, &Signal)> = AXES.into_iter().zip(&vertex).collect();
        m.output_bus("m_axis_tdata", width, &lanes);
        m.output("m_axis_tuser", m.concat(&[&rows.out("chunk_end"), &rows.out("row_end")]));
        m.output("m_axis_tlast", rows.out("strip_end"));
        m.output("m_axis_tvalid", rows.out("valid"));
        Ok([ready, idle])
    }

    /// What stands before the consumer, who takes it where `consumer` is 1; whether there is room for more, and
    /// whether the level may change.
    fn standing(&self, consumer: &Signal) -> Result<(Standing, Signal, Signal)> {
        match self.parameters.finish() {
            _ if self.parameters.registered => self.buffered(consumer),
            Some(finish) => self.finished(finish, consumer),
            None => {
                let (standing, ready) = self.rounded(consumer);
                Ok((standing, ready, self.m.bit(true)))
            }
        }
    }

    /// The columns rounded and kept.
    fn rounded(&self, consumer: &Signal) -> (Standing, Signal) {
        let m = self.m;
        let lanes = self.offers.iter().map(|offer| offer.group.lanes()).max().unwrap_or(0);
        let double = self.offers.iter().any(|offer| offer.second.is_some());

        let full = m.register_reset("full", Word::bit(), 0);
        let free = m.wire("free", !&full | consumer);
        let guard = self.of_group(|offer| match offer.group.double {
            // Both guards' columns lie beyond what it makes.
            true => m.bit(false),
            false => offer.control.out("out_first") | offer.control.out("out_last"),
        });
        let keep = m.wire("keep", self.moves() & !&guard);
        m.on(&keep, &full, m.bit(true));
        m.on(consumer, &full, m.bit(false));

        let ends = self.of_group(|offer| offer.control.out("out_ends"));
        let ending = self.of_group(|offer| offer.control.out("out_ending"));
        let held = |name: &str, value: &Signal| {
            let register = m.register(name, value.word());
            m.on(&keep, &register, value);
            register
        };
        let last = held("strip_end", &m.wire("ends_strip", &ending & &ends));
        let sliced = self.offers.iter().any(|offer| offer.group.most_slices() > 1);

        let mut vertices = vec![];
        let columns = if double { &["", "next_"][..] } else { &[""][..] };
        for (second, prefix) in columns.iter().enumerate() {
            for row in 0..lanes {
                let name = format!("{prefix}row{row}");
                let present = self.present(row, second == 1, &ends, &ending);
                let present = present.map(|present| held(&format!("{name}_present"), &present));
                let coordinates = [0, 1, 2].map(|axis| {
                    let aligned = self.aligned(row, |offer| {
                        let columns = if second == 1 { offer.second } else { Some(offer.columns) };
                        Some(&columns?[axis].rows[row])
                    });
                    let drop = aligned.word().fraction - self.parameters.output_fraction as i32;
                    let rounded = m.round(&aligned, drop as u32, Rounding::HalfUp);
                    held(
                        &format!("{name}_{}_kept", AXES[axis]),
                        &m.wrap(&rounded, self.parameters.output_word()),
                    )
                });
                vertices.push(Vertex { name, coordinates, present });
            }
        }
        let column_end = sliced.then(|| held("column_end", &ends));
        let last_row = self.parameters.longitudinal.map(|_| held("last_row", &self.last_row()));
        (Standing { vertices, last, column_end, valid: full, last_row }, free)
    }

    /// 2^l at level l.
    pub(super) fn last_row(&self) -> Signal {
        let m = self.m;
        let word = Word::range(0, 1 << self.parameters.levels);
        let mut chosen = m.constant(1 << self.parameters.levels, word);
        for (level, is) in (1..).zip(&self.is).take(self.parameters.levels as usize - 1) {
            chosen = m.select(is, m.constant(1 << level, word), &chosen);
        }
        m.wire("rows_below_the_top", m.wrap(&chosen, word))
    }

    /// The ports of whole columns or slices.
    fn stream(&self, standing: &Standing) {
        let m = self.m;
        let widest = standing.vertices.iter().flat_map(|v| v.coordinates.iter().map(Signal::width)).max();
        let width = widest.unwrap_or(1).next_multiple_of(8);
        let bytes = 3 * width as usize / 8;
        let mut lanes: Vec<(String, Signal)> = vec![];
        let mut keeps: Vec<(String, Signal)> = vec![];
        let always = m.bit(true);
        for vertex in &standing.vertices {
            for (axis, coordinate) in AXES.iter().zip(&vertex.coordinates) {
                lanes.push((format!("{}_{axis}", vertex.name), coordinate.clone()));
            }
            let present = vertex.present.as_ref().unwrap_or(&always);
            keeps.push((vertex.name.clone(), m.concat(&vec![present; bytes])));
        }
        let lanes: Vec<(&str, &Signal)> = lanes.iter().map(|(n, s)| (n.as_str(), s)).collect();
        let keeps: Vec<(&str, &Signal)> = keeps.iter().map(|(n, s)| (n.as_str(), s)).collect();
        m.output_bus("m_axis_tdata", width, &lanes);
        m.output_bus("m_axis_tkeep", bytes as u32, &keeps);
        if let Some(end) = &standing.column_end {
            m.output("m_axis_tuser", end);
        }
        m.output("m_axis_tlast", &standing.last);
        m.output("m_axis_tvalid", &standing.valid);
    }

    /// A column or a slice of it reaches the output.
    pub(super) fn moves(&self) -> Signal {
        let signals: Vec<Signal> = self.offers.iter().map(|offer| offer.control.out("out_output")).collect();
        match signals.as_slice() {
            [one] => one.clone(),
            _ => self.m.any(&signals.iter().collect::<Vec<_>>()),
        }
    }

    /// What the group says that puts out at the level of the strip.
    pub(super) fn of_group(&self, of: impl Fn(&Offer) -> Signal) -> Signal {
        let mut chosen: Option<Signal> = None;
        for offer in &self.offers {
            let here: Vec<&Signal> =
                offer.group.levels.clone().map(|level| &self.is[level as usize]).collect();
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
    fn offer(&self, level: u32) -> Option<(&Offer<'a>, u32)> {
        let source = level - 1;
        let offer = self.offers.iter().find(|offer| offer.group.levels.contains(&source))?;
        Some((offer, (1 << source) / offer.group.slices(source)))
    }

    /// Whether a row of a beat is there; nothing where it always is.
    pub(super) fn present(&self, row: usize, second: bool, ends: &Signal, ending: &Signal) -> Option<Signal> {
        let m = self.m;
        let mut always = true;
        let mut cases: Vec<Signal> = vec![];
        for level in 1..=self.parameters.levels {
            let Some((offer, cells)) = self.offer(level) else { continue };
            let sliced = offer.group.slices(level - 1) > 1;
            let inner = row < 2 * cells as usize;
            let last = row == 2 * cells as usize;
            if (!inner && !last) || (second && offer.second.is_none()) {
                always = false;
                continue;
            }
            let mut case = self.is[level as usize - 1].clone();
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

    /// A vertex that leaves in lane `row`, with the binary point of the finest level.
    pub(super) fn aligned<'b>(
        &'b self,
        row: usize,
        of: impl Fn(&'b Offer<'a>) -> Option<&'b Signal>,
    ) -> Signal {
        let mut chosen: Option<Signal> = None;
        for (level, aligned) in self.aligned_levels(row, of) {
            chosen = Some(match chosen {
                Some(other) => self.m.select(&self.is[level as usize - 1], &aligned, &other),
                None => aligned,
            });
        }
        // Every row belongs to the finest level that has it.
        chosen.unwrap_or_else(|| self.m.constant(0, self.parameters.word(self.parameters.levels)))
    }

    /// The same of each level, the finest first.
    pub(super) fn aligned_levels<'b>(
        &'b self,
        row: usize,
        of: impl Fn(&'b Offer<'a>) -> Option<&'b Signal>,
    ) -> Vec<(u32, Signal)> {
        let (m, p) = (self.m, self.parameters);
        let aligned = |level: u32| {
            let (offer, cells) = self.offer(level)?;
            let vertex = (row <= 2 * cells as usize).then(|| of(offer)).flatten()?;
            // The number of a column of this level, which its unit has been proved to make.
            let number = m.wrap(vertex, p.word(level));
            let aligned = m.signal(&number << (p.extra_fraction(p.levels) - p.extra_fraction(level)));
            Some((level, m.rescale(&aligned, p.word(p.levels).fraction)))
        };
        (1..=p.levels).rev().filter_map(aligned).collect()
    }
}
