//! PLY, the Stanford format: ascii and binary of either byte order, any properties in any order.
//!
//! ```text
//! header ─► for each element: for each property: a number, or a counted list of numbers
//! ```
//!
//! Only x, y, z of `vertex` and the corner list of `face` are kept.

use super::draft::Draft;
use super::lines::{Lines, broken, show};
use super::ply_header::{self, Element, Encoding, Meaning, Scalar};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::{BufRead, ErrorKind};

pub(super) fn read(input: impl BufRead, file: &str) -> Result<Mesh> {
    let mut lines = Lines::new(input, file);
    let (encoding, elements) = ply_header::read(&mut lines)?;
    if encoding == Encoding::Ascii {
        return elements_of(Ascii { lines, cursor: 0 }, elements, file);
    }
    let little = encoding == Encoding::LittleEndian;
    let binary = Binary { input: lines.into_input(), little, file, element: String::new(), index: 0 };
    elements_of(binary, elements, file)
}

fn elements_of(mut values: impl Values, elements: Vec<Element>, file: &str) -> Result<Mesh> {
    let mut draft = Draft::new(file, 0);
    // Elements without properties take no room, however many there are said to be.
    for element in elements.iter().filter(|element| !element.properties.is_empty()) {
        for index in 0..element.count {
            values.begin(element, index)?;
            read_element(&mut values, element, &mut draft)?;
            values.end()?;
        }
    }
    draft.finish()
}

fn read_element(values: &mut impl Values, element: &Element, draft: &mut Draft) -> Result<()> {
    let mut position = [0.0; 3];
    let mut corners = Vec::new();
    for property in &element.properties {
        let Some(length) = property.length else {
            let number = values.number(property.number)?;
            if let Meaning::Coordinate(axis) = property.meaning {
                position[axis] = number;
            }
            continue;
        };
        let length = values.number(length)?;
        let length = index(length).ok_or_else(|| {
            values.error(format!("a list of {length} entries")).help("the length of a list is never negative")
        })?;
        for _ in 0..length {
            let number = values.number(property.number)?;
            if property.meaning == Meaning::Corners {
                corners.push(index(number).ok_or_else(|| {
                    let what = format!("{number} is no index of a vertex");
                    values.error(what).help("indices count from 0, up to 2^32 - 1")
                })?);
            }
        }
    }
    match element.name.as_str() {
        "vertex" if element.has(Meaning::Coordinate(0)) => draft.vertex(position, values.line()),
        "face" if element.has(Meaning::Corners) => draft.face(corners, values.line()),
        _ => {}
    }
    Ok(())
}

/// A number read as an integer type, back as an index; every integer type of PLY is exact in `f64`.
fn index(number: f64) -> Option<u32> {
    (number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0).then_some(number as u32)
}

/// The numbers of the body, one after the other.
trait Values {
    fn begin(&mut self, element: &Element, index: u64) -> Result<()>;
    fn number(&mut self, kind: Scalar) -> Result<f64>;
    fn end(&mut self) -> Result<()>;
    fn line(&self) -> Option<u64>;
    fn error(&self, what: String) -> Error;
}

fn cut_off(element: &str, index: u64) -> String {
    format!("the file ends within {element} {index} (counted from 0)")
}

/// One element a line.
struct Ascii<R> {
    lines: Lines<R>,
    /// The first byte of the line not looked at yet.
    cursor: usize,
}

impl<R: BufRead> Ascii<R> {
    fn token(&mut self) -> Option<std::ops::Range<usize>> {
        let rest = &self.lines.text()[self.cursor..];
        let start = self.cursor + rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let word = &self.lines.text()[start..];
        let length = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.cursor = start + length;
        Some(start..start + length)
    }
}

impl<R: BufRead> Values for Ascii<R> {
    fn begin(&mut self, element: &Element, index: u64) -> Result<()> {
        loop {
            if !self.lines.advance()? {
                let what = cut_off(&element.name, index);
                return Err(self.error(what).help("the file was cut off: export or copy it again"));
            }
            self.cursor = 0;
            if self.lines.tokens().next().is_some() {
                return Ok(());
            }
        }
    }

    fn number(&mut self, kind: Scalar) -> Result<f64> {
        let Some(token) = self.token() else {
            let help = "write each element on one line, with all properties that the header names";
            return Err(self.error("the line has too few numbers".into()).help(help));
        };
        let token = &self.lines.text()[token];
        if kind.is_integer() { Ok(self.lines.integer(token)? as f64) } else { self.lines.real(token) }
    }

    fn end(&mut self) -> Result<()> {
        match self.token() {
            None => Ok(()),
            Some(token) => {
                let extra = show(&self.lines.text()[token]);
                let what = format!("the line has more numbers than the header names, from '{extra}' on");
                Err(self.error(what).help("name all properties in the header, or remove the numbers"))
            }
        }
    }

    fn line(&self) -> Option<u64> {
        Some(self.lines.number())
    }

    fn error(&self, what: String) -> Error {
        self.lines.error(what)
    }
}

struct Binary<'a, R> {
    input: R,
    little: bool,
    file: &'a str,
    element: String,
    index: u64,
}

impl<R: BufRead> Binary<'_, R> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.input.read_exact(&mut bytes).map_err(|error| {
            if error.kind() == ErrorKind::UnexpectedEof {
                let what = cut_off(&self.element, self.index);
                Error::input(what).help("the file was cut off: export or copy it again").at(self.file)
            } else {
                broken(&error).at(self.file)
            }
        })?;
        if self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<R: BufRead> Values for Binary<'_, R> {
    fn begin(&mut self, element: &Element, index: u64) -> Result<()> {
        self.index = index;
        if index == 0 {
            self.element.clone_from(&element.name);
        }
        Ok(())
    }

    fn number(&mut self, kind: Scalar) -> Result<f64> {
        Ok(match kind {
            Scalar::I8 => i8::from_be_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_be_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_be_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_be_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_be_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_be_bytes(self.bytes()?).into(),
            Scalar::F32 => f32::from_be_bytes(self.bytes()?).into(),
            Scalar::F64 => f64::from_be_bytes(self.bytes()?),
        })
    }

    fn end(&mut self) -> Result<()> {
        Ok(())
    }

    fn line(&self) -> Option<u64> {
        None
    }

    fn error(&self, what: String) -> Error {
        Error::input(what).at(format!("{}, {} {}", self.file, self.element, self.index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Properties in an unusual order, an element in between, a list to read over.
    fn file(format: &str, body: &[u8]) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty uchar red\nproperty double z\n\
             property list ushort short tail\nproperty float x\nproperty int y\nelement nothing 1000000000000\n\
             element edge 1\nproperty char a\nelement face 1\nproperty list uint ushort vertex_indices\nend_header\n"
        )
        .into_bytes();
        bytes.extend(body);
        bytes
    }

    fn binary_body(bytes_of: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
        let mut body = Vec::new();
        for (x, y, z) in [(0.0f32, 0i32, 0.5f64), (1.5, 0, 0.5), (0.0, -1, 0.5)] {
            body.push(200);
            for field in [&z.to_be_bytes()[..], &2u16.to_be_bytes(), &[0, 7], &[255, 249]] {
                body.extend(bytes_of(field));
            }
            body.extend(bytes_of(&x.to_be_bytes()));
            body.extend(bytes_of(&y.to_be_bytes()));
        }
        body.push(255);
        for field in [&3u32.to_be_bytes()[..], &[0, 2], &[0, 0], &[0, 1]] {
            body.extend(bytes_of(field));
        }
        body
    }

    #[test]
    fn the_three_encodings_say_the_same() {
        let ascii = b"200 .5 2 7 -7 0 0\n\n200 .5 2 7 -7 1.5 0\n200 .5 2 7 -7 0 -1\n-1\n3 2 0 1\n";
        let mesh = read(&file("ascii", ascii)[..], "x").unwrap();
        assert_eq!(mesh.positions[1].to_array(), [1.5, 0.0, 0.5]);
        assert_eq!(mesh.positions[2].to_array(), [0.0, -1.0, 0.5]);
        assert_eq!(mesh.faces, [[2, 0, 1]]);
        assert_eq!(mesh.source.as_ref().unwrap().vertex_lines, [15, 17, 18]);
        let big = binary_body(<[u8]>::to_vec);
        let little = binary_body(|field| field.iter().rev().copied().collect());
        for (format, body) in [("binary_big_endian", big), ("binary_little_endian", little)] {
            let other = read(&file(format, &body)[..], "x").unwrap();
            assert_eq!((&other.positions, &other.faces), (&mesh.positions, &mesh.faces), "{format}");
        }
    }

    #[test]
    fn a_binary_file_cut_anywhere_is_refused_with_its_element() {
        let whole = file("binary_big_endian", &binary_body(<[u8]>::to_vec));
        let error = read(&whole[..whole.len() - 1], "x").unwrap_err();
        assert!(error.what.contains("within face 0"), "{error}");
        for length in 0..whole.len() {
            assert!(read(&whole[..length], "x").is_err());
        }
    }

    #[test]
    fn astronomic_counts_reserve_no_memory() {
        for (format, body) in [("ascii", &b"200 .5 4000000000 1\n"[..]), ("binary_big_endian", &[255; 30])] {
            let text = String::from_utf8(file(format, b"")).unwrap();
            let mut bytes = text.replace("vertex 3", "vertex 1000000000000").into_bytes();
            bytes.extend(body);
            assert!(read(&bytes[..], "x").is_err());
        }
    }

    #[test]
    fn lines_have_exactly_the_announced_numbers() {
        for (bad, what) in [
            ("200 .5 2 7 -7 0\n", "too few"),
            ("200 .5 2 7 -7 0 0 0\n", "more numbers than the header names, from '0'"),
            ("200 .5 -1 0 0\n", "a list of -1 entries"),
            ("200 .5 0 nan 0\n", "not a number"),
            ("200 .5 0 1 1.5\n", "not a whole number"),
        ] {
            let error = read(&file("ascii", bad.as_bytes())[..], "x").unwrap_err();
            assert!(error.what.contains(what), "{error}");
            assert_eq!(error.place.as_deref(), Some("x:15"));
            assert!(error.help.is_some());
        }
    }
}
