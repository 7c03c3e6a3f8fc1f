//! Plots as SVG, from plain numbers: lines and points over two axes, with a legend.
//!
//! ```
//! use subdiv_rtl::report::plot::{Axis, Mark, Plot, Scale, Series};
//! let series = Series::new("measured", Mark::Line, [(1.0, 0.5), (2.0, 0.25)]);
//! let plot = Plot {
//!     title: "Error".into(),
//!     x: Axis::new("level", Scale::Linear),
//!     y: Axis::new("error (lsb)", Scale::Logarithmic),
//!     series: vec![series],
//! };
//! assert!(plot.svg().unwrap().starts_with("<svg"));
//! ```

mod axis;
mod pictures;

pub use axis::Scale;
pub use pictures::row_of_pictures;

use askama::Template;

use crate::error::{Error, Kind, Result};

/// An axis of a plot.
#[derive(Clone, Debug)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
}

impl Axis {
    pub fn new(label: impl Into<String>, scale: Scale) -> Self {
        Axis { label: label.into(), scale }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line with a dot at each point.
    Line,
    /// The same, dashed, with rings.
    Dashed,
    /// Stairs that fall to the right: what can be had for so much.
    Stairs,
    /// Faint dots.
    Dots,
    /// Rings.
    Rings,
}

/// A point with what is said when somebody points at it.
#[derive(Clone, Debug, Default)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub note: String,
    /// For scripts: the attribute `data-key`.
    pub key: String,
}

impl From<(f64, f64)> for Point {
    fn from((x, y): (f64, f64)) -> Self {
        Point { x, y, ..Point::default() }
    }
}

/// Points that belong together.
#[derive(Clone, Debug)]
pub struct Series {
    pub name: String,
    pub mark: Mark,
    /// Which of the colours; nothing: grey.
    pub colour: Option<usize>,
    pub points: Vec<Point>,
}

impl Series {
    pub fn new<P: Into<Point>>(
        name: impl Into<String>,
        mark: Mark,
        points: impl IntoIterator<Item = P>,
    ) -> Self {
        let points = points.into_iter().map(Into::into).collect();
        Series { name: name.into(), mark, colour: Some(0), points }
    }

    pub fn colour(self, colour: usize) -> Self {
        Series { colour: Some(colour), ..self }
    }

    pub fn grey(self) -> Self {
        Series { colour: None, ..self }
    }
}

#[derive(Clone, Debug)]
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
}

/// Colours that differ for colour-blind eyes too (Okabe and Ito).
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b3fa0"];
const GREY: &str = "#777777";

const WIDTH: f64 = 820.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 796.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 416.0;
/// Space for one line of the legend, below the plot.
const ROW: f64 = 22.0;

#[derive(Template)]
#[template(path = "plot.svg")]
struct Page<'a> {
    width: f64,
    height: f64,
    title: &'a str,
    x_label: &'a str,
    y_label: &'a str,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    below: f64,
    before: f64,
    middle: f64,
    centre: f64,
    lowest: f64,
    across: Vec<Tick>,
    up: Vec<Tick>,
    series: Vec<Drawn>,
    legend: Vec<Entry<'a>>,
}

struct Tick {
    at: String,
    base: String,
    label: String,
}

/// A series in places on the paper.
struct Drawn {
    colour: &'static str,
    path: String,
    dashed: bool,
    faint: bool,
    hollow: bool,
    radius: f64,
    marks: Vec<Spot>,
}

struct Spot {
    x: String,
    y: String,
    note: String,
    key: String,
}

struct Entry<'a> {
    name: &'a str,
    colour: &'static str,
    x: f64,
    y: f64,
    dot: f64,
    text: f64,
    base: f64,
    radius: f64,
    line: bool,
    dashed: bool,
    faint: bool,
    hollow: bool,
}

/// A place with two decimals: the same text everywhere.
fn place(x: f64) -> String {
    format!("{x:.2}")
}

impl Plot {
    /// The plot as a file.
    ///
    /// # Errors
    /// None that a user can cause: the template cannot be printed.
    pub fn svg(&self) -> Result<String> {
        let numbers = |of: fn(&Point) -> f64| self.series.iter().flat_map(|s| &s.points).map(of);
        let x = axis::Axis::around(numbers(|p| p.x), self.x.scale, [LEFT, RIGHT]);
        let y = axis::Axis::around(numbers(|p| p.y), self.y.scale, [BOTTOM, TOP]);
        let tick = |axis: &axis::Axis, number: f64| {
            let at = axis.place(number).unwrap_or_default();
            Tick { at: place(at), base: place(at + 4.0), label: axis::label(number) }
        };
        let legend = self.legend();
        let lowest = BOTTOM + 40.0;
        let rows = legend.iter().map(|entry| entry.y).fold(lowest, f64::max);
        let page = Page {
            width: WIDTH,
            height: rows + 20.0,
            title: &self.title,
            x_label: &self.x.label,
            y_label: &self.y.label,
            left: LEFT,
            right: RIGHT,
            top: TOP,
            bottom: BOTTOM,
            below: BOTTOM + 18.0,
            before: LEFT - 8.0,
            middle: (LEFT + RIGHT) / 2.0,
            centre: (TOP + BOTTOM) / 2.0,
            lowest,
            across: x.ticks().into_iter().map(|number| tick(&x, number)).collect(),
            up: y.ticks().into_iter().map(|number| tick(&y, number)).collect(),
            series: self.series.iter().map(|series| draw(series, &x, &y)).collect(),
            legend,
        };
        let text = page
            .render()
            .map_err(|e| Error::new(Kind::ToolFailed, format!("the plot cannot be printed: {e}")))?;
        Ok(text + "\n")
    }

    /// Names from left to right, in as many rows as they need.
    fn legend(&self) -> Vec<Entry<'_>> {
        let (mut x, mut y) = (LEFT, BOTTOM + 66.0);
        let mut entries = vec![];
        for series in self.series.iter().filter(|series| !series.name.is_empty()) {
            let room = 46.0 + 7.2 * series.name.chars().count() as f64;
            if x > LEFT && x + room > RIGHT + 10.0 {
                (x, y) = (LEFT, y + ROW);
            }
            let (line, dashed, faint, hollow, radius) = style(series.mark);
            let colour = colour(series);
            let (dot, text, base) = (x + 11.0, x + 29.0, y + 4.5);
            let name = series.name.as_str();
            entries.push(Entry { name, colour, x, y, dot, text, base, radius, line, dashed, faint, hollow });
            x += room;
        }
        entries
    }
}

fn colour(series: &Series) -> &'static str {
    series.colour.map_or(GREY, |colour| COLOURS[colour % COLOURS.len()])
}

/// Line, dashed, faint, hollow, radius of the dots.
fn style(mark: Mark) -> (bool, bool, bool, bool, f64) {
    match mark {
        Mark::Line => (true, false, false, false, 3.0),
        Mark::Dashed => (true, true, false, true, 3.0),
        Mark::Stairs => (true, false, false, false, 4.0),
        Mark::Dots => (false, false, true, false, 3.0),
        Mark::Rings => (false, false, false, true, 3.0),
    }
}

fn draw(series: &Series, x: &axis::Axis, y: &axis::Axis) -> Drawn {
    let (line, dashed, faint, hollow, radius) = style(series.mark);
    let spots: Vec<(f64, f64, &Point)> =
        series.points.iter().filter_map(|p| Some((x.place(p.x)?, y.place(p.y)?, p))).collect();
    let mut path = String::new();
    for (index, (x, y, _)) in spots.iter().enumerate().filter(|_| line) {
        let (x, y) = (place(*x), place(*y));
        path += &match (index, series.mark) {
            (0, _) => format!("M{x} {y}"),
            (_, Mark::Stairs) => format!("H{x}V{y}"),
            _ => format!("L{x} {y}"),
        };
    }
    let spot = |(x, y, point): (f64, f64, &Point)| Spot {
        x: place(x),
        y: place(y),
        note: point.note.clone(),
        key: point.key.clone(),
    };
    let marks = spots.into_iter().map(spot).collect();
    Drawn { colour: colour(series), path, dashed, faint, hollow, radius, marks }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(name: &str) -> Plot {
        let points = [(1.0, 100.0), (2.0, 10.0), (3.0, 0.0)];
        Plot {
            title: "a < b".into(),
            x: Axis::new("level", Scale::Linear),
            y: Axis::new("error", Scale::Logarithmic),
            series: vec![Series::new(name, Mark::Line, points).colour(1)],
        }
    }

    #[test]
    fn what_does_not_show_is_left_out_and_text_is_escaped() {
        let svg = plot("one & two").svg().unwrap();
        assert_eq!(svg.matches("<circle").count(), 2 + 1); // two points, and one in the legend
        assert!(svg.contains("a &#60; b") && svg.contains("one &#38; two"), "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn an_empty_plot_is_a_plot() {
        let empty = Plot { series: vec![], ..plot("") };
        assert!(empty.svg().unwrap().ends_with("</svg>\n"));
    }
}
