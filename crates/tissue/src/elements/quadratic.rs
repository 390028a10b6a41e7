//! Quadratic tetrahedra: ten nodes each, isoparametric, with the points of their quadrature as domains.
//!
//! An element is made of the eight parts of a tetrahedron of a mesh that was [refined](TetMesh::refined); corners and middles of its edges are its nodes. The
//! strain is linear over an element with straight edges, and four points of degree 2 integrate its elastic energy at rest exactly; of the 30 − 6 motions
//! that are not rigid each has energy. With curved edges quadrature has an error of third order.

use super::domains::{Domains, add_balanced, lanes_in};
use super::key::Key;
use crate::elements::NodeWindow;
use crate::lanes::{FourVectors, matrix_of};
use microsim_mesh::{FAMILIES, PARTS, TetMesh};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Nodes of an element.
const NODES: usize = 10;

/// Points of quadrature in an element.
const POINTS: usize = 4;

/// The corners between which the nodes 4 to 9 lie.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Barycentric coordinates of a point of degree 2: (5 + 3 √5)/20 of the corner that it is next to, (5 − √5)/20 of the others
/// (Hammer & Stroud 1956).
const COORDINATES: [f64; 2] = [0.585_410_196_624_968_5, 0.138_196_601_125_010_5];

/// Points at which F = Σ x_i ⊗ b_i of ten nodes, each with a fraction of the volume: as many of each element.
#[derive(Clone, Debug)]
pub struct QuadraturePoints {
    /// Nodes of the elements.
    nodes: Vec<[u32; NODES]>,
    /// Points of each element.
    points: usize,
    /// b_i of the points \[1/m\].
    gradients: Vec<[Vector3<f64>; NODES]>,
    /// Fractions of the volume \[m³\].
    volumes: Vec<f64>,
    /// Fibre directions, if the mesh has any.
    directions: Vec<[Vector3<f64>; FAMILIES]>,
}

impl QuadraturePoints {
    /// Whether the elements of `mesh` with these indices are all parts of tetrahedra with ten nodes whose points have a positive volume.
    pub fn fit(mesh: &TetMesh, elements: &[u32]) -> bool {
        let mut groups = elements.chunks(PARTS);
        groups.all(|group| {
            let whole = (group[0]..).zip(group).all(|(a, b)| a == *b) && group.len() == PARTS;
            let nodes = mesh.ten_nodes(group[0] as usize).filter(|_| whole);
            nodes.is_some_and(|nodes| {
                let corners = nodes.map(|node| mesh.positions[node as usize]);
                (0..POINTS).all(|point| shape(&corners, point).1 > 0.0)
            })
        })
    }

    /// Four points of each element whose eight parts have these indices, in order, which must [fit](Self::fit): others are left out.
    pub fn of(mesh: &TetMesh, elements: &[u32]) -> Self {
        let mut points = Self {
            nodes: Vec::with_capacity(elements.len() / PARTS),
            points: POINTS,
            gradients: Vec::with_capacity(elements.len() / PARTS * POINTS),
            volumes: Vec::with_capacity(elements.len() / PARTS * POINTS),
            directions: Vec::new(),
        };
        for group in elements.chunks(PARTS) {
            let first = group[0] as usize;
            let Some(nodes) = mesh.ten_nodes(first) else {
                continue;
            };
            points.nodes.push(nodes);
            let corners = nodes.map(|node| mesh.positions[node as usize]);
            for point in 0..POINTS {
                let (mut gradients, mut volume) = shape(&corners, point);
                // Each point lies in the part at its corner.
                if let Some(g) = mesh.prestretches.get(first + point) {
                    gradients.iter_mut().for_each(|b| *b = g.tr_mul(b));
                    volume /= g.determinant();
                }
                points.gradients.push(gradients);
                points.volumes.push(volume);
                if !mesh.directions.is_empty() {
                    points.directions.push(mesh.directions[first + point]);
                }
            }
        }
        points
    }

    /// One point in place of those of each element: with the mean of its deformation gradient. It has no fibre direction.
    pub fn means(&self) -> Self {
        let gradients = self.gradients.chunks(self.points);
        let groups = gradients.zip(self.volumes.chunks(self.points));
        let (gradients, volumes) = groups
            .map(|(gradients, volumes)| {
                let volume: f64 = volumes.iter().sum();
                let mut mean = [Vector3::zeros(); NODES];
                for (gradients, share) in gradients.iter().zip(volumes) {
                    for (mean, gradient) in mean.iter_mut().zip(gradients) {
                        *mean += gradient * (share / volume);
                    }
                }
                (mean, volume)
            })
            .unzip();
        Self {
            nodes: self.nodes.clone(),
            points: 1,
            gradients,
            volumes,
            directions: Vec::new(),
        }
    }

    #[inline(always)]
    fn nodes_of(&self, point: usize) -> &[u32; NODES] {
        // One or four points each: no division.
        &self.nodes[point >> (self.points / 2)]
    }
}

/// Gradients of the shape functions at a point \[1/m\], and its fraction of the volume \[m³\].
fn shape(nodes: &[Vector3<f64>; NODES], point: usize) -> ([Vector3<f64>; NODES], f64) {
    let at: [f64; 4] = std::array::from_fn(|corner| COORDINATES[usize::from(corner != point)]);
    // By the barycentric coordinates 1 to 3; that of 0 is one minus their sum.
    let of_corner = [
        Vector3::new(-1.0, -1.0, -1.0),
        Vector3::x(),
        Vector3::y(),
        Vector3::z(),
    ];
    let mut local = [Vector3::zeros(); NODES];
    for (corner, (slope, at)) in of_corner.iter().zip(at).enumerate() {
        local[corner] = slope * (4.0 * at - 1.0);
    }
    for (middle, [a, b]) in local[4..].iter_mut().zip(EDGES) {
        *middle = (of_corner[b] * at[a] + of_corner[a] * at[b]) * 4.0;
    }
    // ∂x/∂ξ; differences to the first node retain the digits of a small element far from the origin.
    let mut jacobian = Matrix3::zeros();
    for (node, slope) in nodes.iter().zip(&local).skip(1) {
        jacobian += (node - nodes[0]) * slope.transpose();
    }
    let [x, y, z] = [0, 1, 2].map(|k| jacobian.column(k).into_owned());
    let normals = [y.cross(&z), z.cross(&x), x.cross(&y)];
    let six_volumes = x.dot(&normals[0]);
    let gradients = local.map(|slope| {
        (normals[0] * slope[0] + normals[1] * slope[1] + normals[2] * slope[2]) / six_volumes
    });
    (gradients, six_volumes / (6.0 * POINTS as f64))
}

impl Domains for QuadraturePoints {
    fn count(&self) -> usize {
        self.volumes.len()
    }

    fn nodes(&self, point: usize) -> &[u32] {
        self.nodes_of(point)
    }

    fn volume(&self, point: usize) -> f64 {
        self.volumes[point]
    }

    fn directions(&self, point: usize) -> [Vector3<f64>; FAMILIES] {
        let directions = self.directions.get(point);
        directions.copied().unwrap_or_default()
    }

    fn scale_volume(&mut self, point: usize, factor: f64) {
        self.volumes[point] *= factor;
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().flatten().for_each(|n| *n += by);
    }

    fn keys(&self, point: usize, visit: &mut dyn FnMut(Key)) {
        visit(Key::new(&self.nodes_of(point)[..4]));
    }

    /// A body of quadratic tetrahedra is not edited.
    fn splice(&mut self, _removed: &[u32], _added: &Self) -> bool {
        false
    }

    fn make_room(&mut self) {}

    #[inline(always)]
    fn gradient(&self, point: usize, i: usize) -> Vector3<f64> {
        self.gradients[point][i]
    }

    #[inline(always)]
    fn deformation(&self, point: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        let nodes = self.nodes_of(point);
        let gradients = &self.gradients[point];
        let origin = positions[nodes[0] as usize];
        let mut columns = [Vector3::zeros(); 3];
        for (node, b) in nodes[1..].iter().zip(&gradients[1..]) {
            let along = positions[*node as usize] - origin;
            columns[0] += along * b[0];
            columns[1] += along * b[1];
            columns[2] += along * b[2];
        }
        Matrix3::from_columns(&columns)
    }

    #[inline(always)]
    fn add_forces_of_four(
        &self,
        first: usize,
        range: &Range<usize>,
        stress: &[FourVectors; 3],
        forces: &mut NodeWindow<'_>,
    ) {
        for lane in lanes_in(first, range) {
            let nodes = self.nodes_of(first + lane);
            let gradients = &self.gradients[first + lane];
            let scaled = matrix_of(stress, lane) * -self.volumes[first + lane];
            add_balanced(&scaled, nodes, gradients, forces);
        }
    }
}

#[cfg(test)]
mod tests;
