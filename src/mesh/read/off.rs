//! OFF, the format of Geomview, with its coloured, textured and normal-carrying variants.
//!
//! ```text
//! OFF                 or COFF, NOFF, CNOFF, STOFF ...; `#` begins a comment
//! 4 2 5               vertices, faces, edges (the last is not used)
//! 0 0 0 [more]        each vertex: x y z, then what the variant adds
//! 3  0 1 2 [colour]   each face: number of corners, corners from 0
//! ```

use super::{draft::Draft, lines::Lines, lines::show};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::BufRead;

pub(super) fn read(input: impl BufRead, file: &str) -> Result<Mesh> {
    let mut lines = Lines::new(input, file);
    let mut draft = Draft::new(file, 0);
    let [vertices, faces] = header(&mut lines)?;
    for seen in 0..vertices {
        expect_line(&mut lines, seen, vertices, "vertices")?;
        draft.vertex(lines.point(words(&lines))?, Some(lines.number()));
    }
    for seen in 0..faces {
        expect_line(&mut lines, seen, faces, "faces")?;
        draft.face(face(&lines)?, Some(lines.number()));
    }
    if advance(&mut lines)? {
        return Err(lines
            .error(format!("more lines than the {vertices} vertices and {faces} faces announced"))
            .help("correct the counts at the top of the file"));
    }
    draft.finish()
}

/// Checks the keyword and returns the numbers of vertices and faces.
fn header(lines: &mut Lines<impl BufRead>) -> Result<[u32; 2]> {
    advance(lines)?;
    let keyword = words(lines).next().unwrap_or_default();
    let Some(variant) = keyword.strip_suffix(b"OFF") else {
        return Err(lines
            .error(format!("an OFF file begins with the word OFF, not '{}'", show(keyword)))
            .help("give the file the extension of its true format"));
    };
    let binary = words(lines).nth(1).is_some_and(|word| word == b"BINARY");
    if binary || variant.iter().any(|letter| !b"STCN".contains(letter)) {
        return Err(lines
            .error("binary OFF files and those with other than three dimensions are not read")
            .help("export the mesh as plain OFF, OBJ or PLY"));
    }
    // The counts may stand beside the keyword.
    let beside = words(lines).count() > 1;
    if !beside {
        advance(lines)?;
    }
    let mut counts = words(lines).skip(usize::from(beside));
    let mut count = || match counts.next() {
        Some(token) => lines.index(token),
        None => Err(lines
            .error("the numbers of vertices and faces are missing")
            .help("write them below the word OFF: vertices faces edges")),
    };
    Ok([count()?, count()?])
}

fn face(lines: &Lines<impl BufRead>) -> Result<Vec<u32>> {
    let mut words = words(lines);
    let corners = words.next().map_or(Ok(0), |token| lines.index(token))?;
    let mut corner = || match words.next() {
        Some(token) => lines.index(token),
        None => Err(lines
            .error(format!("a face announces {corners} corners and has fewer"))
            .help("correct the number at the beginning of the line")),
    };
    (0..corners).map(|_| corner()).collect()
}

/// Goes to the next line that says something.
fn advance(lines: &mut Lines<impl BufRead>) -> Result<bool> {
    while lines.advance()? {
        if words(lines).next().is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn expect_line(lines: &mut Lines<impl BufRead>, seen: u32, announced: u32, what: &str) -> Result<()> {
    if advance(lines)? {
        return Ok(());
    }
    Err(Error::input(format!("the file ends after {seen} of {announced} {what}"))
        .at(lines.here())
        .help("the file was cut off: export or copy it again"))
}

/// The words of the line up to a comment.
fn words<R: BufRead>(lines: &Lines<R>) -> impl Iterator<Item = &[u8]> {
    let text = lines.text().split(|byte| *byte == b'#').next().unwrap_or_default();
    text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off(text: &str) -> Result<Mesh> {
        read(text.as_bytes(), "x.off")
    }

    #[test]
    fn comments_colours_and_counts_beside_the_keyword() {
        let text = "# c\nCOFF 3 1 0 # counts\n0 0 0 255 0 0 255\n\n1 0 0 0 0 0 0\n# c\n0 1 0\n3 0 1 2 0.5 0.5 0.5\n#\n";
        let mesh = off(text).unwrap();
        assert_eq!(mesh.faces, [[0, 1, 2]]);
        assert_eq!(mesh.source.unwrap().vertex_lines, [3, 5, 7]);
    }

    #[test]
    fn errors_carry_the_line() {
        for (text, place, what) in [
            ("OBJ\n", 1, "begins with the word OFF"),
            ("4OFF\n1 1 1\n", 1, "three dimensions"),
            ("OFF BINARY\n", 1, "binary"),
            ("OFF\n", 2, "numbers of vertices and faces are missing"),
            ("OFF\n3\n", 2, "numbers of vertices and faces are missing"),
            ("OFF\n4294967295 1 0\n0 0 0\n", 4, "ends after 1 of 4294967295 vertices"),
            ("OFF\n1 1 0\n0 0 0\n9 0 1\n", 4, "announces 9 corners"),
            ("OFF\n1 0 0\n0 0 0\n0 0 0\n", 4, "more lines"),
        ] {
            let error = off(text).unwrap_err();
            assert_eq!(error.place, Some(format!("x.off:{place}")), "{text}");
            assert!(error.what.contains(what) && error.help.is_some(), "{error}");
        }
    }
}
