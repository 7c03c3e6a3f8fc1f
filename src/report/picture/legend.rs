//! What the colours mean: a scale for a heat map, samples for the patches.

use super::{
    colour,
    lettering::{length, write},
    lines::Line,
    scene::{Colouring, Scene},
};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

pub struct Legend {
    pub text: Vec<Line>,
    scale: Option<Area>,
    swatches: Vec<(Area, Vec3)>,
}

/// A rectangle in pixels.
#[derive(Clone, Copy)]
struct Area {
    low: Vec2,
    high: Vec2,
}

/// The part of the picture's width that a legend takes, at its right edge.
pub fn share(scene: &Scene) -> f32 {
    if matches!(scene.colouring, Colouring::Plain | Colouring::Strips(_)) { 0.0 } else { 0.11 }
}

impl Legend {
    pub fn new(scene: &Scene, width: f32, height: f32) -> Self {
        let mut legend = Legend { text: Vec::new(), scale: None, swatches: Vec::new() };
        let letter = height / 72.0;
        match scene.colouring {
            // The number of a strip says nothing.
            Colouring::Plain | Colouring::Strips(_) => {}
            Colouring::Values { range, title, .. } => legend.add_scale(range, title, width, height, letter),
            Colouring::Patches(patches) => {
                let depths: BTreeSet<u8> = patches.iter().map(|patch| patch.depth).collect();
                legend.add_depths(&depths, width, height, letter);
            }
        }
        legend
    }

    fn add_scale(&mut self, [low, high]: [f64; 2], title: &str, width: f32, height: f32, letter: f32) {
        let bar_left = width * 0.905;
        let area = Area {
            low: Vec2::new(bar_left, height * 0.30),
            high: Vec2::new(bar_left + 1.5 * letter, height * 0.70),
        };
        self.scale = Some(area);
        for step in 0..=4 {
            let part = f64::from(step) / 4.0;
            let y = area.high.y + (area.low.y - area.high.y) * part as f32;
            let text = number(low + (high - low) * part, high - low);
            write(&mut self.text, &text, Vec2::new(area.high.x + letter, y + letter / 2.0), letter);
        }
        let right = width - 2.0 * letter;
        let start = (area.low.x).min(right - length(title) * letter);
        write(&mut self.text, title, Vec2::new(start, area.low.y - 2.2 * letter), letter);
    }

    fn add_depths(&mut self, depths: &BTreeSet<u8>, width: f32, height: f32, letter: f32) {
        const SHOWN: usize = 8;
        let left = width * 0.885;
        let top = height * 0.5 - depths.len().min(SHOWN) as f32 * 1.1 * letter;
        for (row, depth) in depths.iter().take(SHOWN).enumerate() {
            let low = Vec2::new(left, top + row as f32 * 2.2 * letter);
            let area = Area { low, high: low + Vec2::splat(1.3 * letter) };
            self.swatches.push((area, colour::patch(*depth, 0)));
            let last = row + 1 == SHOWN && depths.len() > SHOWN;
            let text = match depth {
                0 => "regular".to_string(),
                _ if last => format!("depth {depth}.."),
                _ => format!("depth {depth}"),
            };
            write(
                &mut self.text,
                &text,
                Vec2::new(area.high.x + 0.8 * letter, area.high.y - 0.15 * letter),
                letter,
            );
        }
    }

    /// The colour of the legend at a place, laid over what is there.
    pub fn over(&self, below: Vec3, place: Vec2) -> Vec3 {
        let mut colour = below;
        if let Some(area) = self.scale {
            let value = (area.high.y - place.y) / (area.high.y - area.low.y);
            colour = colour.lerp(colour::heat(value), area.cover(place));
        }
        for (area, swatch) in &self.swatches {
            colour = colour.lerp(*swatch, area.cover(place));
        }
        colour
    }
}

impl Area {
    /// How much of the pixel around a place lies inside.
    fn cover(&self, place: Vec2) -> f32 {
        let inside = (place - self.low).min(self.high - place) + Vec2::splat(0.5);
        let inside = inside.clamp(Vec2::ZERO, Vec2::ONE);
        inside.x * inside.y
    }
}

/// A number with as many digits as a scale of this length needs.
fn number(value: f64, length: f64) -> String {
    let magnitude = value.abs().max(length.abs());
    if magnitude != 0.0 && !(1e-3..1e5).contains(&magnitude) {
        return format!("{value:.1e}");
    }
    let mut decimals = 0;
    let mut unit = 1.0;
    while decimals < 6 && length / 4.0 < 20.0 * unit {
        unit /= 10.0;
        decimals += 1;
    }
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_string() } else { short.to_string() }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_the_digits_that_tell_them_apart() {
        let scale = |low: f64, high: f64| {
            [0, 1, 2, 3, 4].map(|k| number(low + (high - low) * f64::from(k) / 4.0, high - low))
        };
        assert_eq!(scale(0.0, 0.5), ["0", "0.125", "0.25", "0.375", "0.5"]);
        assert_eq!(scale(0.0, 400.0), ["0", "100", "200", "300", "400"]);
        assert_eq!(number(2.5e-7, 1e-6), "2.5e-7");
    }
}
