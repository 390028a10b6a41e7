//! Triangles ready for upload, in the frame of the item that they are of.

use nalgebra::Vector3;

/// What moves from picture to picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    /// Item's frame \[m\].
    pub position: [f32; 3],
    /// Unit length, outwards.
    pub normal: [f32; 3],
}

/// What stays: where the material of a vertex lies at rest, and which it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Detail {
    /// Place in the material \[mm\]: patterns are functions of it.
    pub rest: [f32; 3],
    /// Of a body the number of its layer, else 0.
    pub layer: f32,
    /// Of a model with a texture: to the right and down in its picture, each side 1 long.
    pub coordinates: [f32; 2],
}

/// Triangles of one item.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mesh {
    pub vertices: Vec<Vertex>,
    pub details: Vec<Detail>,
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Adds a vertex \[m\] whose material lies where it is drawn.
    pub fn push(&mut self, point: Vector3<f64>, normal: Vector3<f64>) -> u32 {
        let index = self.vertices.len() as u32;
        self.vertices.push(Vertex {
            position: point.map(|part| part as f32).into(),
            normal: normal.map(|part| part as f32).into(),
        });
        self.details.push(Detail {
            rest: point.map(|part| (1e3 * part) as f32).into(),
            ..Detail::default()
        });
        index
    }
}
