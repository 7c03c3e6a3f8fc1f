//! Start-up: the matrix Q_r from 12 control points to 12 differences, by shifts and adds alone.
//!
//! ```text
//! rm = P0-2P1+P2   r0 = P3-2P4+P5   r0' = P4-2P5+P6   r1 = P7-2P8+P9        second differences of the rows
//! sm = P3-2P7+P10  s0 = P0-2P4+P8   s0' = P4-2P8+P11  s1 = P1-2P5+P9        and of the columns
//! N00 = 16^r C00     N10 = 2*8^r C10 + 6*4^r C20 + 2*2^r C30 + G     ...
//! ```
//!
//! Behind the points, which are gathered here, it is a pure function and fully pipelined: the three axes of a patch
//! go through one after the other.
//! The powers of 2^r are shifts by the bits of the level. Reduced numbers are divided by 12 * 16^R at the end,
//! each rounded to the fraction bits of its order; 16^R belongs to the core, so the level does not matter.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::rc::Rc;

use super::engine::DIFFERENCES;
use super::{AXES, Parameters};
use crate::cores::rounder;
use crate::error::{Error, Result};
use crate::fixed::{Precision, Reduced};
use crate::hdl::serial::serial;
use crate::hdl::skew::LEAD;
use crate::hdl::{Builder, Module, Relation, Signal, Word};

pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    if let (Some(_), Some(size)) = (parameters.lanes, parameters.digit()) {
        return in_digits(parameters, size);
    }
    let m = Builder::new("startup");
    describe(&m, parameters);
    let p = control_points(&m, parameters);
    let level = if parameters.has_one_level() {
        m.constant(parameters.max_level.into(), parameters.level())
    } else {
        m.at_time(&m.input("level", parameters.level()), 1)
    };
    differences(&m, parameters, &p, &level)?;
    m.finish()
}

fn describe(m: &Builder, parameters: Parameters) {
    m.purpose("The differences of a patch, step 2^-level, from its 12 control points: matrix Q_r");
    m.purpose("(Bischoff, Kobbelt, Seidel 2000, appendix A.4, with the matrix corrected).");
    m.parameter("modulus", format!("2^{}", parameters.startup_modulus()));
}

/// Clocks in which what chooses the axis goes to all points, by way of few, and in which it chooses.
const HERE: u32 = 3;

/// The same in digits: `first` comes with the axis, and digit 0 of the differences as many clocks later as they declare.
fn in_digits(parameters: Parameters, size: u32) -> Result<Rc<Module>> {
    let inner = Builder::new("startup_matrix");
    describe(&inner, parameters);
    let word = Word::modular(parameters.startup_modulus());
    let p: Vec<Signal> = (0..12).map(|place| inner.input(format!("p{place}"), word)).collect();
    let level = if parameters.has_one_level() {
        inner.constant(parameters.max_level.into(), parameters.level())
    } else {
        inner.input("level", parameters.level())
    };
    differences(&inner, parameters, &p, &level)?;
    let inner = serial(&inner.finish()?, size, parameters.digits(), &["level"])?;

    let m = Builder::new("startup");
    m.purpose(
        "The control points of a patch, and of the chosen axis digit by digit; behind them the matrix.",
    );
    let banks = banks(&m, parameters);
    let [axis_x, axis_y, first] = ["axis_x", "axis_y", "first"].map(|name| {
        let on_the_way = m.pipe(format!("{name}_on_the_way"), m.input(name, Word::bit()));
        m.restart(&m.pipe(format!("{name}_here"), &on_the_way), 0)
    });
    let first = m.restart(&m.pipe("first_chosen", &first), 0);
    let digits: Vec<Signal> = (0..12)
        .map(|place| {
            let [x, y, z] = [0, 1, 2].map(|axis| &banks[axis][place]);
            let width = x.width();
            let chosen = m.select(&axis_x, x, m.select(&axis_y, y, z));
            let chosen = m.restart(&m.pipe(format!("chosen_p{place}"), m.slice(&chosen, 0, width)), 0);
            let point = m.register(format!("p{place}"), Word::unsigned(width));
            let sign = m.slice(&point, width - 1, 1);
            // What is above, and then the sign for ever.
            let signs = |count: u32| vec![sign.clone(); count as usize];
            let above = width.saturating_sub(size);
            let mut parts = signs(width - above);
            if above > 0 {
                parts.push(m.slice(&point, size, above));
            }
            let shifted = m.concat(&parts.iter().collect::<Vec<_>>());
            m.always(&point, m.select(&first, &chosen, &shifted));
            let low = m.slice(&point, 0, width.min(size));
            let mut parts = signs(size - low.width());
            parts.push(low);
            m.restart(&m.concat(&parts.iter().collect::<Vec<_>>()), HERE + LEAD)
        })
        .collect();
    let names: Vec<String> = (0..12).map(|place| format!("p{place}")).collect();
    let mut inputs: Vec<(&str, &Signal)> = names.iter().map(String::as_str).zip(&digits).collect();
    let first_here = m.restart(&first, HERE);
    inputs.push(("first", &first_here));
    // The level of the patch, through all digits of an axis.
    let level = (!parameters.has_one_level()).then(|| {
        let (level, held) =
            (m.input("level", parameters.level()), m.register("level_held", parameters.level()));
        m.on(&first, &held, &level);
        m.restart(&held, HERE + LEAD)
    });
    inputs.extend(level.iter().map(|level| ("level", level)));
    let matrix = m.instance("matrix", &inner, &inputs);
    for (k, l) in DIFFERENCES {
        let name = format!("n{k}{l}");
        m.output(&name, matrix.out(&name));
    }
    m.finish()
}

/// The outputs n00, n10 ... from the control points.
fn differences(m: &Builder, parameters: Parameters, p: &[Signal], level: &Signal) -> Result<()> {
    let second = |name: &str, [a, b, c]: [usize; 3]| m.pipelined(name, &p[a] - 2 * &p[b] + &p[c]);
    let [rm, r0, r0_next, r1] =
        [("rm", [0, 1, 2]), ("r0", [3, 4, 5]), ("r0_next", [4, 5, 6]), ("r1", [7, 8, 9])]
            .map(|(n, i)| second(n, i));
    let [sm, s0, s0_next, s1] =
        [("sm", [3, 7, 10]), ("s0", [0, 4, 8]), ("s0_next", [4, 8, 11]), ("s1", [1, 5, 9])]
            .map(|(n, i)| second(n, i));
    let p8_p7 = m.pipelined("p8_p7", &p[8] - &p[7]);
    let p5_p3 = m.pipelined("p5_p3", &p[5] - &p[3]);
    let p1_p0 = m.pipelined("p1_p0", &p[1] - &p[0]);
    let p7_p1 = m.pipelined("p7_p1", &p[7] - &p[1]);
    let p8_p0 = m.pipelined("p8_p0", &p[8] - &p[0]);

    let c30 = m.pipelined("c30", &rm - 2 * &r0 + &r1);
    let c03 = m.pipelined("c03", &sm - 2 * &s0 + &s1);
    let (c20, c02) = (r0.clone(), s0.clone());
    let c21 = m.pipelined("c21", &r1 - &r0);
    let c12 = m.pipelined("c12", &s1 - &s0);
    let g = m.pipelined("g", &r0 + &r0_next - &rm - &r1);
    let h = m.pipelined("h", &s0 + &s0_next - &sm - &s1);
    let c11 = m.pipelined("c11", &r0 - &p1_p0 + &p8_p7);
    let c10 = m.pipelined("c10", &p1_p0 + &p8_p7 + 2 * &p5_p3);
    let c01 = m.pipelined("c01", &p7_p1 + &p5_p3 + 2 * &p8_p0);
    let c00 = m.pipelined("c00", &p[0] + &p[1] + &p[3] + &p[5] + &p[7] + &p[8] + 6 * &p[4]);
    let c21_c12 = m.pipelined("c21_c12", &c21 + &c12);

    // a = 2^r, b = 4^r, c = 8^r, d = 16^r.
    let bits: Vec<Signal> =
        (0..level.width()).map(|bit| m.wire(format!("level_{bit}"), m.slice(level, bit, 1))).collect();
    let times = |name: &str, value: &Signal, power: u32| match parameters.has_one_level() {
        true => m.wire(name, value << (power * parameters.max_level)),
        false => times_power(m, name, value, &bits, power),
    };
    let d_c00 = times("d_c00", &c00, 4);
    let [c_c10, c_c01] = [("c_c10", &c10), ("c_c01", &c01)].map(|(n, v)| times(n, v, 3));
    let [b_c20, b_c02, b_c11] =
        [("b_c20", &c20), ("b_c02", &c02), ("b_c11", &c11)].map(|(n, v)| times(n, v, 2));
    let [a_c30, a_c03, a_c21, a_c12, a_c21_c12] =
        [("a_c30", &c30), ("a_c03", &c03), ("a_c21", &c21), ("a_c12", &c12), ("a_c21_c12", &c21_c12)]
            .map(|(n, v)| times(n, v, 1));

    let g3 = m.pipelined("g3", 3 * &g);
    let h3 = m.pipelined("h3", 3 * &h);
    let gh = m.pipelined("gh", &g + &h);
    // Order 2 is a multiple of 2, orders 3 and 4 of 12. Exact differences are kept without their zeros at the low end;
    // reduced numbers are to be divided by 12, so those of orders 3 and 4 do without it.
    let exact = parameters.precision == Precision::Exact;
    let twice = if exact { 1 } else { 2 };
    let thrice = |name: &str, x: &Signal| if exact { m.pipelined(name, 3 * x) } else { x.clone() };
    // Rows of the table, in the order of DIFFERENCES.
    let rows = [
        match parameters.half() {
            0 => d_c00.clone(),
            half => m.pipelined("n00_sum", &d_c00 + half),
        },
        m.pipelined("n10_sum", 2 * &c_c10 + 6 * &b_c20 + 2 * &a_c30 + &g),
        m.pipelined("n20_sum", 6 * twice * &m.pipelined("bc20_ac30", &b_c20 + &a_c30) + 7 * twice * &g),
        thrice("n30_sum", &m.pipelined("ac30_g3", &a_c30 + &g3)),
        m.pipelined("n01_sum", 2 * &c_c01 + 6 * &b_c02 + 2 * &a_c03 + &h),
        m.pipelined("n11_sum", 3 * twice * &m.pipelined("bc11_ac", &b_c11 + &a_c21_c12) + twice * &gh),
        thrice("n21_sum", &m.pipelined("ac21_g", &a_c21 + &g)),
        if exact { g3.clone() } else { g.clone() },
        m.pipelined("n02_sum", 6 * twice * &m.pipelined("bc02_ac03", &b_c02 + &a_c03) + 7 * twice * &h),
        thrice("n12_sum", &m.pipelined("ac12_h", &a_c12 + &h)),
        thrice("n03_sum", &m.pipelined("ac03_h3", &a_c03 + &h3)),
        if exact { h3.clone() } else { h.clone() },
    ];
    let rows = match parameters.precision {
        Precision::Exact => rows,
        Precision::Reduced(reduced) => rounded(m, parameters, reduced, level, rows)?,
    };
    let last = rows.iter().filter_map(Signal::time).max().unwrap_or(0);
    for ((k, l), row) in DIFFERENCES.into_iter().zip(&rows) {
        let row = m.at_time(row, last);
        let word = parameters.difference((k, l));
        let row = if row.word() == word { row } else { m.modulo(&row, word.width()) };
        m.output(format!("n{k}{l}"), &row);
    }
    Ok(())
}

/// The points of a patch by axis. They are shifted in, x, y and z together; after 12 of them the first one is at place 0.
fn banks(m: &Builder, parameters: Parameters) -> [Vec<Signal>; 3] {
    let word = parameters.point();
    let points = AXES.map(|axis| m.input(format!("point_{axis}"), word));
    let shift = m.input("shift", Word::bit());
    [0, 1, 2].map(|index| {
        let bank: Vec<Signal> =
            (0..12).map(|place| m.register(format!("{}_{place}", AXES[index]), word)).collect();
        for (place, register) in bank.iter().enumerate() {
            m.on(&shift, register, bank.get(place + 1).unwrap_or(&points[index]));
        }
        bank
    })
}

/// The 12 control points of the chosen axis.
fn control_points(m: &Builder, parameters: Parameters) -> Vec<Signal> {
    let banks = banks(m, parameters);
    let [axis_x, axis_y] = ["axis_x", "axis_y"].map(|name| m.input(name, Word::bit()));
    let modulus = parameters.startup_modulus();
    (0..12)
        .map(|place| {
            let [x, y, z] = [0, 1, 2].map(|index| &banks[index][place]);
            let p = m.pipe(format!("p{place}"), m.select(&axis_x, x, m.select(&axis_y, y, z)));
            if modulus == p.width() {
                return p;
            }
            let number = m.wrap(&p, Word::signed(p.width()));
            m.wire(format!("wide_p{place}"), m.modulo(&number, modulus))
        })
        .collect()
}

/// N(k,l) / (12 * 16^R), rounded to the fraction bits of its order; orders 3 and 4 come without their factor 12.
fn rounded(
    m: &Builder,
    parameters: Parameters,
    reduced: Reduced,
    level: &Signal,
    rows: [Signal; 12],
) -> Result<[Signal; 12]> {
    // Between patches other numbers pass through.
    let valid = m.at_time(&m.input("valid", Word::bit()), 1);
    let mut rounders: BTreeMap<u32, Rc<Module>> = BTreeMap::new();
    let mut rounded = vec![];
    for ((k, l), row) in DIFFERENCES.into_iter().zip(rows) {
        let (order, word) = (k + l, parameters.difference((k, l)));
        if let Entry::Vacant(vacant) = rounders.entry(order) {
            let rounder = rounder::Difference {
                name: format!("round_order_{order}"),
                numerator: row.word(),
                // N is over 3 * 2^(4R + 2), orders 3 and 4 without the factor 12 over 2^4R.
                thirds: order < 3,
                exact: 4 * parameters.max_level + if order < 3 { 2 } else { 0 },
                fraction: reduced.fractions.of(order as usize),
                word,
                mode: reduced.rounding,
            };
            vacant.insert(rounder.build()?);
        }
        // Whether a vertex depends on it; order 2 does not count at level 0, order 3 not at level 1.
        let live = match order {
            0 | 1 => valid.clone(),
            2 => &valid & m.is_not(level, 0),
            _ => &valid & m.compare(Relation::Less, m.constant(1, Word::range(0, 1)), level),
        };
        let live = m.at_time(&live, row.time().unwrap_or(0));
        let inputs = [("numerator", &row), ("live", &live)];
        rounded.push(m.instance(&format!("round_n{k}{l}"), &rounders[&order], &inputs).out("rounded"));
    }
    let count = rounded.len();
    rounded.try_into().map_err(|_| Error::usage(format!("{count} differences in place of 12")))
}

/// `value * 2^(power * level)`: one shift for each bit of the level, two shifts per clock.
fn times_power(m: &Builder, name: &str, value: &Signal, level: &[Signal], power: u32) -> Signal {
    let mut shifted = value.clone();
    for (bit, chosen) in level.iter().enumerate() {
        let amount = power << bit;
        shifted = m.select(chosen, &shifted << amount.min(100), &shifted);
        if bit % 2 == 1 {
            shifted = m.pipe(format!("{name}_part{}", bit / 2), &shifted);
        }
    }
    if level.len() % 2 == 1 { m.pipe(name, &shifted) } else { m.wire(name, &shifted) }
}
