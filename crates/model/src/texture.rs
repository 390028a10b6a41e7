//! Textures: PNG.

use crate::error::{Flaw, ModelError, flawed};
use png::{ColorType, Transformations};
use std::io::Cursor;

/// Most pixels of a side of a texture.
pub const MAX_TEXTURE: u32 = 4096;

/// What is shown where texture coordinates leave 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture again, every other time mirrored.
    Mirrored,
    /// Its edge.
    Clamp,
}

/// A picture for a surface.
#[derive(Clone, PartialEq, Eq)]
pub struct Texture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, opacity of each pixel, sRGB, by rows from the upper left corner.
    pub pixels: Vec<u8>,
    /// Beyond its left and right sides, and beyond the upper and lower ones.
    pub wrap: [Wrap; 2],
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Texture({} x {})", self.width, self.height)
    }
}

/// Reads a texture.
///
/// # Errors
/// Other forms than PNG, sides longer than [`MAX_TEXTURE`], truncated and broken files.
pub fn read_texture(bytes: &[u8]) -> Result<Texture, ModelError> {
    if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        return flawed(Flaw::NotRead, "a JPEG; textures are PNG");
    }
    if bytes.is_empty() {
        return flawed(Flaw::Truncated, "an empty file");
    }
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return flawed(Flaw::UnknownForm, "what is no PNG");
    }
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = (reader.info().width, reader.info().height);
    if width > MAX_TEXTURE || height > MAX_TEXTURE {
        return flawed(
            Flaw::TooLarge,
            format!("{width} × {height} pixels; at most {MAX_TEXTURE} × {MAX_TEXTURE} are read"),
        );
    }
    let size = reader.output_buffer_size().unwrap_or_default();
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(wrong)?;
    data.truncate(frame.buffer_size());
    let pixels: Vec<u8> = match frame.color_type {
        ColorType::Grayscale => data.iter().flat_map(|g| [*g, *g, *g, 255]).collect(),
        ColorType::GrayscaleAlpha => {
            let pixels = data.chunks_exact(2);
            pixels.flat_map(|p| [p[0], p[0], p[0], p[1]]).collect()
        }
        ColorType::Rgb => {
            let pixels = data.chunks_exact(3);
            pixels.flat_map(|p| [p[0], p[1], p[2], 255]).collect()
        }
        ColorType::Rgba => data,
        ColorType::Indexed => return flawed(Flaw::Broken, "a palette that is not there"),
    };
    match pixels.len() == 4 * width as usize * height as usize {
        true => Ok(Texture {
            width,
            height,
            pixels,
            wrap: [Wrap::Repeat; 2],
        }),
        false => flawed(Flaw::Truncated, "fewer pixels than its size"),
    }
}

fn wrong(error: png::DecodingError) -> ModelError {
    let truncated = matches!(&error, png::DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof);
    let flaw = match (&error, truncated) {
        (_, true) => Flaw::Truncated,
        (png::DecodingError::LimitsExceeded, _) => Flaw::TooLarge,
        _ => Flaw::Broken,
    };
    ModelError::new(flaw, format!("a PNG that cannot be read: {error}"))
}
