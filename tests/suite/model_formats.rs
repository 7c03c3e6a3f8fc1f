//! The reference of reduced formats against the definition: every difference from the box spline, rounded as
//! a fraction, and every add done and rounded by the book.

use std::collections::BTreeMap;

use crate::surface_meshes::{Random, shaken, zoo};
use subdiv_rtl::fixed::{Fractions, Precision, Reduced, Rounding};
use subdiv_rtl::model::loop_fd::LoopFd;
use subdiv_rtl::model::render::render;
use subdiv_rtl::surface::basis;
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::table::Table;

fn choose(n: i64, k: i64) -> i128 {
    (0..k).fold(1, |c, x| c * i128::from(n - x) / i128::from(x + 1))
}

/// numerator / denominator, rounded.
fn rounded(numerator: i128, denominator: i128, mode: Rounding) -> i128 {
    match mode {
        Rounding::Floor => numerator.div_euclid(denominator),
        Rounding::Truncate => numerator / denominator,
        Rounding::HalfUp => (2 * numerator + denominator).div_euclid(2 * denominator),
        _ => {
            let (below, rest) = (numerator.div_euclid(denominator), numerator.rem_euclid(denominator));
            let up = 2 * rest > denominator || (2 * rest == denominator && below % 2 != 0);
            below + i128::from(up)
        }
    }
}

/// The differences (k, l) of one axis at (0, 0) of a patch; those that no vertex depends on are missing.
type Differences = BTreeMap<(usize, usize), i128>;

fn start(core: &LoopFd, reduced: Reduced, level: u32, points: &[i128; 12]) -> Differences {
    let n = 1i64 << level;
    let orders = (0..=4i64).flat_map(|k| (0..=4 - k).map(move |l| (k, l)));
    let kept = orders.filter(|&(k, l)| k + l <= n && ![(2, 2), (4, 0), (0, 4)].contains(&(k, l)));
    kept.map(|(k, l)| {
        let mut numerator = 0;
        for (x, y) in (0..=k).flat_map(|x| (0..=l).map(move |y| (x, y))) {
            let mask = basis::mask(level, x as u32, y as u32);
            let sample: i128 = mask.iter().zip(points).map(|(&m, &p)| i128::from(m) * p).sum();
            let sign = if (k - x + l - y) % 2 == 0 { 1 } else { -1 };
            numerator += sign * choose(k, x) * choose(l, y) * sample;
        }
        let order = (k + l) as usize;
        let value =
            rounded(numerator << reduced.fractions.of(order), 12 << (4 * core.max_level()), reduced.rounding);
        ((k as usize, l as usize), value)
    })
    .collect()
}

/// One step along u (`u` = 1) or v.
fn step(reduced: Reduced, old: &Differences, along_u: bool) -> Differences {
    let higher = |(k, l): (usize, usize)| match (k, l, along_u) {
        (3, 0, true) => old.get(&(3, 1)).map(|d| 2 * d),
        (0, 3, false) => old.get(&(1, 3)).map(|d| 2 * d),
        (_, _, true) => old.get(&(k + 1, l)).copied(),
        (_, _, false) => old.get(&(k, l + 1)).copied(),
    };
    let gain = |(k, l): (usize, usize)| match higher((k, l)) {
        Some(higher) => reduced.rounding.apply(higher, reduced.fractions.dropped(k + l)).unwrap(),
        None => 0,
    };
    old.iter().map(|(&kl, &d)| (kl, d + gain(kl))).collect()
}

/// The vertices of a patch, column by column.
fn vertices(core: &LoopFd, level: u32, points: &[[i128; 3]; 12]) -> Vec<[i64; 3]> {
    let reduced = core.precision().reduced().unwrap();
    let n = 1usize << level;
    let mut vertices = vec![[0; 3]; (n + 1) * (n + 2) / 2];
    for axis in 0..3 {
        let mut outer = start(core, reduced, level, &points.map(|p| p[axis]));
        let mut vertex = vertices.iter_mut();
        for i in 0..=n {
            // a column knows only what is differenced along v
            let mut column: Differences = outer.clone();
            for _ in 0..=n - i {
                let last = reduced.fractions.of(0) as i32 - core.extra_fraction();
                let y = Rounding::HalfUp.apply(column[&(0, 0)], last as u32).unwrap();
                let top = 1i128 << (core.output_bits() - 1);
                let y = if reduced.saturate { y.clamp(-top, top - 1) } else { y };
                vertex.next().unwrap()[axis] = y as i64;
                column = step(reduced, &column, false);
            }
            outer = step(reduced, &outer, true);
        }
    }
    vertices
}

fn formats() -> Vec<Reduced> {
    let fractions = ["0", "3", "17", "24", "2,2,3,3,4", "7,11,15,18,18", "5,8,8,8,11", "4,9,9,20,21"];
    let fractions = fractions.map(|text| text.parse::<Fractions>().unwrap());
    let modes = fractions.into_iter().flat_map(|f| Rounding::TOTAL.map(|rounding| (f, rounding)));
    let reduced = modes.map(|(fractions, rounding)| Reduced {
        fractions,
        rounding,
        saturate: fractions.of(0) % 2 == 1,
    });
    reduced.collect()
}

#[test]
fn every_format_and_mode_is_its_definition() {
    let mut random = Random(5);
    for (width, max_level, extra) in [(12, 3, 0), (24, 5, -4), (20, 4, 2), (32, 10, 0), (4, 2, 1)] {
        for reduced in formats() {
            let exact = LoopFd::new(width, extra, max_level).unwrap();
            let Ok(core) = exact.with_precision(Precision::Reduced(reduced)) else {
                assert!((reduced.fractions.of(0) as i32) < extra);
                continue;
            };
            for level in 0..=max_level.min(4) {
                let finer = 4 * (max_level - level);
                let points = [0; 12].map(|_| {
                    [0; 3].map(|_| {
                        let fraction = i128::from(random.bits() >> 1) & ((1i128 << finer.min(60)) - 1);
                        (i128::from(random.coordinate(width)) << finer) + fraction
                    })
                });
                // Left vertices are the columns one after the other; the last column stands on the right.
                let expected = vertices(&core, level, &points);
                let beats = core.beats(level, &points).unwrap();
                let lefts: Vec<[i64; 3]> = beats.iter().map(|beat| beat.left).collect();
                assert_eq!(lefts, expected[..expected.len() - 1], "{core:?}, level {level}");
            }
        }
    }
}

#[test]
fn right_vertices_are_the_left_ones_of_the_next_strip() {
    let reduced = Reduced::new("7,11,15,18,18".parse().unwrap());
    let core = LoopFd::new(16, 0, 5).unwrap().with_precision(Precision::Reduced(reduced)).unwrap();
    let mut random = Random(6);
    let points = [0; 12].map(|_| [0; 3].map(|_| i128::from(random.coordinate(16))));
    let beats = core.beats(5, &points).unwrap();
    let expected = vertices(&core, 5, &points);
    let (mut i, mut j, mut seen) = (0usize, 0usize, 0);
    let at = |i: usize, j: usize| expected[(0..i).map(|c| 33 - c).sum::<usize>() + j];
    for beat in &beats {
        assert_eq!(beat.left, at(i, j));
        if let Some(right) = beat.right {
            assert_eq!(right, at(i + 1, j));
            seen += 1;
        }
        (i, j) = if beat.strip_end { (i + 1, 0) } else { (i, j + 1) };
    }
    assert_eq!(seen, 32 * 33 / 2);
}

#[test]
fn what_a_reduced_core_computes_does_not_depend_on_its_maximum_level() {
    let reduced = Precision::Reduced(Reduced::new("6,9,12,12,14".parse().unwrap()));
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 16, 3);
        let table = Table::for_width(16).unwrap();
        let drawn = |max_level: u32| {
            let core = LoopFd::new(16, 0, max_level).unwrap().with_precision(reduced).unwrap();
            let mut vertices = vec![];
            render(&mesh, 3, &core, &table, &mut vertices).unwrap();
            vertices
        };
        assert!(drawn(3) == drawn(7), "{name}");
    }
}

#[test]
fn meshes_come_out_patch_by_patch() {
    let reduced = Precision::Reduced(Reduced {
        rounding: Rounding::HalfEven,
        ..Reduced::new("6,9,12,12,14".parse().unwrap())
    });
    let core = LoopFd::new(16, 2, 3).unwrap().with_precision(reduced).unwrap();
    let table = Table::for_width(16).unwrap();
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 16, 4);
        let (mut drawn, mut expected) = (vec![], vec![]);
        render(&mesh, 3, &core, &table, &mut drawn).unwrap();
        patches(&mesh, 3, 3, &table, |patch| expected.extend(vertices(&core, patch.level, &patch.points)))
            .unwrap();
        assert!(drawn == expected, "{name}");
    }
}
