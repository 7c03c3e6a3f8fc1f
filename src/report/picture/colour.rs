//! Colours: light is summed in linear sRGB primaries, chosen in Oklab, and written in 8-bit sRGB.
//!
//! Oklab (Björn Ottosson, 2020) has a lightness L in 0..=1 and two axes a (green to red) and b (blue to
//! yellow) in which equal distances look equally different. It needs only sums and cubes, so that every
//! machine gets the same colours.

use super::arithmetic::root;
use glam::Vec3;

/// Linear red, green, blue of an Oklab colour.
pub fn oklab(lightness: f32, a: f32, b: f32) -> Vec3 {
    let cube = |x: f32| x * x * x;
    let l = cube(lightness + 0.396_337_78 * a + 0.215_803_76 * b);
    let m = cube(lightness - 0.105_561_346 * a - 0.063_854_17 * b);
    let s = cube(lightness - 0.089_484_18 * a - 1.291_485_5 * b);
    Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
    .max(Vec3::ZERO)
}

/// The stations of the heat map: pale straw, amber, vermilion, crimson, plum. Lightness falls all the way,
/// so that the map can also be read in grey.
const HEAT: [[f32; 3]; 6] = [
    [0.955, -0.012, 0.045],
    [0.875, 0.010, 0.120],
    [0.760, 0.090, 0.130],
    [0.620, 0.180, 0.095],
    [0.460, 0.165, 0.005],
    [0.300, 0.095, -0.060],
];

/// The heat map at 0..=1: perceptually uniform, since equal steps are equal distances in Oklab.
pub fn heat(value: f32) -> Vec3 {
    let distance = |from: [f32; 3], to: [f32; 3]| Vec3::from(from).distance(Vec3::from(to));
    let total: f32 = HEAT.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
    let mut left = value.clamp(0.0, 1.0) * total;
    for pair in HEAT.windows(2) {
        let length = distance(pair[0], pair[1]);
        if left <= length {
            let at = Vec3::from(pair[0]).lerp(Vec3::from(pair[1]), left / length);
            return oklab(at.x, at.y, at.z);
        }
        left -= length;
    }
    let [lightness, a, b] = HEAT[HEAT.len() - 1];
    oklab(lightness, a, b)
}

/// The colour of a patch: its depth chooses the hue (0, the regular patches, is porcelain), its number one of
/// three shades, so that the three patches of one layer can be told apart.
pub fn patch(depth: u8, number: u32) -> Vec3 {
    const DEPTHS: [[f32; 3]; 8] = [
        [0.86, -0.004, 0.014],
        [0.76, -0.040, -0.075],
        [0.79, 0.020, 0.115],
        [0.72, 0.115, 0.050],
        [0.70, -0.105, 0.045],
        [0.66, 0.070, -0.090],
        [0.60, -0.030, -0.110],
        [0.55, 0.130, 0.070],
    ];
    let [lightness, a, b] = match depth {
        0 => DEPTHS[0],
        // The deepest layers are smaller than a pixel; there the hues may repeat.
        deep => DEPTHS[1 + (usize::from(deep) - 1) % (DEPTHS.len() - 1)],
    };
    let shade = [0.0, -0.045, 0.035][number as usize % 3];
    oklab(lightness + shade, a, b)
}

/// How many colours strips have.
pub const STRIPS: usize = 7;

/// The n-th colour of the strips: equally light, so that no strip stands out.
pub fn strip(number: usize) -> Vec3 {
    const HUES: [[f32; 2]; STRIPS] = [
        [-0.045, -0.075],
        [0.030, 0.100],
        [0.095, 0.030],
        [-0.085, 0.020],
        [0.050, -0.070],
        [-0.030, 0.085],
        [0.000, 0.010],
    ];
    let [a, b] = HUES[number % STRIPS];
    oklab(0.77, a, b)
}

/// Writes linear light as sRGB numbers, 0 to 255.
pub struct Encoder {
    /// The sRGB number at the square of k/SIZE; the curve is almost straight over the square root.
    table: Vec<f32>,
}

impl Encoder {
    const SIZE: usize = 1024;

    pub fn new() -> Self {
        // The curve of IEC 61966-2-1; x^(1/2.4) is the fifth power of the twelfth root.
        let curve = |x: f64| {
            if x <= 0.003_130_8 {
                return 12.92 * x;
            }
            let twelfth = root(x.sqrt().sqrt(), 3);
            let fifth_power = twelfth * twelfth * twelfth * twelfth * twelfth;
            1.055 * fifth_power - 0.055
        };
        let station = |k: usize| {
            let x = k as f64 / Self::SIZE as f64;
            (255.0 * curve(x * x)) as f32
        };
        Encoder { table: (0..=Self::SIZE).map(station).collect() }
    }

    /// The sRGB number of linear light, before rounding.
    pub fn encode(&self, linear: f32) -> f32 {
        let at = linear.clamp(0.0, 1.0).sqrt() * Self::SIZE as f32;
        let below = (at as usize).min(Self::SIZE - 1);
        let (low, high) = (self.table[below], self.table[below + 1]);
        low + (high - low) * (at - below as f32)
    }

    /// One pixel in bytes. The 8 by 8 pattern of Bayer replaces the bands of a soft gradient by a texture
    /// below what the eye sees; it depends on nothing but the place.
    pub fn pixel(&self, linear: Vec3, column: usize, row: usize) -> [u8; 3] {
        let (mut threshold, mut weight) = (0, 32);
        for bit in 0..3 {
            let (x, y) = (column >> bit & 1, row >> bit & 1);
            threshold += weight * (x ^ y) + weight / 2 * y;
            weight /= 4;
        }
        let offset = (threshold as f32 + 0.5) / 64.0;
        linear.to_array().map(|channel| (self.encode(channel) + offset).min(255.0) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_encoder_is_the_srgb_curve() {
        let encoder = Encoder::new();
        for (linear, srgb) in [(0.0, 0.0), (0.003, 9.883), (0.21404, 127.5), (0.5, 187.516), (1.0, 255.0)] {
            assert!((encoder.encode(linear) - srgb).abs() < 0.05, "{linear}: {}", encoder.encode(linear));
        }
    }

    #[test]
    fn oklab_greys_are_neutral() {
        let grey = oklab(0.6, 0.0, 0.0);
        assert!((grey - Vec3::splat(0.216)).abs().max_element() < 1e-4, "{grey}");
    }

    #[test]
    fn the_heat_map_darkens_all_the_way() {
        let luminance = |value: f32| heat(value).dot(Vec3::new(0.2126, 0.7152, 0.0722));
        for step in 0..50 {
            assert!(luminance(step as f32 / 50.0) > luminance((step + 1) as f32 / 50.0), "{step}");
        }
    }

    #[test]
    fn dithering_keeps_the_mean() {
        let (encoder, light) = (Encoder::new(), Vec3::splat(0.2));
        let total: u32 = (0..64).map(|i| u32::from(encoder.pixel(light, i % 8, i / 8)[0])).sum();
        assert!((total as f32 / 64.0 - encoder.encode(0.2)).abs() < 0.02);
    }
}
