//! The true normals of the limit surface at the vertices of the fine mesh, by the tangent masks of their rings.
//!
//! ```text
//!   every quad (S, A_i, D_i, A_i+1) at S says which spoke follows A_i    ─► the ring, counterclockwise
//!   t1, t2 = sum of the masks' weights times the ring   ─► t1 x t2 / |t1 x t2|, outwards
//! ```
//!
//! Positions are those of the [oracle](QuadOracle), taken relative to S before they become `f64`, so a direction is
//! wrong by about 2^-50. A boundary vertex has no closed ring and gets none.

use std::collections::BTreeMap;

use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::masks::tangents;
use crate::surface::catmull_clark::oracle::QuadOracle;

/// A unit vector for every inner vertex of the fine grid; none on the boundary, and where the surface has none.
pub fn limit_normals(oracle: &QuadOracle, grid: &QuadGrid) -> Vec<Option<[f64; 3]>> {
    // Of each vertex: spoke -> (the diagonal behind it, the next spoke).
    let mut rings: Vec<BTreeMap<u32, (u32, u32)>> = vec![BTreeMap::new(); grid.vertex_count()];
    for quad in grid.quads() {
        for i in 0..4 {
            let [s, a, x, next] = [0, 1, 2, 3].map(|k| quad[(i + k) % 4]);
            rings[s as usize].insert(a, (x, next));
        }
    }
    rings.iter().enumerate().map(|(s, ring)| normal(oracle, s, ring)).collect()
}

fn normal(oracle: &QuadOracle, s: usize, ring: &BTreeMap<u32, (u32, u32)>) -> Option<[f64; 3]> {
    let centre = oracle.refined(s);
    let relative = |v: u32| -> [f64; 3] {
        let p = oracle.refined(v as usize);
        [0, 1, 2].map(|x| (p[x] - centre[x]) as f64)
    };
    let masks = tangents(ring.len());
    let mut t = [[0.0; 3]; 2];
    let first = *ring.keys().next()?;
    let mut spoke = first;
    for i in 0..ring.len() {
        // A boundary vertex lacks the quad behind its last spoke.
        let &(x, next) = ring.get(&spoke)?;
        let (a, x) = (relative(spoke), relative(x));
        for (t, mask) in t.iter_mut().zip(&masks) {
            (0..3).for_each(|axis| t[axis] += mask[i][0] * a[axis] + mask[i][1] * x[axis]);
        }
        spoke = next;
    }
    if spoke != first {
        return None;
    }
    let cross: [f64; 3] = std::array::from_fn(|x| {
        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
        t[0][y] * t[1][z] - t[0][z] * t[1][y]
    });
    let length = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 0.0).then(|| cross.map(|c| c / length))
}

/// The angle between two vectors in degrees; 180 where one of them is zero.
pub fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross: [f64; 3] = std::array::from_fn(|x| {
        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
        a[y] * b[z] - a[z] * b[y]
    });
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length(a) == 0.0 || length(b) == 0.0 {
        return 180.0;
    }
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    length(cross).atan2(dot).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::catmull_clark::masks::Corners;
    use crate::surface::catmull_clark::quad_mesh::QuadMesh;

    /// Twice as wide as deep and high: the planes through its middle are planes of symmetry.
    #[test]
    fn a_box_has_normals_along_its_axes() {
        let side = |bit: i64| if bit == 0 { -1 } else { 1 };
        let positions = (0..8).map(|i: i64| [2000 * side(i & 1), 1000 * side(i & 2), -1000 * side(i & 4)]);
        let quads = vec![[0, 1, 3, 2], [2, 3, 7, 6], [6, 7, 5, 4], [4, 5, 1, 0], [1, 5, 7, 3], [2, 6, 4, 0]];
        let mesh = QuadMesh::new(positions.collect(), quads).expect("a mesh");
        for level in 1..=4 {
            let oracle = QuadOracle::new(&mesh, level, Corners::Smooth).expect("an oracle");
            let grid = QuadGrid::new(&mesh, level).expect("a grid");
            let normals = limit_normals(&oracle, &grid);
            let middle = |quad: usize| normals[grid.vertex(quad, 1 << (level - 1), 1 << (level - 1))];
            let axes = [[0, 0, 1], [0, 1, 0], [0, 0, -1], [0, -1, 0], [1, 0, 0], [-1, 0, 0]];
            for (quad, axis) in axes.iter().enumerate() {
                assert!(angle(middle(quad).expect("a normal"), axis.map(f64::from)) < 1e-9, "{quad} {level}");
            }
            // Everywhere outwards.
            for (v, normal) in normals.iter().enumerate() {
                let p = oracle.refined(v).map(|x| x as f64);
                assert!(angle(p, normal.expect("a normal")) < 60.0, "{v} {level}");
            }
        }
    }

    #[test]
    fn a_boundary_has_no_normals_and_a_plane_has_one() {
        let quads = vec![[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
        let positions = (0..9).map(|i: i64| [i % 3 * 90, i / 3 * 70, i % 3 * 90]).collect();
        let mesh = QuadMesh::new(positions, quads).expect("a mesh");
        let oracle = QuadOracle::new(&mesh, 0, Corners::Smooth).expect("an oracle");
        let grid = QuadGrid::new(&mesh, 0).expect("a grid");
        let normals = limit_normals(&oracle, &grid);
        assert_eq!(normals.iter().flatten().count(), 1);
        assert!(angle(normals[4].expect("the middle"), [-1.0, 0.0, 1.0]) < 1e-9);
        assert_eq!(angle([0.0; 3], [1.0, 0.0, 0.0]), 180.0);
    }
}
