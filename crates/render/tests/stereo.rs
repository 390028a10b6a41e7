//! What a stereo pair shows of height. Without a graphics driver the test prints that and passes.

mod common;

use common::renderer;
use microsim_render::{Finish, Image, Item, Picture, Shape, Stereo, StereoLayout, View};

/// Pixels of one eye's picture, whose field is 20 mm.
const SIDE: u32 = 400;
const PIXELS: f64 = 20.0e3;
const DISTANCE: f64 = 0.2;

/// Mean place across of the pixels with no blue of the background in one half of the image, from its middle \[pixels\].
fn across(image: &Image, first: u32) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..SIDE {
        for x in 0..SIDE {
            // Half of linear light, as where a pixel is half covered; black is outside of the field.
            let [red, _, blue] = image.pixel(first + x, y);
            if red > 40 && blue < 188 {
                sum += f64::from(x) + 0.5 - 0.5 * f64::from(SIDE);
                count += 1;
            }
        }
    }
    assert!(count > 50, "{count} pixels of the ball");
    sum / f64::from(count)
}

/// A ball at height h along the view axis lies at x·d/(d − h) − e·h/(d − h) in the plane of focus for an eye at e: the pair has the parallax b·h/(d − h), from which the height
/// follows. Heights half a millimetre apart are distinguished where each is found to a quarter; a fifth of a pixel of parallax is 0.1 mm.
#[test]
fn a_pair_shows_height_to_half_a_millimetre() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let stereo = Stereo {
        layout: StereoLayout::SideBySide,
        ..Stereo::default()
    };
    for tilt in [0.0, 0.6] {
        for step in -2..=8 {
            let height = 0.5e-3 * f64::from(step);
            let view = View {
                centre: [0.0; 3],
                field_diameter: 20.0e-3,
                working_distance: DISTANCE,
                tilt,
            };
            let ball = Item::new(
                Shape::Sphere { radius: 0.4e-3 },
                [1.0e-3, 0.0, height],
                [0.9, 0.1, 0.1],
                Finish::Matte,
            );
            let picture = Picture {
                background: [0.0, 0.0, 1.0],
                stereo,
                ..Picture::new((2 * SIDE, SIDE), view, vec![ball])
            };
            let image = renderer.draw(&picture).expect("a picture");
            let parallax = (across(&image, 0) - across(&image, SIDE)) / PIXELS;
            let nearer = parallax * DISTANCE / (stereo.base + parallax);
            let found = nearer / libm::cos(tilt);
            assert!(
                (found - height).abs() < 0.25e-3,
                "{height} at {tilt}: {found}"
            );
        }
    }
}
