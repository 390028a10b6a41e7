//! The surface of a layer, on which points walk.
//!
//! A walk is a straightest path (Polthier & Schmies 1998): straight in each triangle, and across an edge as if the two triangles
//! lay in one plane. It ends where the layer ends: at an edge beyond which there is no face, or one that is turned away.

use microsim_geometry::{closest_on_triangle, triangle_normal};
use microsim_mesh::TetMesh;
use nalgebra::Vector3;

/// Two boundaries farther apart than this fraction of the mean edge length are not one interface. It covers what two
/// divisions of one curved surface differ by.
pub(super) const REACH: f64 = 0.25;

/// No face.
const NONE: u32 = u32::MAX;

/// Beyond an edge a layer goes on where the outward normals of its two faces differ by less than 60° at rest: else it is a rim.
pub(super) const GOES_ON: f64 = 0.5;

/// No path in one step crosses more faces: one that does stays where it is then.
const MOST_FACES: usize = 256;

/// A triangle of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    /// Outward.
    pub nodes: [u32; 3],
    /// The element behind it.
    pub element: u32,
    /// Its nodes.
    pub tet: [u32; 4],
    /// The faces across the edges from each corner to the next.
    neighbours: [u32; 3],
}

/// The surface of a region.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    region: u32,
    pub faces: Vec<Face>,
    /// How far beyond a rim a point still belongs to the layer \[m\].
    reach: f64,
}

impl Layer {
    pub fn new(mesh: &TetMesh, region: u32) -> Self {
        let faces = mesh.boundary_faces(|element| mesh.regions[element] == region);
        let mut faces: Vec<Face> = faces
            .into_iter()
            .map(|(nodes, element)| Face {
                nodes,
                element,
                tet: mesh.tets[element as usize],
                neighbours: [NONE; 3],
            })
            .collect();
        let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * faces.len());
        for (index, face) in faces.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (face.nodes[side], face.nodes[(side + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], index as u32, side));
            }
        }
        sides.sort_unstable();
        let normal = |face: &Face| triangle_normal(&corners(&face.nodes, &mesh.positions));
        for both in sides.chunk_by(|a, b| a.0 == b.0) {
            let &[(_, one, at), (_, other, there)] = both else {
                continue;
            };
            let [first, second] = [one, other].map(|face| &faces[face as usize]);
            let normals = normal(first).zip(normal(second));
            if normals.is_some_and(|(a, b)| a.dot(&b) > GOES_ON) {
                faces[one as usize].neighbours[at] = other;
                faces[other as usize].neighbours[there] = one;
            }
        }
        Self {
            region,
            faces,
            reach: REACH * mesh.mean_edge_length(),
        }
    }

    /// The same layer of a mesh after an edit. Cuts make edges shorter, and how far a point may lie beyond a rim stays.
    pub fn after_edit(&self, mesh: &TetMesh) -> Self {
        Self {
            reach: self.reach,
            ..Self::new(mesh, self.region)
        }
    }

    /// The same with all its nodes so many further on.
    pub fn shifted(&self, nodes: u32) -> Self {
        let mut shifted = self.clone();
        for face in &mut shifted.faces {
            face.nodes.iter_mut().for_each(|n| *n += nodes);
            face.tet.iter_mut().for_each(|n| *n += nodes);
        }
        shifted
    }

    /// The corners of a face \[m\].
    pub fn corners(&self, face: u32, positions: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
        corners(&self.faces[face as usize].nodes, positions)
    }

    /// Outward unit normal of a face; zero for one without area.
    pub fn normal(&self, face: u32, positions: &[Vector3<f64>]) -> Vector3<f64> {
        triangle_normal(&self.corners(face, positions)).unwrap_or_default()
    }

    /// Where a point in the plane of a face comes to by a vector in that plane \[m\]: the face, and the point in its plane; `None` where it
    /// has left the layer.
    pub fn walk(
        &self,
        positions: &[Vector3<f64>],
        face: u32,
        from: &Vector3<f64>,
        by: &Vector3<f64>,
    ) -> Option<(u32, Vector3<f64>)> {
        let mut face = face;
        let mut at = closest_on_triangle(from, &self.corners(face, positions)).point;
        let mut left = from + by - at;
        // What is beyond a rim, and the edge on which the path is.
        let (mut beyond, mut on) = (Vector3::zeros(), None);
        for _ in 0..MOST_FACES {
            let corners = self.corners(face, positions);
            let Some(edges) = Edges::of(&corners) else {
                break;
            };
            let crossed = (0..3).filter(|side| on != Some(*side)).filter_map(|side| {
                let speed = left.dot(&edges.outward[side]);
                let distance = (corners[side] - at).dot(&edges.outward[side]).max(0.0);
                (speed > distance).then(|| (distance / speed, side))
            });
            let first = crossed.reduce(|first, next| match next.0 < first.0 {
                true => next,
                false => first,
            });
            let Some((part, side)) = first else {
                break;
            };
            at += left * part;
            left *= 1.0 - part;
            let (outward, along) = (&edges.outward[side], &edges.along[side]);
            let across = left.dot(outward);
            left = along * left.dot(along);
            let next = self.faces[face as usize].neighbours[side];
            if next == NONE {
                beyond += outward * across;
                if beyond.norm() > self.reach {
                    return None;
                }
                on = Some(side);
                continue;
            }
            let there = self.faces[next as usize].neighbours;
            let back = there.iter().position(|neighbour| *neighbour == face)?;
            let Some(edges) = Edges::of(&self.corners(next, positions)) else {
                break;
            };
            left -= edges.outward[back] * across;
            (face, on) = (next, Some(back));
        }
        Some((face, at + left + beyond))
    }
}

/// Unit vectors at the edges of a triangle, in its plane.
struct Edges {
    along: [Vector3<f64>; 3],
    outward: [Vector3<f64>; 3],
}

impl Edges {
    /// `None` for a triangle without area.
    fn of(corners: &[Vector3<f64>; 3]) -> Option<Self> {
        let normal = triangle_normal(corners)?;
        let along = [0, 1, 2].map(|side| (corners[(side + 1) % 3] - corners[side]).normalize());
        let outward = along.map(|along| along.cross(&normal));
        Some(Self { along, outward })
    }
}

fn corners(nodes: &[u32; 3], positions: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
    nodes.map(|node| positions[node as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::block_mesh;
    use microsim_mesh::{Arc, CellSplit, Tube};
    use std::f64::consts::PI;

    /// The face of a layer at a point, and whose normal is along another vector.
    fn face_at(layer: &Layer, x: &[Vector3<f64>], point: Vector3<f64>, out: Vector3<f64>) -> u32 {
        let distance = |face: u32| {
            let corners = layer.corners(face, x);
            let faces = triangle_normal(&corners).unwrap().dot(&out) > 0.7;
            let apart = (closest_on_triangle(&point, &corners).point - point).norm();
            if faces { apart } else { f64::INFINITY }
        };
        let all = 0..layer.faces.len() as u32;
        all.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap()
    }

    #[test]
    fn a_walk_on_a_plane_goes_straight_across_any_faces() {
        let mesh = block_mesh([4.0, 3.0, 1.0], [7, 5, 1]);
        let layer = Layer::new(&mesh, 0);
        let x = &mesh.positions;
        let from = Vector3::new(-1.7, -1.1, 0.5);
        let start = face_at(&layer, x, from, Vector3::z());
        // Along an edge of the mesh, through its corners, and anywhere.
        for by in [
            [3.0, 0.0],
            [0.0, 2.0],
            [3.1, 2.3],
            [4.0 / 7.0, 0.6],
            [0.001, 0.0],
        ] {
            let by = Vector3::new(by[0], by[1], 0.0);
            let (face, to) = layer.walk(x, start, &from, &by).unwrap();
            assert!((to - from - by).norm() < 1e-14, "{to}");
            let corners = layer.corners(face, x);
            assert!((closest_on_triangle(&to, &corners).point - to).norm() < 1e-14);
        }
        // The mean edge of these cells is about 0.8, a quarter of it 0.2: then the layer has ended.
        let over = |by: f64| layer.walk(x, start, &from, &Vector3::new(3.7 + by, 0.0, 0.0));
        let (_, rim) = over(0.05).unwrap();
        assert!((rim.x - 2.05).abs() < 1e-14);
        assert_eq!(over(0.5), None);
        // What lies beyond the rim goes along it, and comes back.
        let (face, _) = over(0.05).unwrap();
        let (_, along) = layer
            .walk(x, face, &rim, &Vector3::new(0.0, 2.0, 0.0))
            .unwrap();
        assert!((along - rim - Vector3::new(0.0, 2.0, 0.0)).norm() < 1e-14);
        let (_, back) = layer
            .walk(x, face, &rim, &Vector3::new(-1.0, 0.0, 0.0))
            .unwrap();
        assert!((back - Vector3::new(1.05, rim.y, 0.5)).norm() < 1e-14);
    }

    #[test]
    fn a_walk_around_a_tube_comes_back_to_where_it_began() {
        let tube = Tube {
            center: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            inner_radius: 1.0,
            layers: vec![microsim_mesh::Layer {
                thickness: 0.3,
                cells: 1,
                region: 0,
            }],
            length: 2.0,
            around: 12,
            along: 5,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        };
        let mesh = tube.mesh().unwrap();
        let layer = Layer::new(&mesh, 0);
        // The outer side is a prism of 12 sides: all around it is 12 chords.
        let around = 24.0 * 1.3 * libm::sin(PI / 12.0);
        let half = 1.3 * libm::cos(PI / 12.0);
        let out = Vector3::new(libm::cos(PI / 12.0), libm::sin(PI / 12.0), 0.0);
        let from = out * half + Vector3::z() * 0.03;
        let start = face_at(&layer, &mesh.positions, from, out);
        let by = Vector3::z().cross(&out) * around;
        let (face, to) = layer.walk(&mesh.positions, start, &from, &by).unwrap();
        assert_eq!(face, start);
        // Some thirty turns of rounding.
        assert!((to - from).norm() < 1e-13, "{to} {from}");
    }
}
