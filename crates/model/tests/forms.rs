//! Files of each form, whole and broken. Expected values are those that the files are made of here, or closed forms of a cube.

use microsim_model::{
    Affine, Flaw, MAX_TEXTURE, Model, ModelError, Part, read, read_texture, references,
};
use proptest::prelude::*;
use serde_json::{Value, json};

fn alone(name: &str, bytes: &[u8]) -> Result<Model, ModelError> {
    read(name, bytes, &|_| None)
}

fn flaw(name: &str, bytes: &[u8]) -> Flaw {
    alone(name, bytes).expect_err(name).flaw
}

/// Corners of a cube of side 2 about the origin, and its sides as squares, counterclockwise from outside.
const CORNERS: [[f32; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
const SQUARES: [[usize; 4]; 6] = [
    [0, 3, 2, 1],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

fn cube_triangles() -> impl Iterator<Item = [usize; 3]> {
    SQUARES
        .iter()
        .flat_map(|s| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]])
}

fn obj() -> String {
    let mut text = String::from("# a cube\no cube\n");
    for [x, y, z] in CORNERS {
        text += &format!("v {x} {y} {z}\n");
    }
    for square in SQUARES {
        let [a, b, c, d] = square.map(|v| v + 1);
        text += &format!("f {a} {b} {c} {d}\n");
    }
    text
}

fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(12_u32.to_le_bytes());
    for triangle in cube_triangles() {
        // Its normal is left out, so it may be anything.
        bytes.extend([0; 12]);
        for corner in triangle.map(|v| CORNERS[v]) {
            corner.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_text() -> String {
    let mut text = String::from("solid cube\n");
    for triangle in cube_triangles() {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in triangle.map(|v| CORNERS[v]) {
            text += &format!("  vertex {x:e} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid cube\n"
}

/// A cube of side 2, with texture coordinates, as child of a node that is moved and turned.
fn gltf_parts() -> (Value, Vec<u8>) {
    let mut data = Vec::new();
    for corner in CORNERS {
        corner.iter().for_each(|x| data.extend(x.to_le_bytes()));
    }
    for corner in CORNERS {
        [0.5 * (corner[0] + 1.0), 0.5 * (corner[1] + 1.0)]
            .iter()
            .for_each(|x| data.extend(x.to_le_bytes()));
    }
    for triangle in cube_triangles() {
        triangle
            .iter()
            .for_each(|v| data.extend((*v as u16).to_le_bytes()));
    }
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [
            // A quarter turn about z, then to x = 10.
            { "name": "base", "children": [1], "translation": [10.0, 0.0, 0.0],
              "rotation": [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()] },
            { "name": "cube", "mesh": 0, "translation": [3.0, 0.0, 0.0], "scale": [0.5, 0.5, 0.5] },
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0,
        }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1.0, 1.0] } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3" },
            { "bufferView": 0, "byteOffset": 96, "componentType": 5126, "count": 8, "type": "VEC2" },
            { "bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 160 },
            { "buffer": 0, "byteOffset": 160, "byteLength": 72 },
        ],
        "buffers": [{ "byteLength": 232 }],
    });
    (document, data)
}

fn glb(document: &Value, data: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data = data.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((12 + 8 + json.len() as u32 + 8 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// The file with a value put in, by a JSON pointer.
fn altered(pointer: &str, value: Value) -> Vec<u8> {
    let (mut document, data) = gltf_parts();
    match document.pointer_mut(pointer) {
        Some(place) => *place = value,
        None => {
            let (above, key) = pointer.rsplit_once('/').expect("a key");
            document.pointer_mut(above).expect("a place")[key] = value;
        }
    }
    glb(&document, &data)
}

/// Enclosed volume by the divergence theorem: positive only if all triangles are counterclockwise from outside.
fn volume(part: &Part) -> f64 {
    let corners = part
        .triangles
        .iter()
        .map(|t| t.map(|v| part.positions[v as usize].map(f64::from)));
    let det = |[a, b, c]: [[f64; 3]; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    corners.map(|t| det(t) / 6.0).sum()
}

/// A cube has 24 vertices, as its edges are sharper than the crease, each with the normal of its side.
fn is_cube(part: &Part) {
    assert_eq!((part.triangles.len(), part.positions.len()), (12, 24));
    assert_eq!(volume(part), 8.0);
    for triangle in &part.triangles {
        for v in triangle {
            let (p, n) = (part.positions[*v as usize], part.normals[*v as usize]);
            assert_eq!(p[0] * n[0] + p[1] * n[1] + p[2] * n[2], 1.0, "{p:?} {n:?}");
        }
    }
}

#[test]
fn a_cube_is_the_same_in_obj_and_both_kinds_of_stl() {
    for (name, bytes) in [
        ("a.obj", obj().into_bytes()),
        ("a.stl", stl()),
        ("b.stl", stl_text().into_bytes()),
    ] {
        let model = alone(name, &bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        is_cube(&model.parts[0]);
    }
    // A binary file whose comment begins as a text does.
    let mut disguised = stl();
    disguised[..5].copy_from_slice(b"solid");
    is_cube(&alone("a.stl", &disguised).expect("a cube").parts[0]);
    let named = alone("a.obj", obj().as_bytes()).expect("a cube");
    assert_eq!(
        (&named.nodes[1].name[..], named.nodes[1].parent),
        ("cube", Some(0))
    );
}

/// A tube of 64 sides meets itself at 5.6°: its vertices are shared, and their normals point away from the axis.
#[test]
fn faces_that_meet_at_a_small_angle_are_smooth() {
    let mut text = String::new();
    for k in 0..64 {
        let angle = 2.0 * std::f64::consts::PI * f64::from(k) / 64.0;
        for z in [0.0, 1.0] {
            text += &format!("v {} {} {z}\n", angle.cos(), angle.sin());
        }
    }
    for k in 0..64 {
        let [a, b] = [2 * k + 1, 2 * ((k + 1) % 64) + 1];
        text += &format!("f {a} {b} {} {}\n", b + 1, a + 1);
    }
    let model = alone("tube.obj", text.as_bytes()).expect("a tube");
    let part = &model.parts[0];
    assert_eq!((part.positions.len(), part.triangles.len()), (128, 128));
    for (p, n) in part.positions.iter().zip(&part.normals) {
        // One side has two triangles at a corner and the other one: the mean lies up to a sixth of 5.6° from the radius.
        let along = p[0] * n[0] + p[1] * n[1];
        assert!(along > 0.9998 && n[2].abs() < 1e-6, "{p:?} {n:?}");
    }
}

#[test]
fn obj_has_normals_coordinates_and_indices_from_behind() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 2\nusemtl red\nf -3/1/1 -2/2/1 3/3/-1\n";
    let model = alone("a.obj", text.as_bytes()).expect("a triangle");
    let part = &model.parts[0];
    assert_eq!(part.normals, [[0.0, 0.0, 1.0]; 3]);
    // Rows of a picture run downwards.
    assert_eq!(part.coordinates, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(
        (part.triangles[0], part.positions[1]),
        ([0, 1, 2], [1.0, 0.0, 0.0])
    );
}

#[test]
fn gltf_has_a_hierarchy_of_nodes() {
    let (document, data) = gltf_parts();
    let model = alone("a.glb", &glb(&document, &data)).expect("a cube");
    let names: Vec<_> = model
        .nodes
        .iter()
        .map(|n| (&n.name[..], n.parent))
        .collect();
    assert_eq!(names, [("base", None), ("cube", Some(0))]);
    let part = &model.parts[0];
    assert_eq!((part.node, part.colour), (1, Some([0.5, 0.25, 1.0])));
    is_cube(part);
    assert_eq!(part.coordinates.len(), 24);
    // Half as large, at x = 3 of a frame that is a quarter turn about z at x = 10: its centre is at (10, 3, 0).
    let placed = &model.placed()[0];
    assert!((volume(placed) - 1.0).abs() < 1e-5);
    for (from, to) in part.positions.iter().zip(&placed.positions) {
        let expected = [10.0 - 0.5 * from[1], 3.0 + 0.5 * from[0], 0.5 * from[2]];
        let apart = (0..3)
            .map(|i| (to[i] - expected[i]).abs())
            .fold(0.0, f32::max);
        assert!(apart < 1e-5, "{to:?} {expected:?}");
    }
    for (p, n) in placed.positions.iter().zip(&placed.normals) {
        let out = (p[0] - 10.0) * n[0] + (p[1] - 3.0) * n[1] + p[2] * n[2];
        assert!((out - 0.5).abs() < 1e-5);
    }
}

/// A mirrored node turns its triangles, so that outside stays outside.
#[test]
fn a_mirrored_node_is_not_inside_out() {
    let model = alone("a.glb", &altered("/nodes/1/scale", json!([-1.0, 1.0, 1.0])));
    let placed = &model.expect("a cube").placed()[0];
    assert!((volume(placed) - 8.0).abs() < 1e-5);
    for (p, n) in placed.positions.iter().zip(&placed.normals) {
        assert!((p[0] - 10.0) * n[0] + (p[1] - 3.0) * n[1] + p[2] * n[2] > 0.9);
    }
}

#[test]
fn a_matrix_is_the_same_as_its_parts() {
    let (document, data) = gltf_parts();
    let by_parts = alone("a.glb", &glb(&document, &data)).expect("a cube");
    let mut document = document;
    let node = document.pointer_mut("/nodes/0").expect("a node");
    *node = json!({ "name": "base", "children": [1],
        "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1] });
    let by_matrix = alone("a.glb", &glb(&document, &data)).expect("a cube");
    let places = |model: &Model| model.placed()[0].positions.clone();
    for (a, b) in places(&by_parts).iter().zip(&places(&by_matrix)) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-5), "{a:?} {b:?}");
    }
}

/// Four pixels: red, green, blue, half white.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("memory");
    let pixels = [
        255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128,
    ];
    writer.write_image_data(&pixels).expect("memory");
    writer.finish().expect("memory");
    bytes
}

/// The same cube with a picture, in a buffer of its own file or beside it.
fn textured(image: Value) -> Value {
    let (mut document, _) = gltf_parts();
    document["images"] = json!([image]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    document
}

#[test]
fn pictures_and_buffers_lie_within_or_beside() {
    let (_, mut data) = gltf_parts();
    let picture = png();
    let mut within = textured(json!({ "bufferView": 2, "mimeType": "image/png" }));
    let view = json!({ "buffer": 0, "byteOffset": data.len(), "byteLength": picture.len() });
    let views = within["bufferViews"].as_array_mut();
    views.expect("views").push(view);
    data.extend(&picture);
    within["buffers"][0]["byteLength"] = json!(data.len());
    let bytes = glb(&within, &data);
    assert_eq!(references("a.glb", &bytes), Ok(Vec::new()));
    let model = alone("a.glb", &bytes).expect("a cube");
    assert_eq!((model.textures.len(), model.parts[0].texture), (1, Some(0)));
    assert_eq!(&model.textures[0].pixels[..4], [255, 0, 0, 255]);

    let (_, data) = gltf_parts();
    let mut beside = textured(json!({ "uri": "red green.png" }));
    beside["buffers"][0]["uri"] = json!("cube.bin");
    let bytes = beside.to_string().into_bytes();
    let named = references("a.gltf", &bytes).expect("names");
    assert_eq!(named, ["cube.bin", "red green.png"]);
    let found = read("a.gltf", &bytes, &|name| match name {
        "cube.bin" => Some(&data[..]),
        "red green.png" => Some(&picture[..]),
        _ => None,
    });
    let found = found.expect("a cube");
    assert_eq!(found.textures, model.textures);
    assert_eq!(found.parts[0].positions, model.parts[0].positions);
    assert_eq!(flaw("a.gltf", &bytes), Flaw::Missing);
}

#[test]
fn embedded_buffers_are_read() {
    let (mut document, data) = gltf_parts();
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in data.chunks(3) {
        let mut wide = [0; 3];
        wide[..three.len()].copy_from_slice(three);
        let bits = u32::from_be_bytes([0, wide[0], wide[1], wide[2]]);
        for k in 0..=three.len() {
            text.push(char::from(DIGITS[(bits >> (18 - 6 * k)) as usize & 63]));
        }
        (three.len()..3).for_each(|_| text.push('='));
    }
    document["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{text}"));
    let model = alone("a.gltf", document.to_string().as_bytes()).expect("a cube");
    is_cube(&model.parts[0]);
}

#[test]
fn broken_gltf_is_refused_by_its_flaw() {
    let (document, data) = gltf_parts();
    let whole = glb(&document, &data);
    assert_eq!(flaw("a.glb", b""), Flaw::Truncated);
    for cut in [5, 12, 30, whole.len() / 2, whole.len() - 1] {
        assert_eq!(flaw("a.glb", &whole[..cut]), Flaw::Truncated, "{cut}");
    }
    assert_eq!(
        flaw("a.gltf", &document.to_string().as_bytes()[..100]),
        Flaw::Truncated
    );
    let mut longer = whole.clone();
    longer.push(0);
    assert_eq!(flaw("a.glb", &longer), Flaw::Broken);
    let mut version = whole.clone();
    version[4] = 1;
    assert_eq!(flaw("a.glb", &version), Flaw::NotRead);
    let mut nan = data.clone();
    nan[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(flaw("a.glb", &glb(&document, &nan)), Flaw::NotANumber);
    let mut wrong_index = data.clone();
    wrong_index[160..162].copy_from_slice(&8_u16.to_le_bytes());
    assert_eq!(
        flaw("a.glb", &glb(&document, &wrong_index)),
        Flaw::NoSuchIndex
    );
    for (pointer, value, expected) in [
        ("/asset/version", json!("1.0"), Flaw::NotRead),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            Flaw::NotRead,
        ),
        ("/nodes/0/children/0", json!(7), Flaw::NoSuchIndex),
        ("/nodes/1/children", json!([0]), Flaw::Broken),
        ("/nodes/0/children", json!([1, 1]), Flaw::Broken),
        ("/nodes/1/skin", json!(0), Flaw::NotRead),
        (
            "/nodes/0/rotation",
            json!([0.0, 0.0, 0.0, 0.0]),
            Flaw::NotANumber,
        ),
        (
            "/nodes/0/translation",
            json!([1e9, 0.0, 0.0]),
            Flaw::NotANumber,
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            Flaw::Broken,
        ),
        ("/scene", json!(3), Flaw::NoSuchIndex),
        (
            "/meshes/0/primitives/0/indices",
            json!(9),
            Flaw::NoSuchIndex,
        ),
        ("/meshes/0/primitives/0/mode", json!(1), Flaw::NotRead),
        ("/meshes/0/primitives/0/mode", json!(9), Flaw::Broken),
        ("/meshes/0/primitives/0/targets", json!([{}]), Flaw::NotRead),
        (
            "/meshes/0/primitives/0/material",
            json!(4),
            Flaw::NoSuchIndex,
        ),
        ("/meshes/0/primitives", json!([]), Flaw::Broken),
        (
            "/accessors/0/count",
            json!(9_000_000_000_000_u64),
            Flaw::TooLarge,
        ),
        ("/accessors/0/count", json!(40), Flaw::NoSuchIndex),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            Flaw::NoSuchIndex,
        ),
        ("/accessors/0/componentType", json!(5122), Flaw::Broken),
        ("/accessors/0/sparse", json!({ "count": 1 }), Flaw::NotRead),
        ("/accessors/1/count", json!(7), Flaw::Broken),
        ("/accessors/2/count", json!(35), Flaw::Broken),
        ("/accessors/2/type", json!("VEC3"), Flaw::Broken),
        (
            "/bufferViews/0/byteStride",
            json!(u64::MAX),
            Flaw::NoSuchIndex,
        ),
        (
            "/bufferViews/0/byteLength",
            json!(100_000),
            Flaw::NoSuchIndex,
        ),
        ("/bufferViews/0/buffer", json!(1), Flaw::NoSuchIndex),
        ("/buffers/0/byteLength", json!(100_000), Flaw::Truncated),
        (
            "/buffers/0/uri",
            json!("../secret.bin"),
            Flaw::OutsideFolder,
        ),
        ("/buffers/0/uri", json!("/etc/passwd"), Flaw::OutsideFolder),
        (
            "/buffers/0/uri",
            json!("https://example.org/a.bin"),
            Flaw::OutsideFolder,
        ),
        ("/buffers/0/uri", json!("%2e%2e/a.bin"), Flaw::OutsideFolder),
        ("/buffers/0/uri", json!(".."), Flaw::OutsideFolder),
        ("/buffers/0/uri", json!("data:;base64,A?=="), Flaw::Broken),
        ("/buffers/0/uri", json!("data:text/plain,a"), Flaw::NotRead),
        ("/buffers/0/uri", json!("other.bin"), Flaw::Missing),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            json!([2.0, 0.0, 0.0, 1.0]),
            Flaw::NotANumber,
        ),
        ("/nodes", json!("none"), Flaw::Broken),
    ] {
        let bytes = altered(pointer, value.clone());
        assert_eq!(flaw("a.glb", &bytes), expected, "{pointer} {value}");
    }
    let jpeg = textured(json!({ "uri": "a.jpg", "mimeType": "image/jpeg" }));
    assert_eq!(flaw("a.glb", &glb(&jpeg, &data)), Flaw::NotRead);
    let deep: Vec<Value> = (0..5000)
        .map(|k| json!({ "children": [k + 1] }))
        .chain([json!({})])
        .collect();
    assert_eq!(
        flaw("a.glb", &altered("/nodes", json!(deep))),
        Flaw::TooLarge
    );
}

#[test]
fn broken_obj_is_refused_with_its_line() {
    let cube = obj();
    for (text, expected, line) in [
        ("v 0 0\n", Flaw::Broken, "line 1"),
        ("v 0 0 nan\n", Flaw::NotANumber, "line 1"),
        ("v 0 0 1e30\n", Flaw::NotANumber, "1000000"),
        ("v 0 0 1x\n", Flaw::NotANumber, "line 1"),
        ("v 0 0 0\nf 1 2 3\n", Flaw::NoSuchIndex, "line 2"),
        ("v 0 0 0\nf 0 1 1\n", Flaw::NoSuchIndex, "line 2"),
        ("v 0 0 0\nf -2 1 1\n", Flaw::NoSuchIndex, "line 2"),
        ("v 0 0 0\nf 1 1\n", Flaw::Broken, "line 2"),
        ("v 0 0 0\nf 1/1 1 1\n", Flaw::NoSuchIndex, "line 2"),
        ("v 0 0 0\nf 1///1 1 1\n", Flaw::Broken, "line 2"),
        ("curv 0 1\n", Flaw::Broken, "line 1"),
        ("<html>\n", Flaw::Broken, "line 1"),
        ("# nothing\n", Flaw::Broken, "no triangle"),
    ] {
        let error = alone("a.obj", text.as_bytes()).expect_err(text);
        assert_eq!(error.flaw, expected, "{text}");
        assert!(
            error.to_string().contains(line) || expected == Flaw::NotANumber,
            "{error}"
        );
    }
    assert_eq!(flaw("a.obj", b"v \xff 0 0\n"), Flaw::Broken);
    // Cut within its last line.
    assert_eq!(
        flaw("a.obj", &cube.as_bytes()[..cube.len() - 5]),
        Flaw::Broken
    );
    assert_eq!(flaw("a.ply", cube.as_bytes()), Flaw::UnknownForm);
    assert_eq!(flaw("obj", cube.as_bytes()), Flaw::UnknownForm);
    let much = vec![b'\n'; microsim_model::MAX_BYTES + 1];
    assert_eq!(flaw("a.obj", &much), Flaw::TooLarge);
}

#[test]
fn broken_stl_is_refused() {
    let whole = stl();
    for cut in [1, 83, 84, 100, whole.len() - 1] {
        assert_eq!(flaw("a.stl", &whole[..cut]), Flaw::Truncated, "{cut}");
    }
    let mut longer = whole.clone();
    longer.push(0);
    assert_eq!(flaw("a.stl", &longer), Flaw::Broken);
    let mut many = whole.clone();
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(flaw("a.stl", &many), Flaw::TooLarge);
    let mut nan = whole.clone();
    nan[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_eq!(flaw("a.stl", &nan), Flaw::NotANumber);
    let text = stl_text();
    assert_eq!(
        flaw(
            "a.stl",
            &text.as_bytes()[..text.len() - "endsolid cube\n".len()]
        ),
        Flaw::Truncated
    );
    for (from, to, expected) in [
        ("vertex", "vertex nan", Flaw::NotANumber),
        ("vertex", "vertex 1", Flaw::Broken),
        ("endfacet", "vertex 0 0 0\nendfacet", Flaw::Broken),
        ("outer", "inner", Flaw::Broken),
    ] {
        let wrong = text.replacen(from, to, 1);
        assert_eq!(flaw("a.stl", wrong.as_bytes()), expected, "{to}");
    }
}

#[test]
fn textures_are_png_of_limited_size() {
    let whole = png();
    let texture = read_texture(&whole).expect("a picture");
    assert_eq!((texture.width, texture.height), (2, 2));
    assert_eq!(texture.pixels[12..], [255, 255, 255, 128]);
    for cut in [0, 20, 40, whole.len() - 20] {
        let flaw = read_texture(&whole[..cut]).expect_err("cut").flaw;
        assert!(
            matches!(flaw, Flaw::Truncated | Flaw::UnknownForm),
            "{cut} {flaw:?}"
        );
    }
    let flaw = |bytes: &[u8]| read_texture(bytes).expect_err("refused").flaw;
    assert_eq!(flaw(b"GIF89a"), Flaw::UnknownForm);
    assert_eq!(flaw(&[0xff, 0xd8, 0xff, 0xe0]), Flaw::NotRead);
    let mut flipped = whole.clone();
    flipped[30] ^= 1;
    assert_eq!(flaw(&flipped), Flaw::Broken);
    let mut wide = Vec::new();
    let mut encoder = png::Encoder::new(&mut wide, MAX_TEXTURE + 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("memory");
    writer
        .write_image_data(&vec![0; MAX_TEXTURE as usize + 1])
        .expect("memory");
    writer.finish().expect("memory");
    assert_eq!(flaw(&wide), Flaw::TooLarge);
}

#[test]
fn maps_come_one_behind_another() {
    let turn = Affine {
        linear: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        offset: [1.0, 0.0, 0.0],
    };
    let move_ = Affine {
        offset: [0.0, 2.0, 0.0],
        ..Affine::IDENTITY
    };
    let p = [3.0, 4.0, 5.0];
    assert_eq!(turn.after(&move_).point(p), turn.point(move_.point(p)));
    assert_eq!(turn.point(p), [-3.0, 3.0, 5.0]);
}

/// Bytes of whole files, some of them changed, or cut.
fn mutated() -> impl Strategy<Value = (&'static str, Vec<u8>)> {
    let (document, data) = gltf_parts();
    let files = [
        ("a.glb", glb(&document, &data)),
        ("a.gltf", document.to_string().into_bytes()),
        ("a.obj", obj().into_bytes()),
        ("a.stl", stl()),
        ("b.stl", stl_text().into_bytes()),
    ];
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6);
    (
        0..files.len(),
        changes,
        any::<prop::sample::Index>(),
        any::<bool>(),
    )
        .prop_map(move |(file, changes, end, cut)| {
            let (name, mut bytes) = files[file].clone();
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            if cut {
                bytes.truncate(end.index(bytes.len()));
            }
            (name, bytes)
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever the bytes are: a model whose indices and numbers hold, or a refusal.
    #[test]
    fn no_bytes_make_it_panic((name, bytes) in mutated()) {
        if let Ok(model) = alone(name, &bytes) {
            for part in model.placed() {
                prop_assert_eq!(part.positions.len(), part.normals.len());
                prop_assert!(part.triangles.iter().flatten().all(|v| (*v as usize) < part.positions.len()));
                prop_assert!(part.positions.as_flattened().iter().all(|x| x.is_finite()));
            }
        }
    }

    #[test]
    fn no_bytes_of_a_picture_make_it_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = png();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let _ = read_texture(&bytes);
    }
}
