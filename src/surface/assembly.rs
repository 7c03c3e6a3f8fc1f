//! Puts the samples of all patches together: one position per vertex of the fine mesh, and the cracks.
//!
//! ```text
//!   patch, (i, j), position  -->  vertex id of the fine grid  -->  first position, or the same again,
//!                                                                  or another one: a crack
//! ```

use crate::surface::fine_grid::FineGrid;
use crate::surface::hierarchy::Patch;
use std::collections::BTreeSet;

/// Collects positions by vertex id.
#[derive(Clone, Debug)]
pub struct Assembly<'a> {
    grid: FineGrid<'a>,
    positions: Vec<Option<[i64; 3]>>,
    /// Positions that differ from the first one of their vertex.
    others: BTreeSet<(usize, [i64; 3])>,
}

impl<'a> Assembly<'a> {
    pub fn new(grid: FineGrid<'a>) -> Self {
        let positions = vec![None; grid.vertex_count()];
        Assembly { grid, positions, others: BTreeSet::new() }
    }

    pub fn grid(&self) -> &FineGrid<'a> {
        &self.grid
    }

    /// Sample p(i, j) of a patch.
    pub fn put<P>(&mut self, patch: &Patch<P>, i: usize, j: usize, position: [i64; 3]) {
        let [u, v] = patch.lattice(i as i32, j as i32);
        let id = self.grid.vertex(patch.face as usize, u as usize, v as usize);
        match self.positions[id] {
            None => self.positions[id] = Some(position),
            Some(known) if known == position => {}
            Some(_) => {
                self.others.insert((id, position));
            }
        }
    }

    /// Distinct pairs of a vertex and a position: the vertex count of the subdivided mesh exactly if every
    /// vertex was delivered and no crack is open.
    pub fn distinct_vertices(&self) -> usize {
        self.positions.iter().flatten().count() + self.others.len()
    }

    /// Vertices that came out at more than one position.
    pub fn cracks(&self) -> usize {
        let mut vertices: Vec<usize> = self.others.iter().map(|&(id, _)| id).collect();
        vertices.dedup(); // sorted by the set
        vertices.len()
    }

    /// How far apart the positions of one vertex lie at most, along an axis, in units of the output.
    pub fn largest_crack(&self) -> i64 {
        let mut most = 0;
        for group in self.others.iter().collect::<Vec<_>>().chunk_by(|a, b| a.0 == b.0) {
            let Some(first) = group.first().and_then(|(id, _)| self.positions[*id]) else { continue };
            for axis in 0..3 {
                let all = group.iter().map(|(_, position)| position[axis]).chain([first[axis]]);
                let (least, greatest) = all.fold((i64::MAX, i64::MIN), |(a, b), x| (a.min(x), b.max(x)));
                most = most.max(greatest - least);
            }
        }
        most
    }

    /// Positions that differ from the first one of their vertex, in the order of the vertices.
    pub fn other_positions(&self) -> impl Iterator<Item = (usize, [i64; 3])> + '_ {
        self.others.iter().copied()
    }

    /// The first vertices (at most `limit`) that came out at more than one position, for a message.
    pub fn first_cracks(&self, limit: usize) -> impl Iterator<Item = (usize, [i64; 3])> + '_ {
        self.others.iter().copied().take(limit)
    }

    /// Vertices that no patch delivered.
    pub fn missing(&self) -> usize {
        self.positions.iter().filter(|p| p.is_none()).count()
    }

    /// One position a vertex, in the order of the ids; none if a vertex is missing.
    pub fn positions(&self) -> Option<Vec<[i64; 3]>> {
        self.positions.iter().copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::control_mesh::ControlMesh;
    use crate::surface::hierarchy::{PatchKind, RootClass};

    #[test]
    fn a_difference_in_one_axis_is_a_crack() {
        let mesh = ControlMesh::new(vec![[0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        let mut assembly = Assembly::new(FineGrid::new(&mesh, 0).unwrap());
        let patch = Patch {
            face: 0,
            kind: PatchKind::Regular,
            class: RootClass::Regular,
            level: 0,
            corners: [[0, 0], [1, 0], [0, 1]],
            points: [[0; 3]; 12],
        };
        assembly.put(&patch, 0, 0, [1, 2, 3]);
        assembly.put(&patch, 0, 0, [1, 2, 3]);
        assert_eq!((assembly.cracks(), assembly.missing(), assembly.distinct_vertices()), (0, 2, 1));
        for axis in 0..3 {
            let mut moved = [1, 2, 3];
            moved[axis] += 1;
            assembly.put(&patch, 0, 0, moved);
        }
        assert_eq!((assembly.cracks(), assembly.distinct_vertices()), (1, 4));
        assert_eq!(assembly.largest_crack(), 1);
        assembly.put(&patch, 0, 0, [1, 0, 3]);
        // From 0 to 3 in y.
        assert_eq!((assembly.largest_crack(), assembly.other_positions().count()), (3, 4));
        assembly.put(&patch, 1, 0, [0; 3]);
        assert_eq!(assembly.positions(), None);
        assembly.put(&patch, 0, 1, [5; 3]);
        assert_eq!(assembly.positions(), Some(vec![[1, 2, 3], [0; 3], [5; 3]]));
    }
}
