//! How true the normals of strips are: the angle of face and limit normals to the normal of the limit surface, on
//! closed shapes, level by level; and that strips that share a vertex agree on its normal.

use crate::cc_meshes::{of_shape, shaken, spindle};
use subdiv_rtl::model::cc_strip::normals::{Kind, Normals};
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters};
use subdiv_rtl::surface::catmull_clark::fine_grid::QuadGrid;
use subdiv_rtl::surface::catmull_clark::masks::Corners;
use subdiv_rtl::surface::catmull_clark::normal_oracle::{angle, limit_normals};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::oracle::QuadOracle;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::records::positioned;
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

/// Whether two strips may say this of one vertex: limit normals of irregular vertices differ by the roundings of
/// their tangents, all others are the same integers.
fn agree(regular: bool, kind: Kind, a: [i64; 3], b: [i64; 3]) -> bool {
    let close = || angle(a.map(|c| c as f64), b.map(|c| c as f64)) < 0.02;
    a == b || (kind == Kind::Limit && !regular && close())
}

/// Whether a vertex of the fine grid has valence 4: only control vertices, its first ones, can have another.
fn is_regular(mesh: &QuadMesh, v: usize) -> bool {
    v >= mesh.topology().vertex_count() as usize || mesh.topology().valence(v as u32) == 4
}

/// The normal of every vertex of the fine grid; all strips that have the vertex must agree.
fn normals(mesh: &QuadMesh, method: Method, level: u32, numbers: Numbers, normals: Normals) -> Vec<[i64; 3]> {
    let rings = Rings::new(mesh, Boundary::Ghosts).unwrap();
    let parameters =
        Parameters { numbers, normals: Some(normals), ..Parameters::exact(rings.width().max(16)) };
    let core = CcStrip::new(parameters).unwrap();
    let grid = QuadGrid::new(mesh, level).unwrap();
    let mut found: Vec<Option<[i64; 3]>> = vec![None; grid.vertex_count()];
    let strips = cut(mesh, method);
    for (strip, records) in strips.iter().zip(positioned(mesh, &rings, &strips)) {
        for column in core.columns(level, &records).unwrap() {
            for (row, normal) in column.normals.iter().enumerate() {
                let vertex = strip.fine_vertex(&grid, column.index, row);
                let other = found[vertex].replace(*normal).unwrap_or(*normal);
                let same = agree(is_regular(mesh, vertex), normals.kind, other, *normal);
                assert!(same, "strips differ at vertex {vertex}: {other:?} {normal:?}");
            }
        }
    }
    found.into_iter().map(|normal| normal.expect("every vertex lies on a strip")).collect()
}

#[test]
fn strips_agree_on_the_normals_that_they_share_however_a_mesh_is_cut() {
    for mesh in [of_shape("blob-quads"), shaken(spindle(9), 12, 4), shaken(spindle(3), 12, 5)] {
        for kind in [Kind::Faces, Kind::Limit] {
            for (extra_fraction, unit) in [(0, None), (6, None), (6, Some(14))] {
                // The tangents of irregular vertices are rounded to the unit of the points.
                if kind == Kind::Limit && extra_fraction == 0 {
                    continue;
                }
                for numbers in [Numbers::Exact, Numbers::Guard(6)] {
                    let wanted = Normals { kind, extra_fraction, unit };
                    let [natural, walked] = [Method::Natural, Method::Walk]
                        .map(|method| normals(&mesh, method, 2, numbers, wanted));
                    for (v, (a, b)) in natural.into_iter().zip(walked).enumerate() {
                        assert!(agree(is_regular(&mesh, v), kind, a, b), "vertex {v}: {a:?} {b:?}");
                    }
                }
            }
        }
    }
}

/// The largest and the mean angle to the true normals, in degrees.
fn angles(mesh: &QuadMesh, level: u32, found: &[[i64; 3]], regular_only: bool) -> [f64; 2] {
    let oracle = QuadOracle::new(mesh, level, Corners::Smooth).unwrap();
    let grid = QuadGrid::new(mesh, level).unwrap();
    let exact = limit_normals(&oracle, &grid);
    let angles: Vec<f64> = (0..found.len())
        .filter(|&v| !regular_only || is_regular(mesh, v))
        .filter_map(|v| Some(angle(found[v].map(|c| c as f64), exact[v]?)))
        .collect();
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    [angles.iter().copied().fold(0.0, f64::max), mean]
}

const SHAPES: [&str; 4] = ["torus-quads", "blob-quads", "cube-quads", "double-torus-quads"];

#[test]
fn angles_to_the_normals_of_the_limit_surface() {
    println!("degrees, largest and mean: points of 8 extra fraction bits, coordinates of 14 bits");
    for name in SHAPES {
        let mesh = of_shape(name);
        let mut before = [f64::MAX; 2];
        for level in 1..=5 {
            let of = |kind, unit| {
                let wanted = Normals { kind, extra_fraction: 8.min(6 * level as i32), unit };
                let found = normals(&mesh, Method::Natural, level, Numbers::Exact, wanted);
                angles(&mesh, level, &found, false)
            };
            let (faces, limit) = (of(Kind::Faces, None), of(Kind::Limit, None));
            let unit = of(Kind::Limit, Some(14));
            println!(
                "{name} level {level}: faces {:.3} {:.4}, limit {:.3} {:.4}, limit over 2^14 {:.3} {:.4}",
                faces[0], faces[1], limit[0], limit[1], unit[0], unit[1]
            );
            // The limit's are truer, and both get better with every level.
            assert!(limit[1] <= faces[1] + 0.001, "{name} {level}");
            // Until the rounding of the points is all that is left. (A cube has level 1 by its symmetry.)
            let better = level <= 2 || faces[1] < before[0];
            assert!(better && limit[1] < before[1].max(0.01), "{name} {level}");
            assert!(limit[0] < 0.03 && unit[0] < 0.03, "{name} {level}");
            before = [faces[1], limit[1]];
        }
    }
}

/// With all fraction bits in the points nothing is rounded, and t1 x t2 is the normal of the surface.
#[test]
fn limit_normals_of_regular_vertices_are_exact() {
    for name in ["torus-quads", "blob-quads"] {
        let mesh = of_shape(name);
        let wanted = Normals { kind: Kind::Limit, extra_fraction: 6, unit: None };
        let found = normals(&mesh, Method::Natural, 1, Numbers::Exact, wanted);
        let [most, _] = angles(&mesh, 1, &found, true);
        // Vertices that the table replaced are rounded to these bits, too, and so are off by a little.
        let bound = if name == "torus-quads" { 1e-6 } else { 0.01 };
        println!("{name}: {most:e} degrees");
        assert!(most < bound, "{name}: {most}");
    }
}
