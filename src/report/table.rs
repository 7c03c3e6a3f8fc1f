//! Text tables: columns as wide as their longest cell, numbers to the right, words to the left.
//!
//! ```
//! use subdiv_rtl::report::table::{Align, Table};
//! let mut table = Table::new(&[("simulator", Align::Left), ("cycles", Align::Right)]);
//! table.row(["builtin", "17290"]);
//! table.row(["icarus", "290"]);
//! assert_eq!(
//!     table.plain(),
//!     "simulator  cycles\n\
//!      builtin     17290\n\
//!      icarus        290\n"
//! );
//! ```
//!
//! [`Table::plain`] is bare text. [`Table`] as text (`to_string`) carries ANSI styles; print it through a stream
//! that takes them away where nobody sees them (`anstream`: no terminal, or `NO_COLOR` is set).

use anstyle::{AnsiColor, Style};
use std::fmt;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Right,
}

/// How a cell stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    #[default]
    Normal,
    /// What was hoped for.
    Good,
    /// What must be looked at.
    Bad,
    /// What does not apply.
    Faint,
}

impl Tone {
    fn style(self) -> Style {
        match self {
            Tone::Normal => Style::new(),
            Tone::Good => AnsiColor::Green.on_default(),
            Tone::Bad => AnsiColor::Red.on_default().bold(),
            Tone::Faint => Style::new().dimmed(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct Cell {
    text: String,
    tone: Tone,
}

impl Cell {
    pub fn new(text: impl Into<String>, tone: Tone) -> Self {
        Cell { text: text.into(), tone }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Cell::new(text, Tone::Normal)
    }
}

/// A heading over each column, and rows of one cell for each column. A table without headings lists facts.
#[derive(Clone, Debug)]
pub struct Table {
    headings: Vec<String>,
    aligns: Vec<Align>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    pub fn new(columns: &[(&str, Align)]) -> Self {
        Table {
            headings: columns.iter().map(|(heading, _)| heading.to_string()).collect(),
            aligns: columns.iter().map(|(_, align)| *align).collect(),
            rows: Vec::new(),
        }
    }

    /// Cells beyond the last column are not shown; missing ones are empty.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) -> &mut Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    pub fn plain(&self) -> String {
        self.lines(|text, _| text.to_string())
    }

    fn lines(&self, paint: impl Fn(&str, Style) -> String) -> String {
        let widths: Vec<usize> = (0..self.aligns.len()).map(|column| self.width(column)).collect();
        let mut text = String::new();
        let mut line = |cells: &[(&str, Style)]| {
            // Spaces are put in front of the next cell, so that no line ends with them.
            let mut gap = 0;
            for (column, width) in widths.iter().enumerate() {
                let (cell, style) = cells.get(column).copied().unwrap_or_default();
                let spaces = width - cell.chars().count();
                let (before, after) = match self.aligns[column] {
                    Align::Left => (0, spaces),
                    Align::Right => (spaces, 0),
                };
                if !cell.is_empty() {
                    text.push_str(&" ".repeat(gap + before));
                    text.push_str(&paint(cell, style));
                    gap = 0;
                }
                gap += after + 2 + if cell.is_empty() { before } else { 0 };
            }
            text.push('\n');
        };
        if self.headings.iter().any(|heading| !heading.is_empty()) {
            let bold = Style::new().bold();
            line(&self.headings.iter().map(|heading| (heading.as_str(), bold)).collect::<Vec<_>>());
        }
        for row in &self.rows {
            line(&row.iter().map(|cell| (cell.text.as_str(), cell.tone.style())).collect::<Vec<_>>());
        }
        text
    }

    fn width(&self, column: usize) -> usize {
        let cells = self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.text.chars().count());
        cells.max().unwrap_or(0).max(self.headings[column].chars().count())
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.lines(|text, style| format!("{style}{text}{style:#}")))
    }
}

/// A whole number with a thin mark between thousands: `1 234 567`.
pub fn thousands(number: impl Into<u128>) -> String {
    let digits = number.into().to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A time with three digits and its unit.
pub fn seconds(time: f64) -> String {
    let (value, unit) = match time {
        t if t >= 100.0 => return format!("{t:.0} s"),
        t if t >= 1.0 => (t, "s"),
        t if t >= 1e-3 => (t * 1e3, "ms"),
        t => (t * 1e6, "us"),
    };
    let decimals = if value >= 100.0 { 0 } else { usize::from(value < 10.0) + 1 };
    format!("{value:.decimals$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Table {
        let mut table = Table::new(&[("name", Align::Left), ("n", Align::Right), ("note", Align::Left)]);
        table.row([Cell::from("a"), Cell::from("10"), Cell::new("fine", Tone::Good)]);
        table.row(["longer", "", "x"]);
        table.row(["b"]);
        table
    }

    #[test]
    fn columns_stand_under_each_other_and_no_line_ends_with_spaces() {
        assert_eq!(example().plain(), "name     n  note\na       10  fine\nlonger      x\nb\n");
    }

    #[test]
    fn styles_do_not_move_the_columns() {
        let styled = example().to_string();
        assert!(styled.contains("\u{1b}[32mfine"));
        assert_eq!(anstream::adapter::strip_str(&styled).to_string(), example().plain());
    }

    #[test]
    fn numbers_are_grouped_and_times_have_three_digits() {
        assert_eq!(thousands(1234567_u32), "1 234 567");
        assert_eq!(thousands(12_u32), "12");
        assert_eq!(
            [seconds(0.00012), seconds(0.0345), seconds(1.5), seconds(240.2)],
            ["120 us", "34.5 ms", "1.50 s", "240 s"]
        );
    }
}
