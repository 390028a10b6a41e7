//! Outward normals of the features of a surface.

use crate::skin::{NONE, Skin};
use microsim_geometry::triangle_normal;
use nalgebra::Vector3;

/// The normals of the nodes of a surface at one time, each worked out when it is first asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outward {
    stamp: u32,
    nodes: Vec<(u32, Vector3<f64>)>,
}

impl Outward {
    /// Positions are new.
    pub fn clear(&mut self, skin: &Skin) {
        if self.stamp == u32::MAX || self.nodes.is_empty() {
            self.nodes.clear();
            self.nodes
                .resize(skin.node_count as usize, (0, Vector3::zeros()));
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// The unit normal at a node: those of its triangles, weighted by their angles there (Thürmer, Wüthrich 1998), so that it does not
    /// depend on how flat parts are divided. Of a point whose nearest point of a closed surface is this node it tells the
    /// side (Bærentzen, Aanæs 2005). Zero where there is none.
    pub fn of_node(&mut self, skin: &Skin, now: &[Vector3<f64>], node: u32) -> Vector3<f64> {
        let place = (node - skin.offset) as usize;
        if self.nodes[place].0 != self.stamp {
            self.nodes[place] = (self.stamp, node_normal(skin, now, node));
        }
        self.nodes[place].1
    }
}

fn node_normal(skin: &Skin, now: &[Vector3<f64>], node: u32) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for &triangle in skin.triangles_at(node) {
        let nodes = skin.triangles[triangle as usize];
        let corner = nodes.iter().position(|&n| n == node).unwrap_or(0);
        let [p, q, r] = [0, 1, 2].map(|k| now[nodes[(corner + k) % 3] as usize]);
        if let Some(normal) = triangle_normal(&[p, q, r]) {
            let (u, v) = (q - p, r - p);
            sum += normal * libm::atan2(u.cross(&v).norm(), u.dot(&v));
        }
    }
    sum.try_normalize(0.0).unwrap_or_default()
}

/// The unit normal of a triangle; zero of one without area.
#[inline]
pub(crate) fn of_triangle(skin: &Skin, now: &[Vector3<f64>], triangle: u32) -> Vector3<f64> {
    triangle_normal(&corners(skin, now, triangle)).unwrap_or_default()
}

/// The unit normal at the inside of an edge, half-way between those of its triangles.
pub(crate) fn of_edge(skin: &Skin, now: &[Vector3<f64>], edge: u32) -> Vector3<f64> {
    let triangles = skin.edges[edge as usize].triangles;
    let sum: Vector3<f64> = triangles
        .iter()
        .filter(|&&triangle| triangle != NONE)
        .map(|&triangle| of_triangle(skin, now, triangle))
        .sum();
    sum.try_normalize(0.0).unwrap_or_default()
}

/// The corners of a triangle.
#[inline]
pub(crate) fn corners(skin: &Skin, at: &[Vector3<f64>], triangle: u32) -> [Vector3<f64>; 3] {
    skin.triangles[triangle as usize].map(|node| at[node as usize])
}
