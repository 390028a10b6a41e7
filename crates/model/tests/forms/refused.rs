//! Broken files of each form, by the flaw for which they are refused, and changed bytes at random.

use crate::{alone, altered, flaw, glb, gltf_parts, obj, png, stl, stl_text, textured};
use microsim_model::{Flaw, MAX_BYTES, MAX_TEXTURE, read, read_texture};
use proptest::prelude::*;
use serde_json::{Value, json};

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
        ("/materials/0/alphaMode", json!("BLEND"), Flaw::NotRead),
        ("/materials/0/alphaMode", json!("mask"), Flaw::Broken),
        ("/nodes", json!("none"), Flaw::Broken),
    ] {
        let bytes = altered(pointer, value.clone());
        assert_eq!(flaw("a.glb", &bytes), expected, "{pointer} {value}");
    }
    let blend = altered("/materials/0/alphaMode", json!("BLEND"));
    let why = alone("a.glb", &blend).expect_err("translucent");
    assert!(why.to_string().contains("alphaMode BLEND"), "{why}");
    let mut masked = gltf_parts().0;
    masked["materials"][0]["alphaMode"] = json!("MASK");
    masked["materials"][0]["alphaCutoff"] = json!(-0.5);
    assert_eq!(flaw("a.glb", &glb(&masked, &data)), Flaw::NotANumber);
    let picture = json!({ "uri": "a.png" });
    for (sampler, mode, expected) in [(0, 10_496, Flaw::Broken), (1, 10_497, Flaw::NoSuchIndex)] {
        let mut wrapped = textured(picture.clone());
        wrapped["textures"][0]["sampler"] = json!(sampler);
        wrapped["samplers"] = json!([{ "wrapS": mode }]);
        let (bytes, picture) = (glb(&wrapped, &data), png());
        let found = read("a.glb", &bytes, &|_| Some(&picture));
        let error = found.expect_err("a sampler");
        assert_eq!(error.flaw, expected, "{sampler} {mode}");
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
    let much = vec![b'\n'; MAX_BYTES + 1];
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
