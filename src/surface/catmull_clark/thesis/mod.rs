//! The formulas of Hall's thesis, as printed and as they are.
//!
//! ```text
//!   window            (6.2)  sum over j = 0..l of 3 (3 + 2^j)  =  9l + 6 + 3 * 2^(l+1)         printed: ... - 3
//!   fans              (6.3)  (6 + 2l)(d - 4) pairs of a neighbour and a diagonal               printed as vertices
//!   clocks a column   6.3    2^(l+1) - 2 with one unit, 2^l with one a level, 2^(l-1) doubled
//!   adders            6.4    5 * 2^(l-1) + 4d - 12 of four inputs                             printed: 2^(l+2) + 4d - 10
//! ```
//!
//! `levels` is l, the finest level; `valence` is d, the largest. Source: Hall, sections 2.3 and 6.1 to 6.4.

mod figures;

pub use figures::{Figure, Quantity, figures};

/// (6.1) Vertices of a column of level j, both outside rows included.
pub fn column_vertices(level: u32) -> u64 {
    3 + (1 << level)
}

/// (6.2) Three columns of each level 0..=l.
pub fn window_vertices(levels: u32) -> u64 {
    (0..=levels).map(|level| 3 * column_vertices(level)).sum()
}

/// (6.2) as printed: 9l + 3 * 2^(l+1) - 3.
pub fn window_vertices_printed(levels: u32) -> u64 {
    9 * u64::from(levels) + 3 * (2 << levels) - 3
}

/// (6.3) as printed: (6 + 2l) fans of d - 4 entries, an entry counted as one vertex.
pub fn fan_entries(levels: u32, valence: u32) -> u64 {
    (6 + 2 * u64::from(levels)) * u64::from(valence - 4)
}

/// (6.3) with two vertices an entry, an edge neighbour and a diagonal.
pub fn fan_vertices(levels: u32, valence: u32) -> u64 {
    2 * fan_entries(levels, valence)
}

/// (6.4) The thesis's layout, counted right.
pub fn storage_vertices(levels: u32, valence: u32) -> u64 {
    window_vertices(levels) + fan_vertices(levels, valence)
}

/// The same with the 4 x 4 array at level 0 that the thesis's look-ahead for degree 3 needs.
pub fn storage_with_look_ahead(levels: u32, valence: u32) -> u64 {
    storage_vertices(levels, valence) - 3 * column_vertices(0) + 16
}

/// A layout that keeps what is needed at once: three columns of the levels before the finest, one column of strip
/// vertices of the finest, two fans a side at level 0 and one at each level between.
pub fn lean_storage_vertices(levels: u32, valence: u32) -> u64 {
    let windows: u64 = (0..levels).map(|level| 3 * column_vertices(level)).sum();
    let fans = 2 * (2 + u64::from(levels - 1)) * 2 * u64::from(valence - 4);
    windows + 1 + (1 << levels) + fans
}

/// What the lean layout needs on top, at most, to keep uR beside uL: one vertex a stored column and side.
pub fn lean_storage_extra(levels: u32) -> u64 {
    2 * 3 * u64::from(levels)
}

/// Values that evaluation in eigenspace stores (section 2.3): for each valence up to N the inverse of the
/// eigenvectors, the eigenvalues, and `subpatches` bases of 16 coefficients, over k = 2d + 8 vertices.
pub fn analytic_storage(valence: u32, subpatches: u64) -> u64 {
    (3..=u64::from(valence)).map(|d| 2 * d + 8).map(|k| k * k + k + 16 * subpatches * k).sum()
}

/// Its printed closed form, 4N^3/3 + 71N^2/2 + 205N/6 - 21.
pub fn analytic_storage_printed(valence: u32) -> f64 {
    let n = f64::from(valence);
    4.0 * n.powi(3) / 3.0 + 71.0 * n.powi(2) / 2.0 + 205.0 * n / 6.0 - 21.0
}

/// (3.1) V + P - E of a manifold mesh; printed with + boundaries.
pub fn euler_characteristic(genus: i64, boundaries: i64) -> i64 {
    2 - 2 * genus - boundaries
}

/// 6.1 Positions sent for each vertex of a large regular mesh: vertex by vertex, as OpenGL strips, with fans.
pub const BANDWIDTH: [u64; 3] = [1, 2, 4];

/// Share of the clocks in which the unit of a level works when all levels have one, 2^(level - levels).
pub fn busy(level: u32, levels: u32) -> f64 {
    (f64::from(level) - f64::from(levels)).exp2()
}

/// Area for a column a clock when coarse levels are folded until they are always busy, in units of the finest:
/// a level of half the rows works half of the time, 1 + 1/4 + 1/16 + ..., below 4/3.
pub fn folded_area(levels: u32) -> f64 {
    (0..levels).map(|coarser| 0.25f64.powi(coarser as i32)).sum()
}

/// Two-input adders for a face and a vertex column together in the separable datapath, over X = 3 + 2^level
/// source rows: 9X - 10.
pub fn separable_adders(source_level: u32) -> u64 {
    9 * column_vertices(source_level) - 10
}

/// Vertices of a face and a vertex column together over the same source.
pub fn pair_vertices(source_level: u32) -> u64 {
    2 * (1 + (2 << source_level))
}

/// Operators for one column a clock at the finest level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operators {
    pub four_input_adders: u64,
    pub three_input_adders: u64,
    /// Adders of as many inputs as the largest valence.
    pub fan_adders: u64,
    pub right_shifts_by_4: u64,
    pub right_shifts_by_2: u64,
    pub right_shifts_by_1: u64,
    pub left_shifts_by_1: u64,
    pub multipliers_by_third: u64,
    pub multipliers: u64,
    pub tables: u64,
    /// Entries of each table.
    pub table_entries: u64,
}

/// 6.4 The list as printed. The multipliers are those of its text; the list leaves them and the three-input adders
/// out.
pub fn operators_printed(levels: u32, valence: u32) -> Operators {
    let (rows, d) = (1u64 << levels, u64::from(valence));
    Operators {
        four_input_adders: 4 * rows + 4 * d - 10,
        three_input_adders: 0,
        fan_adders: 4,
        right_shifts_by_4: rows,
        right_shifts_by_2: rows + 2 * d - 4,
        right_shifts_by_1: 2 * rows + 4 * d - 12,
        left_shifts_by_1: rows,
        multipliers_by_third: rows + 2 * d - 6,
        multipliers: 0,
        tables: 4,
        table_entries: d - 4,
    }
}

/// 6.4 counted again, the source columns being those of level l-1: 2^l + 2d - 4 faces, 2^(l-1) + 2d - 6 edges and
/// 2^(l-1) - 1 regular replacements, and two irregular ones with one table kappa_d = 1/(4 d^2).
pub fn operators(levels: u32, valence: u32) -> Operators {
    let (half, d) = (1u64 << (levels - 1), u64::from(valence));
    let (faces, edges, replacements) = (2 * half + 2 * d - 4, half + 2 * d - 6, half - 1);
    Operators {
        four_input_adders: faces + edges + 2 * replacements,
        three_input_adders: replacements,
        fan_adders: 4,
        right_shifts_by_4: replacements,
        right_shifts_by_2: faces + edges,
        right_shifts_by_1: replacements,
        left_shifts_by_1: 0,
        multipliers_by_third: 0,
        multipliers: 2,
        tables: 1,
        table_entries: d - 3, // 3 and 5..=d; 4 is a shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn storage_at_five_levels_and_valence_ten() {
        assert_eq!((window_vertices_printed(5), window_vertices(5)), (234, 243));
        assert_eq!((fan_entries(5, 10), fan_vertices(5, 10)), (96, 192));
        assert_eq!(window_vertices_printed(5) + fan_entries(5, 10), 330);
        assert_eq!(window_vertices(5) + fan_entries(5, 10), 339);
        assert_eq!((storage_vertices(5, 10), storage_with_look_ahead(5, 10)), (435, 439));
        assert_eq!((lean_storage_vertices(5, 10), lean_storage_extra(5)), (315, 30));
        assert_eq!(16 * storage_vertices(5, 10), 6960);
        // 410 appears if the last term of (6.3), -8l, is added instead: 330 + 80
        assert_eq!(330 + 2 * 8 * 5, 410);
    }

    #[test]
    fn closed_forms_of_the_sums() {
        for l in 1..=7u32 {
            assert_eq!(window_vertices(l), 9 * u64::from(l) + 6 + 6 * (1 << l));
        }
        for n in 3..=16u32 {
            let n3 = i64::from(n);
            let closed = (4 * n3.pow(3) + 105 * n3.pow(2) + 701 * n3) / 3 - 618;
            assert_eq!(analytic_storage(n, 1) as i64, closed, "N = {n}");
        }
        assert_eq!((analytic_storage(10, 1), analytic_storage(10, 3)), (6552, 11928));
        assert!((analytic_storage_printed(10) - 5204.0).abs() < 1.0);
    }

    #[test]
    fn operators_at_five_levels_and_valence_ten() {
        let (old, new) = (operators_printed(5, 10), operators(5, 10));
        assert_eq!((old.four_input_adders, new.four_input_adders), (158, 108));
        assert_eq!((old.multipliers_by_third, new.multipliers_by_third), (46, 0));
        assert_eq!((old.right_shifts_by_2, new.right_shifts_by_2), (48, 78));
        assert_eq!((new.three_input_adders, new.right_shifts_by_4, new.table_entries), (15, 15, 7));
        for (l, d) in (1..=7).flat_map(|l| (4..=16).map(move |d| (l, d))) {
            assert_eq!(operators(l, d).four_input_adders, 5 * (1 << (l - 1)) + 4 * u64::from(d) - 12);
        }
    }

    #[test]
    fn folding_costs_a_third_more() {
        assert_eq!((busy(5, 5), busy(4, 5), busy(1, 5)), (1.0, 0.5, 0.0625));
        assert!(folded_area(5) < 4.0 / 3.0 && folded_area(5) > 1.33);
    }

    /// The separable datapath, adder by adder: s = p + n and t = s_old + s + 4c once a row, then the sums of
    /// neighbouring rows, which faces and edges share.
    #[test]
    fn adders_of_the_separable_datapath() {
        for level in 0..=6 {
            let x = column_vertices(level);
            // s = c + n, then t = s_old + s + 4c
            let (s, t) = (x, 2 * x);
            // sums of neighbouring rows of s and t: faces and edges along the strip
            let pairs = 2 * (x - 1);
            // edges across and new vertices: two pairs and four times the middle, inner rows only
            let fours = 2 * 2 * (x - 2);
            assert_eq!(s + t + pairs + fours, separable_adders(level));
        }
        let each = separable_adders(6) as f64 / pair_vertices(6) as f64;
        assert!((each - 2.25).abs() < 0.1, "{each}");
    }
}
