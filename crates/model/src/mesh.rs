//! What a model is: nodes, each with a place in its parent's frame, and parts, each triangles of one colour at a node.

use crate::affine::Affine;
use crate::error::{Flaw, ModelError, flawed};
use crate::texture::Texture;
use std::collections::BTreeMap;

/// Most bytes of a file.
pub const MAX_BYTES: usize = 64 << 20;

/// Most corners of the triangles of a file.
pub const MAX_CORNERS: usize = 3 << 20;

/// Most nodes of a file.
pub const MAX_NODES: usize = 4096;

/// Cosine of the angle at which normals of faces are no longer averaged, where a file has none: 40°.
pub const CREASE: f64 = 0.766_044_443_118_978;

/// A model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Nodes; parents before their children.
    pub nodes: Vec<Node>,
    /// Triangles at the nodes.
    pub parts: Vec<Part>,
    /// Textures that parts refer to.
    pub textures: Vec<Texture>,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its name; empty if it has none.
    pub name: String,
    /// The node in whose frame it is placed.
    pub parent: Option<usize>,
    /// From its own frame to that of its parent.
    pub place: Affine,
}

/// Which part of a surface is there: where the opacity of its texture, times a factor, is at least the cutoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mask {
    /// 0 or more.
    pub cutoff: f32,
    /// From 0 to 1.
    pub factor: f32,
}

/// Triangles of one colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// The node in whose frame they are.
    pub node: usize,
    /// Positions of the vertices.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals of the vertices.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices, from the upper left corner; empty if there are none.
    pub coordinates: Vec<[f32; 2]>,
    /// Vertices of the triangles, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Colour, linear, where the file has one.
    pub colour: Option<[f32; 3]>,
    /// Place in [`Model::textures`].
    pub texture: Option<usize>,
    /// What of it is there; all of it if this is not stated. Only with a texture.
    pub mask: Option<Mask>,
}

impl Model {
    /// Where the frames of the nodes lie in that of the model.
    fn places(&self) -> Vec<Affine> {
        let mut places: Vec<Affine> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let above = node.parent.and_then(|parent| places.get(parent));
            places.push(above.map_or(node.place, |above| above.after(&node.place)));
        }
        places
    }

    /// Refuses chains of nodes that lead too far.
    pub(crate) fn check(&self) -> Result<(), ModelError> {
        match self.places().iter().all(Affine::is_bounded) {
            true => Ok(()),
            false => flawed(Flaw::NotANumber, "nodes that lie too far"),
        }
    }

    /// The parts in the frame of the model: each where its node lies.
    pub fn placed(&self) -> Vec<Part> {
        let places = self.places();
        let place = |part: &Part| places.get(part.node).copied().unwrap_or(Affine::IDENTITY);
        let parts = self.parts.iter();
        parts.map(|part| part.placed(&place(part))).collect()
    }
}

impl Part {
    /// The part at another place. A mirrored one has its triangles turned, so that outside stays outside.
    fn placed(&self, place: &Affine) -> Self {
        let mut part = self.clone();
        for position in &mut part.positions {
            *position = place.point(position.map(f64::from)).map(|x| x as f32);
        }
        let sign = if place.determinant() < 0.0 { -1.0 } else { 1.0 };
        let cofactors = place.cofactors();
        for normal in &mut part.normals {
            let n = normal.map(f64::from);
            let turned =
                cofactors.map(|row| sign * (row[0] * n[0] + row[1] * n[1] + row[2] * n[2]));
            *normal = unit(turned).map(|x| x as f32);
        }
        if sign < 0.0 {
            part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        part
    }

    /// Refuses triangles that name vertices that are not there, and too many.
    pub(crate) fn check(&self) -> Result<(), ModelError> {
        let count = self.positions.len();
        let mut indices = self.triangles.iter().flatten();
        if let Some(wrong) = indices.find(|index| **index as usize >= count) {
            return flawed(
                Flaw::NoSuchIndex,
                format!("a triangle with vertex {wrong} of {count}"),
            );
        }
        match 3 * self.triangles.len() > MAX_CORNERS || count > MAX_CORNERS {
            true => flawed(
                Flaw::TooLarge,
                format!(
                    "{} triangles with {count} vertices; at most {} are read",
                    self.triangles.len(),
                    MAX_CORNERS / 3
                ),
            ),
            false => Ok(()),
        }
    }

    /// Gives the vertices normals: at each the mean, by area, of those of its faces that meet at less than `crease`; a vertex at a sharp edge
    /// becomes several. Triangles without area keep no normal of their own and take part in none.
    pub(crate) fn set_normals(&mut self, crease: f64) {
        let faces: Vec<[f64; 3]> = self.triangles.iter().map(|t| self.area(t)).collect();
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.positions.len()];
        for (face, triangle) in self.triangles.iter().enumerate() {
            triangle.iter().for_each(|v| around[*v as usize].push(face));
        }
        let mut made: BTreeMap<(u32, [u32; 3]), u32> = BTreeMap::new();
        let old = std::mem::take(self);
        let mut new = Self {
            node: old.node,
            colour: old.colour,
            texture: old.texture,
            mask: old.mask,
            ..Self::default()
        };
        for (face, triangle) in old.triangles.iter().enumerate() {
            let own = unit(faces[face]);
            let corners = triangle.map(|v| {
                let mut sum = [0.0; 3];
                // A fan with thousands of faces at one point is round, and costs no more than its first ones.
                let near = around[v as usize].iter().take(MOST_AROUND);
                let own_too = (!near.clone().any(|other| *other == face)).then_some(&face);
                for other in near.chain(own_too) {
                    let n = unit(faces[*other]);
                    if n[0] * own[0] + n[1] * own[1] + n[2] * own[2] >= crease {
                        [0, 1, 2]
                            .into_iter()
                            .for_each(|i| sum[i] += faces[*other][i]);
                    }
                }
                let normal = unit(sum).map(|x| x as f32 + 0.0);
                *made
                    .entry((v, normal.map(f32::to_bits)))
                    .or_insert_with(|| {
                        new.positions.push(old.positions[v as usize]);
                        new.normals.push(normal);
                        new.coordinates.extend(old.coordinates.get(v as usize));
                        new.positions.len() as u32 - 1
                    })
            });
            new.triangles.push(corners);
        }
        *self = new;
    }

    /// Normal of a triangle, as long as twice its area.
    fn area(&self, triangle: &[u32; 3]) -> [f64; 3] {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize].map(f64::from));
        let (u, v) = (
            [0, 1, 2].map(|i| b[i] - a[i]),
            [0, 1, 2].map(|i| c[i] - a[i]),
        );
        [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ]
    }
}

/// Faces at a vertex that its normals are made of.
const MOST_AROUND: usize = 64;

/// The same direction with length 1; z for none.
pub(crate) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    match length > 0.0 && length.is_finite() {
        true => v.map(|x| x / length),
        false => [0.0, 0.0, 1.0],
    }
}

/// Vertices by their bits: equal ones become one.
#[derive(Default)]
pub(crate) struct Welded {
    pub part: Part,
    known: BTreeMap<[u32; 3], u32>,
}

impl Welded {
    pub fn triangle(&mut self, corners: [[f32; 3]; 3]) {
        let corners = corners.map(|corner| {
            *self
                .known
                .entry(corner.map(f32::to_bits))
                .or_insert_with(|| {
                    self.part.positions.push(corner);
                    self.part.positions.len() as u32 - 1
                })
        });
        self.part.triangles.push(corners);
    }
}

/// A node at the origin.
pub(crate) fn root(name: String) -> Node {
    Node {
        name,
        parent: None,
        place: Affine::IDENTITY,
    }
}
