//! Draws small scenes and compares what is seen with closed forms. Without a graphics driver each test prints that and passes.
//!
//! All scenes: field of 20 mm on 400 × 400 pixels, that is 20 pixels per millimetre in the plane of focus.

mod common;

use common::renderer;
use microsim_gpu::Gpu;
use microsim_render::{
    Finish, Image, Item, KEY_LIGHT_AZIMUTH, KEY_LIGHT_ZENITH, Picture, Quality, RenderError,
    Renderer, SHADOW_LEVEL, Shape, Stereo, StereoLayout, View,
};
use std::f64::consts::PI;

const SIDE: u32 = 400;
/// Pixels per metre in the plane of focus.
const PIXELS: f64 = 20.0e3;
const DISTANCE: f64 = 0.2;
/// One texel of the shadow map \[pixels\]: 1024 of them cover 1.5 field radii to each side.
const TEXEL: f64 = 3.0 * 200.0 / 1024.0;

fn picture(items: Vec<Item>) -> Picture {
    let view = View {
        centre: [0.0; 3],
        field_diameter: 20.0e-3,
        working_distance: DISTANCE,
        tilt: 0.0,
    };
    Picture {
        background: [0.0, 0.0, 1.0],
        ..Picture::new((SIDE, SIDE), view, items)
    }
}

/// Mat whose top lies in the plane of focus.
fn mat(colour: [f32; 3]) -> Item {
    Item::new(
        Shape::Box {
            half: [0.1, 0.1, 1.0e-3],
        },
        [0.0, 0.0, -1.0e-3],
        colour,
        Finish::Matte,
    )
}

fn ball(radius: f64, position: [f64; 3], colour: [f32; 3]) -> Item {
    Item::new(Shape::Sphere { radius }, position, colour, Finish::Matte)
}

/// Middle of the pixels that `wanted` picks within nine tenths of the field, in pixels from the middle of the picture, right and
/// up; and their number.
fn centroid(image: &Image, wanted: impl Fn([u8; 3]) -> bool) -> ([f64; 2], usize) {
    let mut sum = [0.0; 2];
    let mut count = 0;
    for y in 0..image.height() {
        for x in 0..image.width() {
            let right = f64::from(x) + 0.5 - 0.5 * f64::from(image.width());
            let up = 0.5 * f64::from(image.height()) - f64::from(y) - 0.5;
            if libm::hypot(right, up) < 0.9 * 0.5 * f64::from(SIDE) && wanted(image.pixel(x, y)) {
                sum[0] += right;
                sum[1] += up;
                count += 1;
            }
        }
    }
    (sum.map(|part| part / count as f64), count)
}

fn assert_near(found: [f64; 2], expected: [f64; 2], tolerance: f64, what: &str) {
    let distance = libm::hypot(found[0] - expected[0], found[1] - expected[1]);
    assert!(
        distance <= tolerance,
        "{what}: found {found:?}, expected {expected:?}, tolerance {tolerance} pixels"
    );
}

fn linear(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::pow((value + 0.055) / 1.055, 2.4)
    }
}

/// sRGB bytes of a fraction (in linear light) of an sRGB colour.
fn dimmed(colour: [f32; 3], fraction: f64) -> [f64; 3] {
    colour.map(|part| {
        let light = fraction * linear((255.0 * part).round() as u8);
        255.0
            * if light <= 0.003_130_8 {
                12.92 * light
            } else {
                1.055 * libm::pow(light, 1.0 / 2.4) - 0.055
            }
    })
}

/// A byte each for the rounding of the colour that went in, of the one expected, and of the one drawn.
fn assert_colour(found: [u8; 3], expected: [f64; 3], what: &str) {
    let near = found
        .iter()
        .zip(expected)
        .all(|(&found, expected)| (f64::from(found) - expected).abs() <= 2.0);
    assert!(near, "{what}: found {found:?}, expected {expected:?}");
}

/// The silhouette of a ball in the focus point is a disc of radius r·d/√(d² − r²). Blue comes from the background alone; a pixel
/// counts when at least half of it is covered. Tolerance: along the circumference 2πρ, a quarter pixel for the chords that stand
/// for the circle and a quarter for the four samples of a pixel.
#[test]
fn ball_covers_the_area_of_its_silhouette() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    for radius in [0.5e-3, 3.0e-3] {
        let image = renderer
            .draw(&picture(vec![ball(radius, [0.0; 3], [1.0, 0.0, 0.0])]))
            .unwrap();
        let (middle, count) = centroid(&image, |[_, _, blue]| linear(blue) < 0.5);
        let silhouette =
            PIXELS * radius * DISTANCE / (DISTANCE * DISTANCE - radius * radius).sqrt();
        let (area, tolerance) = (PI * silhouette * silhouette, PI * silhouette);
        assert!(
            (count as f64 - area).abs() <= tolerance,
            "{count} pixels, expected {area} ± {tolerance}"
        );
        // Symmetric to the pixel, apart from samples that fall just on the edge.
        assert_near(middle, [0.0; 2], 0.5, "middle of the ball");
    }
}

/// A tilted eye sees what is higher further up: h·sin(tilt), enlarged by the perspective d/(d − h·cos(tilt)).
#[test]
fn tilt_and_perspective_place_a_ball() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let (height, tilt) = (4.0e-3, PI / 6.0);
    let mut tilted = picture(vec![ball(1.0e-3, [1.0e-3, 0.0, height], [1.0, 0.0, 0.0])]);
    tilted.view.tilt = tilt;
    let (middle, _) = centroid(&renderer.draw(&tilted).unwrap(), |[_, _, blue]| {
        linear(blue) < 0.5
    });
    let scale = PIXELS * DISTANCE / (DISTANCE - height * libm::cos(tilt));
    assert_near(
        middle,
        [1.0e-3 * scale, height * libm::sin(tilt) * scale],
        0.5,
        "ball seen under 30°",
    );
}

/// A matte surface that faces the microscope shows the colour it was given; the field is round, and black outside.
#[test]
fn mat_has_its_colour_and_the_field_is_round() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let colour = [0.2, 0.5, 0.8];
    let mut wide = picture(vec![mat(colour)]);
    (wide.width, wide.height) = (500, 300);
    let image = renderer.draw(&wide).unwrap();
    assert_colour(
        image.pixel(250, 150),
        dimmed(colour, 1.0),
        "middle of the mat",
    );
    for y in 0..300 {
        for x in 0..500 {
            let distance =
                libm::hypot(f64::from(x) + 0.5 - 250.0, f64::from(y) + 0.5 - 150.0) / 150.0;
            let pixel = image.pixel(x, y);
            if distance >= 1.0 {
                assert_eq!(pixel, [0; 3], "outside the field at ({x}, {y})");
            } else if distance <= 0.98 {
                assert!(pixel[2] > 100, "inside the field at ({x}, {y}): {pixel:?}");
            }
        }
    }
}

/// A ball at height h over the mat throws its shadow h·tan(zenith) away from the lamp, and there is light between the two: height
/// can be read. Tolerance: the lookup leaves the mat by 2.5 texels, which moves the shadow by 2.5·tan(zenith) texels; one more for
/// the raster of the shadow map.
#[test]
fn shadow_shows_the_height() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let colour = [0.6, 0.6, 0.6];
    for height in [3.0e-3, 6.0e-3] {
        let items = vec![
            mat(colour),
            ball(0.7e-3, [0.0, 0.0, height], [0.9, 0.0, 0.0]),
        ];
        let image = renderer.draw(&picture(items)).unwrap();
        let full = linear(153);
        let half_way = 0.5 * (1.0 + SHADOW_LEVEL) * full;
        // Grey and dark within the lit part: shadow; the ball is red, the rim of the field fades further out.
        let (middle, count) = centroid(&image, |[red, green, _]| {
            red.abs_diff(green) < 8
                && linear(red) < half_way
                && linear(red) > 0.9 * SHADOW_LEVEL * full
        });
        let reach = PIXELS * height * libm::tan(KEY_LIGHT_ZENITH);
        let expected = [
            -reach * libm::cos(KEY_LIGHT_AZIMUTH),
            -reach * libm::sin(KEY_LIGHT_AZIMUTH),
        ];
        assert_near(
            middle,
            expected,
            TEXEL * (2.5 * libm::tan(KEY_LIGHT_ZENITH) + 1.0),
            "shadow",
        );
        // The shadow of a ball on a plane is an ellipse, 1/cos(zenith) longer than wide.
        let area = PI * (PIXELS * 0.7e-3).powi(2) / libm::cos(KEY_LIGHT_ZENITH);
        let rim = TEXEL * 2.0 * PI * PIXELS * 0.7e-3 / libm::cos(KEY_LIGHT_ZENITH);
        assert!(
            (count as f64 - area).abs() < rim,
            "shadow of {count} pixels, expected {area} ± {rim}"
        );
        let at =
            |place: [f64; 2]| image.pixel((200.0 + place[0]) as u32, (200.0 - place[1]) as u32);
        assert_colour(at(expected), dimmed(colour, SHADOW_LEVEL), "in the shadow");
        assert_colour(
            at([-expected[0], -expected[1]]),
            dimmed(colour, 1.0),
            "on the lamp's side",
        );
    }
}

/// Both sides of a mesh are drawn alike, whatever the winding of its triangles.
#[test]
fn mesh_is_seen_from_both_sides() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let colour = [0.8, 0.3, 0.3];
    let positions = vec![
        [-4.0e-3, -4.0e-3, 0.0],
        [4.0e-3, -4.0e-3, 0.0],
        [4.0e-3, 4.0e-3, 0.0],
        [-4.0e-3, 4.0e-3, 0.0],
    ];
    let mut draw = |triangles| {
        let sheet = Shape::Mesh {
            positions: positions.clone(),
            triangles,
        };
        renderer
            .draw(&picture(vec![Item::new(
                sheet,
                [0.0; 3],
                colour,
                Finish::Matte,
            )]))
            .unwrap()
    };
    let up = draw(vec![[0, 1, 2], [0, 2, 3]]);
    let down = draw(vec![[0, 2, 1], [0, 3, 2]]);
    assert_colour(up.pixel(210, 190), dimmed(colour, 1.0), "sheet");
    assert!(
        up == down,
        "the sheet looks different when its triangles are turned round"
    );
}

/// Eight millimetres above the plane of focus the edge of a ball is spread over two pixels to each side at the highest quality; without depth of field it is as
/// sharp as the samples of a pixel make it. It comes back.
#[test]
fn depth_of_field_is_left_out() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    renderer.set_quality(Quality::High);
    let above = picture(vec![ball(2.0e-3, [0.0, 0.0, 8.0e-3], [0.7, 0.2, 0.0])]);
    // Half of what is behind shines through the edge; the ball has no blue.
    let is_edge = |[_, _, blue]: [u8; 3]| (60..200).contains(&blue);
    let mut edge = |is_on| {
        renderer.set_depth_of_field(is_on);
        centroid(&renderer.draw(&above).unwrap(), is_edge).1
    };
    let (blurred, sharp, again) = (edge(true), edge(false), edge(true));
    assert!(
        sharp > 50 && blurred > 2 * sharp,
        "{blurred} and {sharp} pixels"
    );
    assert_eq!(again, blurred);
}

/// A moist ball has its highlight where the normal halves the angle between lamp and eye; a matte one has none.
#[test]
fn moist_surface_has_a_highlight() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let radius = 4.0e-3;
    let mut draw = |finish| {
        let item = Item {
            finish,
            ..ball(radius, [0.0; 3], [0.7, 0.2, 0.2])
        };
        renderer
            .draw(&Picture {
                background: [0.0; 3],
                ..picture(vec![item])
            })
            .unwrap()
    };
    // Green is 0.2 at most without a highlight: linear 0.033 against 0.75 more in its middle.
    let bright = |[_, green, _]: [u8; 3]| linear(green) > 0.5;
    let (middle, count) = centroid(&draw(Finish::Moist), bright);
    assert!(count > 10, "{count}");
    let offset = PIXELS * radius * libm::sin(0.5 * KEY_LIGHT_ZENITH);
    // The diffuse light is brighter towards the lamp and the perspective enlarges what is nearer by 2 %: a tenth of the difference.
    assert_near(
        middle,
        [
            offset * libm::cos(KEY_LIGHT_AZIMUTH),
            offset * libm::sin(KEY_LIGHT_AZIMUTH),
        ],
        0.1 * offset,
        "highlight",
    );
    assert_eq!(centroid(&draw(Finish::Matte), bright).1, 0);
}

/// A half translucent sheet mixes its light with what lies behind, and casts no shadow.
#[test]
fn translucent_item_mixes_and_casts_no_shadow() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let sheet = Shape::Box {
        half: [2.0e-3, 2.0e-3, 0.1e-3],
    };
    let glass = Item {
        opacity: 0.5,
        ..Item::new(sheet, [0.0, 0.0, 4.0e-3], [1.0, 0.0, 0.0], Finish::Matte)
    };
    let image = renderer
        .draw(&picture(vec![mat([0.0, 1.0, 0.0]), glass]))
        .unwrap();
    let half = dimmed([1.0; 3], 0.5)[0];
    assert_colour(
        image.pixel(200, 200),
        [half, half, 0.0],
        "through the sheet",
    );
    let shadow = PIXELS * 4.0e-3 * libm::tan(KEY_LIGHT_ZENITH);
    assert_colour(
        image.pixel(200, 200 + shadow as u32),
        [0.0, 255.0, 0.0],
        "where a solid sheet would cast its shadow",
    );
}

/// A mirrored picture is that of the mirrored arrangement under the same lamps, for each eye of a pair, too: of balls, a rod and a closed metal box it is drawn by putting
/// each on the other side. Low quality has no noise: only where a shadow ends, whose filter is not mirrored, may pixels differ by more than rounding, along edges of
/// 220 (ball), 340 (rod) and 100 pixels (box); with its lamp on the wrong side the shadow of the ball alone would differ by 700. The noise of higher qualities, which is not
/// mirrored either, is even on the mean: pictures differ by less than a level in 255.
#[test]
fn a_mirrored_picture_is_that_of_the_mirrored_arrangement() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let arrangement = |side: f64| {
        let rod = Shape::Capsule {
            a: [side * 1.0e-3, 2.0e-3, 1.0e-3],
            b: [side * 5.0e-3, -3.0e-3, 4.0e-3],
            radius: 0.4e-3,
        };
        let block = Shape::RoundedBox {
            half: [0.8e-3, 0.5e-3, 0.3e-3],
            radius: 0.1e-3,
        };
        let block = Item::new(block, [0.0; 3], [0.8; 3], Finish::Metal);
        let tilt = libm::sin(0.3);
        let turn = [0.0, side * tilt, 0.0, libm::cos(0.3)];
        vec![
            mat([0.3, 0.5, 0.4]),
            ball(1.5e-3, [side * -3.0e-3, 1.0e-3, 2.0e-3], [0.9, 0.3, 0.2]),
            Item::new(rod, [0.0; 3], [0.2, 0.3, 0.9], Finish::Moist),
            block.at([side * 3.0e-3, 4.0e-3, 1.0e-3], turn),
        ]
    };
    let layouts = [StereoLayout::Mono, StereoLayout::SideBySide];
    let all = layouts.map(|layout| [Quality::Low, Quality::High].map(|quality| (layout, quality)));
    for (layout, quality) in all.into_iter().flatten() {
        renderer.set_quality(quality);
        let stereo = Stereo {
            layout,
            ..Stereo::default()
        };
        let drawn = |side: f64, mirrored: bool, renderer: &mut Renderer| {
            let mut picture = picture(arrangement(side));
            (picture.mirrored, picture.stereo) = (mirrored, stereo);
            picture.view.tilt = 0.4;
            renderer.draw(&picture).expect("a picture")
        };
        let mirrored = drawn(1.0, true, &mut renderer);
        let moved = drawn(-1.0, false, &mut renderer);
        assert!(
            moved != drawn(1.0, false, &mut renderer),
            "it is not symmetric"
        );
        let differences: Vec<u8> = mirrored
            .rgba8()
            .iter()
            .zip(moved.rgba8())
            .map(|(a, b)| a.abs_diff(*b))
            .collect();
        let mean =
            differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
        assert!(mean < 1.0, "{layout:?}, {quality:?}: {mean}");
        let off = differences
            .chunks_exact(4)
            .filter(|pixel| pixel.iter().any(|d| *d > 3))
            .count();
        let is_even = off < 660;
        assert!(
            is_even || quality == Quality::High,
            "{layout:?}: {off} pixels"
        );
    }
}

/// The same picture has the same bytes: twice in a row, after another size, and from a second renderer of this machine.
#[test]
fn same_picture_has_the_same_bytes() {
    let Some(mut first) = renderer() else { return };
    let Some(mut second) = renderer() else { return };
    let jaw = Shape::Taper {
        a: [0.0; 3],
        b: [0.03, -0.02, 0.02],
        radius_a: 0.1e-3,
        radius_b: 1.0e-3,
    };
    let ring = Shape::Ring {
        radius: 2.0e-3,
        tube: 0.1e-3,
        fraction: 0.7,
    };
    let scene = picture(vec![
        mat([0.1, 0.3, 0.3]),
        ball(1.0e-3, [-2.0e-3, 1.0e-3, 2.0e-3], [0.9, 0.6, 0.1]),
        Item::new(jaw, [0.0, 0.0, 1.0e-3], [0.8; 3], Finish::Metal),
        Item {
            opacity: 0.5,
            ..Item::new(ring, [0.0; 3], [1.0; 3], Finish::Moist)
        },
    ]);
    let image = first.draw(&scene).unwrap();
    assert!(image == first.draw(&scene).unwrap(), "second frame differs");
    let mut small = scene.clone();
    (small.width, small.height) = (33, 17);
    assert_eq!(first.draw(&small).unwrap().rgba8().len(), 4 * 33 * 17);
    assert!(
        image == first.draw(&scene).unwrap(),
        "frame after another size differs"
    );
    assert!(
        image == second.draw(&scene).unwrap(),
        "frame of a second renderer differs"
    );
}

/// What cannot be drawn is an error that names the fault, and the renderer goes on; an empty picture is the background.
#[test]
fn faults_are_errors_and_the_renderer_goes_on() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let empty = picture(Vec::new());
    let oversize = renderer.draw(&Picture {
        width: u32::MAX,
        ..empty.clone()
    });
    assert!(
        matches!(
            oversize,
            Err(RenderError::Size {
                width: u32::MAX,
                ..
            })
        ),
        "{oversize:?}"
    );
    assert!(matches!(
        renderer.draw(&Picture {
            height: 0,
            ..empty.clone()
        }),
        Err(RenderError::Size { height: 0, .. })
    ));
    let lost = picture(vec![
        mat([0.5; 3]),
        ball(1.0, [f64::NAN, 0.0, 0.0], [0.5; 3]),
    ]);
    let error = renderer.draw(&lost).unwrap_err();
    assert_eq!(
        error,
        RenderError::Item {
            index: 1,
            reason: "position is not finite"
        }
    );
    assert_eq!(
        error.to_string(),
        "item 1 of the picture: position is not finite"
    );
    let background = renderer.draw(&empty).unwrap();
    assert_eq!(background.pixel(200, 200), [0, 0, 255]);
}

/// Rendering without reading back gives the same bytes, however many pictures went before; the texture stays while the size does, and takes the view that a
/// window needs.
#[test]
fn rendering_and_reading_back_are_apart() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    assert!(renderer.texture().is_none() && !renderer.is_busy().unwrap());
    assert!(matches!(
        renderer.read_back(),
        Err(RenderError::Device { .. })
    ));
    let at = |x: f64| picture(vec![ball(2.0e-3, [x, 0.0, 0.0], [0.9, 0.2, 0.1])]);
    let expected = renderer.draw(&at(3.0e-3)).unwrap();
    let texture = renderer.texture().cloned();
    for step in -3..=3 {
        renderer.render(&at(1.0e-3 * f64::from(step))).unwrap();
    }
    assert!(renderer.texture() == texture.as_ref());
    assert!(expected == renderer.read_back().unwrap());
    assert!(!renderer.is_busy().unwrap(), "what was read is finished");
    let texture = texture.unwrap();
    assert!(
        texture
            .usage()
            .contains(wgpu::TextureUsages::TEXTURE_BINDING)
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        format: Some(wgpu::TextureFormat::Rgba8Unorm),
        ..Default::default()
    });
    assert!(expected == renderer.read_back().unwrap(), "read twice");
}

/// A device that is lost is an error of the next call, not a panic; a new device draws again.
#[test]
fn loss_of_the_device_is_an_error() {
    let Ok(gpu) = Gpu::off_screen() else {
        println!("picture test skipped: no driver");
        return;
    };
    let mut renderer = Renderer::new(&gpu).unwrap();
    let empty = picture(Vec::new());
    renderer.render(&empty).unwrap();
    assert_eq!(gpu.lost(), None);
    gpu.device().destroy();
    for _ in 0..3 {
        let error = renderer.draw(&empty).unwrap_err();
        assert!(error.to_string().contains("lost"), "{error}");
    }
    assert!(renderer.is_busy().is_err());
    assert!(gpu.lost().is_some());
}
