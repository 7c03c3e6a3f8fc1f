//! The list of the figures: what the thesis prints, what is right, and why they differ.

use super::{
    BANDWIDTH, Operators, analytic_storage, analytic_storage_printed, column_vertices, fan_entries,
    fan_vertices, lean_storage_extra, lean_storage_vertices, operators, operators_printed, storage_vertices,
    storage_with_look_ahead, window_vertices, window_vertices_printed,
};

/// A number of the thesis beside the right one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    pub quantity: Quantity,
    /// What it counts.
    pub name: &'static str,
    /// Where it stands in the thesis.
    pub source: &'static str,
    pub unit: &'static str,
    /// What the thesis prints or its printed formula gives; none where it says nothing.
    pub printed: Option<f64>,
    pub corrected: f64,
    /// Why they differ; empty where they agree.
    pub note: &'static str,
}

/// What a figure counts, for whoever has counted it in a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    Eigenspace,
    EigenspaceSubpatches,
    WordsOnce,
    WordsPlain,
    WordsWithFans,
    Column,
    Windows,
    Fans,
    Storage,
    StorageLookAhead,
    Bytes,
    LeanStorage,
    LeanExtra,
    ClocksShared,
    ClocksPipelined,
    ClocksDouble,
    StartUp,
    FourInputAdders,
    ThreeInputAdders,
    FanAdders,
    ShiftsRightByFour,
    ShiftsRightByTwo,
    ShiftsRightByOne,
    ShiftsLeftByOne,
    MultipliersByThird,
    Multipliers,
    Tables,
    TableEntries,
}

/// All figures for a finest level and a largest valence, in the order of the thesis.
pub fn figures(levels: u32, valence: u32) -> Vec<Figure> {
    let figure = |quantity, name, source, unit, printed: Option<f64>, corrected: f64, note| Figure {
        quantity,
        name,
        source,
        unit,
        printed,
        corrected,
        note,
    };
    let whole = |n: u64| n as f64;
    let (old, new) = (operators_printed(levels, valence), operators(levels, valence));
    let operator = |quantity, name, count: fn(&Operators) -> u64, note| {
        figure(quantity, name, "6.4", "operators", Some(whole(count(&old))), whole(count(&new)), note)
    };
    let windows = (window_vertices_printed(levels), window_vertices(levels));
    let entries = fan_entries(levels, valence);
    // The total is printed for five levels and valence 10 only.
    let total = if (levels, valence) == (5, 10) { 410 } else { windows.0 + entries };
    let bytes = 16.0 * whole(storage_vertices(levels, valence));
    vec![
        figure(
            Quantity::Eigenspace,
            "values stored by evaluation in eigenspace",
            "2.3",
            "values",
            Some(analytic_storage_printed(valence)),
            whole(analytic_storage(valence, 1)),
            "the summand is 4d^2 + 66d + 200, and the closed form adds its constant once only",
        ),
        figure(
            Quantity::EigenspaceSubpatches,
            "the same with the bases of all three sub-patches",
            "2.3",
            "values",
            None,
            whole(analytic_storage(valence, 3)),
            "the picking matrix differs for each of them",
        ),
        figure(
            Quantity::WordsOnce,
            "words a vertex, each sent once",
            "6.1",
            "words",
            Some(1.0),
            whole(BANDWIDTH[0]),
            "",
        ),
        figure(
            Quantity::WordsPlain,
            "words a vertex, as plain strips",
            "6.1",
            "words",
            Some(2.0),
            whole(BANDWIDTH[1]),
            "",
        ),
        figure(
            Quantity::WordsWithFans,
            "words a vertex, with fans",
            "6.1",
            "words",
            Some(4.0),
            whole(BANDWIDTH[2]),
            "",
        ),
        figure(
            Quantity::Column,
            "vertices of a column",
            "(6.1)",
            "vertices",
            Some(whole(column_vertices(levels))),
            whole(column_vertices(levels)),
            "",
        ),
        figure(
            Quantity::Windows,
            "three columns of each level",
            "(6.2)",
            "vertices",
            Some(whole(windows.0)),
            whole(windows.1),
            "the sum ends in + 6, not in - 3",
        ),
        figure(
            Quantity::Fans,
            "fans",
            "(6.3)",
            "vertices",
            Some(whole(entries)),
            whole(fan_vertices(levels, valence)),
            "an entry is a pair of vertices",
        ),
        figure(
            Quantity::Storage,
            "storage",
            "(6.4)",
            "vertices",
            Some(whole(total)),
            whole(storage_vertices(levels, valence)),
            "410 does not follow: the printed formulas give 330, the corrected window 339, with pairs 435",
        ),
        figure(
            Quantity::StorageLookAhead,
            "storage with a 4 x 4 array at level 0",
            "4.2",
            "vertices",
            None,
            whole(storage_with_look_ahead(levels, valence)),
            "not needed where the host sends uL and uR",
        ),
        figure(
            Quantity::Bytes,
            "storage in bytes, four words a vertex",
            "6.2",
            "bytes",
            Some(7.0 * 1024.0),
            bytes,
            "below seven kilobytes, as claimed",
        ),
        figure(
            Quantity::LeanStorage,
            "lean storage",
            "6.2",
            "vertices",
            None,
            whole(lean_storage_vertices(levels, valence)),
            "three columns before the finest level, which keeps one; the fans that are needed at once",
        ),
        figure(
            Quantity::LeanExtra,
            "lean storage, uR beside uL, at most",
            "6.2",
            "vertices",
            None,
            whole(lean_storage_extra(levels)),
            "",
        ),
        figure(
            Quantity::ClocksShared,
            "clocks a column, one unit for all levels",
            "6.3",
            "clocks",
            Some(whole((2 << levels) - 2)),
            whole((2 << levels) - 2),
            "",
        ),
        figure(
            Quantity::ClocksPipelined,
            "clocks a column, one unit a level",
            "7.3",
            "clocks",
            None,
            whole(1 << levels),
            "the thesis leaves it as future work",
        ),
        figure(
            Quantity::ClocksDouble,
            "clocks a column, two columns a clock at the finest level",
            "7.3",
            "clocks",
            None,
            whole(1 << (levels - 1)),
            "a face and a vertex column at once",
        ),
        figure(
            Quantity::StartUp,
            "clocks before the first column, about",
            "6.3",
            "clocks",
            Some(whole(3 * u64::from(levels))),
            whole(3 * u64::from(levels)),
            "",
        ),
        operator(
            Quantity::FourInputAdders,
            "adders of four inputs",
            |o| o.four_input_adders,
            "the source columns are half as long as the new ones",
        ),
        operator(
            Quantity::ThreeInputAdders,
            "adders of three inputs",
            |o| o.three_input_adders,
            "in the text, not in the list",
        ),
        operator(
            Quantity::FanAdders,
            "adders of as many inputs as the largest valence",
            |o| o.fan_adders,
            "",
        ),
        operator(
            Quantity::ShiftsRightByFour,
            "shifts right by four",
            |o| o.right_shifts_by_4,
            "in the text: left",
        ),
        operator(
            Quantity::ShiftsRightByTwo,
            "shifts right by two",
            |o| o.right_shifts_by_2,
            "edges divide by four as faces do",
        ),
        operator(
            Quantity::ShiftsRightByOne,
            "shifts right by one",
            |o| o.right_shifts_by_1,
            "of the replaced vertex only",
        ),
        operator(
            Quantity::ShiftsLeftByOne,
            "shifts left by one",
            |o| o.left_shifts_by_1,
            "the text says right by two; it is right by one",
        ),
        operator(
            Quantity::MultipliersByThird,
            "multipliers by 1/3",
            |o| o.multipliers_by_third,
            "the edge rule is (F1 + F2 + A + B)/4",
        ),
        operator(
            Quantity::Multipliers,
            "multipliers",
            |o| o.multipliers,
            "in the text four, and none in the list",
        ),
        operator(Quantity::Tables, "tables", |o| o.tables, "1/(4 d^2) alone"),
        operator(Quantity::TableEntries, "entries of a table", |o| o.table_entries, "degree 3 has one too"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_figure_that_differs_says_why() {
        for figure in figures(5, 10) {
            assert!(
                figure.printed == Some(figure.corrected)
                    || figure.printed.is_none()
                    || !figure.note.is_empty(),
                "{}",
                figure.name
            );
        }
        let storage = figures(5, 10).into_iter().find(|f| f.quantity == Quantity::Storage).unwrap();
        assert_eq!((storage.printed, storage.corrected), (Some(410.0), 435.0));
    }

    #[test]
    fn every_quantity_stands_in_the_list_once() {
        let list = figures(5, 10);
        let quantities: BTreeSet<Quantity> = list.iter().map(|f| f.quantity).collect();
        assert_eq!((quantities.len(), list.len()), (Quantity::TableEntries as usize + 1, quantities.len()));
    }
}
