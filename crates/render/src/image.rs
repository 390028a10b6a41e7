//! The finished picture: its pixels, and PNG as the one file format.

use std::io;
use std::path::Path;

/// Pixels of a drawn picture, sRGB with opaque alpha, rows from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    rgba8: Vec<u8>,
}

impl Image {
    /// `rgba8` holds `4 * width * height` bytes.
    pub(crate) fn new(width: u32, height: u32, rgba8: Vec<u8>) -> Self {
        debug_assert_eq!(rgba8.len(), 4 * width as usize * height as usize);
        Self {
            width,
            height,
            rgba8,
        }
    }

    /// Width \[pixels\].
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height \[pixels\].
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels: red, green, blue, alpha of the top left pixel, then its right neighbour.
    pub fn rgba8(&self) -> &[u8] {
        &self.rgba8
    }

    /// Red, green and blue of the pixel in column `x` from the left and row `y` from the top.
    ///
    /// # Panics
    /// Outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        assert!(
            x < self.width && y < self.height,
            "pixel ({x}, {y}) outside {} × {}",
            self.width,
            self.height
        );
        let at = 4 * (y as usize * self.width as usize + x as usize);
        [self.rgba8[at], self.rgba8[at + 1], self.rgba8[at + 2]]
    }

    /// The channels of a pixel, to change them; `None` outside the picture.
    pub(crate) fn pixel_mut(&mut self, x: u32, y: u32) -> Option<&mut [u8]> {
        let is_inside = x < self.width && y < self.height;
        let at = 4 * (y as usize * self.width as usize + x as usize);
        is_inside.then(|| &mut self.rgba8[at..at + 3])
    }

    /// The picture as a PNG file in memory (8 bits a channel, sRGB, no alpha: it is opaque everywhere).
    pub fn to_png(&self) -> Vec<u8> {
        let rgb: Vec<u8> = self
            .rgba8
            .chunks_exact(4)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        // A session writes hundreds of frames: fast matters more than the last ten per cent of size.
        encoder.set_compression(png::Compression::Fast);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(&rgb))
            .expect("writing to memory cannot fail and the byte count agrees by construction");
        bytes
    }

    /// Writes the picture as a PNG file, replacing what is there.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write_png(&self, path: &Path) -> io::Result<()> {
        std::fs::write(path, self.to_png())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the PNG decodes to is what went in (size, order of rows and channels).
    #[test]
    fn png_holds_the_same_pixels() {
        let rgba8: Vec<u8> = (0..4 * 3 * 2)
            .map(|i| if i % 4 == 3 { 255 } else { (i * 9) as u8 })
            .collect();
        let image = Image::new(3, 2, rgba8);
        let bytes = image.to_png();
        let mut reader = png::Decoder::new(io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut decoded).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        for y in 0..2 {
            for x in 0..3 {
                let at = 3 * (3 * y + x);
                assert_eq!(
                    image.pixel(x as u32, y as u32),
                    decoded[at..at + 3],
                    "pixel ({x}, {y})"
                );
            }
        }
    }
}
