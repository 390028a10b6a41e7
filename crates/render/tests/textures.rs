//! Draws models with textures and compares what is seen with closed forms. Without a graphics driver each test prints that and passes.
//!
//! All scenes: a square of 10 mm in the plane of focus, facing the microscope, in a field of 20 mm on 400 × 400 pixels: 200 pixels, within which no light falls off up
//! to 110 pixels from the middle.

mod common;

use common::renderer;
use microsim_message::{ObjectScene, ObjectState, Pose, Shape as ObjectShape};
use microsim_render::{Finish, Image, Item, Models, Picture, Shape, View, colour_of};

const SIDE: u32 = 400;
/// Pixels of the square's side.
const SQUARE: f64 = 200.0;

/// In millimetres; its texture upright.
const SQUARE_OBJ: &[u8] = b"v -5 -5 0\nv 5 -5 0\nv 5 5 0\nv -5 5 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

fn picture(items: Vec<Item>) -> Picture {
    let view = View {
        centre: [0.0; 3],
        field_diameter: 20.0e-3,
        working_distance: 0.2,
        tilt: 0.0,
    };
    Picture::new((SIDE, SIDE), view, items)
}

fn png(width: u32, pixels: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, pixels.len() as u32 / width);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(pixels.as_flattened())
        .expect("pixels");
    writer.finish().expect("an end");
    bytes
}

fn square(model: &str, texture: Option<&str>, colour: [f64; 3], finish: Finish) -> ObjectScene {
    ObjectScene {
        objects: vec![ObjectState {
            name: "square".into(),
            shape: ObjectShape::Model {
                model: model.into(),
                scale: 1e-3,
                texture: texture.map(str::to_owned),
            },
            pose: Pose::default(),
            colour,
            finish,
        }],
    }
}

/// Linear light of an sRGB value 0..1 (IEC 61966-2-1).
fn linear(value: f64) -> f64 {
    match value <= 0.04045 {
        true => value / 12.92,
        false => libm::pow((value + 0.055) / 1.055, 2.4),
    }
}

/// sRGB byte of linear light, not rounded.
fn encoded(light: f64) -> f64 {
    let value = match light <= 0.003_130_8 {
        true => 12.92 * light,
        false => 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055,
    };
    255.0 * value
}

#[track_caller]
fn assert_colour(image: &Image, [x, y]: [u32; 2], expected: [f64; 3], tolerance: f64) {
    let found = image.pixel(x, y);
    let near = found
        .iter()
        .zip(expected)
        .all(|(found, expected)| (f64::from(*found) - expected).abs() <= tolerance);
    assert!(near, "{x}, {y}: found {found:?}, expected {expected:?}");
}

/// Four colours, times that of the object, upright, and between their middles the light of both in the ratio of the distances. Tolerance: a byte each for the
/// rounding of the colour that went in and of the one drawn; and drivers divide the distance of two pixels of a texture in 256 steps at least, half of which is
/// 0.6 bytes between these colours (their light differs by less than 0.8, and sRGB has at most 290 bytes per unit of light above 0.2).
#[test]
fn a_texture_is_seen_upright_and_filtered_in_linear_light() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let texels = [[250, 130, 140], [130, 240, 150], [140, 130, 230], [200; 3]];
    let colour = [1.0, 0.9, 0.95];
    let file = png(2, &texels);
    let files: [(&str, &[u8]); 2] = [("square.obj", SQUARE_OBJ), ("four.png", &file)];
    let mut models = Models::new(&files).expect("files");
    let scene = square("square.obj", Some("four.png"), colour, Finish::Matte);
    let image = renderer.draw(&picture(models.items(&scene))).unwrap();
    let light = |texel: usize, k: usize| linear(f64::from(texels[texel][k]) / 255.0);
    let middle = 0.5 * f64::from(SIDE);
    // Between the middles of the texture's pixels; beyond them the opposite side is mixed in, as coordinates repeat.
    for (x, y) in (150..250)
        .step_by(3)
        .flat_map(|x| (150..250).step_by(3).map(move |y| (x, y)))
    {
        // In pixels of the texture from the middle of its first one.
        let [right, down] = [x, y].map(|pixel| {
            let place = (f64::from(pixel) + 0.5 - middle) / SQUARE + 0.5;
            2.0 * place - 0.5
        });
        let expected = std::array::from_fn(|k| {
            let upper = (1.0 - right) * light(0, k) + right * light(1, k);
            let lower = (1.0 - right) * light(2, k) + right * light(3, k);
            let both = (1.0 - down) * upper + down * lower;
            encoded(both * linear(colour[k]))
        });
        assert_colour(&image, [x, y], expected, 2.6);
    }
}

/// A chessboard of fields five times as small as pixels is grey: half the light, 188 of 255 in sRGB.
#[test]
fn a_texture_finer_than_pixels_shows_its_mean() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let board: Vec<[u8; 3]> = (0..1024 * 1024)
        .map(|k| {
            [if (k % 1024 + k / 1024) % 2 == 0 {
                0
            } else {
                255
            }; 3]
        })
        .collect();
    let file = png(1024, &board);
    let files: [(&str, &[u8]); 2] = [("square.obj", SQUARE_OBJ), ("board.png", &file)];
    let mut models = Models::new(&files).expect("files");
    let scene = square("square.obj", Some("board.png"), [1.0; 3], Finish::Matte);
    let image = renderer.draw(&picture(models.items(&scene))).unwrap();
    for (x, y) in (130..270)
        .step_by(3)
        .flat_map(|x| (130..270).step_by(3).map(move |y| (x, y)))
    {
        assert_colour(&image, [x, y], [188.0; 3], 2.0);
    }
}

/// A glTF square with a picture of its own beside it, `own.png`, whose coordinates go from `from` to `to`, with this material and sampler.
fn gltf_with([from, to]: [f32; 2], material: &str, sampler: &str) -> (Vec<u8>, Vec<u8>) {
    let corners: [[f32; 3]; 4] = [
        [-5.0, -5.0, 0.0],
        [5.0, -5.0, 0.0],
        [5.0, 5.0, 0.0],
        [-5.0, 5.0, 0.0],
    ];
    let places: [[f32; 2]; 4] = [[from, to], [to, to], [to, from], [from, from]];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    let numbers = corners.as_flattened().iter().chain(places.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],
"materials":[{MATERIAL}],"textures":[{"source":0,"sampler":0}],"images":[{"uri":"own.png"}],"samplers":[{SAMPLER}],
"buffers":[{"uri":"square.bin","byteLength":92}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},{"buffer":0,"byteOffset":80,"byteLength":12}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-5,-5,0],"max":[5,5,0]},
{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]}"#;
    let text = text.replace("{MATERIAL}", material);
    let text = text.replace("{SAMPLER}", sampler);
    (text.into_bytes(), bytes)
}

const PLAIN: &str = r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#;

fn gltf() -> (Vec<u8>, Vec<u8>) {
    gltf_with([0.0, 1.0], PLAIN, "{}")
}

/// The number of the pixel of a texture of four that is at a place in a row of them that goes on, by glTF 2.0 (5.26).
fn wrapped(mode: u32, place: i32) -> usize {
    let number = match mode {
        10_497 => place.rem_euclid(4),
        33_648 => match place.rem_euclid(8) {
            ahead @ 0..4 => ahead,
            back => 7 - back,
        },
        _ => place.clamp(0, 3),
    };
    number as usize
}

/// Three times the texture in each direction, the middle one as it is. Tolerance as above.
#[test]
fn textures_go_on_as_their_samplers_state() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let texels: [[u8; 3]; 16] = std::array::from_fn(|k| {
        let [x, y] = [k % 4, k / 4].map(|place| place as u8);
        [130 + 30 * x, 130 + 30 * y, 250 - 10 * (x + 3 * y)]
    });
    let own = png(4, &texels);
    for [s, t] in [[10_497, 33_648], [33_648, 33_071], [33_071, 10_497]] {
        let sampler = format!(r#"{{"wrapS":{s},"wrapT":{t}}}"#);
        let (text, bytes) = gltf_with([-1.0, 2.0], PLAIN, &sampler);
        let files: [(&str, &[u8]); 3] = [
            ("square.gltf", &text),
            ("square.gltf/square.bin", &bytes),
            ("square.gltf/own.png", &own),
        ];
        let mut models = Models::new(&files).expect("files");
        let scene = square("square.gltf", None, [1.0; 3], Finish::Matte);
        let image = renderer.draw(&picture(models.items(&scene))).unwrap();
        for (x, y) in (126..275)
            .step_by(7)
            .flat_map(|x| (126..275).step_by(7).map(move |y| (x, y)))
        {
            // In pixels of the texture from the middle of its first one.
            let [right, down] = [x, y].map(|pixel| {
                let place = (f64::from(pixel) + 0.5 - 0.5 * f64::from(SIDE)) / SQUARE + 0.5;
                4.0 * (3.0 * place - 1.0) - 0.5
            });
            let light = |column: i32, row: i32, k: usize| {
                let texel = 4 * wrapped(t, row) + wrapped(s, column);
                linear(f64::from(texels[texel][k]) / 255.0)
            };
            let [column, row] = [right, down].map(|place| place.floor() as i32);
            let [right, down] = [right, down].map(|place| place - place.floor());
            let expected = std::array::from_fn(|k| {
                let along =
                    |row| (1.0 - right) * light(column, row, k) + right * light(column + 1, row, k);
                encoded((1.0 - down) * along(row) + down * along(row + 1))
            });
            assert_colour(&image, [x, y], expected, 2.6);
        }
    }
}

fn png_with_opacity(pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.len() as u32, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(pixels.as_flattened())
        .expect("pixels");
    writer.finish().expect("an end");
    bytes
}

/// Opacity falls from 1 at the middle of the left pixel of the texture, u = 1/4, to 100/255 at that of the right one, u = 3/4; the surface ends where it is, times the factor, the cutoff:
/// `factor · (255 − 155 (2 u − 1/2)) = 255 · cutoff`. Beyond there is the background.
#[test]
fn a_surface_ends_where_its_texture_is_below_the_cutoff() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let own = png_with_opacity(&[[200, 60, 60, 255], [200, 60, 60, 100]]);
    let empty = renderer.draw(&picture(Vec::new())).unwrap();
    for (cutoff, factor) in [(0.5, 1.0), (0.5, 0.75), (0.8, 1.0)] {
        let material = format!(
            r#"{{"alphaMode":"MASK","alphaCutoff":{cutoff},"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"baseColorFactor":[1,1,1,{factor}]}}}}"#
        );
        let (text, bytes) = gltf_with([0.0, 1.0], &material, r#"{"wrapS":33071}"#);
        let files: [(&str, &[u8]); 3] = [
            ("square.gltf", &text),
            ("square.gltf/square.bin", &bytes),
            ("square.gltf/own.png", &own),
        ];
        let mut models = Models::new(&files).expect("files");
        let scene = square("square.gltf", None, [1.0; 3], Finish::Matte);
        let image = renderer.draw(&picture(models.items(&scene))).unwrap();
        let end = 0.25 + 0.5 * (255.0 - 255.0 * cutoff / factor) / 155.0;
        let end = 0.5 * f64::from(SIDE) + SQUARE * (end - 0.5);
        for y in [150, 200, 250] {
            // A pixel is cut where its middle is; two more are left to the smoothing of edges and to what drivers round.
            let [before, behind] = [end - 3.0, end + 3.0].map(|x| x as u32);
            assert_colour(&image, [before, y], [200.0, 60.0, 60.0], 1.0);
            assert_eq!(
                image.pixel(behind, y),
                empty.pixel(behind, y),
                "{cutoff} {factor}"
            );
        }
    }
}

/// A surface of which nothing is there casts no shadow and darkens no crevice: to the byte the picture without it. The same surface, opaque, does both.
#[test]
fn what_is_cut_out_casts_no_shadow() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let translucent = png_with_opacity(&[[200, 60, 60, 100]; 2]);
    let material = PLAIN.replacen('{', r#"{"alphaMode":"MASK","#, 1);
    let (cut, bytes) = gltf_with([0.0, 1.0], &material, "{}");
    let (opaque, _) = gltf();
    let files: [(&str, &[u8]); 7] = [
        ("cut.gltf", &cut),
        ("cut.gltf/square.bin", &bytes),
        ("cut.gltf/own.png", &translucent),
        ("opaque.gltf", &opaque),
        ("opaque.gltf/square.bin", &bytes),
        ("opaque.gltf/own.png", &translucent),
        ("square.obj", SQUARE_OBJ),
    ];
    let mut models = Models::new(&files).expect("files");
    let mut seen = |above: Option<&str>| {
        let mut scene = square("square.obj", None, [0.8; 3], Finish::Matte);
        if let Some(model) = above {
            // A third as large, 1.5 mm above.
            let mut small = square(model, None, [1.0; 3], Finish::Matte);
            let object = &mut small.objects[0];
            object.pose.position[2] = 1.5e-3;
            object.shape = ObjectShape::Model {
                model: model.into(),
                scale: 0.33e-3,
                texture: None,
            };
            scene.objects.append(&mut small.objects);
        }
        renderer.draw(&picture(models.items(&scene))).unwrap()
    };
    let (without, with_cut) = (seen(None), seen(Some("cut.gltf")));
    let with_opaque = seen(Some("opaque.gltf"));
    let mut shadowed = 0;
    for (x, y) in (100..300).flat_map(|x| (100..300).map(move |y| (x, y))) {
        let plain = without.pixel(x, y);
        assert_eq!(with_cut.pixel(x, y), plain, "{x}, {y}");
        // Beside the small square, which reaches 33 pixels from the middle, and 36 in perspective.
        let is_beside = x.abs_diff(200) > 36 || y.abs_diff(200) > 36;
        let darker = with_opaque.pixel(x, y)[0] + 8 < plain[0];
        shadowed += u32::from(is_beside && darker);
    }
    assert!(shadowed > 100, "{shadowed} pixels in shadow");
}

/// A model shows its own texture, upright, unless the object has one; with every finish, solid or not.
#[test]
fn the_texture_of_an_object_goes_before_that_of_its_model() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let (text, bytes) = gltf();
    // Red above, green below; blue above, green below.
    let [own, other] = [[200, 60, 60], [60, 60, 200]].map(|above| png(1, &[above, [60, 200, 60]]));
    let files: [(&str, &[u8]); 4] = [
        ("square.gltf", &text),
        ("square.gltf/square.bin", &bytes),
        ("square.gltf/own.png", &own),
        ("other.png", &other),
    ];
    let mut models = Models::new(&files).expect("files");
    for finish in [Finish::Matte, Finish::Moist, Finish::Metal] {
        for (texture, strongest) in [(None, 0), (Some("other.png"), 2)] {
            for opacity in [1.0, 0.8] {
                let scene = square("square.gltf", texture, [1.0; 3], finish);
                let items = models.items(&scene).into_iter();
                let items = items.map(|item| Item { opacity, ..item });
                let image = renderer.draw(&picture(items.collect())).unwrap();
                for (y, expected) in [(150, strongest), (250, 1)] {
                    let pixel = image.pixel(200, y);
                    let most = (0..3).max_by_key(|k| pixel[*k]);
                    assert_eq!(
                        most,
                        Some(expected),
                        "{finish:?} {texture:?} {opacity}: {pixel:?}"
                    );
                }
            }
        }
    }
}

/// A square whose value rises from 0 at its left side to 1 at its right one shows the colours of the map where they belong: matte, it faces the microscope in full light.
#[test]
fn values_are_seen_in_their_colours() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let half = 5.0e-3_f32;
    let corner = |x: f32, y: f32| [x * half, y * half, 0.0];
    let shape = Shape::Field {
        positions: vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        values: vec![0.0, 1.0, 1.0, 0.0],
    };
    let item = Item::new(shape, [0.0; 3], [1.0; 3], Finish::Matte);
    let image = renderer.draw(&picture(vec![item])).expect("a picture");
    for part in [0.1, 0.3, 0.5, 0.7, 0.9] {
        // Middle of the pixel that holds this part of the side.
        let column = (100.0 + SQUARE * part) as u32;
        let part = (f64::from(column) + 0.5 - 100.0) / SQUARE;
        let expected = colour_of(part).map(|c| 255.0 * f64::from(c));
        assert_colour(&image, [column, SIDE / 2], expected, 2.5);
    }
}
