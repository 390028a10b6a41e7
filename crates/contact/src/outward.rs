//! Outward normals of the features of a surface.

use crate::body::Body;
use crate::skin::{NONE, Skin};
use microsim_geometry::{TriangleFeature, TrianglePoint, triangle_normal};
use nalgebra::Vector3;
use std::cell::Cell;

/// Faces at a node whose normals have a smaller cosine than this with that of another one are not of one smooth surface with it: an
/// edge of more than 60° is sharp. The nine facets of the dissertation's tubes meet at 40°.
const SMOOTH: f64 = 0.5;

/// The normals of the nodes of a surface at one time, each worked out when it is first asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outward {
    stamp: u32,
    nodes: Vec<Cell<(u32, Vector3<f64>)>>,
    /// Of the corners of triangles.
    corners: Vec<Cell<(u32, Vector3<f64>)>>,
}

impl Outward {
    /// Positions are new.
    pub fn clear(&mut self, skin: &Skin) {
        if self.stamp == u32::MAX || self.nodes.is_empty() {
            self.nodes.clear();
            self.nodes.resize(skin.node_count as usize, Cell::default());
            self.corners.clear();
            self.corners
                .resize(3 * skin.triangles.len(), Cell::default());
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// The unit normal at a node: those of its triangles, weighted by their angles there (Thürmer, Wüthrich 1998), so that it does not
    /// depend on how flat parts are divided. Of a point whose nearest point of a closed surface is this node it tells the
    /// side (Bærentzen, Aanæs 2005). Zero where there is none.
    pub fn of_node(&self, skin: &Skin, now: &[Vector3<f64>], node: u32) -> Vector3<f64> {
        let kept = &self.nodes[(node - skin.offset) as usize];
        self.kept(kept, || node_normal(skin, now, node, None))
    }

    /// The unit normal of the smooth part of the surface that a triangle is of, at one of its corners: as at a node, without
    /// the triangles beyond sharp edges, so that near the rim of a flat face the normal is that of the face.
    pub fn of_corner(
        &self,
        skin: &Skin,
        now: &[Vector3<f64>],
        triangle: u32,
        corner: usize,
    ) -> Vector3<f64> {
        let kept = &self.corners[3 * triangle as usize + corner];
        self.kept(kept, || {
            let node = skin.triangles[triangle as usize][corner];
            node_normal(
                skin,
                now,
                node,
                triangle_normal(&corners(skin, now, triangle)),
            )
        })
    }

    fn kept(
        &self,
        kept: &Cell<(u32, Vector3<f64>)>,
        find: impl FnOnce() -> Vector3<f64>,
    ) -> Vector3<f64> {
        let (stamp, normal) = kept.get();
        if stamp == self.stamp {
            return normal;
        }
        let normal = find();
        kept.set((self.stamp, normal));
        normal
    }
}

/// The mean normal of the triangles at a node; with `like`, of those that are smooth with it.
fn node_normal(
    skin: &Skin,
    now: &[Vector3<f64>],
    node: u32,
    like: Option<Vector3<f64>>,
) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for &triangle in skin.triangles_at(node) {
        let nodes = skin.triangles[triangle as usize];
        let corner = nodes.iter().position(|&n| n == node).unwrap_or(0);
        let [p, q, r] = [0, 1, 2].map(|k| now[nodes[(corner + k) % 3] as usize]);
        if let Some(normal) = triangle_normal(&[p, q, r])
            && like.is_none_or(|like| like.dot(&normal) > SMOOTH)
        {
            let (u, v) = (q - p, r - p);
            sum += normal * libm::atan2(u.cross(&v).norm(), u.dot(&v));
        }
    }
    sum.try_normalize(0.0).unwrap_or_default()
}

/// The unit normal at a point of a triangle: that of the part on which it lies.
pub(crate) fn of_point(
    body: &Body,
    now: &[Vector3<f64>],
    triangle: u32,
    at: &TrianglePoint,
) -> Vector3<f64> {
    let skin = &body.skin;
    match at.feature() {
        TriangleFeature::Face => of_triangle(skin, now, triangle),
        TriangleFeature::Edge(side) => {
            let edges = skin.triangle_edges[triangle as usize];
            of_edge(skin, now, edges[usize::from(side)])
        }
        TriangleFeature::Corner(corner) => {
            let node = skin.triangles[triangle as usize][usize::from(corner)];
            body.outward.of_node(skin, now, node)
        }
    }
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
