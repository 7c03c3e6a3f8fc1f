//! Pictures side by side in one SVG, each with its title below.

use askama::Template;

use crate::error::{Error, Kind, Result};

/// Width of one picture on the paper.
const WIDTH: f64 = 400.0;
const GAP: f64 = 16.0;

#[derive(Template)]
#[template(path = "pictures.svg")]
struct Page<'a> {
    title: &'a str,
    width: f64,
    height: f64,
    pictures: Vec<Placed<'a>>,
}

struct Placed<'a> {
    title: &'a str,
    data: String,
    x: f64,
    width: f64,
    height: f64,
    middle: f64,
    below: f64,
}

/// PNG files of one size in pixels, from left to right.
///
/// # Errors
/// None that a user can cause: the template cannot be printed.
pub fn row_of_pictures(
    title: &str,
    pictures: &[(&str, Vec<u8>)],
    [width, height]: [usize; 2],
) -> Result<String> {
    let tall = (WIDTH * height as f64 / width as f64).round();
    let mut placed = vec![];
    for (index, (title, png)) in pictures.iter().enumerate() {
        let x = GAP + index as f64 * (WIDTH + GAP);
        let (middle, below) = (x + WIDTH / 2.0, 44.0 + tall + 24.0);
        placed.push(Placed { title, data: base64(png), x, width: WIDTH, height: tall, middle, below });
    }
    let width = GAP + pictures.len() as f64 * (WIDTH + GAP);
    let page = Page { title, width, height: 44.0 + tall + 44.0, pictures: placed };
    let text = page
        .render()
        .map_err(|e| Error::new(Kind::ToolFailed, format!("the pictures cannot be printed: {e}")))?;
    Ok(format!("{}\n", text.trim_end()))
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |index: usize| u32::from(group.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let value = bits >> (18 - 6 * digit) & 63;
            text.push(if digit <= group.len() { char::from(DIGITS[value as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_vectors_of_the_standard() {
        let vectors = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (text, encoded) in vectors {
            assert_eq!(base64(text.as_bytes()), encoded);
        }
    }

    #[test]
    fn every_picture_is_in_the_row() {
        let pictures = [("one", vec![1, 2, 3]), ("two <", vec![4])];
        let svg = row_of_pictures("title", &pictures, [4, 3]).unwrap();
        assert_eq!(svg.matches("<image").count(), 2);
        assert!(svg.contains("base64,AQID\"") && svg.contains("two &#60;"), "{svg}");
    }
}
