//! Sweeps: what the prepared mesh measures is what the slow way measures, no error is above its bound, and
//! the control points made for it come near.

use crate::surface_meshes;

use crate::surface_meshes::{shaken, zoo};
use subdiv_rtl::fixed::{Fractions, Precision, Reduced, Rounding};
use subdiv_rtl::model::loop_fd::LoopFd;
use subdiv_rtl::model::render::render;
use subdiv_rtl::model::sweep::Prepared;
use subdiv_rtl::surface::assembly::Assembly;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::error_bound::{Accuracy, error_bound_lsb};
use subdiv_rtl::surface::fine_grid::FineGrid;
use subdiv_rtl::surface::limit_oracle::LimitOracle;
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::precision::worst::{self, Side};
use subdiv_rtl::surface::precision::{of_patch, total_lsb};
use subdiv_rtl::surface::table::Table;

fn reduced(fractions: &str, rounding: Rounding, saturate: bool) -> Reduced {
    Reduced { fractions: fractions.parse().unwrap(), rounding, saturate }
}

fn bound(mesh: &ControlMesh, width: u32, extra: i32, level: u32, table: &Table, precision: Precision) -> f64 {
    let exact = error_bound_lsb(&Accuracy {
        width,
        extra_fraction: extra,
        level,
        table_bits: table.bits(),
        largest_irregular_valence: mesh.largest_irregular_valence(),
    });
    precision.reduced().map_or(exact, |reduced| exact - 0.5 + total_lsb(reduced, level, extra))
}

#[test]
fn a_sweep_measures_what_the_slow_way_measures_and_no_error_exceeds_its_bound() {
    let (width, level, table) = (16, 3, Table::for_width(16).unwrap());
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, width, 9);
        let prepared = Prepared::new(&mesh, level, &table).unwrap();
        let oracle = LimitOracle::new(&mesh, level).unwrap();
        let mut buffer = vec![];
        for (fractions, extra) in [("8", 0), ("11", 2), ("5,8,8,8,9", 0), ("3,4,4,6,7", -2), ("1", 0)] {
            for rounding in Rounding::TOTAL {
                let precision = Precision::Reduced(reduced(fractions, rounding, extra == 0));
                let measured = prepared.measure(width, extra, precision, &mut buffer).unwrap();
                let core = LoopFd::new(width, extra, 5).unwrap().with_precision(precision).unwrap();
                let mut vertices = vec![];
                render(&mesh, level, &core, &table, &mut vertices).unwrap();
                assert!(buffer == vertices, "{name}, {precision}");

                let mut assembly = Assembly::new(FineGrid::new(&mesh, level).unwrap());
                let mut vertex = vertices.iter();
                patches(&mesh, level, 5, &table, |patch| {
                    let n = patch.steps() as usize;
                    for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                        assembly.put(patch, i, j, *vertex.next().unwrap());
                    }
                })
                .unwrap();
                assert_eq!(measured.cracks, assembly.cracks(), "{name}, {precision}");
                assert_eq!(measured.largest_crack, assembly.largest_crack(), "{name}, {precision}");
                let first = oracle.error(&assembly.positions().unwrap(), extra).unwrap().max;
                let others = assembly.other_positions().map(|(v, p)| oracle.vertex_error(v, p, extra));
                let max = others.fold(first, f64::max);
                assert!((measured.max - max).abs() <= 2.0 * measured.uncertainty + 1e-12, "{name}");
                let bound = bound(&mesh, width, extra, level, &table, precision);
                assert!(measured.max <= bound + measured.uncertainty, "{name}, {precision}: {measured:?}");
                assert!(f64::from(measured.largest_crack as i32) <= 2.0 * bound, "{name}, {precision}");
            }
        }
        let exact = prepared.measure(width, 0, Precision::Exact, &mut buffer).unwrap();
        assert_eq!((exact.cracks, exact.largest_crack), (0, 0));
        assert!(exact.rms <= exact.max && exact.max <= 0.5625, "{name}: {exact:?}");
    }
}

#[test]
fn outputs_that_do_not_fit_are_refused() {
    let mesh = shaken(surface_meshes::tetrahedron(), 16, 1);
    let prepared = Prepared::new(&mesh, 2, &Table::for_width(16).unwrap()).unwrap();
    let mut buffer = vec![];
    assert!(prepared.measure(mesh.width() - 1, 0, Precision::Exact, &mut buffer).is_err());
    let coarse = Precision::Reduced(reduced("2", Rounding::Floor, false));
    assert!(prepared.measure(16, 3, coarse, &mut buffer).is_err());
}

#[test]
fn derived_control_points_reach_the_bound_through_the_reference() {
    for (level, half) in [(4, 13), (5, 17), (6, 21), (7, 25), (8, 29)] {
        for fraction in [half - 6, half - 1, half, half + 2] {
            let format = Reduced::new(Fractions::uniform(fraction).unwrap());
            let case = worst::points(format, level, 20, Side::Above).unwrap();
            // With all fraction bits in the output nothing is rounded at last.
            let core = LoopFd::new(20, fraction as i32, level).unwrap();
            let core = core.with_precision(Precision::Reduced(format)).unwrap();
            let points = case.points.map(|x| [x.into(), 0, 0]);
            let mut last = 0;
            core.for_each_beat(level, &points, |beat| {
                last = beat.right.map_or(last, |right| right[0]);
            })
            .unwrap();
            // p(n, 0) is the only right vertex of the last strip.
            let exact: f64 = subdiv_rtl::surface::basis::mask(level, 1 << level, 0)
                .iter()
                .zip(case.points)
                .map(|(&m, p)| m as f64 * p as f64)
                .sum::<f64>()
                / subdiv_rtl::surface::basis::denominator(level) as f64;
            let error = last as f64 / f64::from(fraction).exp2() - exact;
            let bound = of_patch(format, level).largest().to_f64_up();
            assert!((case.error_lsb(fraction) - error).abs() < 1e-6 * bound.max(1.0));
            assert!(error >= 0.9 * bound && error <= bound * (1.0 + 1e-9), "level {level}, F = {fraction}");
        }
    }
}

#[test]
fn derived_control_points_as_a_mesh_reach_the_whole_bound() {
    let mut buffer = vec![];
    for (level, fraction) in [(4, 13), (5, 17), (6, 21), (7, 25), (8, 29)] {
        let format = Reduced::new(Fractions::uniform(fraction).unwrap());
        let [above, below] =
            [Side::Above, Side::Below].map(|side| worst::points(format, level, 20, side).unwrap().points);
        let mesh = worst::mesh([&above, &below, &above]).unwrap();
        let prepared = Prepared::new(&mesh, level, &Table::for_width(20).unwrap()).unwrap();
        let measured = prepared.measure(20, 0, Precision::Reduced(format), &mut buffer).unwrap();
        let bound = total_lsb(format, level, 0);
        assert!(measured.max >= 0.9 * bound, "level {level}: {} of {bound}", measured.max);
    }
}
