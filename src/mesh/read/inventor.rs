//! SGI Inventor ASCII, as printed in Hall, "Quadstrip subdivision" (thesis), chapter 5.
//!
//! ```text
//! Coordinate3    { point [ -1.0 -1.0 1.0,  1.0 -1.0 1.0,  ... ] }
//! IndexedFaceSet { materialIndex -1   coordIndex [ 0, 1, 3, 2, -1,   2, 3, 7, 6, -1,   ... ] }
//! ```
//!
//! Commas are blanks, `#` begins a comment, -1 closes a polygon. An `IndexedFaceSet` uses the latest
//! `Coordinate3` of its separator; several of them become one mesh. All other fields are passed over; nodes
//! that would move the points are refused, because what was read would not be what the file shows.

use super::{draft::Draft, lines::Lines, lines::broken, lines::show};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::BufRead;
use std::ops::Range;

const MOVING: [&[u8]; 9] = [
    b"Transform",
    b"Translation",
    b"Rotation",
    b"RotationXYZ",
    b"Scale",
    b"MatrixTransform",
    b"ResetTransform",
    b"Units",
    b"Array",
];

pub(super) fn read(mut input: impl BufRead, file: &str) -> Result<Mesh> {
    let head = input.fill_buf().map_err(|error| broken(&error).at(file))?;
    let first_line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let contains = |word: &[u8]| first_line.windows(word.len()).any(|window| window == word);
    if first_line.starts_with(b"#") && (contains(b" binary") || contains(b"VRML V2")) {
        return Err(Error::input("this kind of Inventor or VRML file is not read")
            .at(format!("{file}:1"))
            .help("export the mesh as Inventor ASCII, OBJ or PLY"));
    }
    let mut scene = Scene {
        words: Words { lines: Lines::new(input, file), word: 0..0, cursor: 0 },
        draft: Draft::new(file, 0),
        points: 0..0,
    };
    scene.nodes()?;
    scene.draft.finish()
}

struct Scene<R> {
    words: Words<R>,
    draft: Draft,
    /// The vertices of the current `Coordinate3`.
    points: Range<usize>,
}

impl<R: BufRead> Scene<R> {
    fn nodes(&mut self) -> Result<()> {
        let mut outer = Vec::new(); // the points to return to at the end of each open brace
        let mut separates = false;
        while self.words.advance()? {
            let was_separator = std::mem::take(&mut separates);
            match self.words.word() {
                b"{" => outer.push(was_separator.then(|| self.points.clone())),
                b"}" => match outer.pop() {
                    Some(points) => self.points = points.unwrap_or(self.points.clone()),
                    None => return Err(self.words.error("a brace closes what was never opened")),
                },
                b"Separator" | b"TransformSeparator" => separates = true,
                b"DEF" => self.words.expect("a name")?,
                b"USE" => {
                    return Err(self
                        .words
                        .error("USE repeats a part of the scene, which is not followed")
                        .help("export the model as one plain mesh"));
                }
                b"Coordinate3" => {
                    let first = self.draft.vertices();
                    self.fields(b"point", Self::point_list)?;
                    self.points = first..self.draft.vertices();
                }
                b"IndexedFaceSet" => self.fields(b"coordIndex", Self::polygons)?,
                word if MOVING.contains(&word) => {
                    let what = format!("a {} node moves the points, which is not followed", show(word));
                    return Err(self
                        .words
                        .error(what)
                        .help("apply the transformation in a modeller and export the mesh again"));
                }
                _ => {}
            }
        }
        if outer.is_empty() { Ok(()) } else { Err(self.words.error("the file ends within open braces")) }
    }

    /// The fields of one node, `{ name value name value ... }`; `read` takes the one called `wanted`.
    fn fields(&mut self, wanted: &[u8], read: fn(&mut Self) -> Result<()>) -> Result<()> {
        self.words.expect("{")?;
        if self.words.word() != b"{" {
            let word = show(self.words.word());
            return Err(self.words.error(format!("'{word}' stands where '{{' belongs")));
        }
        let mut depth = 0;
        loop {
            self.words.expect("}")?;
            match self.words.word() {
                b"}" if depth == 0 => return Ok(()),
                b"}" | b"]" => depth -= 1,
                b"{" | b"[" => depth += 1,
                word if word == wanted && depth == 0 => read(self)?,
                _ => {}
            }
            if depth < 0 {
                return Err(self.words.error("a bracket closes what was never opened"));
            }
        }
    }

    fn point_list(&mut self) -> Result<()> {
        let mut point = Vec::with_capacity(3);
        let mut line = 0;
        self.words.list(|words| {
            if point.is_empty() {
                line = words.lines.number();
            }
            point.push(words.lines.real(words.word())?);
            if let [x, y, z] = point[..] {
                self.draft.vertex([x, y, z], Some(line));
                point.clear();
            }
            Ok(())
        })?;
        if point.is_empty() {
            return Ok(());
        }
        Err(self.words.error("the last point has fewer than three coordinates"))
    }

    fn polygons(&mut self) -> Result<()> {
        let mut corners = Vec::new();
        let mut line = 0;
        let points = self.points.clone();
        self.words.list(|words| {
            if corners.is_empty() {
                line = words.lines.number();
            }
            let index = words.lines.integer(words.word())?;
            if index == -1 {
                self.draft.face(std::mem::take(&mut corners), Some(line));
                return Ok(());
            }
            match usize::try_from(index) {
                Ok(index) if index < points.len() => corners.push((points.start + index) as u32),
                _ => {
                    let what = format!("there is no point {index}: Coordinate3 has {}", points.len());
                    return Err(words.error(what).help("indices count from 0; -1 ends a polygon"));
                }
            }
            Ok(())
        })?;
        if corners.is_empty() {
            return Ok(());
        }
        Err(Error::input(format!("an open polygon: its {} corners are not followed by -1", corners.len()))
            .at(format!("{}:{line}", self.words.lines.file()))
            .help("end each polygon of coordIndex with -1"))
    }
}

/// The words of the file: names, numbers, and each brace and bracket by itself.
struct Words<R> {
    lines: Lines<R>,
    word: Range<usize>,
    cursor: usize,
}

impl<R: BufRead> Words<R> {
    fn word(&self) -> &[u8] {
        &self.lines.text()[self.word.clone()]
    }

    /// Goes to the next word; false at the end of the file.
    fn advance(&mut self) -> Result<bool> {
        loop {
            let text = &self.lines.text()[self.cursor..];
            let blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
            let start = text.iter().position(|byte| !blank(byte)).unwrap_or(text.len());
            let word = &text[start..];
            let length = match word.first() {
                None | Some(b'#') => {
                    self.cursor = 0;
                    if !self.lines.advance()? {
                        self.word = 0..0;
                        return Ok(false);
                    }
                    continue;
                }
                Some(b'{' | b'}' | b'[' | b']') => 1,
                Some(b'"') => word[1..].iter().position(|byte| *byte == b'"').map_or(word.len(), |at| at + 2),
                Some(_) => {
                    let ends = |byte: &u8| blank(byte) || b"{}[]#\"".contains(byte);
                    word.iter().position(ends).unwrap_or(word.len())
                }
            };
            self.word = self.cursor + start..self.cursor + start + length;
            self.cursor = self.word.end;
            return Ok(true);
        }
    }

    /// Goes to the next word, which must be there.
    fn expect(&mut self, what: &str) -> Result<()> {
        if self.advance()? {
            return Ok(());
        }
        Err(self.error(format!("the file ends where {what} is still to come")))
    }

    /// Calls `each` for the values of a field: of `[a b c]`.
    fn list(&mut self, mut each: impl FnMut(&Self) -> Result<()>) -> Result<()> {
        self.expect("[")?;
        if self.word() != b"[" {
            let word = show(self.word());
            return Err(self.error(format!("'{word}' stands where the list's '[' belongs")));
        }
        loop {
            self.expect("]")?;
            if self.word() == b"]" {
                return Ok(());
            }
            each(self)?;
        }
    }

    fn error(&self, what: impl Into<String>) -> Error {
        self.lines
            .error(what)
            .help("expected: Coordinate3 { point [ ... ] } and IndexedFaceSet { coordIndex [ ... -1 ] }")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The box of Hall, chapter 5, as it is printed there.
    const BOX: &str = "Coordinate3 {
  point [
    -1.0 -1.0 1.0,
    1.0 -1.0  1.0,
    -1.0  1.0  1.0,
    1.0  1.0  1.0,
    -1.0 -1.0 -1.0,
    1.0 -1.0 -1.0,
    -1.0  1.0 -1.0,
    1.0  1.0 -1.0,
  ]
}
IndexedFaceSet {
  materialIndex  -1
  normalIndex    -1
  textureCoordIndex  -1
  coordIndex     [
    0, 1, 3, 2, -1,
    2, 3, 7, 6, -1,
    6, 7, 5, 4, -1,
    4, 5, 1, 0, -1,
    1, 5, 7, 3, -1,
    2, 6, 4, 0, -1,
  ]
}
";

    fn iv(text: &str) -> Result<Mesh> {
        read(text.as_bytes(), "x.iv")
    }

    #[test]
    fn the_box_as_printed() {
        let mesh = iv(BOX).unwrap();
        assert_eq!(mesh.positions[6].to_array(), [-1.0, 1.0, -1.0]);
        assert_eq!(mesh.faces[5], [2, 6, 4, 0]);
        let source = mesh.source.unwrap();
        assert_eq!((source.vertex_lines[6], source.face_lines[5]), (9, 23));
    }

    #[test]
    fn a_separator_gives_back_the_points_before_it() {
        let triangle = "IndexedFaceSet { coordIndex [0 1 2 -1] }";
        let text = format!(
            "#Inventor V2.1 ascii\nDEF IndexedFaceSet Separator {{ Material {{ diffuseColor [1 0 0] }}\n\
             Coordinate3{{point[0 0 0 1 0 0 0 1 0]}} Separator {{ Coordinate3 {{ point [5 0 0 6 0 0 5 1 0] }}\n\
             {triangle} }} Info {{ string \"USE }} {{\" }} {triangle} }}"
        );
        assert_eq!(iv(&text).unwrap().faces, [[3, 4, 5], [0, 1, 2]]);
    }

    #[test]
    fn what_cannot_be_read_is_refused_at_its_line() {
        for (from, to, line, what) in [
            ("2, 6, 4, 0, -1,\n", "2, 6, 4, 0\n", 23, "open polygon"),
            ("4, 5, 1, 0, -1,", "4, 5, 1, 8, -1,", 21, "no point 8"),
            ("4, 5, 1, 0, -1,", "4, 5, -2, 8, -1,", 21, "no point -2"),
            ("1.0  1.0 -1.0,\n  ]", "1.0  1.0\n  ]", 11, "fewer than three"),
            ("1.0 -1.0  1.0", "1.0 1e999  1.0", 4, "infinite"),
            ("IndexedFaceSet", "USE a IndexedFaceSet", 13, "USE"),
            ("IndexedFaceSet", "Scale { scaleFactor 2 2 2 } IndexedFaceSet", 13, "Scale node"),
            ("coordIndex     [", "coordIndex", 18, "'['"),
            ("  ]\n}\nIndexed", "  \n}\nIndexed", 12, "not a number"),
            ("Coordinate3 {", "Coordinate3", 2, "'{'"),
            ("Coordinate3 {", "} Coordinate3 {", 1, "closes what was never opened"),
            ("Coordinate3 {", "#VRML V2.0 utf8", 1, "not read"),
        ] {
            let text = BOX.replacen(from, to, 1);
            assert_ne!(text, BOX, "{from}");
            let error = iv(&text).unwrap_err();
            assert!(error.what.contains(what) && error.help.is_some(), "{error}");
            assert_eq!(error.place, Some(format!("x.iv:{line}")), "{error}");
        }
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        let end = BOX.trim_end().len();
        for length in 1..end {
            assert!(iv(&BOX[..length]).is_err(), "{length}");
        }
    }
}
