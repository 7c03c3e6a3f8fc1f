//! Letters and digits for legends, drawn as strokes.
//!
//! Each glyph is a few polygons on a small grid; Chaikin's corner cutting, the simplest subdivision curve, turns
//! them into letters.

use super::lines::Line;
use glam::Vec2;

/// The strokes of a glyph, separated by commas: points as two digits, column and height. The baseline is at
/// height 2, small letters reach 6, digits 8. A stroke that ends with a star is closed.
fn glyph(letter: char) -> &'static str {
    match letter.to_ascii_lowercase() {
        '0' => "42 02 08 48*",
        '1' => "06 28,28 22",
        '2' => "06 08 48 46 02,02 42",
        '3' => "07 08 48 45 15,15 45 42 02 03",
        '4' => "32 38,38 04,04 44",
        '5' => "48 08,08 05,05 06 46 42 02 03",
        '6' => "47 48 08 02 42 46 06 04",
        '7' => "08 48,48 12",
        '8' => "05 45 48 08*,02 42 45 05*",
        '9' => "03 02 42 48 08 04 44 46",
        'a' => "02 42 46 06*,46 42",
        'b' => "08 02,02 42 46 06*",
        'c' => "45 46 06 02 42 43",
        'd' => "02 42 46 06*,48 42",
        'e' => "04 44,44 46 06 02 42 43",
        'f' => "38 18 16 12,06 36",
        'g' => "02 42 46 06*,46 40 00 01",
        'h' => "08 02,03 06 46 44 42",
        'i' => "06 02,08 08",
        'j' => "26 20 00,28 28",
        'k' => "08 02,36 04,04 42",
        'l' => "08 02",
        'm' => "06 02,03 06 36 34 32,33 36 66 64 62",
        'n' => "06 02,03 06 46 44 42",
        'o' => "02 42 46 06*",
        'p' => "06 00,02 42 46 06*",
        'q' => "02 42 46 06*,46 40",
        'r' => "06 02,03 06 36",
        's' => "45 46 06 04 44 42 02 03",
        't' => "18 14 12 32,06 36",
        'u' => "06 02 42 44,46 42",
        'v' => "06 22,22 46",
        'w' => "06 12,12 36,36 52,52 66",
        'x' => "06 42,02 46",
        'y' => "06 22,46 10",
        'z' => "06 46,46 02,02 42",
        '.' => "02 02",
        ',' => "12 01",
        ':' => "02 02,05 05",
        '-' => "04 34",
        '+' => "04 44,26 22",
        '=' => "05 35,03 33",
        '/' => "01 39",
        '(' => "29 07 03 21",
        ')' => "09 27 23 01",
        _ => "",
    }
}

/// Adds the strokes of a text, from its left end on the baseline; `height` is that of a digit, in pixels.
pub fn write(lines: &mut Vec<Line>, text: &str, start: Vec2, height: f32) {
    let unit = height / 6.0;
    let mut x = start.x;
    for letter in text.chars() {
        let strokes = strokes(letter);
        for pair in strokes.iter().flat_map(|stroke| stroke.windows(2)) {
            let place = |p: Vec2| Vec2::new(x + p.x * unit, start.y - (p.y - 2.0) * unit);
            // Nothing is nearer than a legend.
            let ends = [(place(pair[0]), f32::MAX), (place(pair[1]), f32::MAX)];
            lines.push(Line { ends, radius: 0.45 * unit });
        }
        x += advance(&strokes) * unit;
    }
}

/// The length of a text, in digit heights.
pub fn length(text: &str) -> f32 {
    text.chars().map(|letter| advance(&strokes(letter))).sum::<f32>() / 6.0
}

fn advance(strokes: &[Vec<Vec2>]) -> f32 {
    let width = strokes.iter().flatten().map(|p| p.x).fold(0.0, f32::max);
    if strokes.is_empty() { 2.6 } else { width + 1.9 }
}

fn strokes(letter: char) -> Vec<Vec<Vec2>> {
    let number = |byte: u8| f32::from(byte - b'0');
    let stroke = |text: &str| {
        let (text, closed) = text.strip_suffix('*').map_or((text, false), |open| (open, true));
        let corners = text.split(' ').map(|p| Vec2::new(number(p.as_bytes()[0]), number(p.as_bytes()[1])));
        (0..3).fold((corners.collect(), closed), |(points, closed), _| (cut(points, closed), closed)).0
    };
    glyph(letter).split(',').filter(|text| !text.is_empty()).map(stroke).collect()
}

/// One step of corner cutting: new points at a quarter and at three quarters of each edge. An open stroke keeps
/// its ends, a closed one ends where it begins.
fn cut(mut points: Vec<Vec2>, closed: bool) -> Vec<Vec2> {
    let (first, last) = (points[0], points[points.len() - 1]);
    if closed && first != last {
        points.push(first);
    }
    let mut fine: Vec<Vec2> = points
        .windows(2)
        .flat_map(|pair| [pair[0].lerp(pair[1], 0.25), pair[0].lerp(pair[1], 0.75)])
        .collect();
    if closed {
        fine.push(fine[0]);
    } else {
        fine[0] = first;
        let end = fine.len() - 1;
        fine[end] = last;
    }
    fine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_and_digit_can_be_written() {
        for letter in ('a'..='z').chain('A'..='Z').chain('0'..='9').chain(".,:-+=/()".chars()) {
            assert!(!strokes(letter).is_empty(), "{letter}");
        }
    }

    #[test]
    fn text_is_as_long_as_it_is_said_to_be() {
        let mut lines = Vec::new();
        write(&mut lines, "error 0.5", Vec2::new(10.0, 50.0), 12.0);
        let right = lines.iter().flat_map(|line| line.ends).map(|(p, _)| p.x).fold(0.0, f32::max);
        // The space after the last letter counts as well.
        assert!((right + 1.9 * 2.0 - 10.0 - 12.0 * length("error 0.5")).abs() < 1e-3, "{right}");
    }

    #[test]
    fn corner_cutting_keeps_open_ends_and_closes_loops() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(Vec2::from).to_vec();
        let open = cut(square.clone(), false);
        assert_eq!((open[0], open[open.len() - 1]), (square[0], square[3]));
        let closed = cut(square, true);
        assert_eq!((closed.len(), closed[0]), (9, closed[8]));
    }
}
