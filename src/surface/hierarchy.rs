//! Levels 2 to 4 of the paper's hierarchy: an arbitrary patch becomes regular patches and single triangles.
//!
//! ```text
//!   render_patch(r, M):  if r = 0: render_one(M)
//!                        elif all corners regular: render_regular(r, M)
//!                        else: D = S(M); render_regular(r-1, P_m D); render_semi(r-1, P_k D), k = 0, 1, 2
//!   render_semi(r, M):   if r = 0: render_one(M)
//!                        elif top regular: render_regular(r, M)
//!                        else: for i in 0..r: D = S(M); render_regular(r-i-1, P_m D, P_0 D, P_1 D); M = P_2 D
//!                              render_one(M)
//! ```
//!
//! Source: Bischoff, Kobbelt, Seidel 2000, sections 4.2 to 4.4, with two corrections to their listing of
//! the semi-regular routine: it returns after r = 0, and its patches have resolution r-i-1 (the caller has
//! subdivided once). The order of patches is that of the listing, so it depends on the mesh alone.

use crate::surface::arithmetic::Arithmetic;
use crate::surface::cmesh::CMesh;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::regular::control_points;
use crate::surface::subdivide::{select_corner, select_middle, subdivide};

/// How many corners of a triangle of the control mesh are irregular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RootClass {
    /// None.
    Regular,
    /// One.
    SemiRegular,
    /// Two or three.
    Irregular,
}

/// What the twelve points of a patch are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchKind {
    /// The control points of a regular patch.
    Regular,
    /// One triangle at level 0: twelve times its limit positions as P0, P2 and P10, all other points zero.
    ///
    /// At level 0 the sample at corner 0 is (6 P4 + P0 + P1 + P3 + P5 + P7 + P8)/12 and among P0, P2, P10
    /// the rings of the corners hold one each, so the samples are exactly the limit positions.
    One,
}

/// One packet for the forward-difference engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch<P> {
    /// The triangle of the control mesh that this patch is a part of, its root.
    pub face: u32,
    pub kind: PatchKind,
    pub class: RootClass,
    /// The patch has 2^level steps along each edge.
    pub level: u32,
    /// Where its corners lie in the root's grid of 2^r steps: (u, v) with corner 0 of the root at (0, 0),
    /// corner 1 at (2^r, 0), corner 2 at (0, 2^r).
    pub corners: [[i32; 2]; 3],
    /// P0..P11 as numbered in [`crate::surface::regular`].
    pub points: [P; 12],
}

impl<P> Patch<P> {
    /// Steps along each edge, n = 2^level.
    pub fn steps(&self) -> i32 {
        1 << self.level
    }

    /// The place of sample p(i, j), i + j <= n, in the root's grid.
    pub fn lattice(&self, i: i32, j: i32) -> [i32; 2] {
        let [a, b, c] = self.corners;
        [0, 1].map(|x| a[x] + ((b[x] - a[x]) * i + (c[x] - a[x]) * j) / self.steps())
    }
}

/// What a walk over the mesh delivered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Triangles of the control mesh by class.
    pub regular: usize,
    pub semi_regular: usize,
    pub irregular: usize,
    /// Packets by kind.
    pub regular_packets: usize,
    pub one_packets: usize,
    /// Triangles of the fine mesh, 4^r a root.
    pub triangles: u64,
}

/// Walks all triangles of the mesh at resolution `level` (2^level steps per edge) and hands every patch to
/// `sink`. `point` gives the control point of a vertex.
///
/// Points at depth k are in the units of the arithmetic at that depth; a patch of level rho has depth
/// `level - rho`.
pub fn walk<A: Arithmetic>(
    arithmetic: &A,
    mesh: &ControlMesh,
    level: u32,
    point: impl Fn(u32) -> A::Point,
    sink: impl FnMut(&Patch<A::Point>),
) -> Counts {
    let mut walker = Walker {
        arithmetic,
        patch: Patch {
            face: 0,
            kind: PatchKind::Regular,
            class: RootClass::Regular,
            level,
            corners: [[0; 2]; 3],
            points: std::array::from_fn(|_| A::Point::default()),
        },
        counts: Counts::default(),
        sink,
    };
    let (mut root, mut scratch) = (CMesh::default(), Scratch::default());
    let n = 1 << level;
    for face in 0..mesh.triangles().len() {
        root.gather(mesh, face, &point);
        walker.patch.face = face as u32;
        walker.render_patch(level, &root, [[0, 0], [n, 0], [0, n]], &mut scratch);
    }
    walker.counts
}

/// The control meshes that the levels of the hierarchy work on, kept so that none is made twice.
struct Scratch<P> {
    /// Level 4: the subdivided root.
    root: CMesh<P>,
    /// Level 3: the semi-regular patch and its subdivision.
    top: CMesh<P>,
    divided: CMesh<P>,
    /// Level 2: a regular part of either subdivision.
    regular: CMesh<P>,
}

impl<P: Clone + Default> Default for Scratch<P> {
    fn default() -> Self {
        let [root, top, divided, regular] = std::array::from_fn(|_| CMesh::default());
        Scratch { root, top, divided, regular }
    }
}

struct Walker<'a, A: Arithmetic, F> {
    arithmetic: &'a A,
    patch: Patch<A::Point>,
    counts: Counts,
    sink: F,
}

type Corners = [[i32; 2]; 3];

fn middle(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

/// Corners of P_m.
fn middle_corners(c: Corners) -> Corners {
    [middle(c[0], c[1]), middle(c[1], c[2]), middle(c[2], c[0])]
}

/// Corners of P_k.
fn corner_corners(c: Corners, k: usize) -> Corners {
    [middle(c[k], c[(k + 1) % 3]), middle(c[(k + 2) % 3], c[k]), c[k]]
}

impl<A: Arithmetic, F: FnMut(&Patch<A::Point>)> Walker<'_, A, F> {
    fn render_patch(&mut self, r: u32, m: &CMesh<A::Point>, at: Corners, scratch: &mut Scratch<A::Point>) {
        let (class, count) = match m.corner.iter().filter(|c| !c.regular()).count() {
            0 => (RootClass::Regular, &mut self.counts.regular),
            1 => (RootClass::SemiRegular, &mut self.counts.semi_regular),
            _ => (RootClass::Irregular, &mut self.counts.irregular),
        };
        *count += 1;
        self.patch.class = class;
        if r == 0 {
            self.render_one(m, at);
        } else if class == RootClass::Regular {
            self.render_regular(r, m, at);
        } else {
            subdivide(self.arithmetic, m, &mut scratch.root);
            select_middle(&scratch.root, &mut scratch.regular);
            self.render_regular(r - 1, &scratch.regular, middle_corners(at));
            for k in 0..3 {
                select_corner(&scratch.root, k, &mut scratch.top);
                self.render_semi(r - 1, corner_corners(at, k), scratch);
            }
        }
    }

    /// Renders `top`, whose irregular corner, if any, is on top.
    fn render_semi(&mut self, r: u32, mut at: Corners, scratch: &mut Scratch<A::Point>) {
        let Scratch { top, divided, regular, .. } = scratch;
        if r > 0 && top.corner[2].regular() {
            return self.render_regular(r, top, at);
        }
        for level in (0..r).rev() {
            subdivide(self.arithmetic, top, divided);
            select_middle(divided, regular);
            self.render_regular(level, regular, middle_corners(at));
            for k in [0, 1] {
                select_corner(divided, k, regular);
                self.render_regular(level, regular, corner_corners(at, k));
            }
            select_corner(divided, 2, top);
            at = corner_corners(at, 2);
        }
        self.render_one(top, at);
    }

    fn render_regular(&mut self, level: u32, m: &CMesh<A::Point>, at: Corners) {
        control_points(self.arithmetic, m, &mut self.patch.points);
        self.counts.regular_packets += 1;
        self.deliver(PatchKind::Regular, level, at);
    }

    fn render_one(&mut self, m: &CMesh<A::Point>, at: Corners) {
        let [p0, p2, p10] = m.corner.each_ref().map(|c| match c.h() {
            None => self.arithmetic.limit12(&c.centre, c.ring()),
            Some(h) => self.arithmetic.boundary_limit12(&c.ring()[h - 1], &c.centre, &c.ring()[h]),
        });
        self.patch.points = std::array::from_fn(|_| A::Point::default());
        (self.patch.points[0], self.patch.points[2], self.patch.points[10]) = (p0, p2, p10);
        self.counts.one_packets += 1;
        self.deliver(PatchKind::One, 0, at);
    }

    fn deliver(&mut self, kind: PatchKind, level: u32, at: Corners) {
        (self.patch.kind, self.patch.level, self.patch.corners) = (kind, level, at);
        self.counts.triangles += 1 << (2 * level);
        (self.sink)(&self.patch);
    }
}
