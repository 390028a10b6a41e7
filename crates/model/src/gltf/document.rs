//! The JSON of a glTF file, as far as it is read. What a file has besides is left out.

use crate::error::{Flaw, ModelError, flawed};
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<View>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub textures: Vec<TextureEntry>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    #[serde(default)]
    pub targets: Vec<serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub position: Option<usize>,
    pub normal: Option<usize>,
    pub texcoord_0: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct View {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    #[serde(default)]
    pub pbr_metallic_roughness: Surface,
    pub alpha_mode: Option<String>,
    pub alpha_cutoff: Option<f32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Surface {
    pub base_color_factor: Option<[f32; 4]>,
    pub base_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct TextureEntry {
    pub source: Option<usize>,
    pub sampler: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub wrap_s: Option<u32>,
    pub wrap_t: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub uri: Option<String>,
    pub mime_type: Option<MimeType>,
    pub buffer_view: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub(super) enum MimeType {
    #[serde(rename = "image/png")]
    Png,
    #[serde(rename = "image/jpeg")]
    Jpeg,
    #[serde(other)]
    Other,
}

/// One of a list, or a sentence that there is none.
fn of<'d, T>(list: &'d [T], what: &str, index: usize) -> Result<&'d T, ModelError> {
    match list.get(index) {
        Some(found) => Ok(found),
        None => flawed(
            Flaw::NoSuchIndex,
            format!("{what} {index} of {}", list.len()),
        ),
    }
}

impl Document {
    pub fn node(&self, index: usize) -> Result<&Node, ModelError> {
        of(&self.nodes, "node", index)
    }
    pub fn mesh(&self, index: usize) -> Result<&Mesh, ModelError> {
        of(&self.meshes, "mesh", index)
    }
    pub fn accessor(&self, index: usize) -> Result<&Accessor, ModelError> {
        of(&self.accessors, "accessor", index)
    }
    pub fn view(&self, index: usize) -> Result<&View, ModelError> {
        of(&self.buffer_views, "buffer view", index)
    }
    pub fn material(&self, index: usize) -> Result<&Material, ModelError> {
        of(&self.materials, "material", index)
    }
    pub fn texture(&self, index: usize) -> Result<&TextureEntry, ModelError> {
        of(&self.textures, "texture", index)
    }
    pub fn sampler(&self, index: usize) -> Result<&Sampler, ModelError> {
        of(&self.samplers, "sampler", index)
    }
    pub fn image(&self, index: usize) -> Result<&Image, ModelError> {
        of(&self.images, "image", index)
    }

    /// The nodes of the scene that is shown: that which the file names, the first, or all that have no parent.
    pub fn shown(&self) -> Result<Vec<usize>, ModelError> {
        if let Some(scene) = self.scene.or((!self.scenes.is_empty()).then_some(0)) {
            return Ok(of(&self.scenes, "scene", scene)?.nodes.clone());
        }
        let is_child = |index: &usize| self.nodes.iter().any(|n| n.children.contains(index));
        Ok((0..self.nodes.len()).filter(|i| !is_child(i)).collect())
    }
}
