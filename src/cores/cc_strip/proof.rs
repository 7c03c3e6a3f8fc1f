//! The proof by linear forms that every level of a `cc-strip` computes its masks, for all inputs and for
//! every valence.
//!
//! Each level's column unit runs on a window of variables. What leaves must be the classical rules of
//! Catmull and Clark, written from the faces around a vertex and not from the separable sums of the core:
//!
//! ```text
//! F = mean of the face      E = (F1 + F2 + A + B) / 4      V = (sum F + sum A) / d^2 + (d - 2) S / d
//! ```
//!
//! For a valence whose kappa = 1 / (4 d^2) is no binary fraction, V is the rule with the table's constant.

use std::collections::BTreeMap;

use super::Parameters;
use super::engine::{self, passed_places};
use super::fan::{End, fan_names};
use super::schedule::Group;
use super::window::{KEPT, STAGES};
use crate::error::{Error, Kind, Result};
use crate::fixed::{Form, Rounding};
use crate::hdl::linear::Value;
use crate::hdl::{Flat, LinearForms, NodeId, Simulator, Word};

/// Variables of the largest window: three columns of 65 rows and what lies outside.
pub(super) const VARIABLES: usize = 256;

/// What was proved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Proof {
    pub levels: u32,
    /// Valences from 3 to this.
    pub max_valence: u32,
    /// Vertices whose form was compared with their rule.
    pub vertices: u64,
    /// Claims that were met and hold.
    pub claims: u64,
}

/// An integer combination of the window's variables.
pub(super) type Mask = BTreeMap<usize, i128>;

fn plus(sum: &mut Mask, factor: i128, other: &Mask) {
    for (&variable, &weight) in other {
        *sum.entry(variable).or_insert(0) += factor * weight;
    }
}

fn total(parts: &[(i128, &Mask)]) -> Mask {
    let mut sum = Mask::new();
    parts.iter().for_each(|(factor, part)| plus(&mut sum, *factor, part));
    sum
}

/// Runs the proof; an error is a refutation. A mode of rounding that is no floor of a sum is proved with the sums
/// that it rounds: the core is proved with halves rounded up in its place.
///
/// # Errors
/// Of kind `Mismatch` where a vertex is another function of the window; else those of building the engines.
pub fn prove(parameters: Parameters) -> Result<Proof> {
    let rounding = if parameters.rounding == Rounding::Floor { Rounding::Floor } else { Rounding::HalfUp };
    let parameters = Parameters { rounding, ..parameters };
    let mut proof =
        Proof { levels: parameters.levels, max_valence: parameters.max_valence, ..Proof::default() };
    let groups = parameters.groups();
    for index in 0..groups.len() {
        let engine = engine::build(parameters, index, &groups)?;
        let delay = engine.output("out_row_0").map_or(0, |at| engine.latency(&engine.outputs[at]));
        let flat = Flat::new(&engine)?;
        for level in groups[index].levels.clone() {
            for valence in 3..=parameters.max_valence {
                // Different valences at the two ends, so that they cannot be mixed up.
                let other = if valence == parameters.max_valence { 3 } else { valence + 1 };
                let valences = [valence, other];
                let turns: &[_] = match parameters.in_turn(level) || parameters.reads_rows(level) {
                    true => &[Some(0), Some(1), Some(2)],
                    false => &[None],
                };
                for &turn in turns {
                    let claim = Statement { parameters, group: &groups[index], level, valences, turn };
                    let (vertices, claims) = claim.prove(&flat, delay)?;
                    proof.vertices += vertices;
                    proof.claims += claims;
                }
            }
        }
    }
    Ok(proof)
}

/// The control vertices around the middle column as variables.
pub(super) struct Window {
    rows: usize,
    pub(super) columns: [Vec<Mask>; 3],
    ends: [Ring; 2],
}

/// What lies around an end vertex: neighbours and diagonals over the outside from left to right.
struct Ring {
    valence: u32,
    /// a_1 .. a_{d-3}
    neighbours: Vec<Mask>,
    /// x_1 .. x_{d-2}; the first and the last belong to the neighbouring columns.
    diagonals: Vec<Mask>,
}

impl Window {
    fn new(rows: usize, valences: [u32; 2]) -> Window {
        let mut next = 0;
        let mut variable = || {
            next += 1;
            Mask::from([(next - 1, 1)])
        };
        let columns = [0; 3].map(|_| (0..rows).map(|_| variable()).collect());
        let ends = valences.map(|valence| Ring {
            valence,
            neighbours: (0..valence - 3).map(|_| variable()).collect(),
            diagonals: (0..valence - 2).map(|_| variable()).collect(),
        });
        Window { rows, columns, ends }
    }

    /// The end vertex of column c (0, 1, 2), and the row next to it.
    fn end(&self, end: usize, column: usize) -> [&Mask; 2] {
        let rows = &self.columns[column];
        if end == 0 { [&rows[0], &rows[1]] } else { [&rows[self.rows - 1], &rows[self.rows - 2]] }
    }

    /// The edge neighbours of an end of the middle column, and the diagonals between them, all around:
    /// diagonal i lies between neighbours i and i + 1.
    fn around(&self, end: usize) -> (Vec<&Mask>, Vec<&Mask>) {
        let ring = &self.ends[end];
        let ([left, inner_left], [_, inner], [right, inner_right]) =
            (self.end(end, 0), self.end(end, 1), self.end(end, 2));
        let neighbours = std::iter::once(left).chain(&ring.neighbours).chain([right, inner]).collect();
        let diagonals = ring.diagonals.iter().chain([inner_right, inner_left]).collect();
        (neighbours, diagonals)
    }

    /// What a register of the window holds, by its name; nothing where the unit must not look.
    pub(super) fn register(&self, name: &str, sums: bool) -> Option<Mask> {
        let (stage, place) = name.split_once('_')?;
        let column = STAGES.iter().position(|s| *s == stage);
        if let (Some(column), Some(row)) = (column, place.strip_prefix("row_")) {
            let row = row.parse::<usize>().ok()?;
            let vertex = self.columns[column].get(row)?;
            return Some(match column {
                0 if sums => total(&[(1, vertex), (1, self.columns[1].get(row)?)]),
                _ => vertex.clone(),
            });
        }
        self.outside_register(column, place).cloned()
    }

    fn outside_register(&self, column: Option<usize>, place: &str) -> Option<&Mask> {
        let (end, place) = place.split_once('_')?;
        let end = usize::from(end == End::Bottom.name());
        let ring = &self.ends[end];
        let (first, last) = (ring.diagonals.first(), ring.diagonals.last());
        // a_i and x_i count from 1; x_1 and x_{d-2} belong to the neighbouring columns.
        let number = |list: &str| place.strip_prefix(list).and_then(|i| i.parse::<usize>().ok());
        match (column, place) {
            (Some(0), "right") => first,
            (Some(2), "left") => last,
            // The face column to its right lies below the last neighbour, or below the left one's with valence 3.
            (Some(1), "right") => last_face_corner(self, end),
            (Some(1), "left") => ring.neighbours.first(),
            (None, _) => match (number("a_"), number("x_")) {
                (Some(i), _) => ring.neighbours.get(i - 1),
                (_, Some(i)) => ring.diagonals.get(i - 1).filter(|_| i < ring.valence as usize - 2),
                _ => None,
            },
            _ => None,
        }
    }
}

/// The outside vertex that the face column to the right of an end uses: its last outside neighbour; of valence 3,
/// the end vertex of the column before.
fn last_face_corner(window: &Window, end: usize) -> Option<&Mask> {
    window.ends[end].neighbours.last().or(Some(window.end(end, 0)[0]))
}

/// Four times the point of a face.
fn face(corners: [&Mask; 4]) -> Mask {
    total(&corners.map(|c| (1, c)))
}

/// 64 times the point of the edge a-b between two faces, given as four times their points.
fn edge(a: &Mask, b: &Mask, faces: [&Mask; 2]) -> Mask {
    total(&[(4, faces[0]), (4, faces[1]), (16, a), (16, b)])
}

/// An expected vertex: its mask over 64 * 2^more.
struct Rule {
    mask: Mask,
    more: u32,
}

fn plain(mask: Mask) -> Rule {
    Rule { mask, more: 0 }
}

/// What must leave, by the name of the port; first the face column, then the vertex column.
fn rules(window: &Window, table_bits: u32) -> [BTreeMap<String, Rule>; 2] {
    let [p, c, n] = &window.columns;
    let (mut between, mut middle) = (BTreeMap::new(), BTreeMap::new());
    let inner = |a: &[Mask], b: &[Mask], k: usize| face([&a[k], &b[k], &a[k + 1], &b[k + 1]]);
    let last = window.rows - 1;
    let outer = |end: usize| {
        let ring = &window.ends[end];
        let (from, to) = (window.end(end, 1)[0], window.end(end, 2)[0]);
        let first = ring.neighbours.last().unwrap_or(window.end(end, 0)[0]);
        face([from, to, first, &ring.diagonals[ring.diagonals.len() - 1]])
    };
    for k in 0..window.rows {
        let above = if k == 0 { outer(0) } else { inner(c, n, k - 1) };
        let below = if k == last { outer(1) } else { inner(c, n, k) };
        between.insert(format!("row_{}", 2 * k), plain(edge(&c[k], &n[k], [&above, &below])));
        if k < last {
            between.insert(format!("row_{}", 2 * k + 1), plain(total(&[(16, &inner(c, n, k))])));
            let sides = [&inner(p, c, k), &inner(c, n, k)];
            middle.insert(format!("row_{}", 2 * k + 1), plain(edge(&c[k], &c[k + 1], sides)));
        }
        if k > 0 && k < last {
            let around = [&p[k], &c[k - 1], &n[k], &c[k + 1]];
            let corners = [&p[k - 1], &n[k - 1], &p[k + 1], &n[k + 1]];
            let mask = classical(&c[k], &around, &corners);
            middle.insert(format!("row_{}", 2 * k), plain(mask));
        }
    }
    for end in 0..2 {
        let name = |place: &str| format!("{}_{place}", End::BOTH[end].name());
        let (centre, ring) = (window.end(end, 1)[0], &window.ends[end]);
        let (neighbours, diagonals) = window.around(end);
        let point = plain(total(&[(16, &outer(end))]));
        for place in ["left", "right", "a_1"] {
            between.insert(name(place), Rule { mask: point.mask.clone(), more: 0 });
        }
        // Face i lies between neighbours i and i + 1.
        let count = neighbours.len();
        let faces: Vec<Mask> = (0..count)
            .map(|i| face([centre, neighbours[i], diagonals[i], neighbours[(i + 1) % count]]))
            .collect();
        let spoke =
            |i: usize| plain(edge(centre, neighbours[i], [&faces[(i + count - 1) % count], &faces[i]]));
        let outside = ring.valence as usize - 3;
        for i in 1..=outside {
            middle.insert(name(&format!("a_{i}")), spoke(i));
            if i >= 2 {
                middle.insert(name(&format!("x_{i}")), plain(total(&[(16, &faces[i - 1])])));
            }
        }
        // Left of it the face columns see a_1, right of it a_{d-3}; with valence 3 the edges across.
        middle.insert(name("left"), spoke(1));
        middle.insert(name("right"), spoke(outside));
        let row = if end == 0 { 0 } else { 2 * last };
        let mask = replacement(centre, &neighbours, &diagonals, table_bits);
        middle.insert(format!("row_{row}"), Rule { mask, more: table_bits });
    }
    [between, middle]
}

/// 4 d^2 times the vertex rule, from the faces; for d = 4 that is over 64.
fn classical(centre: &Mask, neighbours: &[&Mask], diagonals: &[&Mask]) -> Mask {
    let d = neighbours.len() as i128;
    let mut sum = total(&[(4 * d * (d - 2), centre)]);
    for neighbour in neighbours {
        // Each neighbour belongs to two faces, each face has the centre too.
        plus(&mut sum, 4 + 2, neighbour);
        plus(&mut sum, 1, centre);
    }
    diagonals.iter().for_each(|diagonal| plus(&mut sum, 1, diagonal));
    sum
}

/// The vertex rule over 64 * 2^bits with the table's constant: 64 2^bits S + kappa (classical - 4 d^2 S).
fn replacement(centre: &Mask, neighbours: &[&Mask], diagonals: &[&Mask], bits: u32) -> Mask {
    let d = neighbours.len() as i128;
    let rule = classical(centre, neighbours, diagonals);
    // The nearest integer to 2^bits * 64 / (4 d^2), from the definition and not from the core's table.
    let kappa = ((32i128 << bits) + d * d).div_euclid(2 * d * d);
    total(&[(kappa, &rule), ((64i128 << bits) - kappa * 4 * d * d, centre)])
}

/// One level of a group with given valences at its ends.
pub(super) struct Statement<'a> {
    pub(super) parameters: Parameters,
    pub(super) group: &'a Group,
    pub(super) level: u32,
    pub(super) valences: [u32; 2],
    /// The coordinate in turn, where there are turns; the bank of the next column, where there are banks.
    pub(super) turn: Option<usize>,
}

impl Statement<'_> {
    /// The engine's output is so many clocks behind its window. Returns how many vertices were compared, and how many
    /// claims were checked.
    fn prove(&self, flat: &Flat, delay: u32) -> Result<(u64, u64)> {
        let Statement { parameters, group, level, valences, .. } = *self;
        let window = Window::new(parameters.rows(level), valences);
        // At level 0 the registers hold the control points, without the guard bits.
        let guard = if level == 0 { parameters.extra_fraction(0) } else { 0 };
        let variable = if level == 0 { parameters.input_word() } else { parameters.word(level) };
        let mut simulator = Simulator::new(flat.clone(), LinearForms::<VARIABLES>::new(vec![variable.range]));
        let registers: BTreeMap<String, NodeId> = flat
            .clocked
            .iter()
            .filter_map(|&id| {
                Some((flat.nodes[id.index()].path.as_deref()?.trim_end_matches(KEPT).into(), id))
            })
            .collect();
        let here = format!("window_{level}.");
        if delay > 0 {
            // What is on its way is flushed; of the window only its flags and sums are.
            let state =
                |path: &str| path.strip_prefix(here.as_str()).is_some_and(|name| !name.starts_with("added_"));
            let flushed = |path: &str, id: NodeId| !state(path) || flat.node(id).word == Word::bit();
            registers
                .iter()
                .filter(|(path, id)| flushed(path, **id))
                .for_each(|(_, &id)| simulator.set(id, Value::Integer(0)));
        }
        let (sums, here) = (engine::keeps_sums(group), here.as_str());
        // A registered window keeps the sum of the columns before a clock behind the columns.
        let is_late = |name: &str| parameters.registered && sums && name.starts_with("previous_row_");
        let held = |late: bool| {
            let window = &window;
            registers.iter().filter_map(move |(path, &id)| {
                let name = path.strip_prefix(here).filter(|name| is_late(name) == late)?;
                Some((id, Value::Form(form(&window.register(name, sums)?))))
            })
        };
        held(false).for_each(|(id, value)| simulator.set(id, value));
        if let Some(turn) = self.turn {
            self.in_rams(&mut simulator, &registers, &window, turn);
        }
        let control = |s: &mut Simulator<_>, name: &str, number: u32| {
            if let Some(id) = s.flat.input(name) {
                s.set(id, Value::Integer(number.into()));
            }
        };
        for (name, id) in flat.inputs.clone() {
            // Nothing comes in.
            let is_strobe = name.starts_with("in_") && flat.node(id).word == Word::bit();
            if is_strobe {
                simulator.set(id, Value::Integer(0));
            }
        }
        for name in ["in_axis", "in_fan_axis"] {
            control(&mut simulator, name, self.turn.unwrap_or(0) as u32);
        }
        for l in group.levels.clone() {
            control(&mut simulator, &format!("serve_{l}"), u32::from(l == level));
            control(&mut simulator, &format!("shift_{l}"), 0);
            control(&mut simulator, &format!("write_{l}"), 0);
        }
        for (end, valence) in End::BOTH.iter().zip(valences) {
            control(&mut simulator, &format!("{}_valence", end.name()), valence);
        }

        if delay > 0 {
            ["face", "slice", "walk"].iter().for_each(|name| control(&mut simulator, name, 0));
            simulator.settle();
            simulator.edge(false)?;
            held(true).for_each(|(id, value)| simulator.set(id, value));
        }

        let slices = group.slices(level);
        let cells = (1usize << level) / slices as usize;
        let within = level < group.finest();
        let [between, middle] = rules(&window, parameters.replacement_bits());
        let expected = |rules: &BTreeMap<String, Rule>, name: &str| {
            rules.get(name).map(|rule| rounded(parameters, level, guard, rule))
        };
        let mut compared = 0;
        if group.walked {
            compared += self.walk(&mut simulator, delay, &|name| expected(&middle, name))?;
        }
        for (face, rules) in [(1, &between), (0, &middle)] {
            control(&mut simulator, "face", face);
            let prefix = if face == 1 && group.double { "face" } else { "out" };
            let column = if face == 1 { "face column" } else { "vertex column" };
            let differs = |what: &str, name: &str| {
                let place = format!("level {level}, valences {valences:?}, {column}, {what}, {name}");
                Error::new(Kind::Mismatch, "a vertex is another function of the window").at(place)
            };
            for slice in 0..slices {
                // A row is read once, for the slices that see it.
                for before in slice.saturating_sub(3)..slice {
                    control(&mut simulator, "slice", before);
                    simulator.settle();
                    simulator.edge(false)?;
                }
                control(&mut simulator, "slice", slice);
                control(&mut simulator, &format!("shift_{}", level + 1), u32::from(slice == 0));
                control(&mut simulator, &format!("write_{}", level + 1), u32::from(within));
                for clock in 0..delay {
                    simulator.settle();
                    simulator.edge(false)?;
                    // Behind a vertex column waits the face column of the same window.
                    if clock == 0 && slices == 1 {
                        control(&mut simulator, "face", 1);
                    }
                }
                simulator.settle();
                if parameters.registered {
                    control(&mut simulator, "face", face);
                }
                let lanes = 2 * cells + usize::from(slice + 1 == slices);
                let rows = (0..lanes)
                    .map(|u| (format!("row_{u}"), format!("row_{}", 2 * cells * slice as usize + u)));
                let ends = engine_ends(parameters, slice == 0, slice + 1 == slices);
                let passed = passed_places(parameters, group);
                let ends: Vec<String> = ends.into_iter().filter(|place| passed.contains(place)).collect();
                for (port, name) in rows.chain(ends.into_iter().map(|place| (place.clone(), place))) {
                    let Some(expected) = expected(rules, &name) else { continue };
                    let id = simulator.flat.output(&format!("{prefix}_{port}"));
                    match id.map(|id| *simulator.get(id)) {
                        Some(Value::Form(form)) if form.canonical() == expected => compared += 1,
                        _ => return Err(differs("output", &name)),
                    }
                }
                if within {
                    simulator.edge(false)?;
                }
            }
            if within {
                // The next window of the group has taken the column in.
                for row in 0..parameters.rows(level + 1) {
                    let name = format!("row_{row}");
                    let id = registers.get(&format!("window_{}.next_{name}", level + 1));
                    match (id.map(|&id| *simulator.get(id)), expected(rules, &name)) {
                        (Some(Value::Form(form)), Some(expected)) if form.canonical() == expected => {}
                        _ => return Err(differs("next window", &name)),
                    }
                }
            }
        }
        match simulator.domain.failures.first() {
            Some(failure) => Err(Error { kind: Kind::Mismatch, ..failure.clone() }),
            None => Ok((compared, simulator.domain.proved.len() as u64)),
        }
    }
}

/// What lies outside of the ends that leave with a slice.
fn engine_ends(parameters: Parameters, top: bool, bottom: bool) -> Vec<String> {
    let ends = End::BOTH.iter().zip([top, bottom]).filter(|(_, leaves)| *leaves);
    ends.flat_map(|(end, _)| {
        let places = ["left", "right"].map(String::from).into_iter().chain(fan_names(parameters));
        places.map(|place| format!("{}_{place}", end.name()))
    })
    .collect()
}

pub(super) fn form(mask: &Mask) -> Form<VARIABLES> {
    let mut form = Form::variable(0, 0);
    form.coefficients[0] = 0;
    mask.iter().for_each(|(&variable, &weight)| form.coefficients[variable] = weight as i64);
    form
}

/// The rule as the next level receives it: over the right power of two, rounded.
fn rounded(parameters: Parameters, level: u32, guard: u32, rule: &Rule) -> Form<VARIABLES> {
    let drop = parameters.drop() + rule.more;
    let unit = 1i128 << drop;
    let half = if parameters.rounding == Rounding::Floor { 0 } else { unit / 2 };
    debug_assert_eq!(
        drop,
        parameters.extra_fraction(level) + 6 - parameters.extra_fraction(level + 1) + rule.more
    );
    let mut form = form(&rule.mask);
    form.coefficients.iter_mut().for_each(|c| *c <<= guard);
    Form { constant: half, divisor: unit, ..form }.canonical()
}
