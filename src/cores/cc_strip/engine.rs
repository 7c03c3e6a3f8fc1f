//! The strip engine, one coordinate: the windows of a group of levels, and the one unit that serves them.
//!
//! ```text
//!   column ──► window a ──┐
//!          ┌─► window a+1 ┼─► rows of the level in turn ──► face column   ┐
//!          │   ...        │                            ──► vertex column ├─► column ──► next group
//!          │              └─► its ends ──► fan units   ──►               ┘      │
//!          └────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! A unit that serves one level and whole columns has no multiplexers. Otherwise the rows of the level and of
//! the slice that are in turn are brought to it. Vertices of all levels are plain integers to the unit: each
//! level has as many more fraction bits as its sums over 64 give it.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::columns::{face_column, row_names, vertex_column};
use super::fan::{self, End, Replaced, fan_names};
use super::row_reader;
use super::schedule::Group;
use super::view::EndView;
use super::window::{self, Columns, Producer, is_fan, outside_places, places};
use super::{Parameters, VALENCE_BITS};
use crate::error::Result;
use crate::hdl::{Builder, Module, Placed, Signal, Word};

/// A column that leaves, or a slice of it: rows, and what lies outside in the order of [`outside_places`].
pub struct Outgoing {
    pub rows: Vec<Signal>,
    pub outside: Vec<Signal>,
}

impl Outgoing {
    /// The outputs of a placed engine that begin with a prefix: `out`, or `face` for the second of two columns.
    pub fn of(placed: &Placed, prefix: &str, parameters: Parameters, group: &Group) -> Outgoing {
        let out = |name: String| placed.out(&format!("{prefix}_{name}"));
        Outgoing {
            rows: (0..group.lanes()).map(|u| out(format!("row_{u}"))).collect(),
            outside: passed_places(parameters, group).into_iter().map(out).collect(),
        }
    }
}

/// What lies outside of a column and leaves with it: nothing of the finest one where the ends are walked around, and
/// no fan, which leaves by itself.
pub(super) fn passed_places(parameters: Parameters, group: &Group) -> Vec<String> {
    match group.walked {
        true if group.finest() + 1 == parameters.levels => vec![],
        true => outside_places(parameters).into_iter().filter(|place| !is_fan(place)).collect(),
        false => outside_places(parameters),
    }
}

/// How the columns of a group's first level come in.
pub fn producer(before: Option<&Group>) -> Producer {
    match before {
        None => Producer::Words,
        Some(group) => Producer::Slices { cells: group.cells, slices: group.slices(group.finest()) },
    }
}

/// How the columns of a level within a group come in.
fn within(group: &Group, level: u32) -> Producer {
    // The unit has at least as many cells as a coarse level needs.
    let slices = group.slices(level - 1);
    Producer::Slices { cells: (1 << (level - 1)) / slices, slices }
}

/// Whether the window of a group adds columns for its unit: where the unit works on whole columns of one level. Else
/// rows are brought to the unit before they are added.
pub fn keeps_sums(group: &Group) -> bool {
    group.levels.clone().count() == 1 && group.most_slices() == 1 && !group.walked
}

/// Bits that number the slices of a column.
pub fn slice_bits(group: &Group) -> u32 {
    group.most_slices().ilog2()
}

/// Inputs: the column that comes in (the ports of the window of the first level, see [`window`]), `shift_l` and
/// `write_l` for each level within, `serve_l`, `slice`, `face`, and the valences of the column in the middle.
/// Outputs: `out_..`, and `face_..` where the unit makes two columns.
pub fn build(parameters: Parameters, index: usize, groups: &[Group]) -> Result<Rc<Module>> {
    let group = &groups[index];
    let m = Builder::new(&format!("strip_engine_{index}"));
    let levels: Vec<u32> = group.levels.clone().collect();
    m.purpose(match levels.as_slice() {
        [level] => format!("One coordinate of level {level}: its window and its unit."),
        _ => format!("One coordinate of the levels {} to {}, which share a unit.", levels[0], group.finest()),
    });
    m.parameter("cells", group.cells);

    let bit = |name: String| m.input(name, Word::bit());
    let serve: BTreeMap<u32, Signal> = match levels.as_slice() {
        [level] => BTreeMap::from([(*level, m.bit(true))]),
        _ => levels.iter().map(|&level| (level, bit(format!("serve_{level}")))).collect(),
    };
    let slice: Vec<Signal> = match slice_bits(group) {
        0 => vec![],
        bits => {
            let slice = m.input("slice", Word::unsigned(bits));
            (0..bits).map(|at| m.slice(&slice, at, 1)).collect()
        }
    };
    let face = if group.double { m.bit(false) } else { bit("face".into()) };
    let valences = End::BOTH.map(|e| m.input(format!("{}_valence", e.name()), Word::unsigned(VALENCE_BITS)));

    // The column of the next level is known only when the unit is; it closes the loop below.
    let finest = parameters.word(group.finest() + 1);
    let forward = |place: String| m.forward(format!("made_{place}"), finest);
    let lanes = if parameters.registered { 0 } else { group.lanes() };
    let made: Vec<Signal> = (0..lanes).map(|u| forward(format!("row_{u}"))).collect();
    let made_outside: Vec<Signal> = match parameters.registered {
        true => vec![],
        false => outside_places(parameters).into_iter().map(forward).collect(),
    };
    let mut placed = vec![];
    // What the row reader takes, too.
    let mut known = vec![];
    known.extend((!slice.is_empty()).then(|| {
        let bits: Vec<&Signal> = slice.iter().rev().collect();
        ("slice".to_string(), m.concat(&bits))
    }));
    let mut axis = None;
    for &level in &levels {
        let from = if level == levels[0] {
            producer(index.checked_sub(1).map(|g| &groups[g]))
        } else {
            within(group, level)
        };
        let unit = window::build(parameters, level, from, keeps_sums(group))?;
        let ports: Vec<(String, Signal)> = if level == levels[0] {
            let name = |id: &crate::hdl::NodeId| unit.node(*id).name.clone().unwrap_or_default();
            let input = |id: &crate::hdl::NodeId| {
                let port = unit.node(*id);
                (name(id), m.input_at(format!("in_{}", name(id)), port.word, port.time.unwrap_or(0)))
            };
            unit.inputs.iter().map(input).collect()
        } else {
            let write = bit(format!("write_{level}"));
            let begin = bit(format!("shift_{level}"));
            inner_ports(
                &m,
                parameters,
                level,
                from,
                &Inner { begin, write, slice: &slice, face: &face, rows: &made, outside: &made_outside },
            )
        };
        known.extend(ports.iter().cloned());
        axis = axis.or(ports.iter().find(|(name, _)| name == "axis").map(|(_, axis)| axis.clone()));
        let inputs: Vec<(&str, &Signal)> =
            ports.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
        placed.push(m.instance(&format!("window_{level}"), &unit, &inputs));
    }
    let reader = match levels.as_slice() {
        [level] if parameters.reads_rows(*level) => Some(row_reader::place(&m, parameters, *level, &known)?),
        _ => None,
    };
    let columns: Vec<Columns> =
        levels.iter().zip(&placed).map(|(&level, placed)| Columns::new(parameters, level, placed)).collect();

    let unit = Unit { m: &m, parameters, group, columns: &columns, serve: &serve, slice: &slice };
    if group.walked {
        let walk = bit("walk".into());
        let (column, fans) = unit.walked(&face, valences, &walk, axis.as_ref(), reader.as_ref())?;
        let names = (0..group.lanes()).map(|u| format!("row_{u}")).chain(passed_places(parameters, group));
        for (name, signal) in names.zip(column.rows.iter().chain(&column.outside)) {
            m.output(format!("out_{name}"), m.wire(format!("out_{name}"), fit(&m, signal, finest)));
        }
        for (name, signal) in &fans {
            m.output(format!("out_{name}"), signal);
        }
        return m.finish();
    }
    if parameters.registered {
        let names = (0..group.lanes()).map(|u| format!("row_{u}")).chain(outside_places(parameters));
        let column = unit.registered(&face, valences)?;
        for (name, signal) in names.zip(column.rows.iter().chain(&column.outside)) {
            m.output(format!("out_{name}"), m.wire(format!("out_{name}"), fit(&m, signal, finest)));
        }
        return m.finish();
    }
    let sums = unit.sums(false);
    let between = unit.face_column(&sums)?;
    let middle = unit.vertex_column(valences, &sums)?;
    let both = between.rows.iter().zip(&middle.rows).chain(between.outside.iter().zip(&middle.outside));
    let names = (0..group.lanes()).map(|u| format!("row_{u}")).chain(outside_places(parameters));
    for ((name, (on_face, on_vertex)), made) in names.zip(both).zip(made.iter().chain(&made_outside)) {
        let chosen = if group.double || on_face.is_same(on_vertex) {
            on_vertex.clone()
        } else {
            m.select(&face, on_face, on_vertex)
        };
        let chosen = m.wire(format!("out_{name}"), fit(&m, &chosen, finest));
        m.drive(made, &chosen);
        m.output(format!("out_{name}"), &chosen);
        if group.double {
            m.output(format!("face_{name}"), m.wire(format!("face_{name}"), fit(&m, on_face, finest)));
        }
    }
    m.finish()
}

/// The number in a word that holds it.
fn fit(m: &Builder, signal: &Signal, word: Word) -> Signal {
    if signal.word() == word { signal.clone() } else { m.wrap(m.rescale(signal, word.fraction), word) }
}

/// What goes into a window within a group.
struct Inner<'a> {
    begin: Signal,
    write: Signal,
    slice: &'a [Signal],
    face: &'a Signal,
    rows: &'a [Signal],
    outside: &'a [Signal],
}

fn inner_ports(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    from: Producer,
    inner: &Inner,
) -> Vec<(String, Signal)> {
    let Producer::Slices { cells, slices } = from else { return vec![] };
    // The unit's word is that of the finest level; this level's numbers are smaller, which is proved.
    let narrow = |name: &str, wide: &Signal| {
        if wide.word() == parameters.word(level) {
            return wide.clone();
        }
        m.claim(&format!("level_{level}_{name}"), wide, parameters.word(level), Some(&inner.write))
    };
    let mut ports = vec![("shift".to_string(), inner.begin.clone()), ("fans".to_string(), !inner.face)];
    let lanes = parameters.rows(level).min(2 * cells as usize + 1);
    for (u, row) in inner.rows.iter().take(lanes).enumerate() {
        ports.push((format!("row_{u}"), narrow(&format!("row_{u}"), row)));
    }
    for (place, value) in outside_places(parameters).iter().zip(inner.outside) {
        ports.push((place.clone(), narrow(place, value)));
    }
    for p in 0..slices {
        let here = equals(m, &inner.slice[..slices.ilog2() as usize], p);
        let write = here.map_or(inner.write.clone(), |here| &inner.write & here);
        ports.push((format!("write_{p}"), m.wire(format!("write_{level}_{p}"), &write)));
    }
    ports
}

/// 1 where the bits, the lowest first, make the number; nothing where there are none.
pub fn equals(m: &Builder, bits: &[Signal], number: u32) -> Option<Signal> {
    let literals: Vec<Signal> = bits
        .iter()
        .enumerate()
        .map(|(at, bit)| if number >> at & 1 == 1 { bit.clone() } else { !bit })
        .collect();
    match literals.as_slice() {
        [] => None,
        [one] => Some(one.clone()),
        _ => Some(m.all(&literals.iter().collect::<Vec<_>>())),
    }
}

/// The unit of a group on its windows.
pub(super) struct Unit<'a> {
    pub(super) m: &'a Builder,
    pub(super) parameters: Parameters,
    pub(super) group: &'a Group,
    pub(super) columns: &'a [Columns<'a>],
    serve: &'a BTreeMap<u32, Signal>,
    pub(super) slice: &'a [Signal],
}

impl Unit<'_> {
    pub(super) fn level(&self) -> u32 {
        self.group.finest()
    }

    pub(super) fn cells(&self) -> u32 {
        self.group.cells
    }

    pub(super) fn sliced(&self) -> bool {
        self.group.most_slices() > 1
    }

    /// A signal of the level that is served, in the word of the finest level; the same signal where only one
    /// level has it.
    fn of_level(&self, signals: impl IntoIterator<Item = (u32, Option<Signal>)>) -> Option<Signal> {
        let word = self.parameters.word(self.level());
        let mut chosen: Option<Signal> = None;
        for (level, signal) in signals {
            let Some(signal) = signal else { continue };
            let signal = fit(self.m, &signal, word);
            chosen = Some(match chosen {
                Some(other) => self.m.select(&self.serve[&level], &signal, &other),
                None => signal,
            });
        }
        chosen
    }

    /// Row `at` (-1 is above) of a column as the unit sees it now.
    pub(super) fn row(&self, column: usize, at: i64) -> Option<Signal> {
        self.of_level(self.columns.iter().map(|columns| {
            let slices = self.group.slices(columns.level);
            let bits = &self.slice[..slices.ilog2() as usize];
            let rows = (0..slices).map(|p| columns.row(column, i64::from(p * self.cells()) + at)).collect();
            (columns.level, chosen_by(self.m, bits, rows))
        }))
    }

    /// c + next (`old` false) or previous + c of every row that has them, by its name.
    pub(super) fn sums(&self, old: bool) -> Vec<(String, Signal)> {
        let word = self.parameters.sum_word(self.level());
        let sum = |(name, at): (&String, i64)| match self.columns {
            [only] if keeps_sums(self.group) && old => {
                (0..only.rows() as i64).contains(&at).then(|| only.row(0, at))?
            }
            [only] if keeps_sums(self.group) => only.sum(at),
            _ => {
                let first = usize::from(!old);
                let [a, b] = [self.row(first, at)?, self.row(first + 1, at)?];
                Some(self.m.wire(format!("{}_{name}", if old { "old" } else { "s" }), &a + &b))
            }
        };
        let names = row_names(self.cells());
        let named = names.iter().zip(-1..).filter_map(|(name, at)| Some((name.clone(), sum((name, at))?)));
        named.map(|(name, signal)| (name, fit(self.m, &signal, word))).collect()
    }

    /// The last row of a level in its last slice, as the unit counts.
    fn bottom(&self, level: u32) -> u32 {
        self.cells().min(1 << level)
    }

    fn face_column(&self, sums: &[(String, Signal)]) -> Result<Outgoing> {
        let unit = face_column(self.parameters, self.level(), self.cells())?;
        let named = sums.iter().map(|(row, signal)| (format!("s_{row}"), signal.clone())).collect();
        let placed = place(self.m, "face_column", &unit, named);
        let rows = (0..self.group.lanes())
            .map(|u| placed.out(&format!("{}_{}", if u % 2 == 0 { "edge" } else { "face" }, u / 2)))
            .collect();
        let below = self.next_of_level(|level| match self.bottom(level) {
            row if row == self.cells() => placed.out("face_below"),
            row => placed.out(&format!("face_{row}")),
        });
        // Outside of a face column lies one face point, its only neighbour there.
        let alone = |point: &Signal| vec![point.clone(); 2 + fan_names(self.parameters).len()];
        Ok(Outgoing { rows, outside: [alone(&placed.out("face_above")), alone(&below)].concat() })
    }

    /// A new vertex that depends on which level is served.
    fn next_of_level(&self, of: impl Fn(u32) -> Signal) -> Signal {
        let mut chosen: Option<Signal> = None;
        for columns in self.columns {
            let signal = of(columns.level);
            chosen = Some(match chosen {
                Some(other) if other.is_same(&signal) => other,
                Some(other) => self.m.select(&self.serve[&columns.level], &signal, &other),
                None => signal,
            });
        }
        // A group has a level at least.
        chosen.unwrap_or_else(|| self.m.bit(false))
    }

    fn vertex_column(&self, valences: [Signal; 2], sums: &[(String, Signal)]) -> Result<Outgoing> {
        let m = self.m;
        let unit = vertex_column(self.parameters, self.level(), self.cells(), self.sliced())?;
        let mut inputs = vec![];
        let seen = |row: &str| row != "below" && (row != "above" || self.sliced());
        for (side, rows) in [("old", &self.sums(true)[..]), ("s", sums)] {
            let rows = rows.iter().filter(|(row, _)| seen(row));
            inputs.extend(rows.map(|(row, signal)| (format!("{side}_{row}"), signal.clone())));
        }
        for (row, at) in row_names(self.cells()).iter().zip(-1..).filter(|(row, _)| seen(row)) {
            inputs.extend(self.row(1, at).map(|signal| (format!("column_{row}"), signal)));
        }
        let placed = place(m, "vertex_column", &unit, inputs);
        let fan_unit = fan::build(self.parameters, self.level())?;
        let [top, bottom] = [0, 1].map(|end| {
            let view = self.end(End::BOTH[end], valences[end].clone());
            fan::place(m, self.parameters, &fan_unit, &format!("{}_fan", End::BOTH[end].name()), &view)
        });

        let first = equals(m, self.slice, 0);
        let mut rows = vec![];
        for u in 0..self.group.lanes() as u32 {
            if u % 2 == 1 {
                rows.push(placed.out(&format!("edge_{}", u / 2)));
                continue;
            }
            let k = u / 2;
            let row = match (k, &first) {
                (0, None) => top.vertex.clone(),
                (0, Some(first)) => m.select(first, &top.vertex, placed.out("vertex_0")),
                _ if k == self.cells() => bottom.vertex.clone(),
                _ => placed.out(&format!("vertex_{k}")),
            };
            // Coarse levels that the unit serves too end before its last row.
            let here = self.columns.iter().find(|c| self.bottom(c.level) == k && k < self.cells());
            rows.push(match here {
                Some(columns) => m.select(&self.serve[&columns.level], &bottom.vertex, &row),
                None => row,
            });
        }
        let outside = |end: Replaced| [vec![end.left, end.right], end.fan].concat();
        Ok(Outgoing { rows, outside: [outside(top), outside(bottom)].concat() })
    }

    /// A row near an end; of the previous column, where its sum with the middle one is kept, what is more in it.
    fn end_row(&self, columns: &Columns, column: usize, end: End, inward: usize) -> Signal {
        let row = columns.end_row(column, end, inward);
        if column > 0 || !keeps_sums(self.group) {
            return row;
        }
        let name = format!("{}_previous_{inward}", end.name());
        let middle = columns.end_row(1, end, inward);
        self.m.claim(&name, &row - &middle, self.parameters.word(columns.level), None)
    }

    /// What the fan unit of an end sees, of the level that is served.
    pub(super) fn end(&self, end: End, valence: Signal) -> EndView {
        // Every window has these.
        let pick = |of: &dyn Fn(&Columns) -> Signal| {
            let all = self.columns.iter().map(|columns| (columns.level, Some(of(columns))));
            self.of_level(all).unwrap_or_else(|| self.m.bit(false))
        };
        let entries = 1 + fan_names(self.parameters).len();
        let ring: Vec<Signal> = (0..entries).map(|i| pick(&|c: &Columns| c.fan(end)[i].clone())).collect();
        EndView {
            outer: [0, 1, 2].map(|column| pick(&|c: &Columns| self.end_row(c, column, end, 0))),
            inner: [0, 1, 2].map(|column| pick(&|c: &Columns| self.end_row(c, column, end, 1))),
            before: pick(&|c: &Columns| c.outside(0, end, "right")),
            after: pick(&|c: &Columns| c.outside(2, end, "left")),
            neighbours: ring.iter().step_by(2).cloned().collect(),
            diagonals: ring.iter().skip(1).step_by(2).cloned().collect(),
            valence,
        }
    }
}

/// The option with the number that the bits make, the lowest bit first; what does not exist is never asked for.
pub(super) fn chosen_by(m: &Builder, bits: &[Signal], options: Vec<Option<Signal>>) -> Option<Signal> {
    let mut options = options;
    for bit in bits {
        let pair = |pair: &[Option<Signal>]| match pair {
            [Some(zero), Some(one)] if !zero.is_same(one) => Some(m.select(bit, one, zero)),
            [zero, one] => one.clone().or(zero.clone()),
            _ => pair.first().cloned().flatten(),
        };
        options = options.chunks(2).map(pair).collect();
    }
    options.into_iter().next().flatten()
}

fn place(m: &Builder, name: &str, unit: &Rc<Module>, inputs: Vec<(String, Signal)>) -> Placed {
    let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
    m.instance(name, unit, &inputs)
}

/// Names of the ports of the incoming column of a group, for whoever places the engine.
pub fn incoming_places(parameters: Parameters, level: u32, producer: Producer) -> Vec<String> {
    match producer {
        Producer::Words => places(parameters, level),
        Producer::Slices { cells, .. } => {
            let lanes = parameters.rows(level).min(2 * cells as usize + 1);
            let outside = outside_places(parameters).into_iter();
            let outside = outside.filter(|place| !parameters.walked() || !is_fan(place));
            (0..lanes).map(|u| format!("row_{u}")).chain(outside).collect()
        }
    }
}
