//! A [`View`] as the ports of a unit: its names in a fixed order, and the view that they make.
//!
//! ```text
//! row_c_k          column c = 0, 1, 2, row k        top_outer_c, top_inner_c, top_before, top_after,
//! is_bottom_k      rows that can be the last one    top_a_i, top_x_i, top_valence, and the same of the bottom
//! ```

use super::VALENCE_BITS;
use super::fan::End;
use super::finish::Parameters;
use super::view::{EndView, View};
use crate::hdl::{Builder, Signal, Word};

/// The kinds of ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A coordinate.
    Point,
    IsBottom,
    Valence,
}

/// Every port of a view, in order.
pub fn names(p: Parameters) -> Vec<(String, Kind)> {
    let mut names = vec![];
    for column in 0..3 {
        names.extend((0..p.rows()).map(|row| (format!("row_{column}_{row}"), Kind::Point)));
    }
    names.extend(p.bottoms().map(|row| (format!("is_bottom_{row}"), Kind::IsBottom)));
    for end in End::BOTH.map(End::name) {
        for place in ["outer", "inner"] {
            names.extend((0..3).map(|column| (format!("{end}_{place}_{column}"), Kind::Point)));
        }
        names.extend(["before", "after"].map(|place| (format!("{end}_{place}"), Kind::Point)));
        let last = p.max_valence - 3;
        names.extend((1..=last).map(|i| (format!("{end}_a_{i}"), Kind::Point)));
        names.extend((2..=last).map(|i| (format!("{end}_x_{i}"), Kind::Point)));
        names.push((format!("{end}_valence"), Kind::Valence));
    }
    names
}

/// The signals of a view in the order of [`names`].
fn flatten(p: Parameters, view: &View) -> Vec<Signal> {
    let mut signals: Vec<Signal> = view.rows.iter().flatten().cloned().collect();
    signals.extend(p.bottoms().map(|row| view.is_bottom[row].clone()));
    for end in &view.ends {
        signals.extend(end.outer.iter().chain(&end.inner).chain([&end.before, &end.after]).cloned());
        signals.extend(end.neighbours.iter().chain(&end.diagonals).cloned());
        signals.push(end.valence.clone());
    }
    signals
}

/// The connections of a view to the ports of a unit, its coordinates in `word`.
pub fn connected(
    m: &Builder,
    p: Parameters,
    names: &[(String, Kind)],
    view: &View,
    word: Word,
) -> Vec<(String, Signal)> {
    let connect = |((name, kind), signal): (&(String, Kind), Signal)| {
        // A narrower range of what is the same number has fewer bits.
        let same = *kind != Kind::Point || signal.word() == word;
        (name.clone(), if same { signal } else { m.wrap(&signal, word) })
    };
    names.iter().zip(flatten(p, view)).map(connect).collect()
}

/// The ports of a unit: inputs whose coordinates are in `word`.
pub fn view(m: &Builder, p: Parameters, prefix: &str, word: Word) -> View {
    let signals = names(p).into_iter().map(|(name, kind)| {
        let word = match kind {
            Kind::Point => word,
            Kind::IsBottom => Word::bit(),
            Kind::Valence => Word::unsigned(VALENCE_BITS),
        };
        m.input(format!("{prefix}{name}"), word)
    });
    of_signals(m, p, &signals.collect::<Vec<_>>())
}

/// The view of signals in the order of [`names`].
pub fn of_signals(m: &Builder, p: Parameters, signals: &[Signal]) -> View {
    let mut rest = signals;
    let mut take = |count: usize| {
        let (first, others) = rest.split_at(count);
        rest = others;
        first.to_vec()
    };
    let rows = [0; 3].map(|_| take(p.rows()));
    let mut is_bottom = vec![m.bit(false); p.rows() - 1];
    is_bottom.push(m.bit(true));
    p.bottoms().for_each(|row| is_bottom[row] = take(1).remove(0));
    let last = (p.max_valence - 3) as usize;
    let ends = [0; 2].map(|_| {
        let mut three = || <[Signal; 3]>::try_from(take(3)).unwrap_or_else(|_| [0; 3].map(|_| m.bit(false)));
        let (outer, inner) = (three(), three());
        let (before, after) = (take(1).remove(0), take(1).remove(0));
        EndView {
            outer,
            inner,
            before,
            after,
            neighbours: take(last),
            diagonals: take(last - 1),
            valence: take(1).remove(0),
        }
    });
    View { rows, is_bottom, ends }
}
