//! The strip interface of the thesis: begin, neighbours, vertex, ..., end, as calls and as a stream of words.
//!
//! ```text
//!        n1  n2 ─ n3                 begin
//!          ╲ │                         neighbour n1, n2, n3     the fan of v1, clockwise
//!     ───── v1 ───── v3 ──             vertex v1                odd: top row
//!           │        │                 neighbour ...            counterclockwise
//!     ───── v2 ───── v4 ──             vertex v2                even: bottom row
//!                                      ...
//!                                    end
//! ```
//!
//! The fan of a vertex begins with its first neighbour that is no strip vertex and ends with its last, neighbours
//! and diagonals in turn; diagonals that lie next to a strip neighbour belong to the fan of that neighbour. So it
//! has 2d - 7 entries inside of a strip (none for d = 3). In the first and the last column of an open strip it
//! also holds the guard: `[t(-1), x_1, a_1, ...]` and `[..., a_{d-3}, x_{d-2}, t(M+1)]`, 2d - 5 entries, and the
//! guard alone for d = 3. The valence is never sent: it follows from the length.
//!
//! A closed strip sends each column once. On a rim, [`Call::Gap`] stands where the missing face is: in place of
//! its diagonal, before the first entry or behind the last.
//!
//! Source: Hall, section 4.5. What comes out are the records of [`super::records`].

use super::records::{Column, Guard, Outside, StripRecords};
use crate::error::{Error, Result};

/// One word of the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call<P> {
    Begin { closed: bool },
    Neighbour(P),
    Gap,
    Vertex(P),
    End,
}

/// The calls that send a strip.
pub fn calls<P: Clone>(strip: &StripRecords<P>) -> Vec<Call<P>> {
    let mut calls = vec![Call::Begin { closed: strip.closed }];
    let sent = if strip.closed { strip.len() } else { strip.columns.len() };
    for (c, column) in strip.columns[..sent].iter().enumerate() {
        for end in 0..2 {
            let outside = &column.outside[end];
            let guard = |side: usize| {
                let guard = strip.guards[side].as_ref()?;
                Some((guard.vertices[end].clone(), guard.outside[end].clone()))
            };
            let first = (c == 0 && !strip.closed).then(|| guard(0)).flatten();
            let last = (c == strip.len() && !strip.closed).then(|| guard(1)).flatten();
            calls.extend(fan(outside, first, last));
            calls.push(Call::Vertex(column.vertices[end].clone()));
        }
    }
    calls.push(Call::End);
    calls
}

/// The fan of a vertex with the guards (vertex, u) that it holds.
fn fan<P: Clone>(outside: &Outside<P>, first: Option<(P, P)>, last: Option<(P, P)>) -> Vec<Call<P>> {
    let gap = |face: u32| outside.gap == Some(face);
    let (first_face, last_face) = (1, outside.valence - 2);
    let mut calls = Vec::new();
    let lone = outside.valence == 3; // its one face is the first and the last
    if let Some((vertex, u)) = first {
        calls.push(Call::Neighbour(vertex));
        if !gap(first_face) && !lone {
            calls.push(Call::Neighbour(u));
        }
    }
    if gap(first_face) {
        calls.push(Call::Gap);
    }
    for (i, entry) in outside.fan.iter().enumerate() {
        // entries 1, 3, 5 ... are the diagonals of faces 2, 3, 4 ...
        let missing = i % 2 == 1 && gap(i as u32 / 2 + 2);
        calls.push(if missing { Call::Gap } else { Call::Neighbour(entry.clone()) });
    }
    if gap(last_face) && !lone {
        calls.push(Call::Gap);
    }
    if let Some((vertex, u)) = last {
        if !gap(last_face) && !lone {
            calls.push(Call::Neighbour(u));
        }
        calls.push(Call::Neighbour(vertex));
    }
    calls
}

/// Takes the calls of one strip after the other.
#[derive(Clone, Debug, Default)]
pub struct StripBuilder<P> {
    open: Option<Open<P>>,
}

/// A strip that has begun.
#[derive(Clone, Debug)]
struct Open<P> {
    closed: bool,
    /// The fan of the next vertex; none is a gap.
    fan: Vec<Option<P>>,
    vertices: Vec<(P, Vec<Option<P>>)>,
}

impl<P: Clone> StripBuilder<P> {
    pub fn new() -> Self {
        StripBuilder { open: None }
    }

    /// Any call; the records when it ends a strip.
    ///
    /// # Errors
    /// As those of the single calls.
    pub fn call(&mut self, call: Call<P>) -> Result<Option<StripRecords<P>>> {
        match call {
            Call::Begin { closed } => self.begin(closed).map(|()| None),
            Call::Neighbour(p) => self.neighbour(p).map(|()| None),
            Call::Gap => self.gap().map(|()| None),
            Call::Vertex(p) => self.vertex(p).map(|()| None),
            Call::End => self.end().map(Some),
        }
    }

    /// # Errors
    /// A strip that has begun and not ended.
    pub fn begin(&mut self, closed: bool) -> Result<()> {
        if self.open.is_some() {
            return Err(misuse("begin", "end the strip before the next begins"));
        }
        self.open = Some(Open { closed, fan: Vec::new(), vertices: Vec::new() });
        Ok(())
    }

    /// The next entry of the fan of the vertex that follows.
    ///
    /// # Errors
    /// Outside of a strip.
    pub fn neighbour(&mut self, p: P) -> Result<()> {
        self.inside("neighbour")?.fan.push(Some(p));
        Ok(())
    }

    /// The missing face of a boundary vertex, in its place in the fan.
    ///
    /// # Errors
    /// Outside of a strip.
    pub fn gap(&mut self) -> Result<()> {
        self.inside("gap")?.fan.push(None);
        Ok(())
    }

    /// The next strip vertex: top, bottom, top, ...
    ///
    /// # Errors
    /// Outside of a strip.
    pub fn vertex(&mut self, p: P) -> Result<()> {
        let open = self.inside("vertex")?;
        let fan = std::mem::take(&mut open.fan);
        open.vertices.push((p, fan));
        Ok(())
    }

    /// The end of a strip.
    ///
    /// # Errors
    /// An odd number of vertices, fewer than two columns (three if closed), neighbours without a vertex, a fan
    /// of a length that no valence has, two gaps in one fan.
    pub fn end(&mut self) -> Result<StripRecords<P>> {
        let open = self.open.take().ok_or_else(|| misuse("end", "begin a strip first"))?;
        let least = if open.closed { 6 } else { 4 };
        if !open.fan.is_empty() || !open.vertices.len().is_multiple_of(2) || open.vertices.len() < least {
            let what = format!("a strip of {} vertices ends", open.vertices.len());
            return Err(Error::input(what).help(
                "send each column's top and bottom vertex behind their fans; two columns at least, three if closed",
            ));
        }
        let count = open.vertices.len() / 2;
        let mut parts = Vec::with_capacity(open.vertices.len());
        for (i, (vertex, fan)) in open.vertices.into_iter().enumerate() {
            let ends = [i / 2 == 0, i / 2 + 1 == count].map(|end| end && !open.closed);
            let part = Part::new(vertex, fan, ends).ok_or_else(|| {
                Error::input(format!("the fan of vertex {} of a strip cannot be", i + 1)).help(
                    "send 2d - 7 neighbours for a vertex of d edges, 2d - 5 in the first and last column",
                )
            })?;
            parts.push(part);
        }
        let rows =
            [0, 1].map(|end| Row { parts: parts.iter().skip(end).step_by(2).collect(), closed: open.closed });
        let last = if open.closed { count } else { count - 1 };
        let columns = (0..=last)
            .map(|c| Column {
                vertices: [rows[0].part(c).vertex.clone(), rows[1].part(c).vertex.clone()],
                outside: [rows[0].outside(c), rows[1].outside(c)],
            })
            .collect();
        let guard = |side: usize| {
            let [(top, u_top), (bottom, u_bottom)] = [rows[0].guard(side)?, rows[1].guard(side)?];
            Some(Guard { vertices: [top, bottom], outside: [u_top, u_bottom] })
        };
        Ok(StripRecords { closed: open.closed, columns, guards: [guard(0), guard(1)] })
    }

    fn inside(&mut self, call: &str) -> Result<&mut Open<P>> {
        self.open.as_mut().ok_or_else(|| misuse(call, "begin a strip first"))
    }
}

fn misuse(call: &str, help: &str) -> Error {
    Error::usage(format!("'{call}' at the wrong place")).help(help)
}

/// A vertex and its fan, taken apart.
#[derive(Clone, Debug)]
struct Part<P> {
    vertex: P,
    valence: u32,
    /// a_1, x_2, ..., a_{d-3}; the diagonal of a gap repeats the vertex.
    fan: Vec<P>,
    gap: Option<u32>,
    /// Guard vertex and its u where the fan held one, first and last; u is not sent for valence 3 and gaps.
    guards: [Option<(P, Option<P>)>; 2],
}

impl<P: Clone> Part<P> {
    /// `ends`: whether the vertex stands in the first and in the last column. None if the fan is no fan.
    fn new(vertex: P, fan: Vec<Option<P>>, ends: [bool; 2]) -> Option<Self> {
        let mut fan = std::collections::VecDeque::from(fan);
        let mut guards = [None, None];
        // A rim, where the fan begins with the gap, has no guard. A guard has its u unless that is all there is.
        if ends[0] && fan.front().is_some_and(Option::is_some) {
            guards[0] = Some((fan.pop_front()??, None));
        }
        if ends[1] && fan.back().is_some_and(Option::is_some) {
            guards[1] = Some((fan.pop_back()??, None));
        }
        if let (Some((_, u)), Some(Some(_))) = (&mut guards[0], fan.front()) {
            *u = fan.pop_front()?;
        }
        if let (Some((_, u)), Some(Some(_))) = (&mut guards[1], fan.back()) {
            *u = fan.pop_back()?;
        }
        let has_u = guards.iter().flatten().any(|(_, u)| u.is_some());
        let first = matches!(fan.front(), Some(None)) && fan.pop_front().is_some();
        let last = matches!(fan.back(), Some(None)) && fan.pop_back().is_some();
        let edges = fan.len().div_ceil(2) as u32; // d - 3
        // An odd number of entries; without any, valence 3, there is no face for u to be the diagonal of.
        if fan.len() % 2 == 0 && (!fan.is_empty() || has_u) {
            return None;
        }
        let inside = fan.iter().enumerate().filter(|(_, entry)| entry.is_none());
        let mut gaps: Vec<u32> = inside.map(|(i, _)| if i % 2 == 1 { i as u32 / 2 + 2 } else { 0 }).collect();
        gaps.extend(first.then_some(1));
        gaps.extend(last.then_some(edges + 1));
        if gaps.len() > 1 || gaps.contains(&0) {
            return None;
        }
        let fan = fan.into_iter().map(|entry| entry.unwrap_or_else(|| vertex.clone())).collect();
        Some(Part { valence: edges + 3, fan, gap: gaps.pop(), guards, vertex })
    }
}

/// The top or the bottom row of a strip.
struct Row<'a, P> {
    parts: Vec<&'a Part<P>>,
    closed: bool,
}

impl<P: Clone> Row<'_, P> {
    fn part(&self, c: usize) -> &Part<P> {
        self.parts[c % self.parts.len()]
    }

    /// The neighbour in the row; none beyond a rim.
    fn left(&self, c: usize) -> Option<P> {
        let count = self.parts.len();
        if c > 0 || self.closed {
            return Some(self.part(c + count - 1).vertex.clone());
        }
        self.part(0).guards[0].as_ref().map(|(vertex, _)| vertex.clone())
    }

    fn right(&self, c: usize) -> Option<P> {
        if c + 1 < self.parts.len() || self.closed {
            return Some(self.part(c + 1).vertex.clone());
        }
        self.part(c).guards[1].as_ref().map(|(vertex, _)| vertex.clone())
    }

    fn outside(&self, c: usize) -> Outside<P> {
        let Part { vertex, valence, fan, gap, .. } = self.part(c);
        let or_vertex = |p: Option<P>| p.unwrap_or_else(|| vertex.clone());
        let (left, right) = match (fan.first(), fan.last()) {
            (Some(first), Some(last)) => (first.clone(), last.clone()),
            _ => (or_vertex(self.right(c)), or_vertex(self.left(c))),
        };
        Outside { valence: *valence, fan: fan.clone(), left, right, gap: *gap }
    }

    /// The guard before the first (after the last) column with its u.
    fn guard(&self, side: usize) -> Option<(P, P)> {
        let last = self.parts.len() - usize::from(!self.closed);
        let end = self.part(if side == 0 { 0 } else { last });
        let missing = end.gap == Some(if side == 0 { 1 } else { end.valence - 2 });
        let (vertex, sent) = match &end.guards[side] {
            Some(guard) => guard.clone(),
            None if self.closed => (if side == 0 { self.left(0) } else { self.right(last) }?, None),
            None => return None,
        };
        let u = match sent {
            Some(u) => u,
            None if missing => end.vertex.clone(),
            // Inside of a closed strip, or valence 3: the face is the one over the next strip edge.
            None if self.closed && side == 0 => self.outside(last - 1).right,
            None if self.closed => self.outside(1).left,
            None if side == 0 => self.outside(1).left,
            None => self.outside(last - 1).right,
        };
        Some((vertex, u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(calls: &[Call<u32>]) -> Result<StripRecords<u32>> {
        let mut builder = StripBuilder::new();
        for call in calls {
            if let Some(records) = builder.call(*call)? {
                return Ok(records);
            }
        }
        Err(Error::usage("no end"))
    }

    /// One quad of a regular mesh, by hand.
    ///
    /// ```text
    ///   20 21 22 23       each column's outside vertices in rows 2 and 5,
    ///   30 31 32 33       the quad is 31 41 42 32
    ///   40 41 42 43
    ///   50 51 52 53
    /// ```
    #[test]
    fn a_regular_quad_and_its_sixteen_points() {
        use Call::{Neighbour, Vertex};
        let calls_by_hand = [
            vec![Call::Begin { closed: false }],
            [30, 20, 21].map(Neighbour).to_vec(),
            vec![Vertex(31)],
            [40, 50, 51].map(Neighbour).to_vec(),
            vec![Vertex(41)],
            [22, 23, 33].map(Neighbour).to_vec(),
            vec![Vertex(32)],
            [52, 53, 43].map(Neighbour).to_vec(),
            vec![Vertex(42), Call::End],
        ]
        .concat();
        let records = build(&calls_by_hand).unwrap();
        let regular = |a: u32| Outside { valence: 4, fan: vec![a], left: a, right: a, gap: None };
        assert_eq!(records.columns[0].outside, [regular(21), regular(51)]);
        assert_eq!(records.columns[1].vertices, [32, 42]);
        assert_eq!(records.guards[0], Some(Guard { vertices: [30, 40], outside: [20, 50] }));
        assert_eq!(records.guards[1], Some(Guard { vertices: [33, 43], outside: [23, 53] }));
        assert_eq!((calls(&records), records.words()), (calls_by_hand, 16));
    }

    #[test]
    fn what_is_no_strip_is_refused() {
        use Call::{Begin, End, Gap, Neighbour, Vertex};
        let begin = Begin { closed: false };
        let quad = |fan: &[Call<u32>]| {
            let mut calls = vec![begin];
            calls.extend_from_slice(fan);
            calls.extend([
                Vertex(0),
                Neighbour(9),
                Vertex(1),
                Neighbour(9),
                Vertex(2),
                Neighbour(9),
                Vertex(3),
                End,
            ]);
            build(&calls).map_err(|error| error.what)
        };
        assert!(quad(&[Neighbour(9)]).is_ok());
        assert!(quad(&[Neighbour(9), Neighbour(8)]).is_err());
        assert_eq!(
            quad(&[9, 8, 7, 6].map(Neighbour)),
            Err("the fan of vertex 1 of a strip cannot be".into())
        );
        assert!(quad(&[Neighbour(9), Gap, Neighbour(8), Gap]).is_err(), "two gaps");
        assert!(build(&[Vertex(0)]).is_err() && build(&[begin, begin]).is_err());
        assert!(build(&[begin, Vertex(0), Vertex(1), Vertex(2), End]).is_err());
        assert!(build(&[Begin { closed: true }, Vertex(0), Vertex(1), Vertex(2), Vertex(3), End]).is_err());
    }
}
