//! Pictures of levels in the graphics device: each is read when it is shown for the first time, and then no more.

use crate::level_pictures::{LevelPictures, PictureFile};
use eframe::egui::{Color32, ColorImage, Context, CornerRadius, Image, Rect, TextureHandle};
use eframe::egui::{TextureOptions, Ui, Vec2};
use microsim_model::{Texture, read_texture};
use std::collections::BTreeMap;
use std::fmt;

/// Most pixels of a side: more than any screen shows of a picture in a list, and what every graphics device takes.
const MOST: u32 = 1024;
/// Most pixels of a side of a picture for small places: one that is shown with less than half of its pixels leaves edges out.
const SMALL: usize = 200;

/// A picture in the graphics device, in two sizes.
#[derive(Clone)]
pub struct LevelPicture {
    large: TextureHandle,
    small: TextureHandle,
}

impl fmt::Debug for LevelPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.large.size();
        write!(f, "LevelPicture({width} x {height})")
    }
}

impl LevelPicture {
    /// Width and height that it has within a box, of which it fills one \[points\].
    pub fn size_in(&self, most: Vec2) -> Vec2 {
        let size = self.large.size_vec2();
        size * (most / size).min_elem()
    }

    /// Draws it in the middle of a place.
    pub fn draw(&self, ui: &Ui, place: Rect) {
        let size = self.size_in(place.size());
        let pixels = size.x * ui.ctx().pixels_per_point();
        let texture = match pixels <= 0.5 * self.large.size_vec2().x {
            true => &self.small,
            false => &self.large,
        };
        let place = Rect::from_center_size(place.center(), size);
        Image::new(texture)
            .corner_radius(CornerRadius::same(5))
            .paint_at(ui, place);
    }
}

/// The pictures that were shown.
#[derive(Clone, Debug, Default)]
pub struct Gallery {
    /// By module and number of the level; `None` where there is none, or none that can be shown.
    pictures: BTreeMap<(String, u32), Option<LevelPicture>>,
    complaints: Vec<String>,
}

impl Gallery {
    /// The picture of a level, if there is one that can be shown.
    pub fn picture(
        &mut self,
        context: &Context,
        station: &dyn LevelPictures,
        (module, level): (&str, u32),
    ) -> Option<LevelPicture> {
        let key = (module.to_owned(), level);
        if let Some(known) = self.pictures.get(&key) {
            return known.clone();
        }
        let read = station.picture(module, level);
        let read = read.and_then(|file| file.map(|file| load(context, &file)).transpose());
        let picture = read.unwrap_or_else(|why| {
            self.complaints.push(why);
            // The list of them may be drawn already.
            context.request_repaint();
            None
        });
        self.pictures.insert(key, picture.clone());
        picture
    }

    /// What is wrong with those that cannot be shown.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }
}

/// Reads a picture into the graphics device.
fn load(context: &Context, file: &PictureFile) -> Result<LevelPicture, String> {
    let wrong = |why: String| {
        let path = file.path.display();
        format!("{path}: {why}; the level is shown without its picture")
    };
    let picture = read_texture(&file.bytes).map_err(|error| wrong(error.to_string()))?;
    let (width, height) = (picture.width, picture.height);
    if width.min(height) == 0 || width.max(height) > MOST {
        return Err(wrong(format!(
            "{width} × {height} pixels; expected: 1 to {MOST} a side"
        )));
    }
    let mut image = image(&picture);
    let name = file.path.display().to_string();
    let large = context.load_texture(&name, image.clone(), TextureOptions::LINEAR);
    while image.size.into_iter().max() > Some(SMALL) && image.size.into_iter().min() > Some(1) {
        image = halved(&image);
    }
    let small = context.load_texture(name, image, TextureOptions::LINEAR);
    Ok(LevelPicture { large, small })
}

fn image(picture: &Texture) -> ColorImage {
    let size = [picture.width, picture.height].map(|side| side as usize);
    ColorImage::from_rgba_unmultiplied(size, &picture.pixels)
}

/// Half of its size: each pixel is the mean of four; an odd last row or column is left out.
fn halved(image: &ColorImage) -> ColorImage {
    let size = image.size.map(|side| side / 2);
    let mean = |x: usize, y: usize| {
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let four = four.map(|(dx, dy)| image[(2 * x + dx, 2 * y + dy)].to_array());
        let channel = |c: usize| four.iter().map(|p| u16::from(p[c])).sum::<u16>();
        let [r, g, b, a] = [0, 1, 2, 3].map(|c| ((channel(c) + 2) / 4) as u8);
        Color32::from_rgba_premultiplied(r, g, b, a)
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    ColorImage::new(size, pixels.map(|(x, y)| mean(x, y)).collect())
}

#[cfg(test)]
pub(crate) mod tests;
