//! Writes models as glTF 2.0 in one file (`.glb`): nodes with triangles of one material, lengths in metres.

use crate::Affine;
use serde_json::{Value, json};

/// Magic and version of a container, kinds of its chunks (glTF 2.0, 4.4).
const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";
/// Types of numbers and uses of views (5.1.3, 5.11.5).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34_962;
const INDICES: u32 = 34_963;

/// Triangles of a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Positions of the vertices \[m\], at least one.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals of the vertices, as many.
    pub normals: Vec<[f32; 3]>,
    /// Vertices of the triangles, counterclockwise from outside, at least one.
    pub triangles: Vec<[u32; 3]>,
}

/// A node to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeToWrite {
    /// Its name.
    pub name: String,
    /// The node before it in whose frame it is placed; `None` of a root.
    pub parent: Option<usize>,
    /// Its origin in that frame \[m\].
    pub translation: [f64; 3],
    /// Its turn in that frame, a unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// What it shows.
    pub triangles: Option<Triangles>,
    /// What is stated of it besides; null for nothing.
    pub extras: Value,
}

/// The one material of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialToWrite {
    /// Its name.
    pub name: String,
    /// Base colour, linear.
    pub colour: [f32; 3],
    /// From 0, no metal, to 1.
    pub metallic: f64,
    /// From 0, a mirror, to 1.
    pub roughness: f64,
}

/// Writes a model; `copyright` is its licence.
///
/// # Panics
/// If a node refers to a parent that does not stand before it, or triangles have no corner, or another number of normals than of positions.
pub fn write_glb(nodes: &[NodeToWrite], material: &MaterialToWrite, copyright: &str) -> Vec<u8> {
    let mut file = File::default();
    let mut entries: Vec<Value> = nodes.iter().map(|node| file.node(node)).collect();
    let mut roots = Vec::new();
    for (index, node) in nodes.iter().enumerate() {
        match node.parent {
            None => roots.push(index),
            Some(parent) => {
                assert!(
                    parent < index,
                    "node {index} stands before its parent {parent}"
                );
                match entries[parent]
                    .get_mut("children")
                    .and_then(Value::as_array_mut)
                {
                    Some(children) => children.push(json!(index)),
                    None => entries[parent]["children"] = json!([index]),
                }
            }
        }
    }
    let [red, green, blue] = material.colour;
    let document = json!({
        "asset": {"version": "2.0", "generator": "MicroSim", "copyright": copyright},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": entries,
        "meshes": file.meshes,
        "materials": [{
            "name": material.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [red, green, blue, 1.0],
                "metallicFactor": material.metallic,
                "roughnessFactor": material.roughness,
            },
        }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.binary.len()}],
    });
    container(document.to_string().into_bytes(), file.binary)
}

/// Header and both chunks, each of whole words.
fn container(mut text: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let mut bytes = Vec::with_capacity(length);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((length as u32).to_le_bytes());
    for (kind, chunk) in [(JSON, text), (BINARY, binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// What of a file is written so far.
#[derive(Default)]
struct File {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
}

impl File {
    fn node(&mut self, node: &NodeToWrite) -> Value {
        let mut entry = json!({"name": node.name});
        if node.translation != Affine::IDENTITY.offset {
            entry["translation"] = json!(node.translation);
        }
        if node.rotation != [0.0, 0.0, 0.0, 1.0] {
            entry["rotation"] = json!(node.rotation);
        }
        if let Some(triangles) = &node.triangles {
            entry["mesh"] = json!(self.meshes.len());
            let mesh = self.mesh(&node.name, triangles);
            self.meshes.push(mesh);
        }
        if !node.extras.is_null() {
            entry["extras"] = node.extras.clone();
        }
        entry
    }

    fn mesh(&mut self, name: &str, of: &Triangles) -> Value {
        assert!(!of.triangles.is_empty(), "\"{name}\" has no triangle");
        assert_eq!(
            of.positions.len(),
            of.normals.len(),
            "normals of \"{name}\""
        );
        let position = self.vectors(&of.positions);
        // Stated of positions alone: readers place a camera by it.
        let bound = |least: fn(f32, f32) -> f32, start: f32| {
            [0, 1, 2].map(|k| of.positions.iter().map(|p| p[k]).fold(start, least))
        };
        self.accessors[position]["min"] = json!(bound(f32::min, f32::INFINITY));
        self.accessors[position]["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
        let normal = self.vectors(&of.normals);
        let corners = of.triangles.as_flattened();
        let bytes: Vec<u8> = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes, INDICES);
        let indices = self.accessor(view, UNSIGNED_INT, corners.len(), "SCALAR");
        json!({
            "name": name,
            "primitives": [{
                "attributes": {"POSITION": position, "NORMAL": normal},
                "indices": indices,
                "material": 0,
            }],
        })
    }

    fn vectors(&mut self, of: &[[f32; 3]]) -> usize {
        let numbers = of.as_flattened().iter();
        let bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, VERTICES);
        self.accessor(view, FLOAT, of.len(), "VEC3")
    }

    /// All numbers are words, so every view begins at one.
    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.binary.len(),
            "byteLength": bytes.len(),
            "target": target,
        }));
        self.binary.extend(bytes);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, number: u32, count: usize, kind: &str) -> usize {
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": number,
            "count": count,
            "type": kind,
        }));
        self.accessors.len() - 1
    }
}
