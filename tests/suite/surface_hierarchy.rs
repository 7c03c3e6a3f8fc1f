//! The patch hierarchy on every kind of mesh: no cracks, nothing missing, and the right surface.

use crate::surface_meshes::{assembled, bipyramid, shaken, sheet, tetrahedron, torus, zoo};
use num_rational::BigRational;
use num_traits::Zero;
use subdiv_rtl::surface::arithmetic::{Arithmetic, Real};
use subdiv_rtl::surface::basis;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::fine_grid::FineGrid;
use subdiv_rtl::surface::hierarchy::{Counts, PatchKind, walk};
use subdiv_rtl::surface::limit_oracle::LimitOracle;
use subdiv_rtl::surface::loop_masks::{alpha_rational, gamma_rational};
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::table::Table;

#[test]
fn every_vertex_comes_out_at_one_position_and_none_is_missing() {
    let table = Table::for_width(16).unwrap();
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 16, 7);
        for level in 0..=4 {
            // 12 extra bits: a crack of a 4096th unit would show
            let assembly = assembled(&mesh, level, level, &table, 12);
            assert_eq!(assembly.cracks(), 0, "{name}, level {level}");
            assert_eq!(assembly.missing(), 0, "{name}, level {level}");
            assert_eq!(assembly.distinct_vertices(), assembly.grid().vertex_count(), "{name}, level {level}");
        }
    }
}

#[test]
fn the_surface_does_not_depend_on_the_maximum_level_of_the_core() {
    let table = Table::for_width(16).unwrap();
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 16, 8);
        let [own, larger] = [2, 9].map(|max_level| assembled(&mesh, 2, max_level, &table, 6).positions());
        assert!(own.is_some() && own == larger, "{name}");
    }
}

#[test]
fn triangles_of_the_control_mesh_are_counted_by_class() {
    let counts = |mesh: &ControlMesh, level| {
        patches(mesh, level, level, &Table::for_width(8).unwrap(), |_| {}).unwrap()
    };
    let mesh = shaken(torus(5, 4), 8, 1);
    let expected = Counts { regular: 40, regular_packets: 40, triangles: 40 * 64, ..Counts::default() };
    assert_eq!(counts(&mesh, 3), expected);
    // a tetrahedron at level 3, each face: 1 middle patch, and 3 corners of 3 patches at levels 1 and 0
    // and one triangle
    let mesh = shaken(tetrahedron(), 8, 1);
    let expected = Counts {
        irregular: 4,
        regular_packets: 4 * 19,
        one_packets: 12,
        triangles: 4 * 64,
        ..Counts::default()
    };
    assert_eq!(counts(&mesh, 3), expected);
    // a sheet: regular inside and at straight boundaries, corners of valence 2 and 3
    let mesh = shaken(sheet(5, 4), 8, 1);
    let counts = counts(&mesh, 0);
    assert_eq!((counts.regular, counts.semi_regular, counts.irregular), (18, 6, 0));
    assert_eq!((counts.regular_packets, counts.one_packets), (0, 24));
}

#[test]
fn packets_come_in_the_same_order_with_corners_on_the_grid() {
    let mesh = shaken(bipyramid(5), 12, 3);
    let table = Table::for_width(12).unwrap();
    let run = || {
        let mut all = Vec::new();
        patches(&mesh, 3, 3, &table, |patch| all.push(patch.clone())).unwrap();
        all
    };
    let all = run();
    assert_eq!(all, run());
    for patch in &all {
        let n = patch.steps();
        for [u, v] in patch.corners {
            assert!(u >= 0 && v >= 0 && u + v <= 8 && u % n == 0 && v % n == 0);
        }
        if patch.kind == PatchKind::One {
            assert_eq!(patch.level, 0);
        }
    }
}

#[test]
fn words_that_are_too_narrow_are_refused() {
    use subdiv_rtl::surface::packets::patches_of;
    let mesh = shaken(tetrahedron(), 24, 1);
    let table = Table::for_width(24).unwrap();
    assert!(patches_of::<i64>(&mesh, 2, 9, &table, |_| {}).is_ok());
    assert!(patches_of::<i64>(&mesh, 2, 10, &table, |_| {}).is_err());
    assert!(patches(&mesh, 2, 10, &table, |_| {}).is_ok());
    assert!(patches(&mesh, 3, 2, &table, |_| {}).is_err());
    assert!(patches(&mesh, 3, 11, &table, |_| {}).is_err());
}

#[test]
fn in_floating_point_patches_lie_on_the_globally_subdivided_surface() {
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 20, 9);
        let size = f64::from(1 << 19);
        for level in 0..=4 {
            let oracle = LimitOracle::new(&mesh, level).unwrap();
            let grid = FineGrid::new(&mesh, level).unwrap();
            let point = |v: u32| mesh.positions()[v as usize].map(|x| x as f64 / size);
            let mut largest = 0.0f64;
            walk(&Real, &mesh, level, point, |patch| {
                let denominator = basis::denominator(patch.level) as f64;
                let n = patch.steps();
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    let mask = basis::mask(patch.level, i as u32, j as u32);
                    let [u, v] = patch.lattice(i, j).map(|x| x as usize);
                    let expected = oracle.position(grid.vertex(patch.face as usize, u, v));
                    for x in 0..3 {
                        let sum: f64 = patch.points.iter().zip(mask).map(|(p, w)| p[x] * w as f64).sum();
                        largest = largest.max((sum / denominator - expected[x] / size).abs());
                    }
                }
            });
            assert!(largest <= 1e-13, "{name}, level {level}: {largest:e}");
        }
    }
}

/// The rules in rationals, for meshes of valences 3, 4 and 6.
struct Rational;

type Q = BigRational;
#[derive(Clone, Debug, PartialEq)]
struct Scalar(Q);

impl Default for Scalar {
    fn default() -> Self {
        Scalar(Q::zero())
    }
}

fn q(x: i64) -> Q {
    Q::from_integer(x.into())
}

fn widened(x: num_rational::Ratio<i64>) -> Q {
    Q::new((*x.numer()).into(), (*x.denom()).into())
}

impl Rational {
    fn towards_ring(v: &Scalar, ring: &[Scalar], total: num_rational::Ratio<i64>) -> Q {
        let n = q(ring.len() as i64);
        let sum: Q = ring.iter().map(|c| c.0.clone()).sum();
        &v.0 + widened(total) / &n * (sum - &n * &v.0)
    }
}

impl Arithmetic for Rational {
    type Point = Scalar;

    fn edge(&self, a: &Scalar, b: &Scalar, c: &Scalar, d: &Scalar) -> Scalar {
        Scalar((q(3) * (&a.0 + &b.0) + &c.0 + &d.0) / q(8))
    }
    fn boundary_edge(&self, a: &Scalar, b: &Scalar) -> Scalar {
        Scalar((&a.0 + &b.0) / q(2))
    }
    fn vertex(&self, v: &Scalar, ring: &[Scalar]) -> Scalar {
        Scalar(Self::towards_ring(v, ring, alpha_rational(ring.len()).unwrap()))
    }
    fn boundary_vertex(&self, a: &Scalar, v: &Scalar, b: &Scalar) -> Scalar {
        Scalar((&a.0 + q(6) * &v.0 + &b.0) / q(8))
    }
    fn limit12(&self, v: &Scalar, ring: &[Scalar]) -> Scalar {
        Scalar(q(12) * Self::towards_ring(v, ring, gamma_rational(ring.len()).unwrap()))
    }
    fn boundary_limit12(&self, a: &Scalar, v: &Scalar, b: &Scalar) -> Scalar {
        Scalar(q(2) * (&a.0 + q(4) * &v.0 + &b.0))
    }
    fn ghost(&self, v: &Scalar, b: &Scalar, i: &Scalar) -> Scalar {
        Scalar(&v.0 + &b.0 - &i.0)
    }
}

/// In rationals two routes to one point must meet exactly: patches of different depth share vertices, and
/// the oracle refines globally. This proves the basis against subdivision, not just to rounding.
#[test]
fn in_rationals_patches_meet_the_globally_subdivided_surface_exactly() {
    for (name, triangles) in [("tetrahedron", tetrahedron()), ("sheet", sheet(5, 4)), ("torus", torus(4, 4))]
    {
        let mesh = shaken(triangles, 10, 5);
        let level = 3;
        let oracle = LimitOracle::new(&mesh, level).unwrap();
        let grid = FineGrid::new(&mesh, level).unwrap();
        let scale = num_bigint::BigInt::from(12) << subdiv_rtl::surface::limit_oracle::FRACTION;
        // the oracle rounds irregular vertices to 2^-90 (times 12 in its scale)
        let tolerance = num_bigint::BigInt::from(if name == "torus" || name == "sheet" { 0 } else { 48 });
        walk(
            &Rational,
            &mesh,
            level,
            |v| Scalar(q(mesh.positions()[v as usize][0])),
            |patch| {
                let n = patch.steps();
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    let mask = basis::mask(patch.level, i as u32, j as u32);
                    let sum: Q = patch.points.iter().zip(mask).map(|(p, w)| &p.0 * q(w)).sum();
                    let scaled = sum / q(basis::denominator(patch.level)) * Q::from_integer(scale.clone());
                    let [u, v] = patch.lattice(i, j).map(|x| x as usize);
                    let expected = oracle.limit12(grid.vertex(patch.face as usize, u, v))[0];
                    let difference = scaled - Q::from_integer(expected.into());
                    let bound = Q::from_integer(tolerance.clone());
                    assert!(
                        difference <= bound && -difference <= bound,
                        "{name}: p({i}, {j}) of face {}",
                        patch.face
                    );
                }
            },
        );
    }
}
