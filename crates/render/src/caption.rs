//! A line of text in the corner of a finished picture, in a font of 8 × 8 pixels: what runs, where a picture does not show it.

use crate::image::Image;
use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

/// Side of a character in its font \[dots\].
const SIDE: u32 = 8;
/// A dot has one pixel for so many of the picture's height.
const HEIGHT_PER_DOT: u32 = 300;
/// Around the text \[dots\].
const MARGIN: u32 = 3;
/// What is left of the picture's light behind the text, as a divisor: white stands out from it.
const DIMMED: u8 = 4;

impl Image {
    /// Writes a line in the lower left corner, white on what is dimmed behind it; what does not fit is cut off. Characters beyond Latin 1 are drawn
    /// as a question mark.
    pub fn write_caption(&mut self, text: &str) {
        let dot = (self.height() / HEIGHT_PER_DOT).max(1);
        let glyphs: Vec<[u8; 8]> = text.chars().map(glyph).collect();
        let width = (glyphs.len() as u32 * SIDE + 2 * MARGIN) * dot;
        let height = (SIDE + 2 * MARGIN) * dot;
        let top = self.height().saturating_sub(height);
        for y in 0..height {
            for x in 0..width {
                let Some(pixel) = self.pixel_mut(x, top + y) else {
                    continue;
                };
                let is_lit = (x / dot)
                    .checked_sub(MARGIN)
                    .zip((y / dot).checked_sub(MARGIN));
                let is_lit = is_lit.is_some_and(|(column, row)| {
                    let glyph = glyphs.get((column / SIDE) as usize);
                    let row = glyph.and_then(|glyph| glyph.get(row as usize));
                    // The lowest bit is the leftmost dot.
                    row.is_some_and(|row| row >> (column % SIDE) & 1 == 1)
                });
                for channel in pixel {
                    *channel = if is_lit { u8::MAX } else { *channel / DIMMED };
                }
            }
        }
    }
}

fn glyph(character: char) -> [u8; 8] {
    let found = BASIC_FONTS
        .get(character)
        .or_else(|| LATIN_FONTS.get(character));
    found.unwrap_or_else(|| BASIC_FONTS.get('?').expect("it has all of ASCII"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32) -> Image {
        Image::new(width, height, vec![200; 4 * (width * height) as usize])
    }

    /// An I of that font: a column of six dots on each row of its middle; beyond the box nothing changes.
    #[test]
    fn a_caption_stands_in_the_lower_left_corner() {
        let mut image = grey(40, 20);
        image.write_caption("I");
        let (white, dim) = ([255; 3], [50; 3]);
        let rows: Vec<String> = (9..17)
            .map(|y| {
                let of = |x| if image.pixel(x, y) == white { '#' } else { '.' };
                (3..11).map(of).collect()
            })
            .collect();
        let expected = [
            ".####...", "..##....", "..##....", "..##....", "..##....", "..##....", ".####...",
            "........",
        ];
        assert_eq!(rows, expected);
        assert_eq!(image.pixel(0, 19), dim);
        assert_eq!([image.pixel(14, 19), image.pixel(0, 5)], [[200; 3]; 2]);
    }

    /// What does not fit is cut off, and what the font lacks is a question mark.
    #[test]
    fn awkward_captions_are_drawn() {
        let mut image = grey(9, 4);
        image.write_caption("a long caption");
        let [mut unknown, mut mark] = [grey(20, 20), grey(20, 20)];
        unknown.write_caption("\u{674e}");
        mark.write_caption("?");
        assert_eq!(unknown, mark);
    }
}
