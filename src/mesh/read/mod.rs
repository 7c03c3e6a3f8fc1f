//! Reading meshes: OBJ, OFF, PLY, STL and SGI Inventor ASCII.
//!
//! ```text
//! file ─► format by extension, else by content ─► its reader ─► check ─► Mesh
//! ```
//!
//! Nothing a file claims is believed before it is there: counts reserve no memory, lines end after 64 KiB,
//! and whatever is wrong comes back as one message with file, line and remedy. The reader never panics.

mod draft;
mod inventor;
mod lines;
mod obj;
mod off;
mod ply;
mod ply_header;
mod stl;

use super::Mesh;
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

/// The file formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    Obj,
    Off,
    Ply,
    Stl,
    Inventor,
}

impl FileFormat {
    /// For messages.
    pub const NAMES: &str = "OBJ, OFF, PLY, STL and SGI Inventor ASCII (.iv)";

    /// The format that a file name promises.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "off" | "coff" | "noff" => Some(Self::Off),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "iv" | "wrl" => Some(Self::Inventor),
            _ => None,
        }
    }

    /// The format that the first bytes of a file look like.
    pub fn of_content(head: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(head);
        let begins = |word: &str| text.trim_start().starts_with(word);
        let has_line = |words: [&str; 2]| {
            text.lines().any(|line| words.iter().any(|word| line.trim_start().starts_with(word)))
        };
        if begins("ply") {
            Some(Self::Ply)
        } else if begins("#Inventor") || begins("#VRML") || has_line(["Coordinate3", "IndexedFaceSet"]) {
            Some(Self::Inventor)
        } else if ["OFF", "COFF", "NOFF", "CNOFF", "STOFF"].into_iter().any(begins) {
            Some(Self::Off)
        } else if stl::is_text(head) {
            Some(Self::Stl)
        } else if has_line(["v ", "f "]) {
            Some(Self::Obj)
        } else {
            None
        }
    }
}

/// Reads a mesh; the format comes from the extension, and where that is unknown from the content.
///
/// Vertices that no face uses are left out, and STL corners at exactly the same position become one vertex;
/// [`Mesh::notes`] says so.
///
/// # Errors
/// [`crate::Kind::Input`], with file and line (file and element in binary files) and a remedy.
pub fn read(path: &Path) -> Result<Mesh> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        Error::input(format!("cannot read the mesh: {error}"))
            .at(&name)
            .help("check the path; `subdiv-rtl shapes` lists the built-in meshes")
    };
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(Error::input("this is a folder, not a mesh").at(&name).help("name one file in it"));
    }
    let mut mesh = read_from(file, &name, FileFormat::of_path(path))?;
    mesh.name = path.file_stem().map_or(name, |stem| stem.to_string_lossy().into_owned());
    Ok(mesh)
}

/// How much of a file is looked at to find its format.
const HEAD: u64 = 4096;

/// Reads a mesh from anywhere; `file` is what messages call it, and the format is found from the content
/// where none is given.
pub fn read_from(mut input: impl Read, file: &str, format: Option<FileFormat>) -> Result<Mesh> {
    let mut head = Vec::new();
    input.by_ref().take(HEAD).read_to_end(&mut head).map_err(|error| lines::broken(&error).at(file))?;
    if head.iter().all(u8::is_ascii_whitespace) && (head.len() as u64) < HEAD {
        return Err(Error::input("the file is empty").at(file).help("export the model again"));
    }
    let format = format.or_else(|| FileFormat::of_content(&head)).ok_or_else(|| {
        Error::input("the format of this file is unknown")
            .at(file)
            .help(format!("{} are read; give the file its usual extension", FileFormat::NAMES))
    })?;
    let text = format == FileFormat::Stl && stl::is_text(&head);
    let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }; // UTF-8 byte order mark
    let input = BufReader::with_capacity(1 << 16, Cursor::new(head.split_off(mark)).chain(input));
    match format {
        FileFormat::Obj => obj::read(input, file),
        FileFormat::Off => off::read(input, file),
        FileFormat::Ply => ply::read(input, file),
        FileFormat::Stl if text => stl::read_text(input, file),
        FileFormat::Stl => stl::read_binary(input, file),
        FileFormat::Inventor => inventor::read(input, file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_the_format() {
        for (content, format) in [
            ("ply\nformat ascii 1.0\n", Some(FileFormat::Ply)),
            ("COFF\n3 1 0\n", Some(FileFormat::Off)),
            ("# a\nv 0 0 0\n", Some(FileFormat::Obj)),
            ("solid x\nfacet normal 0 0 1\n", Some(FileFormat::Stl)),
            ("Coordinate3 {\n", Some(FileFormat::Inventor)),
            ("<html>", None),
        ] {
            assert_eq!(FileFormat::of_content(content.as_bytes()), format, "{content}");
        }
    }

    #[test]
    fn an_extension_goes_before_the_content() {
        assert_eq!(FileFormat::of_path(Path::new("a/B.OBJ")), Some(FileFormat::Obj));
        assert_eq!(FileFormat::of_path(Path::new("obj")), None);
    }

    #[test]
    fn nothing_and_blanks_are_an_empty_file() {
        for content in ["", " \n\n"] {
            let error = read_from(content.as_bytes(), "x.obj", Some(FileFormat::Obj)).unwrap_err();
            assert_eq!((error.what.as_str(), error.place.as_deref()), ("the file is empty", Some("x.obj")));
        }
    }

    #[test]
    fn a_byte_order_mark_is_skipped() {
        let mesh = read_from("\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".as_bytes(), "x.obj", None);
        assert_eq!(mesh.unwrap().positions.len(), 3);
    }
}
