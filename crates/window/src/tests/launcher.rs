//! Cards with pictures: a module without one has its texts where the others have theirs, and no text lies on a picture.

use super::{LANGUAGES, SIZES, shapes, show_launcher_with, texts_of};
use crate::gallery::tests::png;
use crate::launcher::Launcher;
use crate::level_pictures::{LevelPictures, PictureFile};
use crate::shortcut::press;
use eframe::egui::epaint::ClippedShape;
use eframe::egui::{Key, Rect, Shape, TextureId};
use microsim_vocabulary::Language;
use std::cell::Cell;

/// Pictures of modules with even numbers; module 3 has one that is broken.
#[derive(Default)]
pub(super) struct Album {
    asked: Cell<usize>,
}

impl LevelPictures for Album {
    fn picture(&self, module: &str, level: u32) -> Result<Option<PictureFile>, String> {
        self.asked.set(self.asked.get() + 1);
        let path = format!("modules/{module}/pictures/level{level}.png").into();
        let bytes = match module {
            "module-0" | "module-2" | "module-4" => png(320, 240),
            "module-3" => b"\x89PNG\r\n\x1a\n".to_vec(),
            _ => return Ok(None),
        };
        Ok(Some(PictureFile { path, bytes }))
    }
}

/// A window in which nothing is scrolled out of sight.
const TALL: [f32; 2] = [1280.0, 1600.0];

/// What is drawn of pictures: where, and what is visible of it.
fn pictures_of(drawn: &[ClippedShape]) -> Vec<(Rect, Rect)> {
    fn visit(shape: &Shape, clip: Rect, found: &mut Vec<(Rect, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| visit(shape, clip, found)),
            Shape::Rect(rect) if rect.fill_texture_id() != TextureId::default() => {
                found.push((rect.rect, clip));
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    for clipped in drawn {
        visit(&clipped.shape, clipped.clip_rect, &mut found);
    }
    found
}

#[test]
fn pictures_have_their_places_beside_texts() {
    for language in LANGUAGES {
        for size in SIZES {
            let (mut launcher, album) = (Launcher::default(), Album::default());
            let drawn = shapes(size, Vec::new(), |ui| {
                show_launcher_with(ui, &mut launcher, language, &album);
            });
            let (pictures, texts) = (pictures_of(&drawn), texts_of(&drawn));
            // Those of modules 0, 2 and 4, and of the chosen level 1 of module 0.
            assert_eq!(pictures.len(), 4, "{size:?}");
            for (place, clip) in &pictures {
                assert!(place.left() >= clip.left() && place.right() <= clip.right());
                for (text, of_text, _) in &texts {
                    let both = place.intersect(*of_text);
                    assert!(!both.is_positive(), "{size:?}: {text:?} lies on a picture");
                }
            }
            let of_level = pictures.last().expect("a picture").0;
            let of_modules = &pictures[..3];
            for (place, _) in of_modules {
                assert!(place.width() >= 80.0 && place.width() < of_level.width());
            }
            // Texts of modules with a picture and without one begin in one column; the border of what is chosen moves its own a little.
            let title = super::words(2);
            let title = crate::text::local(&title, language);
            let titles = texts
                .iter()
                .filter(|(text, place, _)| text == title && place.left() < 0.4 * size[0]);
            let columns: Vec<f32> = titles.map(|(_, place, _)| place.left()).collect();
            assert!(columns.len() >= 6, "{size:?}: {columns:?}");
            let first = columns[0];
            assert!(columns.iter().all(|left| (left - first).abs() < 2.0));
        }
    }
}

/// A picture is asked for when it is shown first, not with each picture of the window or in the other language.
#[test]
fn pictures_are_asked_for_once() {
    let (mut launcher, album) = (Launcher::default(), Album::default());
    let mut show = |key: Option<Key>, language| {
        let events = key.map(press).into_iter().collect();
        shapes(TALL, events, |ui| {
            show_launcher_with(ui, &mut launcher, language, &album);
        })
    };
    show(None, Language::German);
    show(None, Language::English);
    // Eight modules, of which the first is chosen with its level 1.
    assert_eq!(album.asked.get(), 8);
    show(Some(Key::ArrowRight), Language::English);
    let drawn = show(None, Language::German);
    assert_eq!((album.asked.get(), pictures_of(&drawn).len()), (9, 4));
    let complaints = texts_of(&drawn);
    let broken = complaints
        .iter()
        .filter(|(text, ..)| text.contains("module-3/pictures/level1.png"));
    assert_eq!(broken.count(), 1);
}
