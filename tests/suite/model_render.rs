//! The whole way at full size: an irregular mesh of 130 triangles at level 6 through the fast reference.

use crate::surface_meshes::{random_closed, shaken, torus};
use subdiv_rtl::model::loop_fd::LoopFd;
use subdiv_rtl::model::render::render;
use subdiv_rtl::surface::assembly::Assembly;
use subdiv_rtl::surface::error_bound::{Accuracy, error_bound_lsb};
use subdiv_rtl::surface::fine_grid::FineGrid;
use subdiv_rtl::surface::limit_oracle::LimitOracle;
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::table::Table;

const WIDTH: u32 = 24;
const LEVEL: u32 = 6;

#[test]
fn level_six_has_no_cracks_and_keeps_its_bound() {
    let core = LoopFd::new(WIDTH, 0, LEVEL).unwrap();
    let table = Table::for_width(WIDTH).unwrap();
    for (triangles, regular) in [(torus(8, 8), true), (random_closed(67, 2), false)] {
        let mesh = shaken(triangles, WIDTH, 2);
        let mut vertices = Vec::new();
        let counts = render(&mesh, LEVEL, &core, &table, &mut vertices).unwrap();
        assert_eq!(counts.triangles, 4096 * mesh.triangles().len() as u64);

        let mut rest = vertices.iter();
        let mut assembly = Assembly::new(FineGrid::new(&mesh, LEVEL).unwrap());
        patches(&mesh, LEVEL, LEVEL, &table, |patch| {
            let n = 1 << patch.level;
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                assembly.put(patch, i, j, *rest.next().unwrap());
            }
        })
        .unwrap();
        assert!(rest.next().is_none());
        assert_eq!((assembly.cracks(), assembly.missing()), (0, 0));
        assert_eq!(assembly.distinct_vertices(), assembly.grid().vertex_count());

        let oracle = LimitOracle::new(&mesh, LEVEL).unwrap();
        let error = oracle.error(&assembly.positions().unwrap(), 0).unwrap();
        assert_eq!(mesh.largest_irregular_valence().is_none(), regular);
        assert!(!regular || error.at_most_half, "{error:?}");
        let bound = error_bound_lsb(&Accuracy {
            width: WIDTH,
            extra_fraction: 0,
            level: LEVEL,
            table_bits: table.bits(),
            largest_irregular_valence: mesh.largest_irregular_valence(),
        });
        assert!(error.max <= bound && (error.rms - 0.2887).abs() < 0.001, "{error:?}, bound {bound}");
        println!("max {}, rms {}, bound {bound}", error.max, error.rms);
    }
}

#[test]
fn a_buffer_may_be_used_again() {
    let core = LoopFd::new(12, 0, 3).unwrap();
    let table = Table::for_width(12).unwrap();
    let [large, small] = [torus(6, 5), torus(4, 3)].map(|t| shaken(t, 12, 3));
    let (mut reused, mut fresh) = (Vec::new(), Vec::new());
    render(&large, 3, &core, &table, &mut reused).unwrap();
    render(&small, 2, &core, &table, &mut reused).unwrap();
    render(&small, 2, &core, &table, &mut fresh).unwrap();
    assert_eq!(reused, fresh);
}
