//! One coordinate of one level: the window of three columns, and the two column units on it.
//!
//! ```text
//! arrive ─► next ─► middle ─► previous          face column:    middle, next
//!                                               vertex column:  previous, middle, next
//! ```

use std::rc::Rc;

use super::columns::{Column, Outside, face_column, vertex_column};
use super::outside::{End, Window, replace_end};
use super::{Parameters, VALENCE_BITS};
use crate::error::Result;
use crate::fixed::Rounding;
use crate::hdl::{Builder, Module, Signal, Word};

/// The names of a column's vertices in the order of the ports: rows, then what lies outside of both ends.
pub fn column_names(parameters: Parameters, level: u32) -> Vec<String> {
    let mut names: Vec<String> = (0..parameters.rows(level)).map(|k| format!("row_{k}")).collect();
    for end in End::BOTH {
        names.extend(outside_names(parameters, end));
    }
    names
}

/// left, right, a_1, x_2, a_2, ...
pub fn outside_names(parameters: Parameters, end: End) -> Vec<String> {
    let mut names = vec!["left".to_string(), "right".to_string()];
    for i in 1..=parameters.outside_neighbours() {
        if i >= 2 {
            names.push(format!("x_{i}"));
        }
        names.push(format!("a_{i}"));
    }
    names.iter().map(|n| format!("{}_{n}", end.name())).collect()
}

/// Signals in the order of [`column_names`] as a column.
fn column(parameters: Parameters, level: u32, signals: &[Signal]) -> Column {
    let rows = parameters.rows(level);
    let per_end = (signals.len() - rows) / 2;
    let outside = |signals: &[Signal]| Outside {
        left: signals[0].clone(),
        right: signals[1].clone(),
        neighbours: signals[2..].iter().step_by(2).cloned().collect(),
        diagonals: signals[3..].iter().step_by(2).cloned().collect(),
    };
    Column {
        rows: signals[..rows].to_vec(),
        top: outside(&signals[rows..rows + per_end]),
        bottom: outside(&signals[rows + per_end..]),
    }
}

fn flatten(column: &Column) -> Vec<Signal> {
    let outside = |o: &Outside| {
        let mut signals = vec![o.left.clone(), o.right.clone()];
        for (i, a) in o.neighbours.iter().enumerate() {
            signals.extend(i.checked_sub(1).map(|x| o.diagonals[x].clone()));
            signals.push(a.clone());
        }
        signals
    };
    [column.rows.clone(), outside(&column.top), outside(&column.bottom)].concat()
}

/// Inputs: a column (see [`column_names`]), `arrive`, `face` (which column leaves), the valences of the middle
/// column. Outputs: the column that leaves, one level finer, named `out_..`.
pub fn build(parameters: Parameters, level: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("strip_level_{level}"));
    m.purpose(format!(
        "One coordinate of level {level}: a window of three columns with its face and vertex column."
    ));
    m.parameter("max_valence", parameters.max_valence);
    m.parameter("precision", format!("{:?}", parameters.precision));
    let word = parameters.word(level);
    let names = column_names(parameters, level);
    let incoming: Vec<Signal> = names.iter().map(|n| m.input(n.clone(), word)).collect();
    let [arrive, face] = ["arrive", "face"].map(|n| m.input(n, Word::bit()));
    let valences = End::BOTH.map(|e| m.input(format!("{}_valence", e.name()), Word::unsigned(VALENCE_BITS)));

    let stage = |stage: &str, from: &[Signal]| -> Vec<Signal> {
        let register = |(name, value): (&String, &Signal)| {
            let register = m.register(format!("{stage}_{name}"), word);
            m.on(&arrive, &register, value);
            register
        };
        names.iter().zip(from).map(register).collect()
    };
    let next = stage("next", &incoming);
    let middle = stage("middle", &next);
    let previous = stage("previous", &middle);
    let [previous, middle, next] = [previous, middle, next].map(|s| column(parameters, level, &s));

    let between = face_column(&m, &middle, &next);
    let window = Window { previous: &previous, column: &middle, next: &next };
    let [top, bottom] = [(End::Top, &valences[0]), (End::Bottom, &valences[1])]
        .map(|(end, valence)| replace_end(&m, parameters, level, &window, end, valence));
    let rows = vertex_column(&m, &previous, &middle, &next, [top.0, bottom.0]);
    let vertex = flatten(&Column { rows, top: top.1, bottom: bottom.1 });
    // Outside of a face column lies one face point, its only neighbour there.
    let alone = |point: &Signal| Outside {
        left: point.clone(),
        right: point.clone(),
        neighbours: vec![point.clone(); parameters.outside_neighbours()],
        diagonals: vec![point.clone(); parameters.outside_neighbours() - 1],
    };
    let (top, bottom) = (alone(&between.top), alone(&between.bottom));
    let between = flatten(&Column { rows: between.rows, top, bottom });

    let drop = parameters.extra_fraction(level) + 6 - parameters.extra_fraction(level + 1);
    let (finer, last_row) = (column_names(parameters, level + 1), parameters.rows(level + 1) - 1);
    for (place, ((name, on_face), on_vertex)) in finer.iter().zip(&between).zip(&vertex).enumerate() {
        // The sums are over 64, six fraction bits more; a replaced end vertex has those of the table too.
        let on_face = m.rescale(on_face, word.fraction + 6);
        let ended = place == 0 || place == last_row;
        let more = if ended { parameters.replacement_bits() } else { 0 };
        let on_face = m.rescale(&m.signal(&on_face << more), word.fraction + 6 + more as i32);
        let on_vertex = m.rescale(on_vertex, word.fraction + 6 + more as i32);
        let chosen = m.wire(format!("chosen_{name}"), m.select(&face, &on_face, &on_vertex));
        let rounded = m.round(&chosen, drop + more, Rounding::HalfUp);
        m.output(format!("out_{name}"), m.wire(format!("out_{name}"), &rounded));
    }
    m.finish()
}
