//! Reads Verilator's coverage: which lines ran and which bits toggled, and above all which did not.
//!
//! A line of `coverage.dat`, with `^A` and `^B` for the characters 1 and 2 that part keys from values:
//!
//! ```text
//! C '^Af^Bcore.v^Al^B12^An^B7^At^Btoggle^Apage^Bv_toggle/core^Oo^Bsum[3]^Ah^BTOP.core' 41
//! ```

use crate::{Error, Kind, Result};
use std::collections::BTreeMap;
use std::fmt;

/// A point that a run can hit.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CoveragePoint {
    pub file: String,
    pub line: u32,
    pub column: u32,
    /// `line`, `branch` or `toggle`.
    pub kind: String,
    /// The bit that toggles, or the kind of block.
    pub name: String,
    /// The instance within the hierarchy.
    pub hierarchy: String,
}

/// How often each point was hit, over one run or several.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage(BTreeMap<CoveragePoint, u64>);

impl Coverage {
    /// Reads the text of a `coverage.dat`.
    pub(super) fn read(text: &str) -> Result<Coverage> {
        let mut coverage = Coverage::default();
        for (number, line) in text.lines().enumerate().filter(|(_, line)| line.starts_with("C ")) {
            let (point, count) = read_line(line).ok_or_else(|| {
                Error::new(Kind::ToolFailed, "a line of Verilator's coverage cannot be read")
                    .at(format!("coverage.dat:{}", number + 1))
            })?;
            *coverage.0.entry(point).or_default() += count;
        }
        Ok(coverage)
    }

    /// Adds the hits of another run of the same core.
    pub fn merge(&mut self, other: &Coverage) {
        for (point, count) in &other.0 {
            *self.0.entry(point.clone()).or_default() += count;
        }
    }

    /// All points with their hits, in the order of the files and lines.
    pub fn points(&self) -> impl Iterator<Item = (&CoveragePoint, u64)> {
        self.0.iter().map(|(point, &count)| (point, count))
    }

    /// The points that no run has hit.
    pub fn missed(&self) -> impl Iterator<Item = &CoveragePoint> {
        self.points().filter(|&(_, count)| count == 0).map(|(point, _)| point)
    }
}

fn read_line(line: &str) -> Option<(CoveragePoint, u64)> {
    let (keys, count) = line.strip_prefix("C '")?.rsplit_once("' ")?;
    let pairs: BTreeMap<_, _> = keys.split('\u{1}').filter_map(|pair| pair.split_once('\u{2}')).collect();
    let text = |key: &str| pairs.get(key).map(|value| value.to_string());
    // "v_toggle/core": the kind is in the page where the short key is missing.
    let kind = text("t").or_else(|| Some(text("page")?.strip_prefix("v_")?.split('/').next()?.into()));
    let point = CoveragePoint {
        file: text("f")?,
        line: text("l")?.parse().ok()?,
        column: text("n").and_then(|column| column.parse().ok()).unwrap_or(0),
        kind: kind?,
        name: text("o").unwrap_or_default(),
        hierarchy: text("h").unwrap_or_default(),
    };
    Some((point, count.trim().parse().ok()?))
}

impl fmt::Display for CoveragePoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CoveragePoint { file, line, column, kind, name, hierarchy } = self;
        write!(f, "{file}:{line}:{column}: {kind} {name} ({hierarchy})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &str = "# SystemC::Coverage-3\n\
        C '\u{1}f\u{2}core.v\u{1}l\u{2}12\u{1}n\u{2}7\u{1}t\u{2}toggle\u{1}page\u{2}v_toggle/core\u{1}o\u{2}sum[3]\u{1}h\u{2}TOP.core' 0\n\
        C '\u{1}f\u{2}core.v\u{1}l\u{2}9\u{1}n\u{2}5\u{1}page\u{2}v_line/core\u{1}o\u{2}block\u{1}h\u{2}TOP.core' 41\n";

    #[test]
    fn the_points_never_hit_are_listed() {
        let coverage = Coverage::read(DATA).unwrap();
        let missed: Vec<_> = coverage.missed().map(ToString::to_string).collect();
        assert_eq!(missed, ["core.v:12:7: toggle sum[3] (TOP.core)"]);
        assert_eq!(coverage.points().next().unwrap().0.kind, "line");
    }

    #[test]
    fn another_run_may_hit_what_this_one_missed() {
        let mut coverage = Coverage::read(DATA).unwrap();
        coverage.merge(&Coverage::read(&DATA.replace("' 0", "' 3")).unwrap());
        assert_eq!(coverage.missed().count(), 0);
        assert_eq!(coverage.points().map(|(_, count)| count).collect::<Vec<_>>(), [82, 3]);
    }

    #[test]
    fn a_broken_line_is_an_error_with_its_number() {
        let error = Coverage::read("# x\nC '\u{1}f\u{2}core.v' many\n").unwrap_err();
        assert_eq!(error.place.unwrap(), "coverage.dat:2");
    }
}
