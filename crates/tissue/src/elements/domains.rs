//! Domains with a constant deformation gradient, and the plain ones: tetrahedra.

use super::lanes::{FourVectors, LANES, Lanes, product_of_four};
use crate::elements::NodeWindow;
use crate::law::{Lame, Law};
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;
use std::ops::Range;

/// Domains over which F = Σ x_i ⊗ b_i, with Σ b_i = 0.
pub trait Domains: Clone + Debug + Send + Sync + 'static {
    /// Number of domains.
    fn count(&self) -> usize;

    /// Nodes of a domain, each once.
    fn nodes(&self, domain: usize) -> &[u32];

    /// Volume at rest [m³].
    fn volume(&self, domain: usize) -> f64;

    /// Takes each volume times its factor; all that a domain does is in proportion to its volume.
    fn scale_volumes(&mut self, factors: &[f64]);

    /// Takes each node so many further on.
    fn shift_nodes(&mut self, by: u32);

    /// b_i [1/m] of the i-th node of a domain.
    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64>;

    /// F of positions [m], or Ḟ of velocities [m/s].
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64>;

    /// Adds the forces −V P b_i of a stress P [Pa] to the nodes.
    fn add_forces(&self, domain: usize, stress: &Matrix3<f64>, forces: &mut NodeWindow<'_>);

    /// Adds the forces of a law in the domains of `range`, in ascending order.
    #[inline]
    fn add_elastic_forces<L: Law>(
        &self,
        range: Range<usize>,
        positions: &[Vector3<f64>],
        lame: &Lame,
        forces: &mut NodeWindow<'_>,
    ) {
        for domain in range {
            let f = self.deformation(domain, positions);
            self.add_forces(domain, &L::stress(&f, lame), forces);
        }
    }
}

/// Linear tetrahedra, as arrays.
#[derive(Clone, Debug)]
pub struct Tetrahedra {
    nodes: Vec<[u32; 4]>,
    /// Gradients of the last three corners, of four elements each; that of the first is minus their sum.
    gradients: Vec<[FourVectors; 3]>,
    volumes: Vec<Lanes>,
}

/// Blocks of four elements that are gathered before they are worked on: a whole register is read only when the single numbers in it have
/// long been written.
const BLOCKS: usize = 16;

impl Tetrahedra {
    /// The elements of `mesh` with the indices `elements`.
    pub fn new(mesh: &TetMesh, elements: &[u32]) -> Self {
        let mut tetrahedra = Self {
            nodes: Vec::with_capacity(elements.len()),
            gradients: vec![[[Lanes::splat(0.0); 3]; 3]; elements.len().div_ceil(LANES)],
            volumes: vec![Lanes::splat(0.0); elements.len().div_ceil(LANES)],
        };
        for (index, &element) in elements.iter().enumerate() {
            let (gradients, volume) = shape(&mesh.corners(element as usize));
            tetrahedra.nodes.push(mesh.tets[element as usize]);
            let lanes = &mut tetrahedra.gradients[index / LANES];
            for (lanes, gradient) in lanes.iter_mut().zip(gradients) {
                for (lanes, component) in lanes.iter_mut().zip(&gradient) {
                    lanes.0[index % LANES] = *component;
                }
            }
            tetrahedra.volumes[index / LANES].0[index % LANES] = volume;
        }
        tetrahedra
    }

    /// Gradients of the last three corners of an element.
    #[inline(always)]
    fn gradients(&self, element: usize) -> [Vector3<f64>; 3] {
        let lanes = &self.gradients[element / LANES];
        let lane = element % LANES;
        let gradient = |g: &FourVectors| Vector3::new(g[0].0[lane], g[1].0[lane], g[2].0[lane]);
        [gradient(&lanes[0]), gradient(&lanes[1]), gradient(&lanes[2])]
    }

    /// Adds the forces of the elements of some blocks of four, of which those in `range` count.
    #[inline(always)]
    fn add_blocks<L: Law>(
        &self,
        corners: &mut [[FourVectors; 4]; BLOCKS],
        blocks: Range<usize>,
        range: &Range<usize>,
        positions: &[Vector3<f64>],
        lame: &Lame,
        forces: &mut NodeWindow<'_>,
    ) {
        // In the last block what was there before stands in for elements that are missing.
        let end = (LANES * blocks.end).min(self.nodes.len());
        let nodes = &self.nodes[LANES * blocks.start..end];
        for (fours, corners) in nodes.chunks(LANES).zip(&mut *corners) {
            for (lane, nodes) in fours.iter().enumerate() {
                for (corner, &node) in corners.iter_mut().zip(nodes) {
                    let place = &positions[node as usize];
                    corner[0].0[lane] = place[0];
                    corner[1].0[lane] = place[1];
                    corner[2].0[lane] = place[2];
                }
            }
        }
        let gradients = &self.gradients[blocks.clone()];
        let volumes = &self.volumes[blocks];
        for ((corners, gradients), volumes) in corners.iter_mut().zip(gradients).zip(volumes) {
            forces_of_four::<L>(corners, gradients, volumes, lame);
        }
        let mut element = end - nodes.len();
        for (fours, corners) in nodes.chunks(LANES).zip(&*corners) {
            for (lane, nodes) in fours.iter().enumerate() {
                if range.contains(&element) {
                    for (force, &node) in corners.iter().zip(nodes) {
                        let [x, y, z] = force;
                        forces.add(node, Vector3::new(x.0[lane], y.0[lane], z.0[lane]));
                    }
                }
                element += 1;
            }
        }
    }
}

/// Replaces the corners of four elements by the forces on them.
///
/// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers, while next to the
/// gathering of single numbers it does not.
#[inline(never)]
fn forces_of_four<L: Law>(
    corners: &mut [FourVectors; 4],
    [g1, g2, g3]: &[FourVectors; 3],
    volumes: &Lanes,
    lame: &Lame,
) {
    let [origin, ..] = *corners;
    let factor = -*volumes;
    let along = |k: usize| -> FourVectors {
        let other = &corners[k];
        [
            other[0] - origin[0],
            other[1] - origin[1],
            other[2] - origin[2],
        ]
    };
    let along = [along(1), along(2), along(3)];
    let column = |k: usize| product_of_four(&along, &[g1[k], g2[k], g3[k]]);
    let stress = L::stress_of_four(&[column(0), column(1), column(2)], lame);
    let scaled = |k: usize| -> FourVectors {
        let column: &FourVectors = &stress[k];
        [
            column[0] * factor,
            column[1] * factor,
            column[2] * factor,
        ]
    };
    let scaled = [scaled(0), scaled(1), scaled(2)];
    let f1 = product_of_four(&scaled, g1);
    let f2 = product_of_four(&scaled, g2);
    let f3 = product_of_four(&scaled, g3);
    let sum = |i: usize| -(f1[i] + f2[i] + f3[i]);
    *corners = [[sum(0), sum(1), sum(2)], f1, f2, f3];
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
        self.volumes[domain / LANES].0[domain % LANES]
    }

    fn scale_volumes(&mut self, factors: &[f64]) {
        let volumes = self.volumes.iter_mut().flat_map(|four| &mut four.0);
        for (volume, factor) in volumes.zip(factors) {
            *volume *= factor;
        }
    }

    fn shift_nodes(&mut self, by: u32) {
        self.nodes.iter_mut().flatten().for_each(|n| *n += by);
    }

    fn gradient(&self, domain: usize, i: usize) -> Vector3<f64> {
        let gradients = self.gradients(domain);
        match i {
            0 => -(gradients[0] + gradients[1] + gradients[2]),
            _ => gradients[i - 1],
        }
    }

    #[inline(always)]
    fn deformation(&self, domain: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        let [a, b, c, d] = self.nodes[domain];
        let at = |node: u32| &positions[node as usize];
        let (a, b, c, d) = (at(a), at(b), at(c), at(d));
        let [g1, g2, g3] = self.gradients(domain);
        let (e1, e2, e3) = (b - a, c - a, d - a);
        Matrix3::from_fn(|i, k| e1[i] * g1[k] + e2[i] * g2[k] + e3[i] * g3[k])
    }

    #[inline(always)]
    fn add_forces(&self, domain: usize, stress: &Matrix3<f64>, forces: &mut NodeWindow<'_>) {
        let [a, b, c, d] = self.nodes[domain];
        let scaled = stress * -self.volume(domain);
        let [g1, g2, g3] = self.gradients(domain);
        let (f1, f2, f3) = (product(&scaled, &g1), product(&scaled, &g2), product(&scaled, &g3));
        forces.add(a, -(f1 + f2 + f3));
        forces.add(b, f1);
        forces.add(c, f2);
        forces.add(d, f3);
    }

    fn add_elastic_forces<L: Law>(
        &self,
        range: Range<usize>,
        positions: &[Vector3<f64>],
        lame: &Lame,
        forces: &mut NodeWindow<'_>,
    ) {
        let mut corners = [[[Lanes::splat(0.0); 3]; 4]; BLOCKS];
        let end = range.end.div_ceil(LANES);
        for first in (range.start / LANES..end).step_by(BLOCKS) {
            let blocks = first..end.min(first + BLOCKS);
            self.add_blocks::<L>(&mut corners, blocks, &range, positions, lame, forces);
        }
    }
}
