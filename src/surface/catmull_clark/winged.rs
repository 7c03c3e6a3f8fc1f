//! Subdivision in software on winged quadstrips: each strip becomes two parallel ones, twice as long.
//!
//! ```text
//!        ↑    ↑    ↑                          ↑ ↑ ↑ ↑ ↑ ↑
//!   ← ┌────┬────┬────┐ →                  ← ┌──┬──┬──┬──┬──┬──┐ →     strip 2s
//!     │    │    │    │        ──►           ├──┼──┼──┼──┼──┼──┤
//!     └────┴────┴────┘                    ← └──┴──┴──┴──┴──┴──┘ →     strip 2s + 1
//!        ↓    ↓    ↓                          ↓ ↓ ↓ ↓ ↓ ↓
//! ```
//!
//! A strip of M quads keeps two vertices a column and a pointer to the quad above and below each of its quads,
//! and to those before and after the strip: 4M + 4 pointers, where quads that know their corners, edges and
//! neighbours need 12M. Neighbours within the strip are known by their place. The strips grow with every level,
//! so the fine mesh is drawn in long ones (Hall, sections 3.2 to 3.5).

use crate::surface::catmull_clark::masks::Corners;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::strips::Strip;

/// A pointer to a quad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Quad {
    pub strip: u32,
    pub place: u32,
}

/// A strip with the wings that connect it to its neighbours. None is the boundary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WingedStrip {
    /// Top and bottom vertex of the columns 0..=M.
    pub columns: Vec<[u32; 2]>,
    pub above: Vec<Option<Quad>>,
    pub below: Vec<Option<Quad>>,
    pub before: Option<Quad>,
    pub after: Option<Quad>,
}

/// A mesh of winged quadstrips.
#[derive(Clone, Debug)]
pub struct WingedMesh {
    pub positions: Vec<[f64; 3]>,
    pub strips: Vec<WingedStrip>,
    corners: Corners,
}

impl WingedStrip {
    /// M, the number of quads.
    pub fn len(&self) -> usize {
        self.above.len()
    }

    pub fn is_empty(&self) -> bool {
        self.above.is_empty()
    }

    /// Pointers to vertices and quads: 4M + 4.
    pub fn pointers(&self) -> usize {
        2 * self.columns.len() + self.above.len() + self.below.len() + 2
    }
}

impl WingedMesh {
    /// The strips of a mesh and their wings.
    pub fn new(mesh: &QuadMesh, strips: &[Strip], corners: Corners) -> Self {
        let topology = mesh.topology();
        let mut quads = vec![Quad { strip: 0, place: 0 }; mesh.quads().len()];
        for (strip, number) in strips.iter().zip(0..) {
            for (quad, place) in strip.quads().zip(0..) {
                quads[quad as usize] = Quad { strip: number, place };
            }
        }
        let beyond = |half_edge: u32| Some(quads[topology.opposite(half_edge)? as usize / 4]);
        // Corner t is where the strip's half-edge begins; sides follow as left, bottom, right, top.
        let side = |h: u32, i: u32| h / 4 * 4 + (h + i) % 4;
        let winged = |strip: &Strip| WingedStrip {
            columns: (0..=strip.len()).map(|c| strip.column(mesh, c)).collect(),
            above: strip.half_edges().iter().map(|&h| beyond(side(h, 3))).collect(),
            below: strip.half_edges().iter().map(|&h| beyond(side(h, 1))).collect(),
            before: strip.half_edges().first().and_then(|&h| beyond(side(h, 0))),
            after: strip.half_edges().last().and_then(|&h| beyond(side(h, 2))),
        };
        WingedMesh {
            positions: mesh.positions().iter().map(|p| p.map(|x| x as f64)).collect(),
            strips: strips.iter().map(winged).collect(),
            corners,
        }
    }

    /// Pointers of all strips.
    pub fn pointers(&self) -> usize {
        self.strips.iter().map(WingedStrip::pointers).sum()
    }

    /// Corners counterclockwise from the top left; side i runs from corner i to corner i+1.
    fn quad_corners(&self, quad: Quad) -> [u32; 4] {
        let columns = &self.strips[quad.strip as usize].columns;
        let ([t, b], [u, d]) = (columns[quad.place as usize], columns[quad.place as usize + 1]);
        [t, b, d, u]
    }

    /// The quad across side i (left, bottom, right, top).
    fn across(&self, quad: Quad, i: usize) -> Option<Quad> {
        let strip = &self.strips[quad.strip as usize];
        let place = quad.place as usize;
        match i {
            0 if place == 0 => strip.before,
            0 => Some(Quad { place: quad.place - 1, ..quad }),
            1 => strip.below[place],
            2 if place + 1 == strip.len() => strip.after,
            2 => Some(Quad { place: quad.place + 1, ..quad }),
            _ => strip.above[place],
        }
    }

    /// The quad across side i and its side that is the same edge: it runs the other way.
    fn meeting(&self, quad: Quad, i: usize) -> Option<(Quad, usize)> {
        let other = self.across(quad, i)?;
        let to = self.quad_corners(quad)[(i + 1) % 4];
        let from = self.quad_corners(quad)[i];
        let corners = self.quad_corners(other);
        let j = (0..4).find(|&j| corners[j] == to && corners[(j + 1) % 4] == from)?;
        Some((other, j))
    }

    fn quads(&self) -> impl Iterator<Item = Quad> + '_ {
        let places =
            |(strip, s): (u32, &WingedStrip)| (0..s.len() as u32).map(move |place| Quad { strip, place });
        (0..).zip(&self.strips).flat_map(places)
    }

    /// One level of Catmull and Clark's rules, walking from quad to quad by the wings.
    pub fn subdivided(&self) -> WingedMesh {
        let (positions, edges, faces) = self.new_vertices();
        let mut first = Vec::with_capacity(self.strips.len());
        let mut count = 0;
        for strip in &self.strips {
            first.push(count);
            count += strip.len();
        }
        let number = |quad: Quad| first[quad.strip as usize] + quad.place as usize;
        let mut strips = Vec::with_capacity(2 * self.strips.len());
        for (strip, s) in self.strips.iter().zip(0u32..) {
            let quad = |place: usize| Quad { strip: s, place: place as u32 };
            let last = strip.len() - 1;
            // Three rows: top, middle, bottom.
            let mut rows: Vec<[u32; 3]> = Vec::with_capacity(2 * strip.len() + 1);
            for (place, &[t, b]) in strip.columns.iter().enumerate() {
                let (owner, side) = if place <= last { (place, 0) } else { (last, 2) };
                rows.push([t, edges[number(quad(owner))][side], b]);
                if place <= last {
                    let f = number(quad(place));
                    rows.push([edges[f][3], faces[f], edges[f][1]]);
                }
            }
            // The children that meet those of side i: at its first corner, and at its second.
            let meet = |place: usize, i: usize| {
                let meeting = self.meeting(quad(place), i);
                [1, 0].map(|k| meeting.map(|(other, j)| child(other, (j + k) % 4)))
            };
            for lower in [0, 1] {
                let outer = |i: usize| {
                    (0..=last).flat_map(move |place| {
                        let [first, second] = meet(place, i);
                        // The top side runs from right to left.
                        if i == 3 { [second, first] } else { [first, second] }
                    })
                };
                let inner =
                    (0..2 * strip.len() as u32).map(|place| Some(Quad { strip: 2 * s + 1 - lower, place }));
                let (above, below) = match lower {
                    0 => (outer(3).collect(), inner.collect()),
                    _ => (inner.collect(), outer(1).collect()),
                };
                strips.push(WingedStrip {
                    columns: rows.iter().map(|r| [r[lower as usize], r[lower as usize + 1]]).collect(),
                    above,
                    below,
                    before: meet(0, 0)[lower as usize],
                    after: meet(last, 2)[1 - lower as usize],
                });
            }
        }
        WingedMesh { positions, strips, corners: self.corners }
    }

    /// Positions one level deeper, the numbers of the new edge vertices by quad and side, and of the face
    /// vertices by quad. Old vertices keep their numbers.
    fn new_vertices(&self) -> (Vec<[f64; 3]>, Vec<[u32; 4]>, Vec<u32>) {
        let point = |v: u32| self.positions[v as usize];
        let mean = |points: &[[f64; 3]]| {
            std::array::from_fn(|x| points.iter().map(|p| p[x]).sum::<f64>() / points.len() as f64)
        };
        let face_of = |quad: Quad| mean(&self.quad_corners(quad).map(point));
        let mut around = vec![Around::default(); self.positions.len()];
        let mut positions = self.positions.clone();
        let (mut edges, mut faces) = (Vec::new(), Vec::new());
        let mut made = std::collections::BTreeMap::new();
        for quad in self.quads() {
            let corners = self.quad_corners(quad);
            let face = face_of(quad);
            faces.push(positions.len() as u32);
            positions.push(face);
            let mut sides = [0; 4];
            for (i, side) in sides.iter_mut().enumerate() {
                let [a, b] = [corners[i], corners[(i + 1) % 4]];
                let meeting = self.meeting(quad, i);
                let known = meeting.and_then(|(other, j)| made.get(&(other, j)).copied());
                *side = known.unwrap_or(positions.len() as u32);
                if known.is_none() {
                    positions.push(match meeting {
                        Some((other, _)) => mean(&[face, face_of(other), point(a), point(b)]),
                        None => mean(&[point(a), point(b)]),
                    });
                    made.insert((quad, i), *side);
                }
                around[a as usize].add(face, point(b));
                if meeting.is_none() {
                    around[a as usize].add_rim(point(b));
                    around[b as usize].add_rim(point(a));
                }
            }
            edges.push(sides);
        }
        for (v, around) in around.iter().enumerate() {
            positions[v] = around.replaced(self.positions[v], self.corners);
        }
        (positions, edges, faces)
    }
}

/// The quarter of a quad at a corner (top left, bottom left, bottom right, top right).
fn child(quad: Quad, corner: usize) -> Quad {
    let (bottom, right) = (corner == 1 || corner == 2, corner >= 2);
    Quad { strip: 2 * quad.strip + u32::from(bottom), place: 2 * quad.place + u32::from(right) }
}

/// The sums around a vertex.
#[derive(Clone, Copy, Default)]
struct Around {
    /// Sum of face vertices and neighbours.
    sum: [f64; 3],
    quads: u32,
    rim: [f64; 3],
    boundary: bool,
}

impl Around {
    fn add(&mut self, face: [f64; 3], neighbour: [f64; 3]) {
        (0..3).for_each(|x| self.sum[x] += face[x] + neighbour[x]);
        self.quads += 1;
    }

    fn add_rim(&mut self, neighbour: [f64; 3]) {
        (0..3).for_each(|x| self.rim[x] += neighbour[x]);
        self.boundary = true;
    }

    fn replaced(&self, s: [f64; 3], corners: Corners) -> [f64; 3] {
        let d = f64::from(self.quads);
        std::array::from_fn(|x| match (self.boundary, self.quads, corners) {
            (true, 1, Corners::Sharp) => s[x],
            (true, ..) => (6.0 * s[x] + self.rim[x]) / 8.0,
            _ => self.sum[x] / (d * d) + (d - 2.0) / d * s[x],
        })
    }
}

/// Pointers of a winged edge structure: two vertices, two faces and four edges for each edge (Hall, 3.2).
/// 16V for large quad meshes, 24V for triangles.
pub fn winged_edge_pointers(edges: usize) -> usize {
    8 * edges
}

/// Pointers of a face based structure: a vertex, an edge and a face for each corner (Hall, 3.3).
/// 12V for large quad meshes, 18V for triangles.
pub fn face_based_pointers(face_corners: usize) -> usize {
    3 * face_corners
}

/// Pointers of winged quadstrips: 4V for large quad meshes and long strips.
pub fn winged_strip_pointers(quads: usize, strips: usize) -> usize {
    4 * quads + 4 * strips
}
