//! Domains with a constant deformation gradient, and the plain ones: tetrahedra.

use super::key::Key;
use super::splice::splice;
use crate::elements::NodeWindow;
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;

/// Domains over which F = Σ x_i ⊗ b_i, with Σ b_i = 0.
pub trait Domains: Clone + Debug + Send + Sync + 'static {
    /// Number of domains.
    fn count(&self) -> usize;

    /// Nodes of a domain, each once.
    fn nodes(&self, domain: usize) -> &[u32];

    /// Volume at rest [m³].
    fn volume(&self, domain: usize) -> f64;

    /// Takes a volume times a factor; all that a domain does is in proportion to its volume.
    fn scale_volume(&mut self, domain: usize, factor: f64);

    /// Takes each node so many further on.
    fn shift_nodes(&mut self, by: u32);

    /// Calls `visit` with each key of a domain, as [`Elements::keys`](super::Elements::keys).
    fn keys(&self, domain: usize, visit: &mut dyn FnMut(Key));

    /// Takes domains out and puts others in, as [`Elements::splice`](super::Elements::splice).
    fn splice(&mut self, removed: &[u32], added: &Self) -> bool;

    /// b_i [1/m] of the i-th node of a domain.
    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64>;

    /// F of positions [m], or Ḟ of velocities [m/s].
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64>;

    /// Adds the forces −V P b_i of a stress P [Pa] to the nodes.
    fn add_forces(&self, domain: usize, stress: &Matrix3<f64>, forces: &mut NodeWindow<'_>);
}

/// Linear tetrahedra, as arrays.
#[derive(Clone, Debug)]
pub struct Tetrahedra {
    nodes: Vec<[u32; 4]>,
    /// Gradients of the last three corners; that of the first is minus their sum.
    gradients: Vec<[Vector3<f64>; 3]>,
    volumes: Vec<f64>,
}

impl Tetrahedra {
    /// The elements of `mesh` with the indices `elements`.
    pub fn new(mesh: &TetMesh, elements: &[u32]) -> Self {
        let mut tetrahedra = Self {
            nodes: Vec::with_capacity(elements.len()),
            gradients: Vec::with_capacity(elements.len()),
            volumes: Vec::with_capacity(elements.len()),
        };
        for &element in elements {
            let (gradients, volume) = shape(&mesh.corners(element as usize));
            tetrahedra.nodes.push(mesh.tets[element as usize]);
            tetrahedra.gradients.push(gradients);
            tetrahedra.volumes.push(volume);
        }
        tetrahedra
    }
}

/// m·v, written out so that it is inlined.
#[inline(always)]
pub(super) fn product(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let row = |i: usize| m[(i, 0)] * v[0] + m[(i, 1)] * v[1] + m[(i, 2)] * v[2];
    Vector3::new(row(0), row(1), row(2))
}

/// Gradients of the shape functions of the last three corners [1/m], and the volume [m³].
pub(super) fn shape([a, b, c, d]: &[Vector3<f64>; 4]) -> ([Vector3<f64>; 3], f64) {
    let (e1, e2, e3) = (b - a, c - a, d - a);
    let normals = [e2.cross(&e3), e3.cross(&e1), e1.cross(&e2)];
    let six_volumes = e1.dot(&normals[0]);
    (normals.map(|n| n / six_volumes), six_volumes / 6.0)
}

impl Domains for Tetrahedra {
    fn count(&self) -> usize {
        self.nodes.len()
    }

    fn nodes(&self, domain: usize) -> &[u32] {
        &self.nodes[domain]
    }

    fn volume(&self, domain: usize) -> f64 {
        self.volumes[domain]
    }

    fn scale_volume(&mut self, domain: usize, factor: f64) {
        self.volumes[domain] *= factor;
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().flatten().for_each(|n| *n += by);
    }

    fn keys(&self, domain: usize, visit: &mut dyn FnMut(Key)) {
        visit(Key::new(&self.nodes[domain]));
    }

    fn splice(&mut self, removed: &[u32], added: &Self) -> bool {
        splice(&mut self.nodes, removed, &added.nodes);
        splice(&mut self.gradients, removed, &added.gradients);
        splice(&mut self.volumes, removed, &added.volumes);
        true
    }

    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64> {
        let [g1, g2, g3] = &self.gradients[domain];
        match i {
            0 => -(g1 + g2 + g3),
            _ => self.gradients[domain][i - 1],
        }
    }

    #[inline(always)]
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        let [a, b, c, d] = self.nodes[domain].map(|node| &positions[node as usize]);
        let [g1, g2, g3] = &self.gradients[domain];
        let (e1, e2, e3) = (b - a, c - a, d - a);
        Matrix3::from_fn(|i, k| e1[i] * g1[k] + e2[i] * g2[k] + e3[i] * g3[k])
    }

    #[inline(always)]
    fn add_forces(&self, domain: usize, stress: &Matrix3<f64>, forces: &mut NodeWindow<'_>) {
        let [a, b, c, d] = self.nodes[domain];
        let scaled = stress * -self.volumes[domain];
        let [f1, f2, f3] = self.gradients[domain].map(|g| product(&scaled, &g));
        forces.add(a, -(f1 + f2 + f3));
        forces.add(b, f1);
        forces.add(c, f2);
        forces.add(d, f3);
    }
}
