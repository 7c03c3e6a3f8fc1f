//! Figure 16: operations per triangle by level, counted while the mesh is evaluated.
//!
//! ```text
//!   subdivision and projection of the hierarchy   by the rules
//!   a regular patch of level r > 0                start-up, 9 a column, 8 a row of a strip: 79 + 9n + 4n(n+1)
//!   a regular patch of level 0                    three limit masks
//!   with masks                                    levels 1 and 2 vertex by vertex where that is cheaper
//! ```
//!
//! A row of a strip steps two columns, as the published loop does.

use super::counted::{Counter, Vector};
use crate::mesh::Mesh;
use crate::surface::basis;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::hierarchy::{Patch, PatchKind, walk};

/// What one evaluation took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operations {
    pub level: u32,
    pub triangles: u64,
    /// Forward differences from level 1 on.
    pub differences: u64,
    /// Explicit masks at levels 1 and 2 where they take less.
    pub with_masks: u64,
}

/// Evaluates the mesh at a level and counts. `vertex` sees each sample: patch, i, j, position.
pub fn count(
    mesh: &Mesh,
    control: &ControlMesh,
    level: u32,
    mut vertex: impl FnMut(&Patch<Vector<f64>>, usize, usize, Vector<f64>),
) -> Operations {
    let (rules, engine) = (Counter::default(), Counter::default());
    let mut masks = 0;
    let point = |v: u32| mesh.positions[v as usize].to_array();
    let counts = walk(&rules, control, level, point, |patch| {
        let before = engine.operations();
        match (patch.kind, patch.level) {
            (PatchKind::One, _) => {
                for (i, j, p) in [(0, 0, 0), (1, 0, 2), (0, 1, 10)] {
                    vertex(patch, i, j, patch.points[p].map(|x| x / 12.0));
                }
            }
            (PatchKind::Regular, 0) => {
                for (i, j) in [(0, 0), (1, 0), (0, 1)] {
                    vertex(patch, i, j, by_mask(&engine, 0, i, j, &patch.points));
                }
            }
            (PatchKind::Regular, _) => by_differences(&engine, patch, &mut vertex),
        }
        let taken = engine.operations() - before;
        masks += match (patch.kind, patch.level) {
            (PatchKind::Regular, 1 | 2) => {
                let counter = Counter::default();
                let n = 1usize << patch.level;
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    by_mask(&counter, patch.level, i, j, &patch.points);
                }
                taken.min(counter.operations())
            }
            _ => taken,
        };
    });
    Operations {
        level,
        triangles: counts.triangles,
        differences: rules.operations() + engine.operations(),
        with_masks: rules.operations() + masks,
    }
}

/// A sample by its mask: control points of equal weight are added before they are multiplied.
fn by_mask(counter: &Counter, level: u32, i: usize, j: usize, points: &[Vector<f64>; 12]) -> Vector<f64> {
    let mask = basis::mask(level, i as u32, j as u32);
    let denominator = basis::denominator(level) as f64;
    let mut groups: std::collections::BTreeMap<i64, Vector<f64>> = std::collections::BTreeMap::new();
    for (&weight, &point) in mask.iter().zip(points).filter(|(weight, _)| **weight != 0) {
        groups.entry(weight).and_modify(|sum| *sum = counter.plus(*sum, point)).or_insert(point);
    }
    let terms = groups.into_iter().map(|(weight, sum)| counter.times(weight as f64 / denominator, sum));
    terms.reduce(|sum, term| counter.plus(sum, term)).unwrap_or_default()
}

/// The strips of a patch, as the published loop runs over them.
fn by_differences(
    counter: &Counter,
    patch: &Patch<Vector<f64>>,
    vertex: &mut impl FnMut(&Patch<Vector<f64>>, usize, usize, Vector<f64>),
) {
    let n = 1usize << patch.level;
    let scale = 1.0 / basis::denominator(patch.level) as f64;
    let mut outer = counter.start_up(patch.level, &patch.points).scaled(scale);
    for i in 0..n {
        let mut left = outer.column();
        let fourth = outer.row3[1];
        counter.step(&mut outer);
        let mut right = outer.column();
        for j in 0..n - i {
            vertex(patch, i, j, left[0]);
            vertex(patch, i + 1, j, right[0]);
            counter.step_column(&mut left, fourth);
            counter.step_column(&mut right, fourth);
        }
        vertex(patch, i, n - i, left[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{quantise, shape};
    use crate::surface::fine_grid::FineGrid;
    use crate::surface::limit_oracle::LimitOracle;

    fn counted(name: &str, level: u32) -> (f64, Operations) {
        let mesh = shape(name).unwrap();
        let positions = quantise(&mesh, "Q2.12".parse().unwrap()).unwrap().positions;
        let control = ControlMesh::new(positions, mesh.triangles().unwrap()).unwrap();
        let (grid, oracle) =
            (FineGrid::new(&control, level).unwrap(), LimitOracle::new(&control, level).unwrap());
        let mut largest = 0.0f64;
        let operations = count(&mesh, &control, level, |patch, i, j, position| {
            let [u, v] = patch.lattice(i as i32, j as i32);
            let exact = oracle.position(grid.vertex(patch.face as usize, u as usize, v as usize));
            for x in 0..3 {
                largest = largest.max((position[x] - exact[x] / 4096.0).abs());
            }
        });
        (largest, operations)
    }

    /// What was counted was the evaluation of the surface, and it takes what the formulas say.
    #[test]
    fn the_counted_run_evaluates_the_surface() {
        let expected = [
            ("torus", [24.0, 30.25, 12.1875, 6.859_375, 5.121]),
            ("tetrahedron", [15.0, 36.75, 46.8, 34.4, 17.5]),
        ];
        for (name, per_triangle) in expected {
            for (level, expected) in per_triangle.into_iter().enumerate() {
                let (error, operations) = counted(name, level as u32);
                assert!(error < 1e-11, "{name} level {level}: {error}");
                let found = operations.differences as f64 / operations.triangles as f64;
                assert!((found - expected).abs() < 0.05, "{name} level {level}: {found}");
                assert!(operations.with_masks <= operations.differences);
            }
        }
    }

    #[test]
    fn masks_pay_at_the_coarsest_levels() {
        let (_, operations) = counted("torus", 1);
        assert!(operations.with_masks * 3 < operations.differences * 2, "{operations:?}");
        let (_, operations) = counted("torus", 3);
        assert_eq!(operations.with_masks, operations.differences);
    }
}
