//! A cut with few strips: every quad chooses one of its two axes, and neighbours that choose along the edge
//! between them are linked.
//!
//! ```text
//!   ┌───┬───┬───┐      a link needs both:   ─┼─ │ ─┼─   linked        ─┼─ │  │    not linked
//!   │ ─ │ ─ │ │ │
//!   └───┴───┴───┘      strips = quads - links + closed strips
//! ```
//!
//! A chord is the longest row of quads across opposite edges; each quad lies on two (or twice on one).
//!
//! 1. Greedy: the longest free run of any chord becomes a strip, until no quad is free.
//! 2. Chord by chord: with all other choices fixed, the choices along one chord that give the most links are
//!    found exactly (a chain: link or cross links, quad by quad), until no chord improves.
//! 3. Shaken: a stretch of some chord is turned along it and step 2 taken again; kept unless that makes more
//!    strips. The stretches come from a fixed sequence of numbers, fewer for larger meshes.
//!
//! The second step starts from the greedy cut and from both cuts of the thesis, and the fewest strips win, so
//! this cut never has more strips than those. To find the fewest possible is a hard problem for meshes whose
//! chords cannot be told apart as horizontal and vertical ones.

use super::walk::{fewest_neighbours, walk};
use super::{Strip, across};
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// The axis that each quad chose: 0 crosses its sides 0 and 2, 1 its sides 1 and 3.
type Axes = Vec<u8>;

/// Stretches to turn, times quads.
const SHAKES: usize = 400_000;

/// The fewest strips that the three steps find.
pub fn natural(mesh: &QuadMesh) -> Vec<Strip> {
    let chords = chords(mesh);
    let starts = [greedy(mesh, &chords), axes_of(mesh, &walk(mesh)), axes_of(mesh, &fewest_neighbours(mesh))];
    let improved = starts.into_iter().map(|mut axes| {
        improve(mesh, &chords, &mut axes);
        strips_of(mesh, &axes)
    });
    let mut best = improved.min_by_key(Vec::len).unwrap_or_default();
    let mut number = 0u64;
    let mut below = |n: usize| {
        number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (number >> 33) as usize % n
    };
    for _ in 0..(SHAKES / mesh.quads().len()).min(1000) {
        let row = &chords[below(chords.len())].half_edges;
        let (first, length) = (below(row.len()), 1 + below(row.len()));
        let mut axes = axes_of(mesh, &best);
        for h in row.iter().skip(first).take(length) {
            axes[*h as usize / 4] = (h % 2) as u8;
        }
        improve(mesh, &chords, &mut axes);
        let strips = strips_of(mesh, &axes);
        if strips.len() <= best.len() {
            best = strips;
        }
    }
    best
}

fn axes_of(mesh: &QuadMesh, strips: &[Strip]) -> Axes {
    let mut axes = vec![0; mesh.quads().len()];
    for h in strips.iter().flat_map(Strip::half_edges) {
        axes[*h as usize / 4] = (h % 2) as u8;
    }
    axes
}

/// The half-edge by which a strip enters the quad before.
fn back(mesh: &QuadMesh, half_edge: u32) -> Option<u32> {
    mesh.topology().opposite(half_edge).map(|h| h ^ 2)
}

/// A row of quads as entered from left to right.
struct Chord {
    half_edges: Vec<u32>,
    closed: bool,
}

fn chords(mesh: &QuadMesh) -> Vec<Chord> {
    let mut seen = vec![false; mesh.quads().len() * 2];
    let mut chords = Vec::new();
    for start in (0..mesh.quads().len() as u32).flat_map(|q| [4 * q, 4 * q + 1]) {
        if seen[key(start)] {
            continue;
        }
        let mut first = start;
        while let Some(h) = back(mesh, first) {
            first = h;
            if first == start {
                break;
            }
        }
        let (mut half_edges, mut next) = (Vec::new(), Some(first));
        while let Some(h) = next.filter(|&h| !seen[key(h)]) {
            seen[key(h)] = true;
            half_edges.push(h);
            next = across(mesh, h);
        }
        chords.push(Chord { half_edges, closed: next.is_some() });
    }
    chords
}

/// Quad and axis of a half-edge as one number.
fn key(half_edge: u32) -> usize {
    (half_edge / 4 * 2 + half_edge % 2) as usize
}

/// The longest free runs first.
fn greedy(mesh: &QuadMesh, chords: &[Chord]) -> Axes {
    let mut axes = vec![0; mesh.quads().len()];
    let mut free = vec![true; mesh.quads().len()];
    let mut seen = vec![usize::MAX; mesh.quads().len()];
    let mut scan = 0;
    // (length, chord, first place), where ties go to the lowest numbers
    let whole = |(c, chord): (usize, &Chord)| (chord.half_edges.len(), Reverse(c), Reverse(0));
    let mut runs: BinaryHeap<_> = chords.iter().enumerate().map(whole).collect();
    while let Some((length, Reverse(c), Reverse(first))) = runs.pop() {
        let row = &chords[c].half_edges;
        let quad = |place: usize| row[place % row.len()] as usize / 4;
        // A run is broken by quads that are taken, and where it meets itself.
        let (mut pieces, mut begin) = (Vec::new(), first);
        scan += 1;
        for place in first..first + length {
            let taken = !free[quad(place)];
            if taken || seen[quad(place)] == scan {
                pieces.push(begin..place);
                begin = place + usize::from(taken);
                scan += 1;
            }
            seen[quad(place)] = scan;
        }
        pieces.push(begin..first + length);
        if let [whole] = &pieces[..] {
            for place in whole.clone() {
                free[quad(place)] = false;
                axes[quad(place)] = (row[place % row.len()] % 2) as u8;
            }
            continue;
        }
        if chords[c].closed && length == row.len() {
            // Broken somewhere: what lies before the first break continues what lies behind the last.
            let joined = pieces.remove(0);
            if let Some(last) = pieces.last_mut() {
                last.end += joined.len();
            }
        }
        runs.extend(
            pieces.into_iter().filter(|p| !p.is_empty()).map(|p| (p.len(), Reverse(c), Reverse(p.start))),
        );
    }
    axes
}

fn linked(mesh: &QuadMesh, axes: &Axes, half_edge: u32) -> bool {
    let along = |h: u32| u32::from(axes[h as usize / 4]) == h % 2;
    mesh.topology().opposite(half_edge).is_some_and(|opposite| along(half_edge) && along(opposite))
}

/// Chord after chord takes its best choices until none improves.
fn improve(mesh: &QuadMesh, chords: &[Chord], axes: &mut Axes) {
    let mut on_chord = vec![usize::MAX; mesh.quads().len()];
    let quads: Vec<BTreeSet<u32>> =
        chords.iter().map(|chord| chord.half_edges.iter().map(|h| h / 4).collect()).collect();
    // Twice the links that the quads of a chord have.
    let links = |c: usize, axes: &Axes, on_chord: &[usize]| -> usize {
        let links = |h: u32| match mesh.topology().opposite(h) {
            Some(opposite) if linked(mesh, axes, h) => {
                2 - usize::from(on_chord[opposite as usize / 4] == c) // seen from both sides
            }
            _ => 0,
        };
        quads[c].iter().flat_map(|q| 4 * q..4 * q + 4).map(links).sum()
    };
    loop {
        let mut better = false;
        for (c, chord) in chords.iter().enumerate() {
            chord.half_edges.iter().for_each(|&h| on_chord[h as usize / 4] = c);
            let old: Vec<u8> = chord.half_edges.iter().map(|&h| axes[h as usize / 4]).collect();
            let before = links(c, axes, &on_chord);
            choose(mesh, chord, axes);
            // On a chord that meets itself the choices are not independent, so the best is not always better.
            if links(c, axes, &on_chord) > before {
                better = true;
            } else {
                chord.half_edges.iter().zip(old).for_each(|(&h, axis)| axes[h as usize / 4] = axis);
            }
        }
        if !better {
            return;
        }
    }
}

/// The best choices along a chord: `y_i` says that quad i goes along it.
///
/// ```text
///   most of  sum y_i y_i+1 + sum (1 - y_i) c_i       c_i = cross links that quad i would have
/// ```
fn choose(mesh: &QuadMesh, chord: &Chord, axes: &mut Axes) {
    let row = &chord.half_edges;
    let crossing = |&h: &u32| {
        let cross = (h % 2) ^ 1;
        let sides = [h / 4 * 4 + cross, h / 4 * 4 + cross + 2];
        let goes = |side: &&u32| {
            let opposite = mesh.topology().opposite(**side);
            opposite.is_some_and(|o| u32::from(axes[o as usize / 4]) == o % 2)
        };
        sides.iter().filter(goes).count()
    };
    let cross: Vec<usize> = row.iter().map(crossing).collect();
    // A closed chord is a chain for either choice of its first quad.
    let firsts: &[Option<bool>] = if chord.closed { &[Some(true), Some(false)] } else { &[None] };
    let best = firsts.iter().map(|&first| chain(&cross, first)).max_by_key(|(links, _)| *links);
    for (h, along) in row.iter().zip(best.map_or(Vec::new(), |(_, choices)| choices)) {
        axes[*h as usize / 4] = ((h % 2) as u8) ^ u8::from(!along);
    }
}

/// The most links of a chain and its choices. With `first` the chain is a ring that begins so.
fn chain(cross: &[usize], first: Option<bool>) -> (usize, Vec<bool>) {
    // best[i][y]: the most links up to quad i if it chooses y, and what quad i-1 chooses then
    let mut best: Vec<[Option<(usize, bool)>; 2]> = Vec::with_capacity(cross.len());
    for (i, &c) in cross.iter().enumerate() {
        let at = |y: bool| {
            if i == 0 {
                return first.is_none_or(|first| first == y).then_some((if y { 0 } else { c }, false));
            }
            let from =
                |x: bool| best[i - 1][usize::from(x)].map(|(links, _)| (links + usize::from(x && y), x));
            let (links, x) = from(true).max(from(false))?;
            Some((links + if y { 0 } else { c }, x))
        };
        let row = [at(false), at(true)];
        best.push(row);
    }
    let close = |y: bool| usize::from(first == Some(true) && y);
    let end = |y: bool| best[cross.len() - 1][usize::from(y)].map(|(links, _)| (links + close(y), y));
    let Some((links, mut y)) = end(true).max(end(false)) else { return (0, Vec::new()) };
    let mut choices = vec![false; cross.len()];
    for i in (0..cross.len()).rev() {
        choices[i] = y;
        y = best[i][usize::from(y)].is_some_and(|(_, x)| x);
    }
    (links, choices)
}

/// The runs of linked quads.
fn strips_of(mesh: &QuadMesh, axes: &Axes) -> Vec<Strip> {
    let mut free = vec![true; mesh.quads().len()];
    let mut strips = Vec::new();
    for quad in 0..free.len() {
        if !free[quad] {
            continue;
        }
        let start = 4 * quad as u32 + u32::from(axes[quad]);
        let mut first = start;
        while linked(mesh, axes, first) {
            first = back(mesh, first).expect("a linked edge has two sides");
            if first == start {
                break;
            }
        }
        let mut half_edges = Vec::new();
        let mut h = first;
        let closed = loop {
            free[h as usize / 4] = false;
            half_edges.push(h);
            match across(mesh, h) {
                Some(next) if linked(mesh, axes, h ^ 2) => h = next,
                _ => break false,
            }
            if h == first {
                break true;
            }
        };
        strips.push(Strip { half_edges, closed });
    }
    strips
}

#[cfg(test)]
mod tests {
    use super::*;

    /// columns x rows cells, wrapped in neither, one or both directions.
    fn lattice(columns: u32, rows: u32, wrap: [bool; 2]) -> QuadMesh {
        let [width, height] = [columns + u32::from(!wrap[0]), rows + u32::from(!wrap[1])];
        let at = |x: u32, y: u32| (y % height) * width + x % width;
        let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let quads = cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect();
        QuadMesh::new(vec![[0; 3]; (width * height) as usize], quads).unwrap()
    }

    #[test]
    fn a_sheet_is_cut_along_its_longer_side() {
        assert_eq!(natural(&lattice(7, 3, [false; 2])).len(), 3);
        assert_eq!(natural(&lattice(3, 7, [false; 2])).len(), 3);
        let torus = natural(&lattice(12, 6, [true; 2]));
        assert_eq!(torus.len(), 6);
        assert!(torus.iter().all(Strip::is_closed));
    }

    #[test]
    fn a_chain_takes_the_better_of_links_and_cross_links() {
        assert_eq!(chain(&[0, 0, 0], None), (2, vec![true; 3]));
        assert_eq!(chain(&[0, 2, 0], None), (2, vec![true, true, true]));
        assert_eq!(chain(&[2, 2, 0], None).0, 4);
        assert_eq!(chain(&[0, 0, 0], Some(true)).0, 3);
        // all sixteen choices of a ring of four
        for cross in [[2, 0, 0, 1], [0, 2, 2, 0], [1, 1, 1, 1], [2, 0, 2, 0]] {
            let value = |y: u32| {
                let on = |i: usize| y >> (i % 4) & 1 == 1;
                (0..4)
                    .map(|i| usize::from(on(i) && on(i + 1)) + if on(i) { 0 } else { cross[i] })
                    .sum::<usize>()
            };
            let best = [true, false].map(|first| chain(&cross, Some(first)).0).into_iter().max();
            assert_eq!(best, (0..16).map(value).max(), "{cross:?}");
        }
    }

    #[test]
    fn a_cross_of_chords_loses_no_quad() {
        // an L: two arms of a sheet, so that runs are broken by runs
        let mesh = lattice(5, 5, [false; 2]);
        let keep = |q: usize| q % 5 < 2 || q / 5 < 2;
        let quads: Vec<[u32; 4]> = (0..25).filter(|&q| keep(q)).map(|q| mesh.quads()[q]).collect();
        let mut used: Vec<u32> = quads.concat();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap() as u32;
        let mesh =
            QuadMesh::new(vec![[0; 3]; used.len()], quads.iter().map(|q| q.map(number)).collect()).unwrap();
        let strips = natural(&mesh);
        assert_eq!(strips.iter().map(Strip::len).sum::<usize>(), 16);
        assert_eq!(strips.len(), 4);
    }
}
