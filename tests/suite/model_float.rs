//! The published algorithm in floating point, beside fixed point: the figures are those that the number of
//! bits lets expect.

use subdiv_rtl::fixed::{Precision, Reduced};
use subdiv_rtl::mesh::{quantise, shape};
use subdiv_rtl::model::float::{Float, Half, deviation, deviation_of_core};
use subdiv_rtl::model::loop_fd::LoopFd;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::table::Table;

/// A built-in shape within [-1, 1] in Q2.22.
fn control(name: &str) -> ControlMesh {
    let mesh = shape(name).unwrap();
    let quantised = quantise(&mesh, "Q2.22".parse().unwrap()).unwrap();
    ControlMesh::new(quantised.positions, mesh.triangles().unwrap()).unwrap()
}

/// A floating-point number as wide as the reference needs: the algorithm itself must be right.
#[derive(Clone, Copy, Default)]
struct Double(f64);

impl Float for Double {
    const ZERO: Self = Double(0.0);
    fn rounded(x: f64) -> Self {
        Double(x)
    }
    fn plus(self, other: Self) -> Self {
        Double(self.0 + other.0)
    }
    fn minus(self, other: Self) -> Self {
        Double(self.0 - other.0)
    }
    fn times(self, other: Self) -> Self {
        Double(self.0 * other.0)
    }
    fn wide(self) -> f64 {
        self.0
    }
}

#[test]
fn double_precision_shows_that_the_scheme_is_right() {
    for name in ["tetrahedron", "torus", "blob"] {
        let found = deviation::<Double>(&control(name), 5, (-22f64).exp2());
        assert!(found.relative < 1e-13 && found.absolute < 1e-6, "{name}: {found:?}");
    }
}

#[test]
fn single_precision_loses_bits_with_the_level_and_half_precision_fails() {
    let unit = (-22f64).exp2();
    // (The tetrahedron is no example: its coordinates are multiples of 3, which makes twelfths exact.)
    for name in ["torus", "blob"] {
        let mesh = control(name);
        let single: Vec<f64> = (1..=8).map(|level| deviation::<f32>(&mesh, level, unit).relative).collect();
        let half: Vec<f64> = (1..=6).map(|level| deviation::<Half>(&mesh, level, unit).relative).collect();
        println!("{name}: f32 {single:?}");
        println!("{name}: f16 {half:?}");
        // About an ulp at first, several ulps later.
        assert!(single[0] < 1e-6 && single[7] > 2.0 * single[0] && single[7] < 1e-4, "{name}: {single:?}");
        // 2^13 times coarser at first; differences of fine levels drown.
        assert!(half[0] > 100.0 * single[0] && half[5] > 0.005, "{name}: {half:?}");
    }
}

#[test]
fn fixed_point_is_off_by_its_last_place_at_every_level() {
    let table = Table::for_width(24).unwrap();
    for name in ["torus", "blob"] {
        let mesh = control(name);
        for level in [2, 5] {
            let exact = LoopFd::new(24, 0, level).unwrap();
            let found = deviation_of_core(&mesh, level, &exact, &table).unwrap();
            // Half a unit along each axis.
            assert!(found.absolute > 0.3 && found.absolute <= 0.75f64.sqrt() + 1e-6, "{name}: {found:?}");
            let fine = LoopFd::new(24, 8, level).unwrap();
            let finer = deviation_of_core(&mesh, level, &fine, &table).unwrap();
            assert!(finer.relative < found.relative / 100.0, "{name}: {finer:?}");
        }
        let reduced = Precision::Reduced(Reduced::new("8,12,14,17,18".parse().unwrap()));
        let core = LoopFd::new(24, 0, 5).unwrap().with_precision(reduced).unwrap();
        let found = deviation_of_core(&mesh, 5, &core, &table).unwrap();
        assert!(found.absolute <= 3f64.sqrt(), "{name}: {found:?}");
    }
}
