//! STL, text and binary: loose triangles, welded into a mesh.
//!
//! ```text
//! solid NAME                           80 bytes of anything
//!  facet normal 0 0 1                  number of triangles, 32 bits
//!   outer loop                         each triangle, 50 bytes, little endian:
//!    vertex 0 0 0   (three times)        normal, three corners (12 x float32), 16 bits
//!   endloop
//!  endfacet
//! endsolid NAME
//! ```
//!
//! STL repeats each point in every triangle that meets there. Corners at *exactly* the same position become
//! one vertex; nothing is moved and no tolerance guessed. Normals and attributes are not used.

use super::{draft::Draft, lines::Lines, lines::broken, lines::show};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::collections::HashMap;
use std::io::BufRead;

/// Whether these first bytes belong to a text file; binary ones may begin with `solid` as well.
pub(super) fn is_text(head: &[u8]) -> bool {
    let head = head.trim_ascii_start().to_ascii_lowercase();
    let contains = |word: &[u8]| head.windows(word.len()).any(|window| window == word);
    head.starts_with(b"solid") && !head.contains(&0) && (contains(b"facet") || contains(b"endsolid"))
}

pub(super) fn read_text(input: impl BufRead, file: &str) -> Result<Mesh> {
    let mut lines = Lines::new(input, file);
    let mut weld = Weld::new(file);
    let mut open: Option<(u64, Vec<u32>)> = None;
    while lines.advance()? {
        let mut tokens = lines.tokens();
        let word = tokens.next().unwrap_or_default().to_ascii_lowercase();
        match (word.as_slice(), &mut open) {
            (b"vertex", Some((_, corners))) => {
                corners.push(weld.corner(lines.point(tokens)?, Some(lines.number())));
            }
            (b"outer", None) => open = Some((lines.number(), Vec::new())),
            (b"endloop", Some((line, corners))) => {
                if corners.len() != 3 {
                    return Err(lines
                        .error(format!("a loop has {} vertices", corners.len()))
                        .help("the faces of STL are triangles: export the model again"));
                }
                weld.draft.face(std::mem::take(corners), Some(*line));
                open = None;
            }
            (b"", _) | (b"solid" | b"facet" | b"endfacet" | b"endsolid", None) => {}
            _ => {
                return Err(lines
                    .error(format!("'{}' does not belong here", show(&word)))
                    .help("each facet is: facet, outer loop, three vertex lines, endloop, endfacet"));
            }
        }
    }
    if let Some((line, _)) = open {
        return Err(Error::input("the file ends within an open loop")
            .at(format!("{file}:{line}"))
            .help("the file was cut off: export or copy it again"));
    }
    weld.finish()
}

pub(super) fn read_binary(mut input: impl BufRead, file: &str) -> Result<Mesh> {
    let mut take = |bytes: &mut [u8], what: &dyn Fn() -> String| {
        input.read_exact(bytes).map_err(|error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => {
                Error::input(what()).at(file).help("the file was cut off: export or copy it again")
            }
            _ => broken(&error).at(file),
        })
    };
    let mut head = [0; 84];
    take(&mut head, &|| "the file ends within its 84 bytes of header".into())?;
    let announced = u32::from_le_bytes([head[80], head[81], head[82], head[83]]);
    let mut weld = Weld::new(file);
    let mut record = [0; 50];
    for triangle in 0..announced {
        take(&mut record, &|| format!("the file ends after {triangle} of {announced} triangles"))?;
        let number = |i: usize| f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]);
        let corners =
            [12, 24, 36].map(|at| weld.corner([at, at + 4, at + 8].map(|i| number(i).into()), None));
        weld.draft.face(corners.to_vec(), None);
    }
    weld.finish()
}

/// Gives each position its vertex.
struct Weld {
    draft: Draft,
    /// Only asked, never walked: the order of vertices is that of their first corners.
    known: HashMap<[u64; 3], u32>,
}

impl Weld {
    fn new(file: &str) -> Self {
        Weld { draft: Draft::new(file, 0), known: HashMap::new() }
    }

    fn corner(&mut self, position: [f64; 3], line: Option<u64>) -> u32 {
        let position = position.map(|x| x + 0.0); // -0 becomes +0, the same place
        // An astronomic number saturates; `Mesh::check` refuses the mesh then.
        let next = u32::try_from(self.draft.vertices()).unwrap_or(u32::MAX);
        *self.known.entry(position.map(f64::to_bits)).or_insert_with(|| {
            self.draft.vertex(position, line);
            next
        })
    }

    fn finish(mut self) -> Result<Mesh> {
        let (corners, points) = (3 * self.draft.faces(), self.draft.vertices());
        self.draft.note(format!("{corners} corners were welded to {points} vertices (equal positions only)"));
        self.draft.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 6] =
        [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 1., 0.], [1., -0., 0.], [1., 1., 0.25]];

    fn text() -> String {
        let mut text = "solid two\n".to_owned();
        for triangle in CORNERS.chunks(3) {
            text += "facet normal 0 0 1\nOuter Loop\n";
            triangle.iter().for_each(|[x, y, z]| text += &format!("  vertex {x} {y} {z:e}\n"));
            text += "endloop\nendfacet\n";
        }
        text + "endsolid\n"
    }

    fn binary(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2u32.to_le_bytes());
        for triangle in CORNERS.chunks(3) {
            bytes.extend([0; 12]);
            triangle.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([1, 2]);
        }
        bytes
    }

    #[test]
    fn equal_positions_become_one_vertex() {
        for mesh in [read_text(text().as_bytes(), "x"), read_binary(&binary(b"solid")[..], "x")] {
            let mesh = mesh.unwrap();
            assert_eq!(mesh.faces, [[0, 1, 2], [2, 1, 3]]);
            assert_eq!(mesh.positions[3].to_array(), [1.0, 1.0, 0.25]);
            assert!(mesh.notes[0].starts_with("6 corners were welded to 4 vertices"));
        }
    }

    #[test]
    fn binary_that_begins_like_text_is_binary() {
        assert!(!is_text(&binary(b"solid facet")));
        assert!(is_text(text().as_bytes()));
    }

    #[test]
    fn broken_text_is_refused_at_its_line() {
        for (from, to, line, what) in [
            ("endloop\n", "", 7, "'endfacet' does not belong here"),
            ("  vertex 0 0 0e0\n", "", 6, "a loop has 2 vertices"),
            ("vertex 0 0 0e0", "vertex 0 0", 4, "fewer than three"),
            ("Outer Loop", "", 4, "'vertex' does not belong here"),
            ("endloop\nendfacet\nendsolid\n", "", 10, "ends within an open loop"),
        ] {
            let bad = text().replacen(from, to, 1);
            let error = read_text(bad.as_bytes(), "x").unwrap_err();
            assert_eq!(error.place, Some(format!("x:{line}")), "{error}");
            assert!(error.what.contains(what) && error.help.is_some(), "{error}");
        }
    }

    #[test]
    fn a_cut_binary_file_names_the_triangle() {
        let bytes = binary(b"");
        let error = read_binary(&bytes[..bytes.len() - 1], "x").unwrap_err();
        assert_eq!(error.what, "the file ends after 1 of 2 triangles");
        assert!(read_binary(&bytes[..83], "x").unwrap_err().what.contains("84 bytes"));
    }

    #[test]
    fn a_number_that_is_none_is_refused() {
        let mut bytes = binary(b"");
        bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(read_binary(&bytes[..], "x").unwrap_err().place.as_deref(), Some("x, vertex 0"));
    }
}
