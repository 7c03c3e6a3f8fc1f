//! How wide each difference of a reduced format is: wide enough on every patch of every level, proven.
//!
//! ```text
//!   |D| <= (2^W - 1) p_m(r),  its error <= E_m(r),  so I_m integer bits above W suffice where
//!   (2^W - 1) p_m(r) + E_m(r) < 2^(W + I_m - 1)      on every level r of the core
//!
//!   p_1 = 2^-r       p_2 = 2 * 4^-r - 7/3 16^-r       p_3 = 8 * 8^-r - 12 * 16^-r       p_4 = 6 * 16^-r
//!                                              (D40 = 2 D31 and D04 = 2 D13 are kept without their lowest bit)
//!
//!   E_m = sum over c <= 4 - m of  s C(n,c) 2^-F_(m+c)  +  a C(n,c+1) 2^-F_(m+c) where F_(m+c) < F_(m+c+1)
//!         n = 2^r; s = a = 1/2 half up, else 1; the term of the fourth order twice
//!         half even: a = 1/2, s = 3/2, as the proof takes the correction of a tie for an error of its own
//! ```
//!
//! p_m is half the sum of the absolute weights of the control points in D, largest over the places from
//! which a vertex of the patch is reached; at level 0 no vertex depends on order 2, at level 1 none on
//! order 3. Boundary patches completed with ghosts are among them, and three limit positions sent as a patch
//! of level 0. Vertices stay in the hull, up to E_0. What is claimed here is proved for each core.

use super::{Parameters, RegisterForm};
use crate::fixed::precision::HIGHEST_ORDER;
use crate::fixed::{Range, Reduced, Rounding};
use crate::hdl::Word;

/// Everything here is an integer over 2^UNIT.
const UNIT: u32 = 50;

/// The word of D(k,l) in a reduced format, modulo its width: what is not read may be too large for it.
pub fn difference(parameters: Parameters, reduced: Reduced, (k, l): (u32, u32)) -> Word {
    let order = (k + l) as usize;
    let fraction = reduced.fractions.of(order);
    let bits = (parameters.coordinates.width() + fraction) as i32;
    let width = (bits + integer_bits(parameters, reduced, order)).max(2);
    Word::modular(width as u32).fraction((parameters.coordinates.fraction + fraction) as i32)
}

/// Bits at the low end of an exact difference that are always zero and are not kept.
pub fn low_zeros(order: u32) -> u32 {
    [0, 0, 1, 2][order.min(3) as usize]
}

/// The width of D(k,l) in an exact format: modulo 2^B what is kept of it, or fewer bits where it fits them on every
/// level of the core. A patch of level r has control points of W + 4 (R - r) bits; three limit positions sent as a
/// patch of level 0 have more.
pub fn exact_width(parameters: Parameters, (k, l): (u32, u32)) -> u32 {
    if parameters.min_level == 0 {
        return parameters.modulus() - low_zeros(k + l);
    }
    let width = |level: u32| {
        let point = parameters.coordinates.width() + 4 * (parameters.max_level - level);
        point + bits_above(level, (k, l))
    };
    let number = (parameters.min_level..=parameters.max_level).map(width).max().unwrap_or(0);
    number.min(parameters.modulus()) - low_zeros(k + l)
}

/// Bits of N(k,l) above those of the control points at this level, over all places that are reached.
fn bits_above(level: u32, (k, l): (u32, u32)) -> u32 {
    // Levels 0 to 4; from level 5 on they grow by a constant.
    let (coarse, fine) = match (k.min(l), k.max(l)) {
        (0, 0) => ([4, 8, 12, 16, 20], 4 * level + 4),
        (0, 1) => ([9, 10, 11, 14, 17], 3 * level + 5),
        (0, 2) => ([10, 11, 12, 13, 15], 2 * level + 6),
        (1, 1) => ([9, 10, 11, 13, 14], 2 * level + 6),
        (0, 3) => ([10, 10, 11, 12, 12], level + 8),
        (1, 2) => ([9, 9, 10, 10, 11], level + 7),
        (1, 3) => ([8, 8, 8, 8, 8], 8),
        // N40 = 2 N31, N04 = 2 N13.
        _ => ([9, 9, 9, 9, 9], 9),
    };
    coarse.get(level as usize).copied().unwrap_or(fine)
}

/// Bits of the registers that one coordinate differences with: the outer differences and two columns. The next
/// patch waits in as many outer differences again, and the start-up is shared by the coordinates.
pub fn register_bits(parameters: Parameters) -> u32 {
    let form = parameters.registers;
    let mut orders = super::DIFFERENCES.to_vec();
    if matches!(form, RegisterForm::Published23 | RegisterForm::WithoutZero22) {
        orders.extend([(4, 0), (0, 4)]);
    }
    if form == RegisterForm::Published23 {
        orders.push((2, 2));
    }
    let column = [(0, 0), (0, 1), (0, 2), (0, 3)];
    orders.extend(column);
    match form {
        RegisterForm::Relative19 => orders.extend([(1, 0), (1, 1), (1, 2)]),
        _ => orders.extend(column),
    }
    orders.into_iter().map(|kl| parameters.difference(kl).width()).sum()
}

/// I_m: integer bits above W.
pub fn integer_bits(parameters: Parameters, reduced: Reduced, order: usize) -> i32 {
    let width = parameters.coordinates.width();
    let lowest_live = [0, 0, 1, 2, 2][order].max(parameters.min_level);
    let spread = (1i128 << width) - 1;
    let most = (lowest_live..=parameters.max_level).map(|level| {
        let exact = match order {
            0 => 1 << (width - 1 + UNIT),
            _ => spread * largest(order, level),
        };
        exact + error(reduced, order, level)
    });
    let Some(most) = most.max() else { return -(width as i32) };
    // The least I with most < 2^(W + I - 1) 2^UNIT; at order 0 the lower end itself is a number.
    let most = if order == 0 { most - 1 } else { most };
    (128 - most.leading_zeros()) as i32 - UNIT as i32 - width as i32 + 1
}

/// Every value of D(0,0) that is a vertex.
pub fn vertex_range(parameters: Parameters, reduced: Reduced) -> Range {
    let fraction = reduced.fractions.of(0);
    let hull = Range::signed(parameters.coordinates.width()) * (1i128 << fraction);
    let levels = parameters.min_level..=parameters.max_level;
    let error = levels.map(|level| error(reduced, 0, level)).max().unwrap_or(0);
    let error = error >> (UNIT - fraction);
    Range::new(hull.min - error, hull.max + error)
}

/// p_m(r) over 2^UNIT.
fn largest(order: usize, level: u32) -> i128 {
    let two_to = |bits: u32| 1i128 << (UNIT - bits);
    match (order, level) {
        (1, r) => two_to(r),
        // Rounded up.
        (2, r) => 2 * two_to(2 * r) - 7 * two_to(4 * r) / 3,
        (3, r) => 8 * two_to(3 * r) - 12 * two_to(4 * r),
        (_, r) => 6 * two_to(4 * r),
    }
}

/// E_m(r) over 2^UNIT.
fn error(reduced: Reduced, order: usize, level: u32) -> i128 {
    let (n, fractions) = (1i128 << level, reduced.fractions);
    let choose = |c: usize| (0..c as i128).fold(1, |product, x| product * (n - x) / (x + 1));
    let (halves_of_start, halves_of_add) = match reduced.rounding {
        Rounding::HalfUp | Rounding::Exact => (1, 1),
        Rounding::HalfEven => (3, 1),
        Rounding::Floor | Rounding::Truncate => (2, 2),
    };
    let terms = (0..=HIGHEST_ORDER - order).map(|c| {
        let at = order + c;
        let start = if at == HIGHEST_ORDER { 2 * choose(c) } else { choose(c) };
        let adds = if at < HIGHEST_ORDER && fractions.dropped(at) > 0 { choose(c + 1) } else { 0 };
        (start * halves_of_start + adds * halves_of_add) << (UNIT - 1 - fractions.of(at))
    });
    terms.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Precision;

    fn bits(min_level: u32, max_level: u32, fractions: &str) -> [i32; 5] {
        let parameters =
            Parameters::new("Q12.12".parse().unwrap(), 12, max_level, RegisterForm::Minimal20).unwrap();
        let reduced = Reduced::new(fractions.parse().unwrap());
        let parameters = parameters
            .with_precision(Precision::Reduced(reduced))
            .and_then(|parameters| parameters.with_min_level(min_level))
            .unwrap();
        [0, 1, 2, 3, 4].map(|order| integer_bits(parameters, reduced, order))
    }

    #[test]
    fn a_core_of_all_levels_pays_for_the_coarse_ones() {
        assert_eq!(bits(0, 8, "10,17,24,30,30"), [1, 1, 0, -2, -4]);
        assert_eq!(bits(0, 5, "17"), [1, 1, 0, -2, -4]);
    }

    #[test]
    fn a_core_of_one_level_needs_fewer_bits_the_higher_the_order() {
        // D10 along a boundary can be 2^-r times the whole range, so its error takes one bit more.
        for (r, fractions) in [(3, "5,8,8,8,11"), (5, "7,11,15,18,18"), (8, "10,17,24,30,30")] {
            assert_eq!(bits(r as u32, r as u32, fractions), [1, 2 - r, 2 - 2 * r, 4 - 3 * r, 4 - 4 * r]);
        }
    }

    #[test]
    fn register_bits_are_those_of_the_engine() {
        for form in RegisterForm::ALL {
            let exact = Parameters::new("Q8.8".parse().unwrap(), 8, 5, form).unwrap();
            // Zeros at the low end: of the 12 outer differences 15, of the two columns 6, of D40 and D04 and of D22 two.
            let zeros = 15 + 6 + if form.count() > 20 { 2 * (form.count() - 20) } else { 0 };
            assert_eq!(register_bits(exact), form.count() * exact.modulus() - zeros);
            let fractions = if form == RegisterForm::Relative19 { "17" } else { "8,12,14,17,18" };
            let reduced = Precision::Reduced(Reduced::new(fractions.parse().unwrap()));
            for parameters in [exact, exact.with_precision(reduced).unwrap()] {
                let engine = super::super::engine::build(parameters).unwrap();
                let registers = engine.nodes.iter().filter(|node| {
                    let name = node.name.as_deref().unwrap_or_default();
                    // d00, left_0, ...; not the stages behind them, of which the right column of 19 is one.
                    let column = if form == RegisterForm::Relative19 { "gap_" } else { "right_" };
                    let rest = ["d", "left_", column].iter().find_map(|p| name.strip_prefix(p));
                    let differenced = rest.is_some_and(|rest| rest.parse::<u32>().is_ok());
                    matches!(node.cell, crate::hdl::Cell::Register { .. }) && differenced
                });
                assert_eq!(
                    registers.map(|n| n.word.width()).sum::<u32>(),
                    register_bits(parameters),
                    "{form}"
                );
            }
        }
        // One level alone, 16 bits: 743 exact ones if each register is as narrow as it can be.
        let parameters = Parameters::new("Q8.8".parse().unwrap(), 8, 8, RegisterForm::Minimal20).unwrap();
        let reduced = Precision::Reduced(Reduced::new("11,18,23,29,30".parse().unwrap()));
        let parameters = parameters.with_min_level(8).and_then(|p| p.with_precision(reduced)).unwrap();
        assert_eq!(register_bits(parameters), 512);
    }

    #[test]
    fn large_errors_get_the_room_they_need() {
        // B(1024) / 2 > 2^34: the first difference above 2^23 by far
        assert!(bits(0, 10, "0")[0] > 10);
    }
}
