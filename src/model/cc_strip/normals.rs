//! Normals of the vertices of a finest column, by walking around each vertex.
//!
//! ```text
//!   D1 ── A1 ── D0      counterclockwise seen from outside; face i = S, A_i, D_i, A_i+1
//!   │     │     │
//!   A2 ── S ─── A0      faces:  N = sum over the faces of twice their vector area
//!   │     │     │                 = sum of S x A_i + A_i x D_i + D_i x A_i+1 + A_i+1 x S
//!   D2 ── A3 ── D3      limit:  N = t1 x t2
//!
//!   t1 = sum A_d C_i A_i + (C_i + C_i+1) D_i,  C_i = cos(2 pi i/d);  t2 with sines: Halstead, Kass, DeRose 1993
//! ```
//!
//! All points are first rounded half up to the fraction bits of the vectors. From there on face normals are exact,
//! and limit normals of valence 4 too; so two strips that share a vertex agree on these, wherever each begins to
//! walk. The weights of other valences are integers over 2^16, and the tangents are rounded half up: what two
//! strips find differs by the roundings, about 2^-14 radians and half a unit of each tangent. Twice the vector area of a
//! quad is the cross product of its diagonals, and half the sum of the cross products of the edges at its four
//! corners; the thesis (section 4.4) takes the corner at the vertex only, whose product no other vertex shares.

use super::around::Three;
use super::level::LevelColumn;
use super::{Parameters, Point, rounded};
use crate::error::{Error, Result};
use crate::surface::catmull_clark::masks::tangents;
use crate::surface::catmull_clark::strips::records::Outside;

/// Which normals are put out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The sum of the vector areas of the faces around the vertex: the thesis's normals.
    Faces,
    /// The normal of the limit surface.
    Limit,
}

/// The normals that a core puts out.
///
/// A normal is an integer vector in units of 2^-2f square input units. The face sum is twice the area around
/// the vertex; t1 x t2 is 144 times the product of the surface's derivatives by columns and rows at valence 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Normals {
    pub kind: Kind,
    /// f: fraction bits of the points that normals are computed from, beyond those of the input.
    pub extra_fraction: i32,
    /// n: put out unit vectors over 2^n instead.
    pub unit: Option<u32>,
}

impl Normals {
    /// # Errors
    /// Rims, vectors of more bits than the finest level has or whose normals exceed 63 bits, unit vectors of
    /// other than 8 to 16 bits.
    pub fn check(&self, parameters: &Parameters) -> Result<()> {
        let refuse = |what: String, help: &str| Err(Error::usage(what).help(help));
        if parameters.rims {
            return refuse("normals with rims".into(), "complete the boundary by ghosts");
        }
        let width = parameters.width as i32 + self.extra_fraction;
        let finest = parameters.numbers.fraction(parameters.max_levels) as i32;
        if width < 2 || self.extra_fraction > finest || normal_bits(self.kind, width as u32, parameters) > 63
        {
            let what = format!("normals from points of {width} bits");
            return refuse(what, "use 2 to 27 bits, and no more fraction bits than the finest level has");
        }
        if self.unit.is_some_and(|n| !(8..=16).contains(&n)) {
            return refuse(format!("unit normals over 2^{:?}", self.unit), "use 8 to 16 fraction bits");
        }
        Ok(())
    }

    /// The normals of the middle column of three, whose points have `fraction` fraction bits.
    pub fn column(&self, three: &Three, fraction: i32) -> Vec<[i64; 3]> {
        let drop = fraction - self.extra_fraction;
        let (Some(p), Some(n)) = (three.previous, three.next) else { return vec![] };
        let [p, c, n] = [p, three.column, n].map(|column| reduced(column, drop));
        let finished = |r: usize| {
            let normal = self.normal(c.rows[r], &Ring::around(&p, &c, &n, r));
            match self.unit {
                Some(bits) => super::unit::unit(normal, bits),
                None => normal.map(|x| x as i64),
            }
        };
        (0..c.rows.len()).map(finished).collect()
    }

    fn normal(&self, s: Point, ring: &Ring) -> Point {
        let d = ring.neighbours.len();
        if self.kind == Kind::Limit {
            let [t1, t2] = weights(d).map(|weights| ring.tangent(&weights));
            return cross(t1, t2);
        }
        let faces = (0..d).map(|i| {
            let corners = [s, ring.neighbours[i], ring.diagonals[i], ring.neighbours[(i + 1) % d]];
            let sides = (0..4).map(|k| cross(corners[k], corners[(k + 1) % 4]));
            sides.fold([0; 3], add)
        });
        faces.fold([0; 3], add)
    }
}

/// Bits of a component of the largest normal, sign included: |N| <= 2d s^2 and 72 s^2 for points within s.
fn normal_bits(kind: Kind, width: u32, parameters: &Parameters) -> u32 {
    let most = match kind {
        Kind::Faces => 2 * u64::from(parameters.max_valence),
        Kind::Limit => 72,
    };
    2 * width + 1 + most.next_power_of_two().ilog2()
}

fn add(a: Point, b: Point) -> Point {
    std::array::from_fn(|x| a[x] + b[x])
}

fn cross(a: Point, b: Point) -> Point {
    std::array::from_fn(|x| {
        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
        a[y] * b[z] - a[z] * b[y]
    })
}

/// The column with its points over the fraction bits of the vectors.
fn reduced(column: &LevelColumn, drop: i32) -> LevelColumn {
    let mut point = |p: &Point| p.map(|x| rounded(x, drop));
    let rows = column.rows.iter().map(&mut point).collect();
    LevelColumn { rows, outside: column.outside.each_ref().map(|o: &Outside<Point>| o.map(&mut point)) }
}

/// Fraction bits of the weights of tangents.
const WEIGHT_BITS: u32 = 16;

/// The weights of A_i and D_i in both tangents over 2^16: those of the surface, scaled so that the absolute values
/// of a tangent's add up to 12 at most, which those of valence 4 do exactly, and rounded. The weight of A_0 is then what
/// makes the sum zero.
fn weights(valence: usize) -> [Vec<[i128; 2]>; 2] {
    let masks = tangents(valence);
    let length = |mask: &Vec<[f64; 2]>| mask.iter().flatten().map(|w| w.abs()).sum::<f64>();
    let longest = length(&masks[0]).max(length(&masks[1]));
    // A little less than 12, so that rounding stays below it.
    let goal = if valence == 4 { 12.0 } else { 12.0 - (-8f64).exp2() };
    let scale = goal / longest * f64::from(WEIGHT_BITS).exp2();
    masks.map(|mask| {
        let mut mask: Vec<[i128; 2]> = mask.iter().map(|w| w.map(|w| (w * scale).round() as i128)).collect();
        mask[0][0] -= mask.iter().flatten().sum::<i128>();
        mask
    })
}

/// The neighbours A_i of a vertex and the diagonals D_i between A_i and A_i+1, counterclockwise; at an end of the
/// column A_0 is the neighbour within it.
struct Ring {
    neighbours: Vec<Point>,
    diagonals: Vec<Point>,
}

impl Ring {
    fn around(p: &LevelColumn, c: &LevelColumn, n: &LevelColumn, r: usize) -> Ring {
        let end = match r {
            0 => 0,
            _ if r + 1 == c.rows.len() => 1,
            _ => {
                let neighbours = vec![n.rows[r], c.rows[r - 1], p.rows[r], c.rows[r + 1]];
                let diagonals = vec![n.rows[r - 1], p.rows[r - 1], p.rows[r + 1], n.rows[r + 1]];
                return Ring { neighbours, diagonals };
            }
        };
        // From the left to the right neighbour over the outside: clockwise at the top.
        let fan = &c.outside[end].fan;
        let mut neighbours = vec![*p.outer(end)];
        neighbours.extend(fan.iter().step_by(2));
        neighbours.push(*n.outer(end));
        let mut diagonals = vec![p.outside[end].right];
        diagonals.extend(fan.iter().skip(1).step_by(2));
        if c.outside[end].valence > 3 {
            diagonals.push(n.outside[end].left);
        }
        diagonals.insert(0, *p.inner(end));
        diagonals.push(*n.inner(end));
        if end == 0 {
            neighbours.reverse();
            diagonals.reverse();
        }
        neighbours.insert(0, *c.inner(end));
        Ring { neighbours, diagonals }
    }

    /// The weighted sum of the ring, rounded to the unit of its points.
    fn tangent(&self, weights: &[[i128; 2]]) -> Point {
        let entries = weights.iter().zip(self.neighbours.iter().zip(&self.diagonals));
        let sum = entries.fold([0; 3], |sum: Point, (w, (a, x))| {
            std::array::from_fn(|k| sum[k] + w[0] * a[k] + w[1] * x[k])
        });
        sum.map(|x| rounded(x, WEIGHT_BITS as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::catmull_clark::masks::VALENCES;

    #[test]
    fn weights_add_up_to_nothing_and_stay_within_twelve() {
        for d in VALENCES {
            for (mask, exact) in weights(d).iter().zip(tangents(d)) {
                assert_eq!(mask.iter().flatten().sum::<i128>(), 0, "valence {d}");
                let length: i128 = mask.iter().flatten().map(|w| w.abs()).sum();
                assert!(length <= 12 << WEIGHT_BITS, "valence {d}: {length}");
                // All have one factor, so that the direction is that of the masks.
                let scale = mask[1][0].max(mask[2][0].abs()) as f64 / exact[1][0].max(exact[2][0].abs());
                for (w, exact) in mask.iter().flatten().zip(exact.iter().flatten()) {
                    assert!((*w as f64 - exact * scale).abs() < 12.0, "valence {d}: {w} {}", exact * scale);
                }
            }
        }
        let unit = 1 << WEIGHT_BITS;
        let [t1, _] = weights(4);
        assert_eq!(t1, [[4, 1], [0, -1], [-4, -1], [0, 1]].map(|w| w.map(|w: i128| w * unit)));
    }
}
