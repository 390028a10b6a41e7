//! Outward normals of the features of a surface.

use crate::body::Body;
use crate::skin::{NONE, Skin};
use microsim_geometry::{TriangleFeature, TrianglePoint, triangle_normal};
use nalgebra::Vector3;
use std::cell::Cell;

/// Faces at a node whose normals have a smaller cosine than this with that of another one are not of one smooth surface with it: an
/// edge of more than 60° is sharp. The nine facets of the dissertation's tubes meet at 40°.
const SMOOTH: f64 = 0.5;

/// An edge between faces whose normals have a larger cosine than this is flat.
const FLAT: f64 = 0.999;

/// A triangle at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    stamp: u32,
    /// The product of two of its edges, and of their largest coordinates \[m²\].
    cross: Vector3<f64>,
    size: f64,
    /// The unit normal; zero of one without area.
    pub normal: Vector3<f64>,
}

/// What is derived from the positions of a surface at one time, each worked out when it is first asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outward {
    stamp: u32,
    faces: Vec<Cell<Face>>,
    /// Whether edges are ridges.
    ridges: Vec<Cell<(u32, bool)>>,
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
            let face = Face {
                stamp: 0,
                cross: Vector3::zeros(),
                size: 0.0,
                normal: Vector3::zeros(),
            };
            self.faces.clear();
            self.faces.resize(skin.triangles.len(), Cell::new(face));
            self.ridges.clear();
            self.ridges.resize(skin.edges.len(), Cell::default());
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// The unit normal at a node: those of its triangles, weighted by their angles there (Thürmer, Wüthrich 1998), so that it does not
    /// depend on how flat parts are divided. Of a point whose nearest point of a closed surface is this node it tells the
    /// side (Bærentzen, Aanæs 2005). Zero where there is none.
    pub fn of_node(&self, skin: &Skin, now: &[Vector3<f64>], node: u32) -> Vector3<f64> {
        let kept = &self.nodes[(node - skin.offset) as usize];
        self.kept(kept, || self.node_normal(skin, now, node, None))
    }

    /// A triangle.
    #[inline]
    pub fn face(&self, skin: &Skin, now: &[Vector3<f64>], triangle: u32) -> Face {
        let kept = &self.faces[triangle as usize];
        let face = kept.get();
        if face.stamp == self.stamp {
            return face;
        }
        let corners = corners(skin, now, triangle);
        let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
        let face = Face {
            stamp: self.stamp,
            cross: u.cross(&v),
            size: u.amax() * v.amax(),
            normal: triangle_normal(&corners).unwrap_or_default(),
        };
        kept.set(face);
        face
    }

    /// The unit normal at the inside of an edge, half-way between those of its triangles.
    pub fn of_edge(&self, skin: &Skin, now: &[Vector3<f64>], edge: u32) -> Vector3<f64> {
        let triangles = skin.edges[edge as usize].triangles;
        let sum: Vector3<f64> = triangles
            .iter()
            .filter(|&&triangle| triangle != NONE)
            .map(|&triangle| self.face(skin, now, triangle).normal)
            .sum();
        sum.try_normalize(0.0).unwrap_or_default()
    }

    /// Whether the faces of an edge do not lie in one plane, and it points outward.
    pub fn is_ridge(&self, skin: &Skin, now: &[Vector3<f64>], edge: u32) -> bool {
        let kept = &self.ridges[edge as usize];
        let (stamp, is_ridge) = kept.get();
        if stamp == self.stamp {
            return is_ridge;
        }
        let triangles = skin.edges[edge as usize].triangles;
        let is_ridge = !triangles.contains(&NONE) && {
            let normals = triangles.map(|triangle| self.face(skin, now, triangle).normal);
            stands_out(skin, now, edge, &normals)
        };
        kept.set((self.stamp, is_ridge));
        is_ridge
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
            let normal = self.face(skin, now, triangle).normal;
            self.node_normal(skin, now, node, Some(normal))
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

    /// The mean normal of the triangles at a node; with `like`, of those that are smooth with it.
    fn node_normal(
        &self,
        skin: &Skin,
        now: &[Vector3<f64>],
        node: u32,
        like: Option<Vector3<f64>>,
    ) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for &triangle in skin.triangles_at(node) {
            let normal = self.face(skin, now, triangle).normal;
            if like.is_none_or(|like| like.dot(&normal) > SMOOTH) {
                let nodes = skin.triangles[triangle as usize];
                let corner = nodes.iter().position(|&n| n == node).unwrap_or(0);
                let [p, q, r] = [0, 1, 2].map(|k| now[nodes[(corner + k) % 3] as usize]);
                let (u, v) = (q - p, r - p);
                sum += normal * libm::atan2(u.cross(&v).norm(), u.dot(&v));
            }
        }
        sum.try_normalize(0.0).unwrap_or_default()
    }
}

impl Face {
    /// Whether two points are clearly on one side of its plane; `from` leads from its first corner to each.
    #[inline]
    pub fn on_one_side(&self, from: &[Vector3<f64>; 2]) -> bool {
        let heights = from.map(|p| p.dot(&self.cross));
        // A triple product is rounded by less than 16 units of its largest part.
        let noise = 64.0 * f64::EPSILON * self.size * from[0].amax().max(from[1].amax());
        heights[0].min(heights[1]) > noise || heights[0].max(heights[1]) < -noise
    }
}

/// Whether an edge between faces with these normals is no flat one and points outward.
pub(crate) fn stands_out(
    skin: &Skin,
    at: &[Vector3<f64>],
    edge: u32,
    normals: &[Vector3<f64>; 2],
) -> bool {
    let edge = &skin.edges[edge as usize];
    let beyond = skin.opposite(edge, 1);
    let height = (at[beyond as usize] - at[edge.nodes[0] as usize]).dot(&normals[0]);
    normals[0].dot(&normals[1]) <= FLAT && height < 0.0
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
        TriangleFeature::Face => body.outward.face(skin, now, triangle).normal,
        TriangleFeature::Edge(side) => {
            let edges = skin.triangle_edges[triangle as usize];
            body.outward.of_edge(skin, now, edges[usize::from(side)])
        }
        TriangleFeature::Corner(corner) => {
            let node = skin.triangles[triangle as usize][usize::from(corner)];
            body.outward.of_node(skin, now, node)
        }
    }
}

/// The corners of a triangle.
#[inline]
pub(crate) fn corners(skin: &Skin, at: &[Vector3<f64>], triangle: u32) -> [Vector3<f64>; 3] {
    skin.triangles[triangle as usize].map(|node| at[node as usize])
}
