//! The finishing stage of cc-strip: limit positions, normals and unit vectors, bit for bit against the reference, on
//! windows of real meshes and on random extreme ones.

use crate::cc_meshes::{Random, of_shape};
use crate::cc_stage::{Case, FRACTION, Stage, case, random_window, windows};
use subdiv_rtl::cores::cc_strip::finish::{self, Kind, Parameters};
use subdiv_rtl::fixed::Rounding;
use subdiv_rtl::hdl::Word;
use subdiv_rtl::model::cc_strip::around::Three;
use subdiv_rtl::model::cc_strip::{CcStrip, Parameters as Reference, normals};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;

#[test]
fn windows_of_meshes_are_finished_as_the_reference_does() {
    let normals = [
        None,
        Some((Kind::Faces, 4, None)),
        Some((Kind::Limit, 2, None)),
        Some((Kind::Faces, 6, Some(14))),
        Some((Kind::Limit, 5, Some(14))),
    ];
    for name in ["cube-quads", "torus-quads", "blob-quads", "double-torus-quads"] {
        let mesh = of_shape(name);
        for (normals, numbers) in
            normals.into_iter().flat_map(|n| [(n, Numbers::Exact), (n, Numbers::Guard(6))])
        {
            let limit = normals.is_none_or(|(kind, ..)| kind == Kind::Limit);
            let mut stage = Stage::new(Case { numbers, limit, normals, max_valence: 10, ..case() });
            for level in 1..=3 {
                let mut windows = windows(&stage.reference, &mesh, level);
                windows.truncate(60);
                assert!(windows.len() > 5);
                stage.run(level, &windows).unwrap();
            }
        }
    }
}

#[test]
fn extreme_windows_are_finished_as_the_reference_does() {
    let cases = [
        case(),
        Case { width: 24, levels: [2, 2], max_valence: 16, extra_fraction: 12, ..case() },
        Case { width: 8, levels: [1, 1], max_valence: 4, extra_fraction: -3, ..case() },
        Case { width: 32, levels: [1, 2], numbers: Numbers::Guard(5), extra_fraction: -10, ..case() },
        Case { limit: false, normals: Some((Kind::Faces, 11, None)), max_valence: 16, ..case() },
        Case { width: 24, normals: Some((Kind::Limit, 3, None)), max_valence: 16, ..case() },
        Case { width: 32, normals: Some((Kind::Limit, -6, Some(16))), ..case() },
        Case { width: 12, normals: Some((Kind::Faces, 0, Some(8))), levels: [1, 4], ..case() },
        Case { width: 4, normals: Some((Kind::Faces, 0, Some(14))), levels: [1, 1], ..case() },
    ];
    for case in cases {
        let mut stage = Stage::new(case);
        let mut random = Random(u64::from(case.width));
        for level in case.levels[0]..=case.levels[1] {
            let windows: Vec<_> = (0..200).map(|_| random_window(&case, level, &mut random)).collect();
            stage.run(level, &windows).unwrap();
        }
    }
}

/// A point of all equal coordinates has no normal: zero stays zero.
#[test]
fn flat_windows_have_no_normal() {
    for kind in [Kind::Faces, Kind::Limit] {
        let case = Case { normals: Some((kind, 4, Some(14))), ..case() };
        let mut stage = Stage::new(case);
        let mut random = Random(3);
        let mut window = random_window(&case, 2, &mut random);
        for column in &mut window {
            column.rows.iter_mut().for_each(|p| *p = [5 << 12; 3]);
            for outside in &mut column.outside {
                *outside = outside.map(&mut |_| [5 << 12; 3]);
            }
        }
        stage.run(2, &[window.clone()]).unwrap();
        let [p, c, n] = &window;
        let three = Three { previous: Some(p), column: c, next: Some(n) };
        assert!(stage.reference.finish(2, 0, three).normals.iter().flatten().all(|&x| x == 0));
    }
}

/// Counterclockwise quads of a convex solid: normals point away from its middle.
#[test]
fn normals_point_outwards() {
    let mesh = of_shape("cube-quads");
    for kind in [Kind::Faces, Kind::Limit] {
        let stage = Stage::new(Case { normals: Some((kind, 4, Some(14))), ..case() });
        for [p, c, n] in &windows(&stage.reference, &mesh, 3) {
            let output = stage.reference.finish(3, 0, Three { previous: Some(p), column: c, next: Some(n) });
            for (v, normal) in output.vertices.iter().zip(&output.normals) {
                let along: i64 = v.iter().zip(normal).map(|(v, n)| v * n).sum();
                let length = v.iter().map(|v| (v * v) as f64).sum::<f64>().sqrt();
                let cosine = along as f64 / length / 16384.0;
                assert!(cosine > 0.8, "{kind:?}: {v:?} {normal:?}");
            }
        }
    }
}

#[test]
fn what_a_stage_cannot_do_is_refused_with_a_remedy() {
    let good = case().parameters();
    let normals = |kind, point_fraction, unit| Some(finish::Normals { kind, point_fraction, unit });
    let bad = [
        Parameters { rounding: Rounding::Exact, ..good },
        Parameters { output: Word::signed(16).fraction(FRACTION + 40), ..good },
        // -1/2^16 of 16 bits becomes 13 bits: the largest number is rounded up.
        Parameters { output: Word::signed(13).fraction(FRACTION - 3), ..good },
        Parameters { normals: normals(Kind::Faces, 40, None), ..good },
        Parameters { normals: normals(Kind::Limit, FRACTION as u32 + 14, None), ..good },
        Parameters { normals: normals(Kind::Faces, FRACTION as u32, Some(7)), ..good },
        Parameters { normals: normals(Kind::Faces, FRACTION as u32, Some(17)), ..good },
    ];
    assert!(good.check().is_ok());
    for parameters in bad {
        let error = parameters.check().unwrap_err();
        assert!(error.help.is_some(), "{error:?}");
    }
    let exact = Reference { width: 16, ..Reference::exact(16) };
    let normals = |kind, extra_fraction, unit| Some(normals::Normals { kind, extra_fraction, unit });
    for (normals, rims) in [
        (normals(normals::Kind::Faces, 0, None), true),
        (normals(normals::Kind::Limit, 14, None), false),
        (normals(normals::Kind::Faces, 43, None), false),
        (normals(normals::Kind::Faces, -15, None), false),
        (normals(normals::Kind::Faces, 0, Some(17)), false),
    ] {
        let error = CcStrip::new(Reference { normals, rims, ..exact }).unwrap_err();
        assert!(error.help.is_some(), "{error:?}");
    }
}
