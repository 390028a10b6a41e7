//! Models and textures of objects: a level that names them runs and states them; broken ones are refused before the run, with the key, the file and the reason.

use crate::tree::Tree;
use crate::{assert_refused, run, tree};
use serde_json::json;

const LEVEL: &str = "modules/touch-spheres/levels/level1.toml";
const ASSETS: &str = "modules/touch-spheres/assets";
const INPUT: &str = "script:level1-pass.toml";

/// A square of side 2 with texture coordinates.
const SQUARE: &str =
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

/// A picture of one black pixel: signature, IHDR, IDAT and IEND, made with Python's zlib.
const PIXEL: &[u8] = &[
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52,
    0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b,
    0x55, 0x00, 0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x60, 0x00, 0x00, 0x00,
    0x02, 0x00, 0x01, 0x48, 0xaf, 0xa4, 0x71, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae,
    0x42, 0x60, 0x82,
];

/// Level 1 with these keys of a model in the place of its mat.
fn with_model(keys: &str) -> Tree {
    let tree = tree();
    let mat = "shape = \"box\"\nhalf_size = [\"30 mm\", \"30 mm\", \"0.5 mm\"]";
    tree.edit(LEVEL, mat, &format!("shape = \"model\"\n{keys}"));
    tree
}

#[test]
fn a_model_is_looked_for_in_the_module_then_in_the_installation_and_stated() {
    let tree = with_model("model = \"mat.obj\"\nscale = 0.03\ntexture = \"weave.png\"");
    tree.write(&format!("{ASSETS}/mat.obj"), SQUARE);
    tree.write("assets/mat.obj", "of another");
    tree.write("assets/weave.png", PIXEL);
    run(&tree, INPUT, &["--no-pictures"]).expect(0);
    let text = std::fs::read_to_string(tree.path("x.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let changed = [LEVEL, &format!("{ASSETS}/mat.obj"), "assets/weave.png"];
    assert_eq!(report["session"]["changed_files"], json!(changed));
    tree.microsim(&["replay", "x.session", "--verify"])
        .expect(0);
    tree.microsim(&["check", LEVEL]).expect(0);
    // The same level with another file is another plan.
    let hash = |report: &serde_json::Value| report["session"]["state_hash"].clone();
    let before = hash(&report);
    assert!(before.is_string(), "{report}");
    for file in ["x.session", "x.json"] {
        std::fs::remove_file(tree.path(file)).expect("it is there");
    }
    tree.write(
        &format!("{ASSETS}/mat.obj"),
        SQUARE.replace("v 1 1 0", "v 1 1 0.5"),
    );
    run(&tree, INPUT, &["--no-pictures"]).expect(0);
    let text = std::fs::read_to_string(tree.path("x.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_ne!(hash(&report), before);
}

#[test]
fn broken_models_and_textures_are_refused_before_the_run() {
    let glb = |json: &str| {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((20 + json.len() as u32).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json.as_bytes());
        bytes
    };
    let outside =
        r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"../../secret.bin","byteLength":4}]}"#;
    for (file, content, complaint) in [
        (
            "mat.obj",
            b"v 0 0 0\nf 1 2 3\n".to_vec(),
            "line 2: index 2 of 1",
        ),
        (
            "mat.obj",
            b"v 0 0 nan\n".to_vec(),
            "line 1: `nan`, which is no number",
        ),
        ("mat.obj", Vec::new(), "an empty file"),
        (
            "mat.stl",
            vec![0; 60],
            "60 bytes; a binary STL has a header of 84",
        ),
        (
            "mat.glb",
            glb("{\"asset\":{\"version\":\"1.0\"}}"),
            "version 1.0 of glTF",
        ),
        (
            "mat.glb",
            glb(outside)[..40].to_vec(),
            "40 bytes; its header states",
        ),
        ("mat.glb", glb(outside), "the file `../../secret.bin`"),
        (
            "mat.gltf",
            outside.as_bytes().to_vec(),
            "the file `../../secret.bin`",
        ),
        (
            "mat.gltf",
            outside.replace("../../secret.bin", "mat.bin").into_bytes(),
            "mat.bin",
        ),
        (
            "mat.fbx",
            b"Kaydara FBX Binary".to_vec(),
            "does not end in .glb, .gltf, .obj or .stl",
        ),
    ] {
        let tree = with_model(&format!("model = \"{file}\""));
        let path = tree.write(&format!("{ASSETS}/{file}"), &content);
        assert_refused(&tree, INPUT, complaint);
        let checked = tree.microsim(&["check", LEVEL, "--json"]).expect(1).json();
        let problem = checked["problems"][0].as_str().expect("a sentence");
        assert!(problem.contains(complaint), "{problem}");
        assert!(
            problem.contains("level1.toml:23:9: key `object[0].model`"),
            "{problem}"
        );
        // The file that is wrong is named: the model, or one that it needs and that is not there.
        let named = if complaint == "mat.bin" {
            complaint
        } else {
            file
        };
        assert!(problem.contains(named), "{} in {problem}", path.display());
    }
    let tree = with_model("model = \"mat.obj\"");
    assert_refused(&tree, INPUT, "`mat.obj`, which is not in ");
    let square = SQUARE.as_bytes();
    for (texture, content, complaint) in [
        ("weave.png", &PIXEL[..50], "a PNG that cannot be read"),
        ("weave.png", b"\xff\xd8\xff\xe0", "a JPEG; textures are PNG"),
        ("weave.png", b"GIF89a", "what is no PNG"),
        ("mat.obj", square, "a model, expected a picture in PNG"),
    ] {
        let tree = with_model(&format!("model = \"mat.obj\"\ntexture = \"{texture}\""));
        tree.write(&format!("{ASSETS}/mat.obj"), square);
        tree.write(&format!("{ASSETS}/{texture}"), content);
        assert_refused(&tree, INPUT, complaint);
    }
    let tree = with_model("model = \"mat.obj\"\ntexture = \"weave.png\"");
    tree.write(
        &format!("{ASSETS}/mat.obj"),
        SQUARE
            .replace("/1", "")
            .replace("/2", "")
            .replace("/3", "")
            .replace("/4", ""),
    );
    tree.write(&format!("{ASSETS}/weave.png"), PIXEL);
    assert_refused(
        &tree,
        INPUT,
        "a texture for `mat.obj`, which has no texture coordinates",
    );
}
