//! Wavefront OBJ.
//!
//! ```text
//! v  x y z [w or r g b]        a vertex, numbered from 1
//! f  1 2/2 -1//5               a face: vertex[/texture][/normal]; -1 is the latest vertex
//! ```
//!
//! All else is passed over. `t crease` and `t corner` (OpenSubdiv's tags) are counted, because without them
//! the surface is another one.

use super::{draft::Draft, lines::Lines, lines::show};
use crate::error::Result;
use crate::mesh::Mesh;
use std::io::BufRead;

pub(super) fn read(input: impl BufRead, file: &str) -> Result<Mesh> {
    let mut lines = Lines::new(input, file);
    let mut draft = Draft::new(file, 1);
    let mut tags = 0;
    while lines.advance_joined()? {
        let mut tokens = lines.tokens();
        match tokens.next() {
            Some(b"v") => draft.vertex(lines.point(tokens)?, Some(lines.number())),
            Some(b"f") => {
                let corners = tokens.map(|token| corner(&lines, token, draft.vertices()));
                let corners = corners.collect::<Result<_>>()?;
                draft.face(corners, Some(lines.number()));
            }
            Some(b"t") => tags += 1,
            _ => {}
        }
    }
    if tags > 0 {
        draft.note(format!(
            "{tags} tags (crease or corner) were passed over: the surface is smooth everywhere"
        ));
    }
    draft.finish()
}

/// `vertex[/texture][/normal]` as an index from 0.
fn corner(lines: &Lines<impl BufRead>, token: &[u8], vertices: usize) -> Result<u32> {
    let number = token.split(|byte| *byte == b'/').next().unwrap_or(token);
    let vertex = lines.integer(number)?;
    let index = if vertex < 0 { vertices as i64 + vertex } else { vertex - 1 };
    u32::try_from(index).map_err(|_| {
        lines
            .error(format!("there is no vertex {} ({vertices} vertices so far)", show(number)))
            .help("vertices count from 1; negative numbers count back from the latest, -1")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obj(text: &str) -> Result<Mesh> {
        read(text.as_bytes(), "x.obj")
    }

    #[test]
    fn all_forms_of_a_corner_mean_the_vertex() {
        let text =
            "v 0 0 0\nv 1 0 0 1\nvt 0 0\nf 1/1 2/1/9 4//7\nv 1 1 0 .5 .5 .5\nv 0 1 0\nf -4 -2 \\\n -1\n";
        let mesh = obj(text).unwrap();
        assert_eq!(mesh.faces, [[0, 1, 3], [0, 2, 3]]);
        let source = mesh.source.unwrap();
        assert_eq!((source.vertex_lines, source.face_lines), (vec![1, 2, 5, 6], vec![4, 7]));
    }

    #[test]
    fn errors_carry_the_line() {
        for (text, place) in [
            ("v 0 0\n", "x.obj:1"),
            ("v 0 0 nan\n", "x.obj:1"),
            ("v 0 0 0\nf 1 2 x\n", "x.obj:2"),
            ("v 0 0 0\nf 0 1 1\n", "x.obj:2"),
            ("v 0 0 0\nf -2 1 1\n", "x.obj:2"),
            ("v 0 0 0\n\nf 1 2 3\n", "x.obj:3"),
            ("v 0 0 0\nf 1 1 9223372036854775808\n", "x.obj:2"),
            ("v 0 0 0\nf 1 -9223372036854775808 1\n", "x.obj:2"),
        ] {
            let error = obj(text).unwrap_err();
            assert_eq!(error.place.as_deref(), Some(place), "{text}");
            assert!(error.help.is_some(), "{text}");
        }
    }

    #[test]
    fn ignored_creases_are_told() {
        let mesh = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nt crease 2/1/0 0 1 2.0\n").unwrap();
        assert!(mesh.notes[0].starts_with("1 tags"));
    }
}
