//! Files of each form, whole and broken. Expected values are those that the files are made of here, or closed forms of a cube.

mod refused;

use microsim_model::{Affine, Flaw, Mask, Model, ModelError, Part, Wrap, read, references};
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

/// Wrap modes by their numbers in glTF 2.0 (5.26), cutoffs with the default of the form, opacities of materials; what is of one opacity below the cutoff everywhere is not there.
#[test]
fn textures_wrap_and_surfaces_are_cut_out() {
    let (_, data) = gltf_parts();
    let picture = png();
    let read = |document: &Value| {
        let bytes = glb(document, &data);
        read("a.glb", &bytes, &|_| Some(&picture)).expect("a cube")
    };
    let textured = || textured(json!({ "uri": "a.png" }));
    let plain = read(&textured());
    assert_eq!(plain.textures[0].wrap, [Wrap::Repeat; 2]);
    assert_eq!(plain.parts[0].mask, None);
    let mut document = textured();
    document["samplers"] = json!([{}, { "wrapS": 33_648, "wrapT": 33_071, "magFilter": 9728 }]);
    document["textures"][0]["sampler"] = json!(1);
    let wrap = read(&document).textures[0].wrap;
    assert_eq!(wrap, [Wrap::Mirrored, Wrap::Clamp]);

    let mut document = textured();
    document["materials"][0]["alphaMode"] = json!("MASK");
    let [cutoff, factor] = [0.5, 1.0];
    assert_eq!(read(&document).parts[0].mask, Some(Mask { cutoff, factor }));
    document["materials"][0]["alphaCutoff"] = json!(0.25);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.75]);
    let mask = read(&document).parts[0].mask;
    let [cutoff, factor] = [0.25, 0.75];
    assert_eq!(mask, Some(Mask { cutoff, factor }));

    for opacity in [0.5, 0.49] {
        let (mut document, _) = gltf_parts();
        document["materials"][0]["alphaMode"] = json!("MASK");
        let colour = json!([1, 1, 1, opacity]);
        document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = colour;
        // A file without anything to be seen is refused.
        match alone("a.glb", &glb(&document, &data)) {
            Ok(model) => assert!(opacity == 0.5 && model.parts[0].mask.is_none()),
            Err(error) => assert!(opacity == 0.49 && error.flaw == Flaw::Broken, "{error}"),
        }
    }
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
