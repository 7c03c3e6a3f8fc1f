//! A strip of quads through a `cc-strip`: the words that go in, the columns that come out.
//!
//! ```text
//! column  =  top vertex, what lies outside of it, bottom vertex, what lies outside of it
//! strip   =  left guard, columns 0 .. M, right guard
//! ```

use crate::cores::cc_strip::Role;
use crate::cosim::{Beat, Port};
use crate::surface::catmull_clark::strips::records::{Guard, Outside, StripRecords};

type Point = [i64; 3];

/// The words of a strip with guards at both ends, in the shape of the core's input port.
///
/// Nothing for a strip with rims: it has columns that no guard stands beside.
pub fn words(port: &Port, strip: &StripRecords<Point>) -> Option<Vec<Beat>> {
    let [Some(left), Some(right)] = &strip.guards else { return None };
    let mut words = vec![];
    guard(port, left, Role::OutsideRight, &mut words);
    words.iter_mut().for_each(|word| word.user |= 1 << 8);
    for column in &strip.columns {
        for (vertex, outside) in column.vertices.iter().zip(&column.outside) {
            words.push(word(port, Role::Vertex, outside.valence, vertex));
            words.extend(surroundings(port, outside));
        }
        end_column(&mut words);
    }
    guard(port, right, Role::OutsideLeft, &mut words);
    if let Some(last) = words.last_mut() {
        last.last = true;
    }
    Some(words)
}

/// The fan of a vertex; with valence 3, which has none, the outside vertices of the face columns beside it.
fn surroundings(port: &Port, outside: &Outside<Point>) -> Vec<Beat> {
    if outside.valence == 3 {
        let sides = [(Role::OutsideLeft, &outside.left), (Role::OutsideRight, &outside.right)];
        return sides.map(|(role, vertex)| word(port, role, 0, vertex)).to_vec();
    }
    outside.fan.iter().map(|vertex| word(port, Role::Fan, 0, vertex)).collect()
}

fn guard(port: &Port, guard: &Guard<Point>, side: Role, words: &mut Vec<Beat>) {
    for (vertex, outside) in guard.vertices.iter().zip(&guard.outside) {
        words.push(word(port, Role::Vertex, 4, vertex));
        words.push(word(port, side, 0, outside));
    }
    end_column(words);
}

fn end_column(words: &mut [Beat]) {
    if let Some(word) = words.last_mut() {
        word.user |= 1 << 7;
    }
}

fn word(port: &Port, role: Role, valence: u32, vertex: &Point) -> Beat {
    let mut beat = port.beat_of(&vertex.map(i128::from));
    beat.user = role as u64 | u64::from(valence) << 2;
    beat
}
