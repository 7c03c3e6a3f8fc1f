//! The header of a PLY file: which elements follow, how many, and how they are written.
//!
//! ```text
//! ply
//! format binary_little_endian 1.0       or ascii, binary_big_endian
//! element vertex 8
//! property float x                      a number ...
//! element face 6
//! property list uchar int vertex_indices       ... or a counted list of numbers
//! end_header
//! ```

use super::lines::{Lines, show};
use crate::error::{Error, Result};
use std::io::BufRead;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Coordinate 0, 1 or 2 of a vertex.
    Coordinate(usize),
    /// The corners of a face.
    Corners,
    /// Read over.
    Other,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub meaning: Meaning,
    /// The type of a list's length; nothing for a single number.
    pub length: Option<Scalar>,
    pub number: Scalar,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    /// As claimed; not to be believed.
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    pub fn has(&self, meaning: Meaning) -> bool {
        self.properties.iter().any(|property| property.meaning == meaning)
    }
}

/// Reads up to and with `end_header`.
pub(super) fn read(lines: &mut Lines<impl BufRead>) -> Result<(Encoding, Vec<Element>)> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    if !lines.advance()? || lines.tokens().ne([b"ply"]) {
        return Err(wrong(lines, "a PLY file begins with a line that says ply"));
    }
    loop {
        if !lines.advance()? {
            return Err(wrong(lines, "the file ends before end_header"));
        }
        let words: Vec<&[u8]> = lines.tokens().collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, b"1.0"] => encoding = Some(encoding_named(lines, name)?),
            [b"element", name, count] => {
                let count = lines.integer(count)?;
                let count = u64::try_from(count).map_err(|_| wrong(lines, "a count is negative"))?;
                let name = String::from_utf8_lossy(name).into_owned();
                if name == "tristrips" {
                    return Err(wrong(lines, "triangle strips are not read")
                        .help("export the mesh with faces instead of strips"));
                }
                elements.push(Element { name, count, properties: Vec::new() });
            }
            [b"property", ref rest @ ..] => match elements.last_mut() {
                None => return Err(wrong(lines, "a property comes before the first element")),
                Some(element) => {
                    let property = property(lines, &element.name, rest)?;
                    element.properties.push(property);
                }
            },
            [b"end_header"] => break,
            _ => {
                let line = show(lines.text());
                return Err(wrong(lines, format!("the header line '{line}' is not understood")));
            }
        }
    }
    let encoding = encoding.ok_or_else(|| wrong(lines, "the header names no format"))?;
    for (name, meanings) in [
        ("vertex", &[Meaning::Coordinate(0), Meaning::Coordinate(1), Meaning::Coordinate(2)][..]),
        ("face", &[Meaning::Corners]),
    ] {
        let element = elements.iter().find(|element| element.name == name);
        if !element.is_some_and(|element| meanings.iter().all(|&meaning| element.has(meaning))) {
            return Err(wrong(lines, "vertices with x, y, z or faces with vertex_indices are missing")
                .help("export the model as a mesh with faces, not as points alone"));
        }
    }
    Ok((encoding, elements))
}

fn encoding_named(lines: &Lines<impl BufRead>, name: &[u8]) -> Result<Encoding> {
    match name {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(wrong(lines, format!("the format '{}' is unknown", show(name)))),
    }
}

/// What follows the word `property`.
fn property(lines: &Lines<impl BufRead>, element: &str, words: &[&[u8]]) -> Result<Property> {
    let scalar = |name: &[u8]| {
        let unknown = || wrong(lines, format!("the type '{}' is unknown", show(name)));
        Scalar::from_name(name).ok_or_else(unknown)
    };
    let (name, length, number) = match *words {
        [b"list", length, number, name] => (name, Some(scalar(length)?), scalar(number)?),
        [number, name] => (name, None, scalar(number)?),
        _ => return Err(wrong(lines, "a property has a type and a name, or list, two types and a name")),
    };
    if length.is_some_and(|length| !length.is_integer()) {
        return Err(wrong(lines, "the length of a list must have an integer type"));
    }
    let meaning = match (element, name, length) {
        ("vertex", b"x", None) => Meaning::Coordinate(0),
        ("vertex", b"y", None) => Meaning::Coordinate(1),
        ("vertex", b"z", None) => Meaning::Coordinate(2),
        ("face", b"vertex_indices" | b"vertex_index", Some(_)) if number.is_integer() => Meaning::Corners,
        _ => Meaning::Other,
    };
    Ok(Property { meaning, length, number })
}

fn wrong(lines: &Lines<impl BufRead>, what: impl Into<String>) -> Error {
    lines.error(what).help("the header must follow the PLY format 1.0: export the model again")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Result<(Encoding, Vec<Element>)> {
        read(&mut Lines::new(text.as_bytes(), "x.ply"))
    }

    const GOOD: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty double y\n\
        property int16 z\nproperty list uchar float extra\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";

    #[test]
    fn elements_and_their_properties() {
        let (encoding, elements) = header(GOOD).unwrap();
        assert_eq!(encoding, Encoding::Ascii);
        let vertex = &elements[0];
        assert_eq!((vertex.name.as_str(), vertex.count, vertex.properties.len()), ("vertex", 3, 4));
        assert_eq!(vertex.properties[3].meaning, Meaning::Other);
        assert_eq!(elements[1].properties[0].meaning, Meaning::Corners);
    }

    #[test]
    fn each_mistake_in_a_header_has_its_line() {
        for (from, to, line) in [
            ("ply\n", "plx\n", 1),
            ("format ascii 1.0\n", "format ascii 2.0\n", 2),
            ("ascii", "base64", 2),
            ("format ascii 1.0\n", "", 10),
            ("vertex 3", "vertex -3", 4),
            ("vertex 3", "vertex 99999999999999999999", 4),
            ("element vertex 3\n", "", 4),
            ("float x", "half x", 5),
            ("float x", "list float int x", 5),
            ("float x", "float", 5),
            ("float x", "float w", 11),
            ("uchar int vertex_index", "uchar float vertex_index", 11),
            ("element face", "element tristrips", 9),
            ("end_header\n", "", 11),
        ] {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD);
            let error = header(&text).unwrap_err();
            assert_eq!(error.place, Some(format!("x.ply:{line}")), "{to}: {error}");
            assert!(error.help.is_some());
        }
    }
}
