//! Writes the dish in which the spheres of level 2 are: `cargo run --release -p microsim-module-touch-spheres --example write_touch_spheres_dish`. A shallow bowl of
//! revolution, 20 mm wide, of dark ceramics, before which spheres and needle are well seen, with printed rings each 2 mm apart and a cross, as a binary glTF with its texture in it. Metres; z up, its foot at z = 0.

use serde_json::json;
use std::error::Error;
use std::path::Path;

/// Corners of a ring of the bowl.
const AROUND: u32 = 96;
/// Half the width of the square of the bottom that the texture shows \[m\].
const HALF: f64 = 0.0105;
/// Pixels of a side of the texture.
const SIDE: u32 = 512;

/// Strips of the profile, each from one point to the next: radius and height \[m\], and the direction of the normal \[rad\] from the outward radius towards z.
const STRIPS: [[[f64; 3]; 2]; 6] = {
    use std::f64::consts::{FRAC_PI_2 as UP, PI};
    const SLOPE: f64 = 2.618;
    [
        // The bottom, its bend, the inner wall, rim, outer wall.
        [[0.0, 0.0005, UP], [0.0078, 0.0005, UP]],
        [[0.0078, 0.0005, UP], [0.0086, 0.0008, 2.1]],
        [[0.0086, 0.0008, 2.1], [0.0096, 0.0020, SLOPE]],
        [[0.0096, 0.0020, SLOPE], [0.0099, 0.0022, UP]],
        [[0.0099, 0.0022, UP], [0.0101, 0.0020, 0.0]],
        [[0.0101, 0.0020, 0.0], [0.0086, 0.0, SLOPE - PI]],
    ]
};

/// Colour of the ceramics and of the print, sRGB.
const GROUND: [f64; 3] = [56.0, 70.0, 76.0];
const PRINT: [f64; 3] = [140.0, 162.0, 168.0];

/// Where the texture shows a place: what is seen from above.
fn coordinates(x: f64, y: f64) -> [f32; 2] {
    [(0.5 + 0.5 * x / HALF) as f32, (0.5 - 0.5 * y / HALF) as f32]
}

/// How much of the print covers a place of the texture, 0 to 1, one pixel soft.
fn print(x: f64, y: f64) -> f64 {
    let pixel = 2.0 * HALF / f64::from(SIDE);
    let line = |distance: f64, half: f64| ((half - distance) / pixel + 0.5).clamp(0.0, 1.0);
    let radius = libm::hypot(x, y);
    let rings = [0.002, 0.004, 0.006].map(|ring| line((radius - ring).abs(), 6e-5));
    let cross = line(x.abs().min(y.abs()), 5e-5) * line(radius - 0.0072, 0.0);
    rings.into_iter().fold(cross, f64::max)
}

fn texture() -> Result<Vec<u8>, png::EncodingError> {
    let mut pixels = Vec::with_capacity(3 * (SIDE * SIDE) as usize);
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let place = |k: u32| 2.0 * HALF * ((f64::from(k) + 0.5) / f64::from(SIDE) - 0.5);
        let covered = print(place(column), -place(row));
        for (ground, print) in GROUND.iter().zip(PRINT) {
            pixels.push((ground + covered * (print - ground)).round() as u8);
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIDE, SIDE);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(bytes)
}

/// The file.
pub fn dish() -> Result<Vec<u8>, Box<dyn Error>> {
    let (mut positions, mut normals, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let mut indices: Vec<u32> = Vec::new();
    for strip in STRIPS {
        let first = positions.len() as u32;
        for [radius, height, slope] in strip {
            for k in 0..AROUND {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(AROUND);
                let [c, s] = [libm::cos(angle), libm::sin(angle)];
                let (x, y) = (radius * c, radius * s);
                positions.push([x, y, height].map(|v| v as f32));
                let out = libm::cos(slope);
                normals.push([out * c, out * s, libm::sin(slope)].map(|v| v as f32));
                places.push(coordinates(x, y));
            }
        }
        for k in 0..AROUND {
            let next = (k + 1) % AROUND;
            let [a, b, c, d] = [k, next, AROUND + k, AROUND + next].map(|v| first + v);
            // At the axis two corners of one triangle are one point.
            indices.extend([a, c, d]);
            if strip[0][0] > 0.0 {
                indices.extend([a, d, b]);
            }
        }
    }
    let mut binary: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut take = |bytes: Vec<u8>| {
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        binary.extend(bytes);
        binary.resize(binary.len().next_multiple_of(4), 0);
    };
    let bytes = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    take(bytes(positions.as_flattened()));
    take(bytes(normals.as_flattened()));
    take(bytes(places.as_flattened()));
    take(indices.iter().flat_map(|i| i.to_le_bytes()).collect());
    take(texture()?);
    let count = positions.len();
    let reach = STRIPS.as_flattened().iter().map(|point| point[0]);
    let reach = reach.fold(0.0, f64::max) as f32;
    let document = json!({
        "asset": { "version": "2.0", "generator": "write_touch_spheres_dish of MicroSim", "copyright": "MicroSim, MIT OR Apache-2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "dish", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "material": 0 }] }],
        "materials": [{ "name": "ceramics", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 33_071, "wrapT": 33_071 }],
        "images": [{ "bufferView": 4, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": [-reach, -reach, 0.0], "max": [reach, reach, 0.0022] },
            { "bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": count, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5125, "count": indices.len(), "type": "SCALAR" },
        ],
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend((12 + 8 + text.len() as u32 + 8 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}

fn main() -> Result<(), Box<dyn Error>> {
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/dish.glb");
    std::fs::write(target, dish()?)?;
    Ok(())
}
