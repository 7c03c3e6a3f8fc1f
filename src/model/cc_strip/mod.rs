//! The reference of the core `cc-strip`: the columns of a quadstrip in, the columns of its refinement out.
//!
//! ```text
//!   level 0   -1   0   1   2  ...   M   M+1              guards -1 and M+1, two strip vertices a column
//!   level 1     -1 0 1 2 3 ...     2M  2M+1              1 + 2^l strip vertices, one outside record at each end
//!   ...
//!   level L         0 1 ...       2^L M                  put out: rounded, or projected to the limit
//!
//!   face column 2c+1   from columns c, c+1       E F E ... F E
//!   vertex column 2c   from columns c-1, c, c+1  V E V ... E V
//! ```
//!
//! [`level`] makes one column from its sources, [`window`] runs all levels in the order of the hardware,
//! [`schedule`] counts the clocks. Plain integers throughout; every new vertex is one sum, rounded once.
//! Source: Hall, chapters 4 and 5, with the outside records of [`records`].
//!
//! [`records`]: crate::surface::catmull_clark::strips::records

pub mod around;
pub mod level;
pub mod render;
pub mod schedule;
pub mod window;

use crate::error::{Error, Result};
use crate::fixed::Rounding;
use crate::surface::catmull_clark::masks::VALENCES;
use crate::surface::catmull_clark::numbers::{MAX_LEVELS, Numbers};
use crate::surface::catmull_clark::strips::records::{Column, Guard, Outside, StripRecords};
use crate::surface::catmull_clark::table::Table;
use level::LevelColumn;
use window::Windows;

/// A position with as many fraction bits as its level has.
pub type Point = [i128; 3];

/// The numbers that a core is generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// W: bits of a coordinate of the records, ghosts included, 2..=32.
    pub width: u32,
    /// The most levels L, 1..=7.
    pub max_levels: u32,
    /// The largest valence of a strip vertex, 4..=16.
    pub max_valence: u32,
    pub numbers: Numbers,
    /// How a new vertex loses the bits that its level does not keep. What is put out is rounded half up.
    pub rounding: Rounding,
    /// b: fraction bits of the table.
    pub table_bits: u32,
    /// f: fraction bits of the output beyond those of the input; may be negative.
    pub extra_fraction: i32,
    /// Put out limit positions instead of refined control points.
    pub limit: bool,
    /// Take records with gaps, and strips without guards.
    pub rims: bool,
}

impl Parameters {
    /// Exact numbers, the default table, refined positions in the input's format, no rims.
    pub fn exact(width: u32) -> Self {
        Parameters {
            width,
            max_levels: MAX_LEVELS,
            max_valence: *VALENCES.end() as u32,
            numbers: Numbers::Exact,
            rounding: Rounding::HalfUp,
            table_bits: width + 13,
            extra_fraction: 0,
            limit: false,
            rims: false,
        }
    }
}

/// The reference of one core.
#[derive(Clone, Debug)]
pub struct CcStrip {
    parameters: Parameters,
    table: Table,
}

/// One column of the output: strip vertices from top to bottom in output units.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputColumn {
    /// 0..=2^L M.
    pub index: usize,
    /// 1 + 2^L of them.
    pub vertices: Vec<[i64; 3]>,
}

impl CcStrip {
    /// # Errors
    /// Numbers outside the ranges that [`Parameters`] states, more than 42 guard bits, outputs of W + f bits
    /// outside 2..=63, a table that [`Table::new`] refuses.
    pub fn new(parameters: Parameters) -> Result<Self> {
        let Parameters { width, max_levels, max_valence, numbers, extra_fraction, .. } = parameters;
        let refuse = |what: String, help: &str| Err(Error::usage(what).help(help));
        if !(2..=32).contains(&width) {
            return refuse(format!("coordinates of {width} bits"), "use 2 to 32 bits, for example Q12.12");
        }
        if !(1..=MAX_LEVELS).contains(&max_levels) {
            return refuse(format!("{max_levels} levels"), "a strip is subdivided 1 to 7 times");
        }
        if !(4..=*VALENCES.end() as u32).contains(&max_valence) {
            return refuse(format!("a maximum valence of {max_valence}"), "use 4 to 16");
        }
        if numbers.fraction(max_levels) > Numbers::MAX_GUARD {
            return refuse(numbers.to_string(), "use 0 to 42 guard bits, or the exact format");
        }
        if !(2..=63).contains(&(width as i32 + extra_fraction)) {
            let what = format!("{extra_fraction} extra fraction bits on {width} bits");
            return refuse(what, "the output has 2 to 63 bits in all");
        }
        Ok(CcStrip { parameters, table: Table::new(parameters.table_bits)? })
    }

    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Bits of a vertex of level `level`: W and its fraction bits. The rules are convex, so that the integer
    /// part never grows.
    pub fn vertex_bits(&self, level: u32) -> u32 {
        self.parameters.width + self.parameters.numbers.fraction(level)
    }

    /// The output columns of a strip that is subdivided `levels` times, in order.
    ///
    /// # Errors
    /// As [`CcStrip::for_each_column`].
    pub fn columns(&self, levels: u32, strip: &StripRecords<[i64; 3]>) -> Result<Vec<OutputColumn>> {
        let mut columns = Vec::new();
        self.for_each_column(levels, strip, |_, _, _| {}, |column| columns.push(column))?;
        Ok(columns)
    }

    /// All columns of all levels: `[level][index + 1]`, indices -1 to 2^level M + 1; none for a guard that a
    /// rim has not.
    ///
    /// # Errors
    /// As [`CcStrip::for_each_column`].
    pub fn levels(
        &self,
        levels: u32,
        strip: &StripRecords<[i64; 3]>,
    ) -> Result<Vec<Vec<Option<LevelColumn>>>> {
        let mut all = vec![Vec::new(); levels as usize + 1];
        self.for_each_column(
            levels,
            strip,
            |level, _, column| all[level as usize].push(column.cloned()),
            |_| {},
        )?;
        Ok(all)
    }

    /// Runs a strip in the order of the hardware: when a column arrives at a level, the vertex column and the
    /// face column that it completes are made, each followed by all that it completes itself.
    ///
    /// `made(level, index, column)` sees every column of every level in this order, the input included;
    /// `put` every column of the output.
    ///
    /// # Errors
    /// More levels than the core has, a record that it cannot take: a coordinate beyond W bits, a valence
    /// below 3 or above the maximum, a fan of another length, a gap or a missing guard without rims.
    pub fn for_each_column(
        &self,
        levels: u32,
        strip: &StripRecords<[i64; 3]>,
        made: impl FnMut(u32, i64, Option<&LevelColumn>),
        put: impl FnMut(OutputColumn),
    ) -> Result<()> {
        if !(1..=self.parameters.max_levels).contains(&levels) {
            return Err(Error::usage(format!("a strip at level {levels}"))
                .help(format!("this core was made for 1 to {} levels", self.parameters.max_levels)));
        }
        self.check(strip)?;
        let mut windows = Windows::new(self, levels, strip.len(), made, put);
        let wide = |p: &[i64; 3]| self.scaled(*p);
        let [left, right] = [0, 1].map(|end| {
            let guard = strip.guards[end].as_ref()?;
            Some(LevelColumn::guard(
                &guard.vertices.map(|p| wide(&p)),
                &guard.outside.map(|p| wide(&p)),
                end == 0,
            ))
        });
        windows.arrive(0, -1, left);
        for (c, column) in strip.columns.iter().enumerate() {
            let rows = column.vertices.iter().map(wide).collect();
            let outside = column.outside.each_ref().map(|o| o.map(&mut |p| wide(p)));
            windows.arrive(0, c as i64, Some(LevelColumn { rows, outside }));
        }
        windows.arrive(0, strip.columns.len() as i64, right);
        Ok(())
    }

    /// A coordinate of the input in the format of level 0.
    fn scaled(&self, p: [i64; 3]) -> Point {
        p.map(|x| i128::from(x) << self.parameters.numbers.fraction(0))
    }

    fn check(&self, strip: &StripRecords<[i64; 3]>) -> Result<()> {
        let Parameters { width, max_valence, rims, .. } = self.parameters;
        let refuse = |what: String, help: String| Err(Error::input(what).help(help));
        if strip.is_empty() {
            return refuse("a strip without quads".into(), "a strip has two columns at least".into());
        }
        if !rims && strip.has_rims() {
            return refuse(
                "a strip with a rim, for a core without".into(),
                "complete the boundary by ghosts, or generate the core with rims".into(),
            );
        }
        for (c, column) in strip.columns.iter().enumerate() {
            for Outside { valence: d, fan, gap, .. } in &column.outside {
                let open = [
                    c == 0 && strip.guards[0].is_none() && *gap != Some(1),
                    c == strip.len() && strip.guards[1].is_none() && gap.map(|g| g + 2) != Some(*d),
                ];
                if open.contains(&true) {
                    return refuse(
                        format!("column {c} has neither a guard nor a gap beside it"),
                        "a strip ends at a guard or at a rim".into(),
                    );
                }
                if !(3..=max_valence).contains(d) {
                    return refuse(
                        format!("column {c} has a vertex of valence {d}"),
                        format!("valences 3 to {max_valence} are possible: raise --max-valence (up to 16)"),
                    );
                }
                if fan.len() != (2 * *d as usize).saturating_sub(7) || gap.is_some_and(|g| g < 1 || g > d - 2)
                {
                    return refuse(
                        format!("column {c} has {} fan entries at valence {d}", fan.len()),
                        "a fan has 2d - 7 entries, none for valence 3".into(),
                    );
                }
            }
        }
        let least = -(1i64 << (width - 1));
        let fits = |x: &i64| (least..-least).contains(x);
        let in_column = |c: &Column<[i64; 3]>| {
            let records = c.outside.iter().flat_map(|o| o.fan.iter().chain([&o.left, &o.right]));
            c.vertices.iter().chain(records).flatten().all(fits)
        };
        let in_guard = |g: &Guard<[i64; 3]>| g.vertices.iter().chain(&g.outside).flatten().all(fits);
        if !strip.columns.iter().all(in_column) || !strip.guards.iter().flatten().all(in_guard) {
            return refuse(
                format!("a coordinate that does not fit {width} bits"),
                "a ghost can lie outside of the mesh: use more integer bits".into(),
            );
        }
        Ok(())
    }
}

/// `x / 2^shift`, rounded; a negative shift multiplies.
pub(super) fn rounded(x: i128, shift: i32, mode: Rounding) -> i128 {
    if shift <= 0 {
        return x << -shift;
    }
    let (below, rest) = (x >> shift, x & ((1 << shift) - 1));
    let half = 1 << (shift - 1);
    below
        + i128::from(match mode {
            Rounding::HalfUp | Rounding::Exact => rest >= half,
            Rounding::HalfEven => rest > half || (rest == half && below & 1 == 1),
            Rounding::Floor => false,
            Rounding::Truncate => x < 0 && rest != 0,
        })
}
