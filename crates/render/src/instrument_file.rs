//! Instruments as glTF files, for programs beyond this one.
//!
//! A file has the nodes `instrument`, and in it `fixed`, `left` and `right`, in metres. glTF has y up, the frame of a tool has its handle along +z: `instrument` turns by −90°
//! about x, so that the handle points up; in its frame all is as in that of the tool, with the tip of the closed jaws in the origin. The nodes of the jaws lie in the pivot, and
//! turning them about their own y axis opens them: `left` by minus half the angle between the jaws, `right` by half of it. The angle between fully open jaws stands in the
//! extras of `instrument` as `opening_angle` \[rad\].

use std::f64::consts::FRAC_1_SQRT_2;

use microsim_model::{MaterialToWrite, NodeToWrite, Triangles, write_glb};
use serde_json::{Value, json};

use crate::instruments::{Instrument, Sizes};
use crate::light::linear_from_srgb;
use crate::shape::Model;

/// The licence of shapes that are made here.
const LICENCE: &str = "MicroSim developers; MIT OR Apache-2.0";
/// How polished steel is.
const ROUGHNESS: f64 = 0.35;

/// An instrument as a `.glb`, of steel of a colour (sRGB), with the angle between its fully open jaws \[rad\].
pub fn write(
    instrument: &Instrument,
    sizes: Sizes,
    opening_angle: f64,
    colour: [f32; 3],
) -> Vec<u8> {
    let root = NodeToWrite {
        name: "instrument".into(),
        parent: None,
        translation: [0.0; 3],
        rotation: [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2],
        triangles: None,
        extras: json!({ "opening_angle": opening_angle }),
    };
    let part = |name: &str, model: &Model, z: f64| NodeToWrite {
        name: name.into(),
        parent: Some(0),
        translation: [0.0, 0.0, z],
        rotation: [0.0, 0.0, 0.0, 1.0],
        triangles: Some(about(model, z)),
        extras: Value::Null,
    };
    let nodes = [
        root,
        part("fixed", &instrument.fixed, 0.0),
        part("left", &instrument.left, sizes.pivot),
        part("right", &instrument.right, sizes.pivot),
    ];
    let material = MaterialToWrite {
        name: "steel".into(),
        colour: colour.map(|part| linear_from_srgb(f64::from(part)) as f32),
        metallic: 1.0,
        roughness: ROUGHNESS,
    };
    write_glb(&nodes, &material, LICENCE)
}

/// The triangles of a part in a frame whose origin lies at z \[m\].
fn about(model: &Model, z: f64) -> Triangles {
    let mesh = model.mesh();
    let place = |position: [f32; 3]| {
        let [x, y, along] = position;
        [x, y, (f64::from(along) - z) as f32]
    };
    let corners = mesh.indices.chunks_exact(3);
    Triangles {
        positions: mesh.vertices.iter().map(|v| place(v.position)).collect(),
        normals: mesh.vertices.iter().map(|v| v.normal).collect(),
        triangles: corners.map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instruments::Kind;
    use microsim_geometry::Pose;
    use microsim_model::read;
    use nalgebra::{Point3, Rotation3, Vector3};

    const SIZES: Sizes = Sizes {
        pivot: 18e-3,
        tip: 0.125e-3,
    };
    const ANGLE: f64 = 0.21;
    const KINDS: [Kind; 6] = [
        Kind::Forceps,
        Kind::AngledForceps,
        Kind::Scissors,
        Kind::Dilator,
        Kind::NeedleHolder,
        Kind::Clamp,
    ];

    fn file(kind: Kind) -> Vec<u8> {
        write(
            &Instrument::of(kind, SIZES),
            SIZES,
            ANGLE,
            [0.83, 0.85, 0.86],
        )
    }

    /// Single precision at the end of a handle of 0.12 m is worth 7 nm.
    const ROUNDED: f64 = 2e-8;

    fn place(v: [f32; 3]) -> Vector3<f64> {
        Vector3::from(v.map(f64::from))
    }

    /// Read again, every part has the vertices of the generator once it is turned back from y up, and the triangles and the colour; the jaws' nodes lie in the pivot.
    #[test]
    fn what_is_read_is_what_was_made() {
        for kind in KINDS {
            let bytes = file(kind);
            let model = read("a.glb", &bytes, &|_| None).expect("a model");
            let names: Vec<&str> = model.nodes.iter().map(|n| n.name.as_str()).collect();
            assert_eq!(names, ["instrument", "fixed", "left", "right"]);
            for jaw in [2, 3] {
                assert_eq!(model.nodes[jaw].place.offset, [0.0, 0.0, SIZES.pivot]);
            }
            let instrument = Instrument::of(kind, SIZES);
            let made = [&instrument.fixed, &instrument.left, &instrument.right];
            // From y up: up is what was along the handle.
            let back = |p: [f32; 3]| Vector3::new(p[0], -p[2], p[1]).map(f64::from);
            for (part, made) in model.placed().iter().zip(made) {
                let mesh = made.mesh();
                assert_eq!(part.positions.len(), mesh.vertices.len());
                for (found, vertex) in part.positions.iter().zip(&mesh.vertices) {
                    let off = (back(*found) - place(vertex.position)).norm();
                    assert!(off < ROUNDED, "{kind:?}: {off} m");
                }
                assert_eq!(part.triangles.as_flattened(), mesh.indices);
                let colour = part.colour.expect("a colour");
                assert!(
                    (colour[0] - 0.6563).abs() < 1e-3,
                    "0.83 of sRGB: {colour:?}"
                );
            }
        }
    }

    /// A jaw that is turned by its node lies where the renderer has it: half the angle each, about the y axis of the node.
    #[test]
    fn turning_a_node_opens_its_jaw() {
        let instrument = Instrument::of(Kind::Forceps, SIZES);
        for opening in [0.0, 0.4, 1.0] {
            let posed = instrument.posed(SIZES.pivot, ANGLE, opening);
            for (part, side) in [(1, -1.0), (2, 1.0)] {
                let (model, position, turn) = &posed[part];
                let pose = Pose::from_arrays(*position, *turn);
                let half = 0.5 * ANGLE * opening * side;
                let node = Rotation3::from_axis_angle(&Vector3::y_axis(), half);
                let written = about(model, SIZES.pivot);
                for (found, vertex) in written.positions.iter().zip(&model.mesh().vertices) {
                    let turned = node * Point3::from(place(*found));
                    let found = turned.coords + Vector3::z() * SIZES.pivot;
                    let expected = pose.apply(&place(vertex.position));
                    assert!((found - expected).norm() < ROUNDED, "{part} at {opening}");
                }
            }
        }
    }

    fn number(value: &Value) -> usize {
        value.as_u64().expect("a number") as usize
    }

    fn words(bytes: &[u8]) -> impl Iterator<Item = [u8; 4]> + '_ {
        bytes.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]])
    }

    /// What glTF 2.0 demands of the structure and can be checked on the bytes (4.4, 3.6.2, 3.7.2): chunks of whole words that fill the file, views within the buffer and apart, accessors
    /// within their views and aligned, bounds of positions that are those of the numbers, normals of length 1, indices of vertices that there are, each node the child of one.
    #[test]
    fn files_have_the_structure_that_gltf_demands() {
        for kind in KINDS {
            let bytes = file(kind);
            let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[at + k])) as usize;
            assert_eq!(
                (&bytes[..4], word(4), word(8)),
                (&b"glTF"[..], 2, bytes.len())
            );
            let text_length = word(12);
            assert_eq!((&bytes[16..20], text_length % 4), (&b"JSON"[..], 0));
            let binary_at = 20 + text_length;
            assert_eq!(&bytes[binary_at + 4..binary_at + 8], b"BIN\0");
            let binary = &bytes[binary_at + 8..];
            assert_eq!((word(binary_at), binary.len() % 4), (binary.len(), 0));
            let json: Value = serde_json::from_slice(&bytes[20..binary_at]).expect("JSON");
            assert_eq!(json["asset"]["version"], "2.0");
            assert_eq!(json["asset"]["copyright"], LICENCE);
            assert_eq!(json["materials"][0]["name"], "steel");
            assert_eq!(json["buffers"][0]["byteLength"], binary.len());
            let list = |name: &str| json[name].as_array().expect("a list").clone();
            let mut end = 0;
            for view in list("bufferViews") {
                let [from, length] = ["byteOffset", "byteLength"].map(|key| number(&view[key]));
                assert!(from >= end && from % 4 == 0 && length > 0);
                end = from + length;
            }
            assert!(end <= binary.len());
            let data = |accessor: &Value, size: usize| {
                let view = &json["bufferViews"][number(&accessor["bufferView"])];
                let [from, length] = ["byteOffset", "byteLength"].map(|key| number(&view[key]));
                assert_eq!(length, number(&accessor["count"]) * size);
                &binary[from..from + length]
            };
            let accessor = |index: &Value| json["accessors"][number(index)].clone();
            for mesh in list("meshes") {
                let primitive = &mesh["primitives"][0];
                assert_eq!(primitive["material"], 0);
                let position = accessor(&primitive["attributes"]["POSITION"]);
                let normal = accessor(&primitive["attributes"]["NORMAL"]);
                let vectors = |of: &Value| -> Vec<[f32; 3]> {
                    assert_eq!(
                        (of["componentType"].clone(), of["type"].clone()),
                        (json!(5126), json!("VEC3"))
                    );
                    let numbers: Vec<f32> = words(data(of, 12)).map(f32::from_le_bytes).collect();
                    numbers
                        .chunks_exact(3)
                        .map(|v| [v[0], v[1], v[2]])
                        .collect()
                };
                let places = vectors(&position);
                for k in 0..3 {
                    let of_axis = || places.iter().map(|p| p[k]);
                    let bounds = [
                        ("min", of_axis().fold(f32::INFINITY, f32::min)),
                        ("max", of_axis().fold(f32::NEG_INFINITY, f32::max)),
                    ];
                    for (key, expected) in bounds {
                        let stated = position[key][k].as_f64().expect("a bound") as f32;
                        assert_eq!(stated, expected, "{key} {k}");
                    }
                }
                let normals = vectors(&normal);
                assert_eq!(normals.len(), places.len());
                for normal in normals {
                    assert!((place(normal).norm() - 1.0).abs() < 1e-5, "{normal:?}");
                }
                let indices = accessor(&primitive["indices"]);
                assert_eq!(
                    (indices["componentType"].clone(), indices["type"].clone()),
                    (json!(5125), json!("SCALAR"))
                );
                let corners: Vec<u32> = words(data(&indices, 4)).map(u32::from_le_bytes).collect();
                assert_eq!(corners.len() % 3, 0);
                assert!(
                    corners
                        .iter()
                        .all(|corner| (*corner as usize) < places.len())
                );
            }
            let mut parents = vec![0; list("nodes").len()];
            let children = list("nodes")
                .into_iter()
                .filter_map(|n| n["children"].as_array().cloned());
            let roots = json["scenes"][0]["nodes"]
                .as_array()
                .expect("roots")
                .clone();
            for child in children.flatten().chain(roots) {
                parents[number(&child)] += 1;
            }
            assert!(parents.iter().all(|count| *count == 1), "{parents:?}");
            let angle = json["nodes"][0]["extras"]["opening_angle"].as_f64();
            assert_eq!(angle, Some(ANGLE));
        }
    }
}
