//! Puts the vertices of all strips together: one position per vertex of the fine mesh, and the cracks.
//!
//! ```text
//!   vertex id of the fine grid, position  -->  first position, or the same again, or another one: a crack
//! ```

use crate::surface::catmull_clark::fine_grid::QuadGrid;
use std::collections::BTreeSet;

/// Collects positions by vertex id.
#[derive(Clone, Debug)]
pub struct QuadAssembly<'a> {
    grid: QuadGrid<'a>,
    positions: Vec<Option<[i64; 3]>>,
    /// Positions that differ from the first one of their vertex.
    others: BTreeSet<(usize, [i64; 3])>,
}

impl<'a> QuadAssembly<'a> {
    pub fn new(grid: QuadGrid<'a>) -> Self {
        let positions = vec![None; grid.vertex_count()];
        QuadAssembly { grid, positions, others: BTreeSet::new() }
    }

    pub fn grid(&self) -> &QuadGrid<'a> {
        &self.grid
    }

    /// The position of a vertex of the fine grid.
    pub fn put(&mut self, vertex: usize, position: [i64; 3]) {
        match self.positions[vertex] {
            None => self.positions[vertex] = Some(position),
            Some(known) if known == position => {}
            Some(_) => {
                self.others.insert((vertex, position));
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

    /// The first vertices (at most `limit`) that came out at more than one position, for a message.
    pub fn first_cracks(&self, limit: usize) -> impl Iterator<Item = (usize, [i64; 3])> + '_ {
        self.others.iter().copied().take(limit)
    }

    /// Vertices that no strip delivered.
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
    use crate::surface::catmull_clark::quad_mesh::QuadMesh;

    #[test]
    fn a_vertex_at_two_positions_is_a_crack() {
        let mesh = QuadMesh::new(vec![[0; 3]; 4], vec![[0, 1, 2, 3]]).unwrap();
        let mut assembly = QuadAssembly::new(QuadGrid::new(&mesh, 0).unwrap());
        (0..4).for_each(|v| assembly.put(v, [v as i64, 2, 3]));
        assembly.put(1, [1, 2, 3]);
        assert_eq!((assembly.cracks(), assembly.distinct_vertices(), assembly.missing()), (0, 4, 0));
        [7, 7, 8].iter().for_each(|&x| assembly.put(1, [x; 3]));
        assert_eq!((assembly.cracks(), assembly.distinct_vertices()), (1, 6));
        assert_eq!(assembly.positions().unwrap()[1], [1, 2, 3]);
    }
}
