//! A line of text in the corner of a finished picture, in a font of 8 × 8 pixels: what runs, where a picture does not show it.

use crate::image::Image;
use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

/// Side of a character in its font \[dots\].
pub(crate) const SIDE: u32 = 8;
/// A dot has one pixel for so many of the picture's height.
const HEIGHT_PER_DOT: u32 = 300;
/// Around the text \[dots\].
const MARGIN: u32 = 3;
/// What is left of the picture's light behind the text, as a divisor: white stands out from it.
const DIMMED: u8 = 4;

impl Image {
    /// Pixels of a dot of the font.
    pub(crate) fn dot(&self) -> u32 {
        (self.height() / HEIGHT_PER_DOT).max(1)
    }

    /// Writes a line in the lower left corner, white on what is dimmed behind it; what does not fit is cut off. Characters beyond Latin 1 are drawn
    /// as a question mark.
    pub fn write_caption(&mut self, text: &str) {
        let dot = self.dot();
        let width = (text.chars().count() as u32 * SIDE + 2 * MARGIN) * dot;
        let height = (SIDE + 2 * MARGIN) * dot;
        let top = self.height().saturating_sub(height);
        self.dim([0, top], [width, height]);
        self.write_at([MARGIN * dot, top + MARGIN * dot], text);
    }

    /// Dims what lies in a box from its upper left corner on \[pixels\].
    pub(crate) fn dim(&mut self, [left, top]: [u32; 2], [width, height]: [u32; 2]) {
        self.change([left, top], [width, height], |pixel| {
            pixel.iter_mut().for_each(|channel| *channel /= DIMMED);
        });
    }

    /// Fills a box from its upper left corner on \[pixels\] with a colour, sRGB.
    pub(crate) fn fill(&mut self, from: [u32; 2], size: [u32; 2], colour: [f32; 3]) {
        let colour = colour.map(|part| (255.0 * part).round() as u8);
        self.change(from, size, |pixel| pixel.copy_from_slice(&colour));
    }

    /// Writes white text from a place on \[dots\].
    pub(crate) fn write_line(&mut self, place: [u32; 2], text: &str) {
        let dot = self.dot();
        self.write_at(place.map(|part| part * dot), text);
    }

    /// The same from a place in pixels on.
    fn write_at(&mut self, [left, top]: [u32; 2], text: &str) {
        let dot = self.dot();
        for (number, character) in text.chars().enumerate() {
            let glyph = glyph(character);
            let left = left + number as u32 * SIDE * dot;
            for (row, column) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
                // The lowest bit is the leftmost dot.
                if glyph[row as usize] >> column & 1 == 1 {
                    let from = [left + column * dot, top + row * dot];
                    self.change(from, [dot; 2], |pixel| pixel.fill(u8::MAX));
                }
            }
        }
    }

    /// Changes the pixels of a box as far as it lies in the picture.
    fn change(
        &mut self,
        [left, top]: [u32; 2],
        [width, height]: [u32; 2],
        mut change: impl FnMut(&mut [u8]),
    ) {
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            if let Some(pixel) = self.pixel_mut(left + x, top + y) {
                change(pixel);
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
