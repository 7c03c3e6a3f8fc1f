//! The strips against a second reference in integers: the whole mesh subdivided at once with the same
//! roundings. Every position must be the same, bit for bit, so neither fans nor guards nor the order of the
//! columns leave a trace.

use crate::cc_meshes::{closed, open, ragged};
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters};
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};
use subdiv_rtl::surface::catmull_clark::table::Table;

type Point = [i128; 3];

fn half_up(p: Point, shift: u32) -> Point {
    p.map(|x| if shift == 0 { x } else { (x + (1 << (shift - 1))) >> shift })
}

fn add(sum: &mut Point, factor: i128, p: &Point) {
    (0..3).for_each(|x| sum[x] += factor * p[x]);
}

/// One level of the whole mesh: `more` fraction bits are added, and each new vertex is rounded once.
fn subdivide(p: &[Point], coarse: &QuadGrid, fine: &QuadGrid, more: u32, table: &Table) -> Vec<Point> {
    // by vertex: 6 sum A + sum D, valence, boundary neighbours;  by edge: faces, ends, number of faces
    let mut spread = vec![([0; 3], 0usize, [0; 3], 0); p.len()];
    let mut edges = vec![([0; 3], [0; 3], 0); fine.vertex_count()];
    let mut new = vec![[0; 3]; fine.vertex_count()];
    let (n, quads) = (coarse.steps(), coarse.mesh().quads().len());
    let places = || (0..quads).flat_map(move |q| (0..n * n).map(move |i| (q, i / n, i % n)));
    for (q, u, v) in places() {
        let lattice = [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]];
        let ids = lattice.map(|[u, v]| coarse.vertex(q, u, v));
        let mut face = [0; 3];
        ids.iter().for_each(|&id| add(&mut face, 1, &p[id]));
        new[fine.vertex(q, 2 * u + 1, 2 * v + 1)] = half_up(face.map(|x| x << more), 2);
        for i in 0..4 {
            let (next, diagonal) = (ids[(i + 1) % 4], ids[(i + 2) % 4]);
            add(&mut spread[ids[i]].0, 6, &p[next]);
            add(&mut spread[ids[i]].0, 1, &p[diagonal]);
            spread[ids[i]].1 += 1;
            let ([a, b], [c, d]) = (lattice[i], lattice[(i + 1) % 4]);
            let edge = &mut edges[fine.vertex(q, a + c, b + d)];
            add(&mut edge.0, 1, &face);
            edge.1 = p[ids[i]];
            add(&mut edge.1, 1, &p[next]);
            edge.2 += 1;
        }
    }
    for (q, u, v) in places() {
        let lattice = [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]];
        for i in 0..4 {
            let ([a, b], [c, d]) = (lattice[i], lattice[(i + 1) % 4]);
            if edges[fine.vertex(q, a + c, b + d)].2 == 1 {
                let ends = [coarse.vertex(q, a, b), coarse.vertex(q, c, d)];
                for [v, w] in [ends, [ends[1], ends[0]]] {
                    add(&mut spread[v].2, 1, &p[w]);
                    spread[v].3 += 1;
                }
            }
        }
    }
    for (q, u, v) in (0..quads).flat_map(|q| (0..=n).flat_map(move |u| (0..=n).map(move |v| (q, u, v)))) {
        let id = coarse.vertex(q, u, v);
        let (around, d, rim, rims) = spread[id];
        new[fine.vertex(q, 2 * u, 2 * v)] = if rims > 0 {
            let mut sum = rim;
            add(&mut sum, 6, &p[id]);
            half_up(sum.map(|x| x << more), 3)
        } else {
            let mut sum = around;
            add(&mut sum, -7 * d as i128, &p[id]);
            let sum = [0, 1, 2].map(|x| (p[id][x] << table.bits()) + i128::from(table.kappa(d)) * sum[x]);
            half_up(sum.map(|x| x << more), table.bits())
        };
    }
    for (new, (faces, ends, count)) in new.iter_mut().zip(edges) {
        match count {
            0 => {}
            1 => *new = half_up(ends.map(|x| x << more), 1),
            _ => {
                let mut sum = faces;
                add(&mut sum, 4, &ends);
                *new = half_up(sum.map(|x| x << more), 4);
            }
        }
    }
    new
}

fn global(mesh: &QuadMesh, levels: u32, numbers: Numbers, table: &Table) -> Vec<Point> {
    let start = |p: &[i64; 3]| p.map(|x| i128::from(x) << numbers.fraction(0));
    let mut positions: Vec<Point> = mesh.positions().iter().map(start).collect();
    for level in 0..levels {
        let grids = [level, level + 1].map(|level| QuadGrid::new(mesh, level).unwrap());
        let more = numbers.fraction(level + 1) - numbers.fraction(level);
        positions = subdivide(&positions, &grids[0], &grids[1], more, table);
    }
    positions
}

#[test]
fn strips_and_the_whole_mesh_round_to_the_same_integers() {
    let meshes: Vec<_> = closed().into_iter().chain(open()).chain(ragged()).collect();
    for (name, mesh) in &meshes {
        for numbers in [Numbers::Exact, Numbers::Guard(0), Numbers::Guard(4)] {
            let levels = 3;
            let rings = Rings::new(mesh, Boundary::Rim).unwrap();
            let core = CcStrip::new(Parameters {
                numbers,
                extra_fraction: numbers.fraction(levels) as i32,
                rims: true,
                table_bits: 20,
                ..Parameters::exact(rings.width())
            })
            .unwrap();
            let assembly = core.render(mesh, &rings, &cut(mesh, Method::Natural), levels).unwrap();
            let expected = global(mesh, levels, numbers, core.table());
            let got = assembly.positions().unwrap();
            let differs = got.iter().zip(&expected).position(|(a, b)| a.map(i128::from) != *b);
            assert_eq!((differs, got.len()), (None, expected.len()), "{name} {numbers}");
        }
    }
}
