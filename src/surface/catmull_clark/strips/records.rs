//! The columns of a strip as the engine receives them: two vertices, and what lies outside of each.
//!
//! ```text
//!        x_2 ── a_2 ── x_3                 outside record of the top vertex v, left to right:
//!         │      │      │                    valence d = 5 (left, right, inner, a_1, a_2)
//!   ...─ a_1     │     a_2 ...               fan     [a_1, x_2, a_2]          2d - 7 entries, 0 for d = 3
//!          ╲     │    ╱                      left  = uL, right = uR: the outside vertex used by the face
//!   left ─────── v ─────── right             column on that side
//!                │
//!              inner                       d >= 4: uL = a_1, uR = a_{d-3}
//!                                          d = 3:  uL = right neighbour, uR = left neighbour
//! ```
//!
//! There are d-3 outside edges a_i and d-2 outside faces f_i, between a_{i-1} and a_i (a_0 = left neighbour,
//! a_{d-2} = right neighbour); x_i is the diagonal of f_i, and those of the first and the last face are u of the
//! neighbouring columns. So the outside face over a strip edge is v_c, v_c+1, uR(c), uL(c+1), always.
//! The bottom vertex is the mirror image.
//!
//! A guard is the column before the first quad (after the last): the next quad across the first edge, as two
//! vertices and their uR (uL). A closed strip's guards are its own columns.
//!
//! With [`Boundary::Rim`] an outside face may be missing: `gap` is its number i. Where the first (last) edge of
//! an open strip is a boundary edge there is no guard, and its vertices have a missing left (right) neighbour,
//! counted in d, next to the gap: a_0 (a_{d-2}) does not exist. Entries that do not exist repeat the vertex.
//!
//! [`Boundary::Rim`]: crate::surface::catmull_clark::rings::Boundary::Rim

use super::Strip;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::{Rings, Spoke};

/// What lies outside of a strip vertex. `P` is a vertex number or a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outside<P> {
    /// d, the number of edges at the vertex, ghosts included.
    pub valence: u32,
    /// a_1, x_2, a_2, ..., x_{d-3}, a_{d-3}, from left to right.
    pub fan: Vec<P>,
    /// The outside vertex of the face column to the left, uL.
    pub left: P,
    /// The outside vertex of the face column to the right, uR.
    pub right: P,
    /// The number of the outside face that is missing, 1..=d-2.
    pub gap: Option<u32>,
}

/// A column of a strip: top and bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column<P> {
    pub vertices: [P; 2],
    pub outside: [Outside<P>; 2],
}

/// The column beyond an end of a strip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guard<P> {
    pub vertices: [P; 2],
    /// uR of a left guard, uL of a right one.
    pub outside: [P; 2],
}

/// All that is sent for one strip of M quads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StripRecords<P> {
    pub closed: bool,
    /// Columns 0..=M; the last is the first again in a closed strip.
    pub columns: Vec<Column<P>>,
    /// Columns -1 and M+1; none at a rim.
    pub guards: [Option<Guard<P>>; 2],
}

impl<P> Outside<P> {
    /// Words sent besides the vertex: the fan, or both u where there is none.
    pub fn words(&self) -> usize {
        if self.valence == 3 { 2 } else { self.fan.len() }
    }

    pub fn map<Q>(&self, f: &mut impl FnMut(&P) -> Q) -> Outside<Q> {
        Outside {
            valence: self.valence,
            fan: self.fan.iter().map(&mut *f).collect(),
            left: f(&self.left),
            right: f(&self.right),
            gap: self.gap,
        }
    }
}

impl<P> StripRecords<P> {
    /// M, the number of quads.
    pub fn len(&self) -> usize {
        self.columns.len() - 1
    }

    /// A strip has a quad at least.
    pub fn is_empty(&self) -> bool {
        self.columns.len() < 2
    }

    /// Words sent: positions of all columns and guards.
    pub fn words(&self) -> usize {
        let column = |c: &Column<P>| 2 + c.outside.iter().map(Outside::words).sum::<usize>();
        let guards = 4 * self.guards.iter().flatten().count();
        self.columns.iter().map(column).sum::<usize>() + guards
    }

    /// The largest d.
    pub fn largest_valence(&self) -> u32 {
        self.columns.iter().flat_map(|c| &c.outside).map(|o| o.valence).max().unwrap_or(0)
    }

    /// Whether an engine without rims can take the strip.
    pub fn has_rims(&self) -> bool {
        self.guards.iter().any(Option::is_none)
            || self.columns.iter().flat_map(|c| &c.outside).any(|o| o.gap.is_some())
    }

    pub fn map<Q>(&self, mut f: impl FnMut(&P) -> Q) -> StripRecords<Q> {
        let column = |c: &Column<P>| Column {
            vertices: [f(&c.vertices[0]), f(&c.vertices[1])],
            outside: [c.outside[0].map(&mut f), c.outside[1].map(&mut f)],
        };
        let columns = self.columns.iter().map(column).collect();
        let guard = |g: &Guard<P>| Guard {
            vertices: [f(&g.vertices[0]), f(&g.vertices[1])],
            outside: [f(&g.outside[0]), f(&g.outside[1])],
        };
        let [left, right] = &self.guards;
        let left = left.as_ref().map(guard);
        let guard = |g: &Guard<P>| Guard {
            vertices: [f(&g.vertices[0]), f(&g.vertices[1])],
            outside: [f(&g.outside[0]), f(&g.outside[1])],
        };
        StripRecords { closed: self.closed, columns, guards: [left, right.as_ref().map(guard)] }
    }
}

/// The records of a strip in numbers of vertices and ghosts.
pub fn records(mesh: &QuadMesh, rings: &Rings, strip: &Strip) -> StripRecords<u32> {
    let walks = |c: usize| {
        let [top, bottom] = strip.column(mesh, c);
        [Walk::over(rings.ring(top), top, bottom, true), Walk::over(rings.ring(bottom), bottom, top, false)]
    };
    let columns = (0..=strip.len())
        .map(|c| Column { vertices: strip.column(mesh, c), outside: walks(c).map(|walk| walk.record()) })
        .collect();
    let [first, last] = [0, strip.len()].map(walks);
    let guard = |nodes: [Option<u32>; 2], outside: [Option<u32>; 2], vertices: [u32; 2]| {
        let vertices = [nodes[0]?, nodes[1]?].into_iter().zip(vertices);
        let [(top, inner_top), (bottom, inner_bottom)] =
            <[_; 2]>::try_from(vertices.collect::<Vec<_>>()).ok()?;
        let outside = [outside[0].unwrap_or(inner_top), outside[1].unwrap_or(inner_bottom)];
        Some(Guard { vertices: [top, bottom], outside })
    };
    let left = guard(
        first.each_ref().map(|walk| walk.left()),
        first.each_ref().map(|walk| walk.first_diagonal()),
        strip.column(mesh, 0),
    );
    let right = guard(
        last.each_ref().map(|walk| walk.right()),
        last.each_ref().map(|walk| walk.last_diagonal()),
        strip.column(mesh, strip.len()),
    );
    StripRecords { closed: strip.is_closed(), columns, guards: [left, right] }
}

/// The records of all strips with positions.
pub fn positioned(mesh: &QuadMesh, rings: &Rings, strips: &[Strip]) -> Vec<StripRecords<[i64; 3]>> {
    let position = |v: &u32| rings.positions()[*v as usize];
    strips.iter().map(|strip| records(mesh, rings, strip).map(position)).collect()
}

/// The way over the outside of a vertex from its left to its right strip neighbour.
struct Walk {
    vertex: u32,
    /// a_0 .. a_{d-2}: left neighbour, outside neighbours, right neighbour. Only ends can be missing.
    neighbours: Vec<Option<u32>>,
    /// Diagonals of f_1 .. f_{d-2}; none for the gap.
    diagonals: Vec<Option<u32>>,
}

impl Walk {
    /// Around `vertex` from its neighbour `inner` in the same column.
    fn over(ring: &[Spoke], vertex: u32, inner: u32, top: bool) -> Self {
        let d = ring.len();
        let start =
            ring.iter().position(|s| s.neighbour == inner).expect("the column is an edge of the mesh");
        // Counterclockwise from the inner neighbour: spokes 1..d, faces 0..d; face i lies before spoke i+1.
        let spoke = |i: usize| ring[(start + i) % d];
        let mut neighbours: Vec<Option<u32>> = (1..d).map(|i| Some(spoke(i).neighbour)).collect();
        let mut diagonals: Vec<Option<u32>> = (1..d - 1).map(|i| spoke(i).diagonal).collect();
        // A missing strip face: its far neighbour is missing too, and the face beyond that is the gap.
        if spoke(0).diagonal.is_none() {
            neighbours.insert(0, None);
            diagonals.insert(0, None);
        }
        if spoke(d - 1).diagonal.is_none() {
            neighbours.push(None);
            diagonals.push(None);
        }
        // With the strip below, counterclockwise from the inner neighbour is right to left.
        if top {
            neighbours.reverse();
            diagonals.reverse();
        }
        Walk { vertex, neighbours, diagonals }
    }

    fn left(&self) -> Option<u32> {
        self.neighbours[0]
    }

    fn right(&self) -> Option<u32> {
        self.neighbours[self.neighbours.len() - 1]
    }

    fn first_diagonal(&self) -> Option<u32> {
        self.diagonals[0]
    }

    fn last_diagonal(&self) -> Option<u32> {
        self.diagonals[self.diagonals.len() - 1]
    }

    fn record(&self) -> Outside<u32> {
        let outside = &self.neighbours[1..self.neighbours.len() - 1];
        let or_vertex = |node: Option<u32>| node.unwrap_or(self.vertex);
        let mut fan = Vec::new();
        for (i, &neighbour) in outside.iter().enumerate() {
            if i > 0 {
                fan.push(or_vertex(self.diagonals[i]));
            }
            fan.push(or_vertex(neighbour));
        }
        let (left, right) = match outside {
            [] => (self.right(), self.left()),
            [first, .., last] => (*first, *last),
            [only] => (*only, *only),
        };
        Outside {
            valence: self.neighbours.len() as u32 + 1,
            fan,
            left: or_vertex(left),
            right: or_vertex(right),
            gap: self.diagonals.iter().position(Option::is_none).map(|i| i as u32 + 1),
        }
    }
}
