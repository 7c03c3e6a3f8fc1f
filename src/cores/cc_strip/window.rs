//! The window of a level, one coordinate: three columns, and what lies outside of them.
//!
//! ```text
//! words or rows ──► next ──► middle ──► previous
//!
//! next, middle    rows, and at both ends the outside vertices left and right
//! previous        rows, and at both ends the one on its right
//! fan             a_2, x_2, ... at both ends: of two columns at level 0, of one beyond
//! ```
//!
//! A column moves on when the first part of the next one comes; the rest of it only fills `next`. A fan is
//! needed while its vertex is in the middle. From level 1 on every other column is a face column, whose ends
//! have valence 4 and one outside vertex, which is left and right; so one fan serves a window.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::Parameters;
use super::fan::{End, fan_names};
use super::places::{Axes, Place};
use crate::error::Result;
use crate::hdl::{Builder, Module, Placed, Signal, Sum, Word};

/// How columns come into a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Producer {
    /// A word at a time, with a strobe for each place.
    Words,
    /// Slices of 2 `cells` + 1 rows, so many for a column.
    Slices { cells: u32, slices: u32 },
}

/// Places of a column at level 0 in the order of their names: rows, then at each end left, right, fan.
pub fn places(parameters: Parameters, level: u32) -> Vec<String> {
    let last = parameters.rows(level) - 1;
    // Inner rows may be kept elsewhere.
    let is_here = |k: &usize| !parameters.reads_rows(level) || *k < 2 || *k + 1 >= last;
    let mut names: Vec<String> = (0..=last).filter(is_here).map(|k| format!("row_{k}")).collect();
    names.extend(outside_places(parameters));
    names
}

/// What lies outside of both ends of a column.
pub fn outside_places(parameters: Parameters) -> Vec<String> {
    End::BOTH.iter().flat_map(|end| end_places(parameters, *end)).collect()
}

/// Whether a place holds an entry of a fan.
pub fn is_fan(place: &str) -> bool {
    place.contains("_a_") || place.contains("_x_")
}

fn end_places(parameters: Parameters, end: End) -> Vec<String> {
    let places = ["left", "right"].map(String::from).into_iter().chain(fan_names(parameters));
    places.map(|place| format!("{}_{place}", end.name())).collect()
}

/// Behind the name of a register that holds a vertex without its guard bits.
pub const KEPT: &str = "_kept";

/// Inputs: `shift` (the columns move on) and what comes in: for words `word` and `write_..` for each place; for
/// slices `row_u`, the outside places, `write_p` for slice p, and `fans` where they bring fans.
/// Outputs: `next_..`, `middle_..`, `previous_..` and `fan_..`. With `sums`, for a unit that works on whole columns of
/// this level alone, `sum_..` is next + middle, from above to below, and `previous_row_..` the sum of the two columns
/// before, which is what the vertex column needs of the previous one.
///
/// Where the ends are walked around, strobes come a clock before what they are for, and every place has registers of
/// its own for them; and a fan comes by itself, an entry a clock: `fan_a` and `fan_x`, with a strobe for every number.
/// Where coordinates take turns, there are places for all three, and `axis` says whose are read and written, `fan_axis`
/// whose fan comes.
pub fn build(parameters: Parameters, level: u32, producer: Producer, sums: bool) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("level_window_{level}"));
    m.purpose(format!("One coordinate of three columns of level {level} and of what lies outside of them."));
    m.parameter("max_valence", parameters.max_valence);
    m.parameter("precision", format!("{:?}", parameters.precision));
    // At level 0 the guard bits are zero: they are not kept, but put below the point on the way out.
    let word = if level == 0 { parameters.input_word() } else { parameters.word(level) };
    let begin = m.input("shift", Word::bit());
    let guard = (parameters.word(level).fraction - word.fraction) as u32;
    let kept = if guard == 0 { "" } else { KEPT };
    // A normal weighs what the fan of its vertex has not with zero: a number it must be, from reset on.
    let weighed = parameters.normals.is_some();
    let axes = parameters.in_turn(level).then(|| Axes::new(&m, level));
    let stage = |stage: &str, place: &str| {
        let name = format!("{stage}_{place}{kept}");
        match (weighed && is_fan(place), &axes) {
            (true, _) => Place::Register(m.register_reset(name, word, 0)),
            (_, None) => Place::Register(m.register_at(name, word, None, u32::from(parameters.walked()))),
            (_, Some(axes)) => axes.place(&m, name, word, stage == "fan"),
        }
    };
    // A strobe for a place alone.
    let own = |what: &str, place: &str, strobe: &Signal| match parameters.walked() && strobe.time() == Some(0)
    {
        true => m.copy(format!("{place}_{what}"), strobe),
        false => strobe.clone(),
    };
    let keep = |name: String, sum: Sum| match parameters.registered {
        true => m.pipe(name, sum),
        false => m.wire(name, sum),
    };
    let put = |name: String, kept: &Signal| match guard {
        0 => m.output(name, kept),
        _ => m.output(name, m.rescale(&m.signal(kept << guard), parameters.word(level).fraction)),
    };
    let incoming = Incoming::new(&m, parameters, level, producer);
    // The outside vertices that the outside face over the strip edge has, by end.
    let mut left_of: Vec<(&str, Signal)> = vec![];
    let mut right_of: Vec<(&str, Signal)> = vec![];

    for place in places(parameters, level) {
        let is_fan = is_fan(&place);
        let (strobe, value) = incoming.at(&m, &place);
        let strobe = own("writes", &place, &strobe);
        if is_fan && level > 0 {
            let fan = stage("fan", &place);
            fan.takes(&m, &strobe, &value);
            put(format!("fan_{place}"), fan.value());
            continue;
        }
        let next = stage("next", &place);
        next.takes(&m, &strobe, &value);
        let moves = own("moves", &place, &begin);
        let moved = |to: &Place, from: &Place| to.takes(&m, &moves, from.value());
        let middle = stage(if is_fan { "fan" } else { "middle" }, &place);
        moved(&middle, &next);
        if is_fan {
            put(format!("fan_{place}"), middle.value());
            continue;
        }
        put(format!("next_{place}"), next.value());
        put(format!("middle_{place}"), middle.value());
        // The outside face over a strip edge has the vertex right of its first end, and left of its second.
        if let Some(end) = End::BOTH.iter().find(|end| sums && place == format!("{}_right", end.name())) {
            right_of.push((end.name(), middle.value().clone()));
        }
        if let Some(end) = End::BOTH.iter().find(|end| sums && place == format!("{}_left", end.name())) {
            left_of.push((end.name(), next.value().clone()));
        }
        if sums && place.starts_with("row_") {
            let sum = keep(format!("added_{place}"), middle.value() + next.value());
            // Of a registered sum the previous one is taken a clock later.
            let late = sum.time().unwrap_or(0);
            let previous = m.register_at(format!("previous_{place}{kept}"), sum.word(), None, late);
            m.on(&m.delay(&begin, late), &previous, &sum);
            put(format!("previous_{place}"), &previous);
            put(format!("sum_{place}"), &sum);
        } else if !place.ends_with("_left") {
            let previous = stage("previous", &place);
            moved(&previous, &middle);
            put(format!("previous_{place}"), previous.value());
        }
    }
    for ((end, left), (_, right)) in left_of.iter().zip(&right_of) {
        put(format!("sum_{end}"), &keep(format!("added_{end}"), right + left));
    }
    m.finish()
}

/// The strobes of fans that come by themselves, by their names.
type Strobes = RefCell<BTreeMap<String, Signal>>;

/// How fans come in.
enum Fans {
    /// Columns bring them where this is 1.
    Along(Signal),
    /// They come by themselves: a_i and x_i.
    Alone([Signal; 2]),
}

/// What comes in, and when it belongs to a place.
enum Incoming {
    Words { word: Signal },
    Slices { cells: u32, slices: u32, rows: Vec<Signal>, writes: Vec<Signal>, fans: Fans, strobes: Strobes },
}

impl Incoming {
    fn new(m: &Builder, parameters: Parameters, level: u32, producer: Producer) -> Incoming {
        let data = u32::from(parameters.walked());
        match producer {
            Producer::Words => Incoming::Words { word: m.input_at("word", parameters.input_word(), data) },
            Producer::Slices { cells, slices } => {
                let lanes = parameters.rows(level).min(2 * cells as usize + 1);
                let value = |name: String| m.input_at(name, parameters.word(level), data);
                let row = |u: usize| value(format!("row_{u}"));
                let rows = (0..lanes).map(row).collect();
                // Inner rows that are kept elsewhere need none.
                let is_here = |p: u32| !parameters.reads_rows(level) || p == 0 || p + 1 == slices;
                let write = |p| m.input(format!("write_{p}"), Word::bit());
                let writes = (0..slices).map(|p| if is_here(p) { write(p) } else { m.bit(false) }).collect();
                let fans = match parameters.walked() {
                    false => Fans::Along(m.input("fans", Word::bit())),
                    true => Fans::Alone(["fan_a", "fan_x"].map(|name| value(name.into()))),
                };
                Incoming::Slices { cells, slices, rows, writes, fans, strobes: Strobes::default() }
            }
        }
    }

    /// The strobe and the value of a place.
    fn at(&self, m: &Builder, place: &str) -> (Signal, Signal) {
        match self {
            Incoming::Words { word } => (m.input(format!("write_{place}"), Word::bit()), word.clone()),
            Incoming::Slices { cells, slices, rows, writes, fans, strobes } => {
                if let Some(row) = place.strip_prefix("row_").and_then(|row| row.parse::<u32>().ok()) {
                    let slice = (row / (2 * cells)).min(slices - 1);
                    let lane = (row - 2 * cells * slice) as usize;
                    return (writes[slice as usize].clone(), rows[lane].clone());
                }
                if let (Fans::Alone(fans), true) = (fans, is_fan(place)) {
                    // top_a_2 and top_x_2 come together.
                    let (end, entry) = place.split_once('_').unwrap_or_default();
                    let (kind, number) = entry.split_once('_').unwrap_or_default();
                    let name = format!("{end}_fan_{number}");
                    let known = strobes.borrow().get(&name).cloned();
                    let data = rows[0].time().unwrap_or(0);
                    let strobe = known.unwrap_or_else(|| m.input_at(&name, Word::bit(), data));
                    strobes.borrow_mut().insert(name, strobe.clone());
                    return (strobe, fans[usize::from(kind == "x")].clone());
                }
                let value = m.input_at(place, rows[0].word(), rows[0].time().unwrap_or(0));
                // The top leaves with the first slice, the bottom with the last.
                let write =
                    if place.starts_with(End::Top.name()) { &writes[0] } else { &writes[writes.len() - 1] };
                match fans {
                    Fans::Along(fans) if is_fan(place) => (write & fans, value),
                    _ => (write.clone(), value),
                }
            }
        }
    }
}

/// The outputs of a placed window.
pub struct Columns<'a> {
    pub level: u32,
    pub placed: &'a Placed,
    parameters: Parameters,
}

/// Columns from left to right.
pub const STAGES: [&str; 3] = ["previous", "middle", "next"];

impl<'a> Columns<'a> {
    pub fn new(parameters: Parameters, level: u32, placed: &'a Placed) -> Self {
        Columns { level, placed, parameters }
    }

    pub fn rows(&self) -> usize {
        self.parameters.rows(self.level)
    }

    /// A row of a column; beyond the ends the outside vertex that its face column there uses. The previous column
    /// has no face column on its left, so nothing is known above and below it.
    pub fn row(&self, column: usize, row: i64) -> Option<Signal> {
        let stage = STAGES[column];
        if (0..self.rows() as i64).contains(&row) {
            return Some(self.placed.out(&format!("{stage}_row_{row}")));
        }
        let end = match row {
            -1 => End::Top,
            _ if row == self.rows() as i64 => End::Bottom,
            _ => return None,
        };
        match column {
            1 => Some(self.outside(1, end, "right")),
            2 => Some(self.outside(2, end, "left")),
            _ => None,
        }
    }

    pub fn outside(&self, column: usize, end: End, place: &str) -> Signal {
        self.placed.out(&format!("{}_{}_{place}", STAGES[column], end.name()))
    }

    /// The sum of the middle and the next row, or of those beyond the ends, where the window makes it.
    pub fn sum(&self, row: i64) -> Option<Signal> {
        match row {
            -1 => Some(self.placed.out(&format!("sum_{}", End::Top.name()))),
            _ if row == self.rows() as i64 => Some(self.placed.out(&format!("sum_{}", End::Bottom.name()))),
            _ => (0..self.rows() as i64).contains(&row).then(|| self.placed.out(&format!("sum_row_{row}"))),
        }
    }

    /// The end vertex of a column, `inward` rows into the strip.
    pub fn end_row(&self, column: usize, end: End, inward: usize) -> Signal {
        let row = if end == End::Top { inward } else { self.rows() - 1 - inward };
        self.placed.out(&format!("{}_row_{row}", STAGES[column]))
    }

    /// a_1, x_2, a_2, ... of the middle column.
    pub fn fan(&self, end: End) -> Vec<Signal> {
        let behind = fan_names(self.parameters);
        let behind = behind.iter().map(|place| self.placed.out(&format!("fan_{}_{place}", end.name())));
        std::iter::once(self.outside(1, end, "left")).chain(behind).collect()
    }
}
