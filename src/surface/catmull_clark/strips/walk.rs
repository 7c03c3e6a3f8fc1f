//! The two cutting algorithms of the thesis: a walk across opposite edges until it cannot go on.
//!
//! ```text
//!   walk                from the first free quad, in the direction of its first edge
//!   fewest neighbours   from a free quad with the fewest free neighbours,
//!                       towards the free neighbour that itself has the fewest
//! ```
//!
//! The thesis picks a random quad; here ties and choices go by number, so that the strips are the same on every
//! run. A walk that comes back to its first quad closes the strip. Source: Hall, section 4.6.

use super::{Strip, across};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use std::collections::BTreeSet;

/// From each quad that is still free, in one direction.
pub fn walk(mesh: &QuadMesh) -> Vec<Strip> {
    let mut free = vec![true; mesh.quads().len()];
    let mut strips = Vec::new();
    for quad in 0..free.len() {
        if free[quad] {
            strips.push(follow(mesh, 4 * quad as u32, &mut free));
        }
    }
    strips
}

/// Goes on from the quad that `half_edge` belongs to, marking quads as taken.
fn follow(mesh: &QuadMesh, half_edge: u32, free: &mut [bool]) -> Strip {
    let mut half_edges = Vec::new();
    let mut next = Some(half_edge);
    while let Some(h) = next.filter(|&h| free[h as usize / 4]) {
        free[h as usize / 4] = false;
        half_edges.push(h);
        next = across(mesh, h);
    }
    Strip { closed: next == Some(half_edge), half_edges }
}

/// The improved walk.
pub fn fewest_neighbours(mesh: &QuadMesh) -> Vec<Strip> {
    let mut free = vec![true; mesh.quads().len()];
    let mut degree: Vec<usize> =
        (0..free.len() as u32).map(|q| mesh.topology().face_neighbours(q).flatten().count()).collect();
    let mut queue: BTreeSet<(usize, u32)> = degree.iter().copied().zip(0..).collect();
    let mut strips = Vec::new();
    while let Some(&(_, quad)) = queue.first() {
        let strip = follow(mesh, direction(mesh, quad, &free, &degree), &mut free);
        for taken in strip.quads() {
            queue.remove(&(degree[taken as usize], taken));
        }
        for neighbour in strip.quads().flat_map(|q| mesh.topology().face_neighbours(q).flatten()) {
            if free[neighbour as usize] {
                let degree = &mut degree[neighbour as usize];
                queue.remove(&(*degree, neighbour));
                *degree -= 1;
                queue.insert((*degree, neighbour));
            }
        }
        strips.push(strip);
    }
    strips
}

/// The half-edge by which to enter `quad` so that the walk leaves it towards the neighbour with the fewest free
/// neighbours.
fn direction(mesh: &QuadMesh, quad: u32, free: &[bool], degree: &[usize]) -> u32 {
    let open = |exit: &u32| {
        let neighbour = mesh.topology().opposite(*exit)? as usize / 4;
        free[neighbour].then_some((degree[neighbour], *exit))
    };
    let exits = 4 * quad..4 * quad + 4;
    exits.clone().filter_map(|exit| open(&exit)).min().map_or(4 * quad, |(_, exit)| exit ^ 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(columns: u32, rows: u32) -> QuadMesh {
        let at = |x: u32, y: u32| y * (columns + 1) + x;
        let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let quads = cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect();
        QuadMesh::new(vec![[0; 3]; ((columns + 1) * (rows + 1)) as usize], quads).unwrap()
    }

    #[test]
    fn the_walk_goes_straight_until_the_boundary() {
        // half-edge 0 of a cell runs along the lower side, so the walk goes up
        let strips = walk(&sheet(3, 2));
        assert_eq!(strips.iter().map(Strip::len).collect::<Vec<_>>(), [2, 2, 2]);
        assert_eq!(strips[0].quads().collect::<Vec<_>>(), [0, 3]);
    }

    #[test]
    fn the_improvement_goes_where_fewest_are_left() {
        let strips = fewest_neighbours(&sheet(4, 3));
        assert_eq!(strips[0].quads().next(), Some(0));
        // both directions lead to quads of degree 3, and the lower exit wins: to the right
        assert_eq!(strips[0].quads().collect::<Vec<_>>(), [0, 1, 2, 3]);
        // now all corners of the rest have degree 2, and from corner 4 the fewest are in corner 8
        assert_eq!(strips[1].quads().collect::<Vec<_>>(), [4, 8]);
        assert_eq!(strips.len(), 5);
    }
}
