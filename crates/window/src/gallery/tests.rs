//! Pictures are read once, and one that is none is named.

use super::*;
use eframe::egui::vec2;
use std::cell::Cell;

/// A grey picture.
pub(crate) fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    let pixels = vec![128; (width * height) as usize];
    let written = encoder.write_header();
    let written = written.and_then(|mut writer| writer.write_image_data(&pixels));
    written.expect("a picture in memory");
    bytes
}

/// A station whose level 1 has these bytes as picture; level 2 has none, and that of level 3 cannot be read.
struct Station {
    bytes: Vec<u8>,
    asked: Cell<usize>,
}

impl LevelPictures for Station {
    fn picture(&self, _: &str, level: u32) -> Result<Option<PictureFile>, String> {
        self.asked.set(self.asked.get() + 1);
        match level {
            1 => Ok(Some(PictureFile {
                path: "modules/hold/pictures/level1.png".into(),
                bytes: self.bytes.clone(),
            })),
            2 => Ok(None),
            _ => Err("level3.png cannot be read: permission denied".into()),
        }
    }
}

fn station(bytes: Vec<u8>) -> Station {
    let asked = Cell::new(0);
    Station { bytes, asked }
}

/// What comes of level 1 with these bytes: the size of its picture, or the complaint.
fn shown(bytes: Vec<u8>) -> Result<[usize; 2], String> {
    let mut gallery = Gallery::default();
    let picture = gallery.picture(&Context::default(), &station(bytes), ("hold", 1));
    match (picture, gallery.complaints()) {
        (Some(picture), []) => Ok(picture.large.size()),
        (None, [why]) => Err(why.clone()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_picture_is_read_once_and_one_that_is_missing_is_no_complaint() {
    let context = Context::default();
    let station = station(png(320, 240));
    let mut gallery = Gallery::default();
    for _ in 0..3 {
        assert!(gallery.picture(&context, &station, ("hold", 1)).is_some());
        assert!(gallery.picture(&context, &station, ("hold", 2)).is_none());
    }
    assert_eq!((station.asked.get(), gallery.complaints().len()), (2, 0));
    for _ in 0..3 {
        assert!(gallery.picture(&context, &station, ("hold", 3)).is_none());
    }
    assert_eq!(station.asked.get(), 3);
    let complaints = ["level3.png cannot be read: permission denied"];
    assert_eq!(gallery.complaints(), complaints);
    gallery.picture(&context, &station, ("cut", 1));
    assert_eq!(station.asked.get(), 4, "another module has others");
}

/// Whatever is in the file: a picture, or one line that names the file.
#[test]
fn a_file_that_is_no_picture_gives_one_line() {
    let good = png(6, 4);
    assert_eq!(shown(good.clone()), Ok([6, 4]));
    // All that comes before the end of the pixels is needed; the last twelve bytes only state that nothing follows.
    for end in 0..good.len() - 12 {
        let why = shown(good[..end].to_vec()).expect_err("a part of a file");
        assert!(
            why.starts_with("modules/hold/pictures/level1.png: "),
            "{why}"
        );
        assert_eq!(why.lines().count(), 1, "{why}");
    }
    for at in 0..good.len() {
        let mut flipped = good.clone();
        flipped[at] ^= 0x40;
        // Bytes that say how colours are meant may be anything.
        let _ = shown(flipped);
    }
    for (bytes, what) in [
        (b"GIF89a".to_vec(), "no PNG"),
        (vec![0xff, 0xd8, 0xff, 0xe0], "JPEG"),
        (
            png(MOST + 1, 1),
            "1025 × 1 pixels; expected: 1 to 1024 a side",
        ),
    ] {
        let why = shown(bytes).expect_err(what);
        assert!(why.contains(what), "{why}");
    }
    assert_eq!(shown(png(MOST, 1)), Ok([1024, 1]));
}

#[test]
fn a_picture_fills_its_place_in_one_direction() {
    let context = Context::default();
    let station = station(png(320, 240));
    let picture = Gallery::default().picture(&context, &station, ("hold", 1));
    let picture = picture.expect("a picture");
    assert_eq!(picture.size_in(vec2(160.0, 200.0)), vec2(160.0, 120.0));
    assert_eq!(picture.size_in(vec2(640.0, 120.0)), vec2(160.0, 120.0));
    assert_eq!(picture.small.size(), [160, 120]);
}

#[test]
fn half_of_a_picture_has_the_mean_of_four_pixels() {
    let grey = |level: u8| Color32::from_rgb(level, 0, 255 - level);
    let levels = [0, 10, 99, 20, 30, 99];
    let image = ColorImage::new([3, 2], levels.map(grey).to_vec());
    let half = halved(&image);
    // (0 + 10 + 20 + 30) / 4; the third column is left out.
    assert_eq!((half.size, half.pixels), ([1, 1], vec![grey(15)]));
}
