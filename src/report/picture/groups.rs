//! Groups of triangles, such as the strips that a mesh was cut into: where they border, and which colour each gets.
//!
//! ```text
//!   ▒▒▒▒▒▒▒▒
//!   ░░░░│▓▓▓     neighbours differ: each group takes the first colour that no neighbour before it has
//!   ░░░░│▓▓▓
//! ```

use super::colour::STRIPS;
use std::collections::{BTreeMap, BTreeSet};

/// The edges between triangles of different groups, each once, with the two groups.
pub fn borders<G: Copy + Ord>(triangles: &[[u32; 3]], groups: &[G]) -> Vec<([u32; 2], [G; 2])> {
    let mut edges: Vec<([u32; 2], G)> = Vec::with_capacity(3 * triangles.len());
    for (&[a, b, c], group) in triangles.iter().zip(groups) {
        edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], *group)));
    }
    edges.sort_unstable();
    let differ = |pair: &&[([u32; 2], G)]| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1;
    edges.windows(2).filter(differ).map(|pair| (pair[0].0, [pair[0].1, pair[1].1])).collect()
}

/// The number of each group's colour, below [`STRIPS`]. Where a group has too many neighbours, one of them has its
/// colour; the border between them is drawn anyway.
pub fn colours(triangles: &[[u32; 3]], groups: &[u32]) -> BTreeMap<u32, usize> {
    let mut neighbours: BTreeMap<u32, BTreeSet<u32>> = groups.iter().map(|&g| (g, BTreeSet::new())).collect();
    for (_, [a, b]) in borders(triangles, groups) {
        neighbours.entry(a).or_default().insert(b);
        neighbours.entry(b).or_default().insert(a);
    }
    let mut colours = BTreeMap::new();
    for (&group, beside) in &neighbours {
        let taken: BTreeSet<usize> = beside.iter().filter_map(|b| colours.get(b).copied()).collect();
        // Where to begin looking differs, so that all colours are used.
        let order = (0..STRIPS).map(|k| (group as usize + k) % STRIPS);
        let free = order.clone().find(|colour| !taken.contains(colour));
        colours.insert(group, free.unwrap_or(group as usize % STRIPS));
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of n triangles around vertex 0, each a group of its own number.
    fn fan(n: u32) -> Vec<[u32; 3]> {
        (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect()
    }

    #[test]
    fn neighbours_differ_and_borders_are_found_once() {
        // The numbers of neighbours differ by the number of colours, so that they begin with the same one.
        let groups: Vec<u32> = (0..6).map(|i| i * STRIPS as u32).collect();
        let found = borders(&fan(6), &groups);
        assert_eq!(found.len(), 6);
        let colours = colours(&fan(6), &groups);
        for (edge, [a, b]) in found {
            assert_eq!(edge[0], 0);
            assert_ne!(colours[&a], colours[&b], "{a} and {b}");
        }
    }

    #[test]
    fn one_group_has_no_border() {
        assert!(borders(&fan(5), &[3; 5]).is_empty());
        assert_eq!(colours(&fan(5), &[3; 5]).len(), 1);
    }
}
