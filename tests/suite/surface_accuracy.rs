//! The true error of every output vertex against the limit surface.

use crate::surface_meshes;

use crate::surface_meshes::{assembled, shaken, zoo};
use subdiv_rtl::surface::error_bound::{Accuracy, error_bound_lsb};
use subdiv_rtl::surface::limit_oracle::LimitOracle;
use subdiv_rtl::surface::table::Table;

#[test]
fn every_mesh_keeps_its_proven_bound_and_regular_ones_are_correctly_rounded() {
    let (mut regular, mut irregular) = (0, 0);
    for (name, triangles) in zoo() {
        for (width, seed) in [(8, 11), (24, 12)] {
            let mesh = shaken(triangles.clone(), width, seed);
            let table = Table::for_width(width).unwrap();
            for level in 0..=4 {
                let outputs = assembled(&mesh, level, level, &table, 0).positions().unwrap();
                let error = LimitOracle::new(&mesh, level).unwrap().error(&outputs, 0).unwrap();
                let bound = error_bound_lsb(&Accuracy {
                    width,
                    extra_fraction: 0,
                    level,
                    table_bits: table.bits(),
                    largest_irregular_valence: mesh.largest_irregular_valence(),
                });
                let place = format!("{name}, width {width}, level {level}: {error:?}");
                assert!(error.max <= bound && bound <= 0.5 + 1.0 / 16.0, "{place}, bound {bound}");
                assert!(error.uncertainty < 1e-25, "{place}");
                // uniformly distributed roundings: 1/sqrt(12)
                assert!(outputs.len() < 500 || (error.rms - 0.2887).abs() < 0.02, "{place}");
                if mesh.largest_irregular_valence().is_none() {
                    assert!(error.at_most_half && error.uncertainty == 0.0, "{place}");
                    regular += 1;
                } else {
                    irregular += 1;
                }
            }
        }
    }
    assert!(regular >= 40 && irregular >= 80, "{regular} regular and {irregular} irregular runs");
}

#[test]
fn a_coarse_table_is_noticed() {
    // 8 bits for coordinates of 24: the error is far beyond a unit, and the bound says so
    let mesh = shaken(surface_meshes::bipyramid(7), 24, 3);
    let table = Table::new(8).unwrap();
    let outputs = assembled(&mesh, 2, 2, &table, 0).positions().unwrap();
    let error = LimitOracle::new(&mesh, 2).unwrap().error(&outputs, 0).unwrap();
    let bound = error_bound_lsb(&Accuracy {
        width: 24,
        extra_fraction: 0,
        level: 2,
        table_bits: 8,
        largest_irregular_valence: Some(7),
    });
    assert!(error.max > 100.0 && error.max < bound, "{} of {bound}", error.max);
}

#[test]
fn extra_fraction_bits_scale_the_error() {
    let mesh = shaken(surface_meshes::torus(4, 3), 10, 4);
    let table = Table::for_width(10).unwrap();
    for extra_fraction in [-6, -1, 0, 3, 9] {
        let outputs = assembled(&mesh, 2, 2, &table, extra_fraction).positions().unwrap();
        let error = LimitOracle::new(&mesh, 2).unwrap().error(&outputs, extra_fraction).unwrap();
        assert!(error.at_most_half && error.max > 0.3, "f = {extra_fraction}: {error:?}");
    }
}
