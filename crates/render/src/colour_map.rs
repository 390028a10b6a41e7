//! Colours of values: viridis, whose steps look equal, also to who sees no red or no green, and in grey.
//!
//! By Stéfan van der Walt and Nathaniel Smith, of matplotlib 2.0, in the public domain (CC0): 33 of its 256 colours; between them is the line, which is off by 2 of 255 at most.

use microsim_model::{Texture as Pixels, Wrap};
use std::sync::OnceLock;

use crate::textures::Texture;

/// Evenly spaced, from the lowest value, sRGB.
const STOPS: [[u8; 3]; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 55, 129],
    [66, 64, 134],
    [62, 73, 137],
    [59, 82, 139],
    [55, 91, 141],
    [51, 99, 141],
    [47, 107, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 130, 142],
    [35, 137, 142],
    [33, 145, 140],
    [31, 151, 139],
    [31, 159, 136],
    [33, 166, 133],
    [39, 173, 129],
    [49, 181, 123],
    [61, 188, 116],
    [76, 194, 108],
    [92, 200, 99],
    [110, 206, 88],
    [129, 211, 77],
    [149, 216, 64],
    [170, 220, 50],
    [192, 223, 37],
    [213, 226, 26],
    [234, 229, 26],
    [253, 231, 37],
];

/// Pixels of the texture.
const WIDTH: u32 = 256;

/// The colour of a part from 0 to 1, sRGB; beyond, that of the nearer end.
pub fn colour_of(part: f64) -> [f32; 3] {
    let last = STOPS.len() - 1;
    let place = part.clamp(0.0, 1.0) * last as f64;
    let first = (place as usize).min(last - 1);
    let between = place - first as f64;
    std::array::from_fn(|k| {
        let [low, high] = [first, first + 1].map(|stop| f64::from(STOPS[stop][k]));
        ((low + between * (high - low)) / 255.0) as f32
    })
}

/// All of them from left to right, one for the process.
pub(crate) fn texture() -> &'static Texture {
    static TEXTURE: OnceLock<Texture> = OnceLock::new();
    TEXTURE.get_or_init(|| {
        let pixel = |x: u32| {
            let [red, green, blue] = colour_of(f64::from(x) / f64::from(WIDTH - 1))
                .map(|part| (255.0 * part).round() as u8);
            [red, green, blue, u8::MAX]
        };
        Texture::new(Pixels {
            width: WIDTH,
            height: 1,
            pixels: (0..WIDTH).flat_map(pixel).collect(),
            wrap: [Wrap::Clamp; 2],
        })
    })
}

/// Where the colour of a part from 0 to 1 is in the texture: in the middle of its first pixel 0, in that of the last one 1.
pub(crate) fn coordinates(part: f32) -> [f32; 2] {
    let width = WIDTH as f32;
    [(0.5 + part * (width - 1.0)) / width, 0.5]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::linear_from_srgb;

    /// CIE lightness of an sRGB colour, from 0 to 100.
    fn lightness(colour: [f32; 3]) -> f64 {
        let [red, green, blue] = colour.map(|part| linear_from_srgb(f64::from(part)));
        let light = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        116.0 * libm::cbrt(light) - 16.0
    }

    /// Equal steps of the value are equal steps of lightness, from the darkest to the brightest colour: 15 to 91 in 16 steps are 4.75 each.
    #[test]
    fn values_can_be_read_by_their_lightness() {
        let all: Vec<f64> = (0..=16)
            .map(|k| lightness(colour_of(f64::from(k) / 16.0)))
            .collect();
        assert!(
            (all[0] - 15.0).abs() < 1.0 && (all[16] - 91.0).abs() < 1.0,
            "{all:?}"
        );
        for pair in all.windows(2) {
            assert!((pair[1] - pair[0] - 4.75).abs() < 1.6, "{all:?}");
        }
    }

    #[test]
    fn what_lies_beyond_has_the_colour_of_the_end() {
        assert_eq!(colour_of(-1.0), colour_of(0.0));
        assert_eq!(
            colour_of(2.0),
            [253, 231, 37].map(|part| part as f32 / 255.0)
        );
    }
}
