//! All strips of a mesh, rendered by the reference, are the mesh of the oracle: no crack, no missing vertex,
//! errors within the proven bound, and no error at all where the rules are exact.

use crate::cc_meshes::{closed, of_mesh, open, ragged, shaken, wheel};
use std::path::Path;
use subdiv_rtl::fixed::Rounding;
use subdiv_rtl::mesh;
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters};
use subdiv_rtl::surface::catmull_clark::assembly::QuadAssembly;
use subdiv_rtl::surface::catmull_clark::error_bound::{Accuracy, error_bound_lsb};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::oracle::{QuadOracle, Target};
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

struct Case<'a> {
    name: &'a str,
    mesh: &'a QuadMesh,
    rings: Rings,
    boundary: Boundary,
}

impl<'a> Case<'a> {
    fn new(name: &'a str, mesh: &'a QuadMesh, boundary: Boundary) -> Self {
        Case { name, mesh, rings: Rings::new(mesh, boundary).unwrap(), boundary }
    }

    fn oracle(&self, levels: u32) -> QuadOracle {
        QuadOracle::new(self.mesh, levels, self.boundary.corners()).unwrap()
    }

    /// Renders without cracks and holes.
    fn render(&self, method: Method, levels: u32, change: impl Fn(&mut Parameters)) -> Rendered<'a> {
        let mut parameters = Parameters::exact(self.rings.width());
        parameters.rims = self.boundary == Boundary::Rim;
        change(&mut parameters);
        let core = CcStrip::new(parameters).unwrap();
        let assembly = core.render(self.mesh, &self.rings, &cut(self.mesh, method), levels).unwrap();
        let what = format!("{} {:?} level {levels} {parameters:?}", self.name, self.boundary);
        assert_eq!((assembly.cracks(), assembly.missing()), (0, 0), "{what}");
        Rendered { assembly, parameters, what }
    }
}

struct Rendered<'a> {
    assembly: QuadAssembly<'a>,
    parameters: Parameters,
    what: String,
}

impl Rendered<'_> {
    fn positions(&self) -> Vec<[i64; 3]> {
        self.assembly.positions().unwrap()
    }

    /// Every output lies within the bound of the true position; returns the largest error.
    fn check(&self, oracle: &QuadOracle, largest_irregular_valence: Option<usize>) -> f64 {
        let Parameters { width, numbers, rounding, table_bits, extra_fraction, limit, .. } = self.parameters;
        let levels = self.assembly.grid().level();
        let bound = error_bound_lsb(&Accuracy {
            width,
            extra_fraction,
            levels,
            numbers,
            rounding,
            table_bits,
            largest_irregular_valence,
            limit,
        });
        let target = if limit { Target::Limit } else { Target::Refined };
        let error = oracle.error(&self.positions(), target, extra_fraction).unwrap();
        assert!(error.max <= bound + error.uncertainty, "{}: {} above {bound}", self.what, error.max);
        error.max
    }
}

/// Every mesh with every way to complete its boundary that it admits.
fn cases(meshes: &[(&'static str, QuadMesh)], test: impl Fn(&Case)) {
    for (name, mesh) in meshes {
        for boundary in [Boundary::Ghosts, Boundary::Rim] {
            let closed = mesh.topology().boundary_loops().is_empty();
            if (boundary == Boundary::Rim && closed) || Rings::new(mesh, boundary).is_err() {
                continue;
            }
            test(&Case::new(name, mesh, boundary));
        }
    }
}

fn zoo() -> Vec<(&'static str, QuadMesh)> {
    closed().into_iter().chain(open()).chain(ragged()).collect()
}

#[test]
fn the_zoo_is_rendered_within_the_bound_in_every_format() {
    let formats = [Numbers::Exact, Numbers::Guard(0), Numbers::Guard(3), Numbers::Guard(6)];
    cases(&zoo(), |case| {
        for levels in 1..=3 {
            let oracle = case.oracle(levels);
            for numbers in formats {
                for (limit, rounding) in [false, true].into_iter().zip([Rounding::HalfUp; 2]).chain([
                    (false, Rounding::HalfEven),
                    (false, Rounding::Floor),
                    (true, Rounding::Truncate),
                ]) {
                    let rendered = case.render(Method::Natural, levels, |p| {
                        (p.numbers, p.limit, p.rounding) = (numbers, limit, rounding);
                    });
                    rendered.check(&oracle, Some(case.rings.largest_valence()));
                }
            }
        }
    });
}

#[test]
fn every_cut_gives_the_same_positions() {
    cases(&zoo(), |case| {
        for numbers in [Numbers::Exact, Numbers::Guard(2)] {
            let of = |method| {
                let rendered = case.render(method, 2, |p| (p.numbers, p.extra_fraction) = (numbers, 2));
                rendered.positions()
            };
            let natural = of(Method::Natural);
            assert!(natural == of(Method::Walk) && natural == of(Method::FewestNeighbours), "{}", case.name);
        }
    });
}

/// Rules of regular meshes are exact: with all fraction bits in the output nothing is off.
#[test]
fn regular_meshes_are_exact_in_the_exact_format() {
    let mut cases_seen = 0;
    for (name, mesh) in zoo() {
        for boundary in [Boundary::Ghosts, Boundary::Rim] {
            let Ok(rings) = Rings::new(&mesh, boundary) else { continue };
            let topology = mesh.topology();
            let regular = |v: u32| topology.is_boundary(v) || topology.valence(v) == 4;
            if !(0..topology.vertex_count()).all(regular) || rings.width() > 20 {
                continue;
            }
            let case = Case::new(name, &mesh, boundary);
            for levels in 1..=4 {
                let rendered = case.render(Method::Natural, levels, |p| p.extra_fraction = 6 * levels as i32);
                let oracle = case.oracle(levels);
                let error = oracle.error(&rendered.positions(), Target::Refined, 6 * levels as i32).unwrap();
                assert_eq!(error.max, 0.0, "{}", rendered.what);
            }
            cases_seen += 1;
        }
    }
    assert!(cases_seen > 20, "{cases_seen}");
}

/// kappa of 8 and 16 is a power of two, so only the rounding to 6 bits a level remains.
#[test]
fn valences_eight_and_sixteen_need_no_table() {
    for d in [8, 16] {
        let mesh = shaken(wheel(d, false), 12, u64::from(d)); // all other inner vertices have valence 4
        let case = Case::new("wheel", &mesh, Boundary::Ghosts);
        let coarse = case.render(Method::Natural, 3, |p| (p.extra_fraction, p.table_bits) = (18, 10));
        let fine = case.render(Method::Natural, 3, |p| (p.extra_fraction, p.table_bits) = (18, 40));
        assert!(coarse.positions() == fine.positions(), "valence {d}");
    }
}

#[test]
fn ghosts_and_rims_are_the_same_surface_where_every_boundary_vertex_is_regular() {
    let mut seen = 0;
    for (name, mesh) in open() {
        let topology = mesh.topology();
        if (0..topology.vertex_count()).any(|v| topology.is_boundary(v) && topology.valence(v) != 3) {
            continue;
        }
        seen += 1;
        for (levels, limit) in (1..=3).flat_map(|levels| [(levels, false), (levels, true)]) {
            let ghosts = Case::new(name, &mesh, Boundary::Ghosts);
            let rims = Case::new(name, &mesh, Boundary::Rim);
            let of = |case: &Case| {
                let format = |p: &mut Parameters| (p.extra_fraction, p.limit, p.table_bits) = (4, limit, 40);
                case.render(Method::Natural, levels, format).positions().concat()
            };
            // the limits of ghosts and of rims have other weights, 1/36 and 1/6, so that a tie can go both ways
            let off = of(&ghosts).iter().zip(of(&rims)).map(|(a, b)| (a - b).abs()).max();
            assert!(off <= Some(i64::from(limit)), "{name} level {levels} limit {limit}");
        }
    }
    assert!(seen >= 5);
}

#[test]
fn deep_levels_stay_within_the_bound() {
    for (name, mesh) in closed().iter().filter(|(name, _)| ["cube", "torus 3x3", "spindle 5"].contains(name))
    {
        let case = Case::new(name, mesh, Boundary::Ghosts);
        for levels in 5..=6 {
            let oracle = case.oracle(levels);
            for (numbers, limit) in [(Numbers::Exact, true), (Numbers::Guard(3), false)] {
                let rendered =
                    case.render(Method::Natural, levels, |p| (p.numbers, p.limit) = (numbers, limit));
                let most = rendered.check(&oracle, mesh.largest_irregular_valence());
                assert!(numbers != Numbers::Exact || most <= 0.5 + 1.0 / 16.0);
            }
        }
    }
}

/// The widest coordinates at the deepest level, on the largest fan.
#[test]
fn nothing_overflows_at_32_bits_and_seven_levels() {
    let mesh = shaken(wheel(15, false), 29, 7);
    let case = Case::new("wheel", &mesh, Boundary::Ghosts);
    assert!(case.rings.width() >= 31);
    let oracle = case.oracle(7);
    for limit in [false, true] {
        let rendered =
            case.render(Method::Natural, 7, |p| (p.limit, p.width, p.table_bits) = (limit, 32, 45));
        rendered.check(&oracle, Some(15));
    }
}

#[test]
fn shared_meshes_are_rendered_within_half_a_unit_and_a_sixteenth() {
    let folder = Path::new("../shared/meshes");
    if !folder.is_dir() {
        println!("skipped: there is no {}", folder.display());
        return;
    }
    for name in ["cube", "torus_quad", "disc_quad", "square_quad", "spot_cc"] {
        let mesh = of_mesh(&mesh::read(&folder.join(format!("{name}.obj"))).unwrap(), 20);
        cases(&[("file", mesh)], |case| {
            for levels in 1..=4 {
                let oracle = case.oracle(levels);
                for limit in [false, true] {
                    let rendered = case.render(Method::Natural, levels, |p| p.limit = limit);
                    let most = rendered.check(&oracle, Some(case.rings.largest_valence()));
                    println!("{name} {:?} level {levels} limit {limit}: {most:.4} lsb", case.boundary);
                    assert!(most <= 0.5 + 1.0 / 16.0);
                }
            }
        });
    }
}
