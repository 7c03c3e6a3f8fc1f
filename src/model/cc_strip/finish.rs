//! What leaves the finest level: positions, refined or projected to the limit surface, and their normals.
//!
//! ```text
//!   refined   S                                                        rounded half up, once
//!   limit     S + lambda_d (4 sum A + sum D - 5d S)                     lambda_d = 1/(d (d+5)), from the table
//!   rim       V + (A + B - 2V)/6
//! ```
//!
//! The sums are exact and over 2^b, b the bits of the table. Source: Halstead, Kass, DeRose 1993.

use super::around::{Around, Three, plus};
use super::{CcStrip, OutputColumn, Parameters, Point, rounded};

impl Parameters {
    /// Whether what is put out for a column depends on its neighbours.
    pub fn looks_sideways(&self) -> bool {
        self.limit || self.normals.is_some()
    }
}

impl CcStrip {
    /// The output of the middle column of three at level `levels`, the finest.
    ///
    /// The neighbours are needed where [`Parameters::looks_sideways`]; a limit takes a missing one for a rim.
    pub fn finish(&self, levels: u32, index: usize, three: Three) -> OutputColumn {
        let parameters = &self.parameters;
        let shift = parameters.numbers.fraction(levels) as i32 - parameters.extra_fraction;
        let narrow = |p: Point, shift: i32| p.map(|x| rounded(x, shift) as i64);
        let rows = 0..three.column.rows.len();
        let position = |r: usize| {
            let s = three.column.rows[r];
            match parameters.limit {
                true => narrow(self.limit(s, three.around(r)), shift + self.table.bits() as i32),
                false => narrow(s, shift),
            }
        };
        let normals = parameters
            .normals
            .map(|normals| normals.column(&three, parameters.numbers.fraction(levels) as i32))
            .unwrap_or_default();
        OutputColumn { index, vertices: rows.map(position).collect(), normals }
    }

    /// 2^b times the limit position: S + lambda_d (4 sum A + sum D - 5d S), or V + (A + B - 2V)/6 on a rim.
    fn limit(&self, s: Point, around: Around) -> Point {
        let (spread, weight) = match around {
            Around::Rim { neighbours } => (plus(neighbours, -2, s), self.table.sixth()),
            Around::Ring { valence, neighbours, diagonals } => {
                (plus(plus(diagonals, 4, neighbours), -5 * valence as i128, s), self.table.lambda(valence))
            }
        };
        std::array::from_fn(|x| (s[x] << self.table.bits()) + spread[x] * i128::from(weight))
    }
}
