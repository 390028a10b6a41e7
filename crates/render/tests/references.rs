//! Pictures of recorded states of the field against committed ones. Without a graphics driver each test prints that it is skipped.
//!
//! The states are what a tick published (coordination, level 4, script `level4-pass`, 5 s) or what scenes come to (`tear-layer` at 0.4 s, `cut-oblique` at 0.05 s,
//! `vessel-two-tools` at 1.2 s), so a change of physics changes no picture. The pictures are of medium quality, 480 × 270, drawn with llvmpipe of Mesa 22.3; to record them again:
//! `MICROSIM_RECORD=1 cargo test --release -p microsim-render --test references`.
//!
//! Tolerance. Drivers place samples within pixels differently and round differently. The outlines of these pictures pass through about 2,500 of their 130,000 pixels, 2 %; a sample
//! more or less inside changes such a pixel by a quarter of the contrast, 16 to 64 of 255. Half of those pixels may therefore change by more than 16; elsewhere the noise that turns the penumbrae
//! differs by rounding in few pixels. Over the whole picture that is less than 1 of 255 on the mean. Both together find a body that is not drawn, a layer of another
//! colour, a light that is missing (the second test).

mod fixture;

use microsim_gpu::Gpu;
use microsim_render::{Image, Picture, Quality, Renderer};
use std::path::{Path, PathBuf};

const NAMES: [&str; 4] = [
    "coordination-level4",
    "cut-oblique",
    "tear-layer",
    "vessel-two-tools",
];
const SIZE: (u32, u32) = (480, 270);
/// A pixel differs if one of its channels does by more than this [of 255].
const DIFFERS: u8 = 16;
/// Fraction of the pixels that may differ.
const DIFFERENT: f64 = 0.005;
/// Mean difference of all channels of all pixels [of 255].
const MEAN: f64 = 0.5;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references")
}

fn renderer() -> Option<Renderer> {
    match Gpu::off_screen() {
        Ok(gpu) => Some(Renderer::of_quality(&gpu, Quality::Medium).expect("it takes the shaders")),
        Err(error) => {
            println!("picture test skipped: {error}");
            None
        }
    }
}

fn state(name: &str) -> Picture {
    let file = folder().join(name).with_extension("json");
    fixture::picture(
        &std::fs::read_to_string(file).expect("the state is there"),
        SIZE,
    )
}

/// Rows of red, green, blue.
fn pixels(image: &Image) -> Vec<u8> {
    let pixels = image.rgba8().chunks_exact(4);
    pixels.flat_map(|p| [p[0], p[1], p[2]]).collect()
}

fn read(file: &Path) -> Vec<u8> {
    let bytes = std::fs::read(file).expect("the reference is there");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .expect("a PNG file");
    let mut pixels = vec![0; reader.output_buffer_size().expect("of this size")];
    let info = reader.next_frame(&mut pixels).expect("a picture");
    assert_eq!((info.width, info.height), SIZE);
    pixels
}

/// Fraction of the pixels that differ, and mean difference.
fn difference(found: &[u8], expected: &[u8]) -> (f64, f64) {
    assert_eq!(found.len(), expected.len());
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    let all: Vec<u8> = found.iter().zip(expected).map(off).collect();
    let different = all
        .chunks_exact(3)
        .filter(|p| p.iter().any(|d| *d > DIFFERS));
    let mean = all.iter().map(|d| f64::from(*d)).sum::<f64>() / all.len() as f64;
    (different.count() as f64 / (all.len() / 3) as f64, mean)
}

fn is_same((different, mean): (f64, f64)) -> bool {
    different <= DIFFERENT && mean <= MEAN
}

fn write(file: &Path, rgb: &[u8]) {
    let file = std::fs::File::create(file).expect("the folder is there");
    let mut encoder = png::Encoder::new(file, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a picture");
    writer.write_image_data(rgb).expect("all of it");
}

/// Each picture is the committed one; one that is not leaves both and eight times their difference in `target/pictures`.
#[test]
fn pictures_are_the_committed_ones() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let mut complaints = Vec::new();
    for name in NAMES {
        let image = renderer.draw(&state(name)).expect("it can be drawn");
        let reference = folder().join(name).with_extension("png");
        if std::env::var_os("MICROSIM_RECORD").is_some() {
            write(&reference, &pixels(&image));
            continue;
        }
        let (found, expected) = (pixels(&image), read(&reference));
        let off = difference(&found, &expected);
        if !is_same(off) {
            let left = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/pictures");
            std::fs::create_dir_all(&left).expect("target can be written");
            let eightfold: Vec<u8> = found
                .iter()
                .zip(&expected)
                .map(|(a, b)| a.abs_diff(*b).saturating_mul(8))
                .collect();
            for (kind, rgb) in [
                ("found", &found),
                ("expected", &expected),
                ("difference", &eightfold),
            ] {
                write(&left.join(format!("{name}.{kind}.png")), rgb);
            }
            complaints.push(format!(
                "{name}: {:.2} % of the pixels differ, {:.2} of 255 on the mean; allowed are {:.2} % and {MEAN}; see {}",
                100.0 * off.0,
                off.1,
                100.0 * DIFFERENT,
                left.display()
            ));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// The comparison finds a body that is missing, one whose opened faces are taken for outer ones, and another light.
#[test]
fn other_pictures_are_refused() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    for name in ["cut-oblique", "tear-layer"] {
        let expected = read(&folder().join(name).with_extension("png"));
        let mut refuse = |what: &str, change: &dyn Fn(&mut Picture)| {
            let mut picture = state(name);
            change(&mut picture);
            let image = renderer.draw(&picture).expect("it can be drawn");
            let off = difference(&pixels(&image), &expected);
            assert!(!is_same(off), "{name} {what}: {off:?}");
        };
        refuse("without its body", &|picture| picture.tissues.clear());
        refuse("without layers", &|picture| {
            let tissue = &mut picture.tissues[0];
            tissue.regions.clear();
            tissue.inner.clear();
            tissue.colour = [0.6, 0.5, 0.3];
        });
        refuse("from another side", &|picture| picture.view.tilt += 0.1);
    }
}

/// After a release there is no picture, and the next one is the same to the byte: targets and tissue are made again.
#[test]
fn what_is_released_is_drawn_again() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let state = state("vessel-two-tools");
    let before = renderer.draw(&state).expect("it draws");
    renderer.release();
    assert!(renderer.texture().is_none() && renderer.read_back().is_err());
    assert!(renderer.draw(&state).expect("it draws again") == before);
}
