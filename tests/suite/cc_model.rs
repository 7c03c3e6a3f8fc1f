//! The reference of cc-strip column by column: its order, its windows, its numbers, and what it refuses.

use crate::cc_meshes::{of_shape, shaken, spindle, wheel};
use subdiv_rtl::fixed::Rounding;
use subdiv_rtl::model::cc_strip::schedule::{Schedule, timeline};
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::records::{Column, Guard, Outside, StripRecords, positioned};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

fn strips_of(mesh: &QuadMesh) -> (u32, Vec<StripRecords<[i64; 3]>>) {
    let rings = Rings::new(mesh, Boundary::Ghosts).unwrap();
    (rings.width(), positioned(mesh, &rings, &cut(mesh, Method::Natural)))
}

/// One quad in a regular surroundings where each coordinate is a function of column and row.
fn regular_quad(at: impl Fn(i64, i64) -> i64) -> StripRecords<[i64; 3]> {
    let point = |c: i64, r: i64| [at(c, r), 0, 0];
    let outside = |c: i64, r: i64| Outside {
        valence: 4,
        fan: vec![point(c, r)],
        left: point(c, r),
        right: point(c, r),
        gap: None,
    };
    let column =
        |c| Column { vertices: [point(c, 0), point(c, 1)], outside: [outside(c, -1), outside(c, 2)] };
    let guard =
        |c| Some(Guard { vertices: [point(c, 0), point(c, 1)], outside: [point(c, -1), point(c, 2)] });
    StripRecords { closed: false, columns: vec![column(0), column(1)], guards: [guard(-1), guard(2)] }
}

#[test]
fn sixteen_points_give_the_bicubic_masks() {
    let core = CcStrip::new(Parameters::exact(12)).unwrap();
    // an impulse of 1 at column 0, row 0: F = 1/4, E = 6/16, V' = 36/64 around it, and so on
    let levels = core.levels(1, &regular_quad(|c, r| i64::from((c, r) == (0, 0)))).unwrap();
    let rows = |c: i64| {
        let column = levels[1][(c + 1) as usize].as_ref().unwrap();
        column.rows.iter().map(|p| p[0]).collect::<Vec<_>>()
    };
    assert_eq!(rows(-1), [24, 16, 4]);
    assert_eq!(rows(0), [36, 24, 6]);
    assert_eq!(rows(1), [24, 16, 4]);
    assert_eq!(rows(2), [6, 4, 1]);
    let outside = |c: i64| levels[1][(c + 1) as usize].as_ref().unwrap().outside[0].fan[0][0];
    assert_eq!([-1, 0, 1, 2].map(outside), [16, 24, 16, 4]);
}

#[test]
fn guard_bits_round_each_new_vertex_once_from_its_sum() {
    let parameters = Parameters { numbers: Numbers::Guard(1), ..Parameters::exact(12) };
    let core = CcStrip::new(parameters).unwrap();
    // the impulse of 8 in halves: F 4, E 6, V' 9;  towards the other end 1, 1.5 and 0.25
    let levels = core.levels(1, &regular_quad(|c, r| 8 * i64::from((c, r) == (0, 0)))).unwrap();
    let rows =
        |c: i64| levels[1][(c + 1) as usize].as_ref().unwrap().rows.iter().map(|p| p[0]).collect::<Vec<_>>();
    assert_eq!((rows(0), rows(2)), (vec![9, 6, 2], vec![2, 1, 0]));
}

#[test]
fn new_vertices_are_rounded_in_the_mode_of_the_core() {
    // the impulse of -8 in halves: F -4, E -6, V' -9;  towards the other end -1, -1.5 and -0.25
    for (rounding, expected) in [
        (Rounding::HalfUp, [[-9, -6, -1], [-1, -1, 0]]),
        (Rounding::HalfEven, [[-9, -6, -2], [-2, -1, 0]]),
        (Rounding::Floor, [[-9, -6, -2], [-2, -1, -1]]),
        (Rounding::Truncate, [[-9, -6, -1], [-1, -1, 0]]),
    ] {
        let core = CcStrip::new(Parameters { numbers: Numbers::Guard(1), rounding, ..Parameters::exact(12) });
        let strip = regular_quad(|c, r| -8 * i64::from((c, r) == (0, 0)));
        let levels = core.unwrap().levels(1, &strip).unwrap();
        let rows = |c: usize| levels[1][c + 1].as_ref().unwrap().rows.iter().map(|p| p[0] as i64);
        let found = [0, 2].map(|c| rows(c).collect::<Vec<_>>());
        assert_eq!(found, expected.map(Vec::from), "{rounding}");
    }
}

#[test]
fn columns_are_made_in_the_order_of_the_recursion() {
    let core = CcStrip::new(Parameters::exact(12)).unwrap();
    let order = |levels: u32| {
        let mut order = Vec::new();
        let strip = regular_quad(|_, _| 0);
        core.for_each_column(levels, &strip, |level, index, _| order.push((level, index)), |_| {}).unwrap();
        order
    };
    let two = [
        (0, -1),
        (0, 0),
        (1, -1),
        (0, 1),
        (1, 0),
        (2, -1),
        (1, 1),
        (2, 0),
        (2, 1),
        (0, 2),
        (1, 2),
        (2, 2),
        (2, 3),
        (1, 3),
        (2, 4),
        (2, 5),
    ];
    assert_eq!(order(2), two);
    for levels in 1..=5 {
        let made = order(levels).into_iter().filter(|(level, _)| *level > 0);
        assert!(made.eq(timeline(Schedule::Shared, 1, levels).iter().map(|m| (m.level, m.index))));
    }
}

#[test]
fn every_level_has_its_columns_and_the_output_its_part_of_them() {
    let (width, strips) = strips_of(&of_shape("disc-quads"));
    for limit in [false, true] {
        let core = CcStrip::new(Parameters { limit, ..Parameters::exact(width) }).unwrap();
        for strip in &strips {
            let levels = core.levels(3, strip).unwrap();
            for (level, columns) in levels.iter().enumerate() {
                assert_eq!(columns.len(), (strip.len() << level) + 3);
                assert!(columns.iter().flatten().all(|c| c.rows.len() == (1 << level) + 1));
            }
            let output = core.columns(3, strip).unwrap();
            assert!(output.iter().map(|c| c.index).eq(0..=8 * strip.len()));
            assert!(output.iter().all(|c| c.vertices.len() == 9));
        }
    }
}

/// Fewer levels are the same refinement as in a core for more.
#[test]
fn the_most_levels_of_a_core_change_nothing() {
    let (width, strips) = strips_of(&shaken(spindle(5), 12, 9));
    for numbers in [Numbers::Exact, Numbers::Guard(3)] {
        let of = |max_levels: u32| {
            let core = CcStrip::new(Parameters { max_levels, numbers, ..Parameters::exact(width) }).unwrap();
            core.columns(2, &strips[0]).unwrap()
        };
        assert_eq!(of(2), of(7));
    }
}

#[test]
fn intermediate_vertices_stay_within_their_bits() {
    let mesh = shaken(wheel(7, true), 12, 4);
    let (width, strips) = strips_of(&mesh);
    for numbers in [Numbers::Exact, Numbers::Guard(5)] {
        let core = CcStrip::new(Parameters { numbers, ..Parameters::exact(width) }).unwrap();
        for strip in &strips {
            for (level, columns) in core.levels(4, strip).unwrap().iter().enumerate() {
                let bits = core.vertex_bits(level as u32);
                let range = -(1i128 << (bits - 1))..1 << (bits - 1);
                let outside = |c: &subdiv_rtl::model::cc_strip::level::LevelColumn| {
                    c.outside.iter().flat_map(|o| o.fan.clone()).collect::<Vec<_>>()
                };
                let all = columns.iter().flatten().flat_map(|c| [c.rows.clone(), outside(c)].concat());
                assert!(all.flatten().all(|x| range.contains(&x)), "level {level} {numbers}");
            }
        }
    }
}

#[test]
fn what_a_core_cannot_take_is_refused_with_a_remedy() {
    let exact = Parameters::exact(12);
    let bad = [
        Parameters { width: 33, table_bits: 45, ..exact },
        Parameters { max_levels: 8, ..exact },
        Parameters { max_levels: 0, ..exact },
        Parameters { max_valence: 17, ..exact },
        Parameters { max_valence: 3, ..exact },
        Parameters { numbers: Numbers::Guard(43), ..exact },
        Parameters { extra_fraction: 60, ..exact },
        Parameters { table_bits: 9, ..exact },
    ];
    for parameters in bad {
        assert!(CcStrip::new(parameters).unwrap_err().help.is_some(), "{parameters:?}");
    }
    let refusal = |parameters: Parameters, levels: u32, strip: &StripRecords<[i64; 3]>| {
        let error = CcStrip::new(parameters).unwrap().columns(levels, strip).unwrap_err();
        assert!(error.help.is_some());
        error.what
    };
    let quad = regular_quad(|_, _| 0);
    let (width, strips) = strips_of(&shaken(spindle(9), 12, 1));
    let core = Parameters { max_valence: 8, ..Parameters::exact(width) };
    assert!(strips.iter().any(|strip| strip.largest_valence() == 9));
    let nine = strips.iter().find(|strip| strip.largest_valence() == 9).unwrap();
    assert!(refusal(core, 1, nine).ends_with("has a vertex of valence 9"));
    assert_eq!(refusal(Parameters { max_levels: 3, ..exact }, 4, &quad), "a strip at level 4");
    assert_eq!(refusal(exact, 1, &regular_quad(|c, _| 1500 * c)), "a coordinate that does not fit 12 bits");
    let mut short = quad.clone();
    short.columns[1].outside[0].fan.clear();
    assert_eq!(refusal(exact, 1, &short), "column 1 has 0 fan entries at valence 4");
    let mut rim = quad.clone();
    rim.guards[0] = None;
    assert_eq!(refusal(exact, 1, &rim), "a strip with a rim, for a core without");
    let rims = Parameters { rims: true, ..exact };
    assert_eq!(refusal(rims, 1, &rim), "column 0 has neither a guard nor a gap beside it");
    assert_eq!(refusal(exact, 1, &StripRecords { columns: vec![], ..quad }), "a strip without quads");
}
