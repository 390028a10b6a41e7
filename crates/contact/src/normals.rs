//! Outward normals of the features of a surface.

use crate::surface::{ContactSurface, NONE};
use microsim_geometry::triangle_normal;
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

/// Normals derived from the positions of a surface at one time, each computed when it is first needed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Normals {
    stamp: u32,
    faces: Vec<Cell<Face>>,
    /// Whether edges are ridges.
    ridges: Vec<Cell<(u32, bool)>>,
    nodes: Vec<Cell<(u32, Vector3<f64>)>>,
    /// Of the corners of triangles.
    corners: Vec<Cell<(u32, Vector3<f64>)>>,
}

impl Normals {
    /// Positions are new.
    pub fn clear(&mut self, surface: &ContactSurface) {
        if self.stamp == u32::MAX || self.nodes.is_empty() {
            self.nodes.clear();
            self.nodes
                .resize(surface.node_count as usize, Cell::default());
            self.corners.clear();
            self.corners
                .resize(3 * surface.triangles.len(), Cell::default());
            let face = Face {
                stamp: 0,
                cross: Vector3::zeros(),
                size: 0.0,
                normal: Vector3::zeros(),
            };
            self.faces.clear();
            self.faces.resize(surface.triangles.len(), Cell::new(face));
            self.ridges.clear();
            self.ridges.resize(surface.edges.len(), Cell::default());
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// The unit normal at a node: those of its triangles, weighted by their angles there (Thürmer, Wüthrich 1998), so that it does not
    /// depend on how flat parts are divided. Of a point whose nearest point of a closed surface is this node it gives the
    /// side (Bærentzen, Aanæs 2005). Zero where there is none.
    pub fn of_node(
        &self,
        surface: &ContactSurface,
        now: &[Vector3<f64>],
        node: u32,
    ) -> Vector3<f64> {
        let cached = &self.nodes[(node - surface.offset) as usize];
        self.cached(cached, || self.node_normal(surface, now, node, None))
    }

    /// A triangle.
    #[inline]
    pub fn face(&self, surface: &ContactSurface, now: &[Vector3<f64>], triangle: u32) -> Face {
        let cached = &self.faces[triangle as usize];
        let face = cached.get();
        if face.stamp == self.stamp {
            return face;
        }
        let corners = surface.corners(now, triangle);
        let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
        let face = Face {
            stamp: self.stamp,
            cross: u.cross(&v),
            size: u.amax() * v.amax(),
            normal: triangle_normal(&corners).unwrap_or_default(),
        };
        cached.set(face);
        face
    }

    /// The unit normal at the inside of an edge, halfway between those of its triangles.
    pub fn of_edge(
        &self,
        surface: &ContactSurface,
        now: &[Vector3<f64>],
        edge: u32,
    ) -> Vector3<f64> {
        let triangles = surface.edges[edge as usize].triangles;
        let sum: Vector3<f64> = triangles
            .iter()
            .filter(|&&triangle| triangle != NONE)
            .map(|&triangle| self.face(surface, now, triangle).normal)
            .sum();
        sum.try_normalize(0.0).unwrap_or_default()
    }

    /// Whether the faces of an edge do not lie in one plane, and it points outward.
    pub fn is_ridge(&self, surface: &ContactSurface, now: &[Vector3<f64>], edge: u32) -> bool {
        let cached = &self.ridges[edge as usize];
        let (stamp, is_ridge) = cached.get();
        if stamp == self.stamp {
            return is_ridge;
        }
        let triangles = surface.edges[edge as usize].triangles;
        let is_ridge = !triangles.contains(&NONE) && {
            let normals = triangles.map(|triangle| self.face(surface, now, triangle).normal);
            is_convex_edge(surface, now, edge, &normals)
        };
        cached.set((self.stamp, is_ridge));
        is_ridge
    }

    /// The unit normal of the smooth part of the surface that a triangle is of, at one of its corners: as at a node, without
    /// the triangles beyond sharp edges, so that near the rim of a flat face the normal is that of the face.
    pub fn of_corner(
        &self,
        surface: &ContactSurface,
        now: &[Vector3<f64>],
        triangle: u32,
        corner: usize,
    ) -> Vector3<f64> {
        let cached = &self.corners[3 * triangle as usize + corner];
        self.cached(cached, || {
            let node = surface.triangles[triangle as usize][corner];
            let normal = self.face(surface, now, triangle).normal;
            self.node_normal(surface, now, node, Some(normal))
        })
    }

    fn cached(
        &self,
        cached: &Cell<(u32, Vector3<f64>)>,
        find: impl FnOnce() -> Vector3<f64>,
    ) -> Vector3<f64> {
        let (stamp, normal) = cached.get();
        if stamp == self.stamp {
            return normal;
        }
        let normal = find();
        cached.set((self.stamp, normal));
        normal
    }

    /// The mean normal of the triangles at a node; with `like`, of those that are smooth with it.
    fn node_normal(
        &self,
        surface: &ContactSurface,
        now: &[Vector3<f64>],
        node: u32,
        like: Option<Vector3<f64>>,
    ) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for &triangle in surface.triangles_at(node) {
            let normal = self.face(surface, now, triangle).normal;
            if like.is_none_or(|like| like.dot(&normal) > SMOOTH) {
                let nodes = surface.triangles[triangle as usize];
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
pub(crate) fn is_convex_edge(
    surface: &ContactSurface,
    at: &[Vector3<f64>],
    edge: u32,
    normals: &[Vector3<f64>; 2],
) -> bool {
    let edge = &surface.edges[edge as usize];
    let beyond = surface.opposite(edge, 1);
    let height = (at[beyond as usize] - at[edge.nodes[0] as usize]).dot(&normals[0]);
    normals[0].dot(&normals[1]) <= FLAT && height < 0.0
}
