//! One self-contained HTML page: plots, and a table that can be sorted and searched; nothing is loaded from elsewhere.
//!
//! A click on a row or on a point of a plot shows the command that belongs to it.

use askama::Template;

use crate::error::{Error, Kind, Result};

/// A page as its template takes it.
#[derive(Clone, Debug, Default, Template)]
#[template(path = "points.html")]
pub struct Page {
    pub title: String,
    pub lead: String,
    /// What is recommended, and its command; empty: nothing.
    pub advice: String,
    pub advised_command: String,
    /// Plots as SVG.
    pub plots: Vec<String>,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    pub footer: String,
}

#[derive(Clone, Debug)]
pub struct Column {
    pub name: String,
    /// Said when somebody points at it.
    pub note: String,
    /// Words stand on the left, numbers on the right.
    pub left: bool,
}

#[derive(Clone, Debug)]
pub struct Row {
    /// The same as that of the points of the plots.
    pub key: String,
    pub command: String,
    /// Stands out.
    pub front: bool,
    pub cells: Vec<Cell>,
}

#[derive(Clone, Debug)]
pub struct Cell {
    pub text: String,
    /// The number to sort by; empty: by the text.
    pub order: String,
    pub left: bool,
}

impl Cell {
    pub fn words(text: impl Into<String>) -> Self {
        Cell { text: text.into(), order: String::new(), left: true }
    }

    pub fn number(text: impl Into<String>, order: f64) -> Self {
        Cell { text: text.into(), order: order.to_string(), left: false }
    }
}

impl Page {
    /// The page as a file.
    ///
    /// # Errors
    /// None that a user can cause: the template cannot be printed.
    pub fn html(&self) -> Result<String> {
        let text = self
            .render()
            .map_err(|e| Error::new(Kind::ToolFailed, format!("the page cannot be printed: {e}")))?;
        Ok(format!("{}\n", text.trim_end()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_nothing_comes_from_elsewhere() {
        let page = Page {
            title: "<b>".into(),
            plots: vec!["<svg></svg>\n".into()],
            columns: vec![Column { name: "n".into(), note: "".into(), left: false }],
            rows: vec![Row {
                key: "k\"".into(),
                command: "a & b".into(),
                front: true,
                cells: vec![Cell::number("1", 1.0)],
            }],
            ..Page::default()
        };
        let html = page.html().unwrap();
        assert!(html.contains("&#60;b&#62;") && html.contains("<svg></svg>") && html.contains("a &#38; b"));
        assert!(!html.contains("k\"\"") && !html.contains("http"));
    }
}
