//! Couplings between layers: a node tied to a point of another layer (adventitia on media, NUMERICS 6).
//!
//! The point is given by barycentric weights of the nodes of a triangle or a tetrahedron. With d = x − Σ b_i x_i a tie pulls with
//! a force along d whose size t depends on |d| alone ([`Bond`]): its forces are opposite on the two sides, so momentum and angular
//! momentum are conserved, and they have a potential. A tie is gone for ever when the element that owns its point is removed.
//! What a tie has been through is one internal variable.
//!
//! What is here: ties whose points stay where they are. Those that slide: [`Sliding`]. Ties are elastic but for what they lose
//! when they come off: a viscous force along the rate of d would turn the two parts. The parts bring their viscosity.

mod bond;
mod follow;
mod layer;
mod pairing;
mod sliding;

use bond::Pull;
pub use bond::{Bond, Cohesion};
pub(crate) use follow::Followed;
use follow::coordinates;
pub use pairing::{CoupleError, couple, couple_sliding};
pub use sliding::Sliding;

use crate::elements::key::Key;
use crate::elements::splice::{Inherited, make_room, splice};
use crate::elements::{
    Configuration, Constraints, ElementMatrix, Elements, EnergyKind, NodeWindow, Tangent,
};
use crate::range::{MaterialError, not_negative, positive};
use nalgebra::{Matrix3, Vector3};
use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

/// Constants of a coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingConstants {
    /// Stiffness per area of the interface \[N/m³\], > 0.
    pub stiffness_per_area: f64,
    /// How it comes off.
    pub bond: Bond,
}

impl CouplingConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("stiffness_per_area", self.stiffness_per_area, "> 0 N/m³")?;
        self.bond.check(self.stiffness_per_area)
    }
}

/// Constants of a coupling that slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingConstants {
    /// Stiffness per area of the interface \[N/m³\], > 0, along the normal and across it.
    pub stiffness_per_area: f64,
    /// Coefficient of friction μ, ≥ 0.
    pub friction: f64,
    /// τ: force per area that resists however the layers are pressed \[Pa\], ≥ 0.
    pub shear_strength: f64,
}

impl SlidingConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("stiffness_per_area", self.stiffness_per_area, "> 0 N/m³")?;
        not_negative("friction", self.friction, ">= 0")?;
        not_negative("shear_strength", self.shear_strength, ">= 0 Pa")
    }
}

/// The point of another part to which a node is tied: nodes with weights of sum 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Support {
    /// A point of a triangle.
    Triangle([u32; 3], [f64; 3]),
    /// A point in or near a tetrahedron.
    Tet([u32; 4], [f64; 4]),
}

/// One tie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// The node; none of those of the support.
    pub node: u32,
    /// The point.
    pub support: Support,
    /// Element of the mesh that owns the point.
    pub element: u32,
    /// k \[N/m\].
    pub stiffness: f64,
}

/// A tie as the loops see it: d = Σ weight·x over the first `count` nodes.
#[derive(Clone, Copy, Debug)]
struct Stencil {
    nodes: [u32; 5],
    weights: [f64; 5],
    count: usize,
}

impl Stencil {
    fn of(tie: &Tie) -> Self {
        let mut stencil = Self {
            nodes: [tie.node; 5],
            weights: [1.0, 0.0, 0.0, 0.0, 0.0],
            count: 1,
        };
        let (nodes, weights): (&[u32], &[f64]) = match &tie.support {
            Support::Triangle(nodes, weights) => (nodes, weights),
            Support::Tet(nodes, weights) => (nodes, weights),
        };
        for (node, weight) in nodes.iter().zip(weights) {
            stencil.nodes[stencil.count] = *node;
            stencil.weights[stencil.count] = -weight;
            stencil.count += 1;
        }
        stencil
    }

    fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    fn weighted(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let nodes = self.nodes().iter().map(|&node| node as usize);
        nodes.zip(self.weights.iter().copied())
    }

    /// d = Σ weight·x.
    fn offset(&self, positions: &[Vector3<f64>]) -> Vector3<f64> {
        let mut offset = Vector3::zeros();
        for (node, weight) in self.weighted() {
            offset += positions[node] * weight;
        }
        offset
    }
}

/// A set of ties of one bond.
#[derive(Clone, Debug)]
pub struct Coupling {
    stencils: Vec<Stencil>,
    stiffness: Vec<f64>,
    elements: Vec<u32>,
    bond: Bond,
}

impl Coupling {
    /// The coupling by these ties. The lengths of a cohesive bond are those of its constants with `stiffness_per_area` \[N/m³\].
    pub fn new(ties: &[Tie], bond: Bond) -> Self {
        Self {
            stencils: ties.iter().map(Stencil::of).collect(),
            stiffness: ties.iter().map(|tie| tie.stiffness).collect(),
            elements: ties.iter().map(|tie| tie.element).collect(),
            bond,
        }
    }

    /// Number of ties that still pull.
    pub fn whole(&self, internal: &[f64]) -> usize {
        internal
            .iter()
            .filter(|past| !self.bond.is_off(**past))
            .count()
    }

    /// The pull of a tie at a distance \[m\], by its stiffness. Without internal variables all are as at the start.
    fn pull(&self, element: usize, distance: f64, internal: &[f64]) -> Pull {
        let past = internal.get(element).copied().unwrap_or(0.0);
        self.bond.pull(distance, past)
    }
}

impl Elements for Coupling {
    fn kind(&self) -> EnergyKind {
        EnergyKind::Coupling
    }

    fn count(&self) -> usize {
        self.stencils.len()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        self.stencils[element].nodes()
    }

    fn initial_internal(&self) -> Vec<f64> {
        vec![0.0; self.stencils.len()]
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let energies = self.stencils.iter().enumerate().map(|(element, stencil)| {
            let distance = stencil.offset(at.positions).norm();
            self.stiffness[element] * self.pull(element, distance, at.internal).energy
        });
        energies.sum()
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        for element in range {
            let stencil = &self.stencils[element];
            let offset = stencil.offset(at.positions);
            let secant = self.pull(element, offset.norm(), at.internal).secant;
            let pull = offset * (-secant * self.stiffness[element]);
            for (node, weight) in stencil.weighted() {
                forces.add(node as u32, pull * weight);
            }
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let stencil = &self.stencils[element];
        out.reset(stencil.count);
        let offset = stencil.offset(at.positions);
        let distance = offset.norm();
        let Pull { secant, slope, .. } = self.pull(element, distance, at.internal);
        let mut block = Matrix3::from_diagonal_element(secant * self.stiffness[element]);
        if slope != secant {
            // Only beyond its onset, where d has a direction.
            let slope = match tangent {
                Tangent::Exact => slope,
                Tangent::Positive => slope.max(0.0),
            };
            let along = offset / distance;
            let factor = (slope - secant) * self.stiffness[element];
            block += along * along.transpose() * factor;
        }
        for i in 0..stencil.count {
            for j in 0..stencil.count {
                *out.block_mut(i, j) = block * (stencil.weights[i] * stencil.weights[j]);
            }
        }
    }

    fn is_viscous(&self) -> bool {
        false
    }

    fn relaxation_time(&self, _: usize) -> f64 {
        0.0
    }

    fn damping(&self, element: usize, _at: &Configuration<'_>, out: &mut ElementMatrix) {
        out.reset(self.stencils[element].count);
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.stiffness[element] *= factor;
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let mut shifted = self.clone();
        for stencil in &mut shifted.stencils {
            stencil.nodes.iter_mut().for_each(|n| *n += nodes);
        }
        Arc::new(shifted)
    }

    /// Each of its nodes.
    fn keys(&self, element: usize, visit: &mut dyn FnMut(Key)) {
        let nodes = self.stencils[element].nodes();
        nodes.iter().for_each(|node| visit(Key::new(&[*node])));
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let Some(added) = (added as &dyn Any).downcast_ref::<Self>() else {
            return false;
        };
        splice(&mut self.stencils, removed, &added.stencils);
        splice(&mut self.stiffness, removed, &added.stiffness);
        splice(&mut self.elements, removed, &added.elements);
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.stencils);
        make_room(&mut self.stiffness);
        make_room(&mut self.elements);
    }

    /// Its past is that of the tie it was.
    fn inherited(&self, _added: &dyn Elements, ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        let same = ancestors.iter().map(|from| Inherited {
            constant: 0.0,
            terms: from.iter().take(1).map(|&old| (old, 1.0)).collect(),
        });
        same.collect()
    }

    fn flow(&self, positions: &[Vector3<f64>], internal: &mut [f64], _h: f64) -> bool {
        for (stencil, past) in self.stencils.iter().zip(internal) {
            *past = self.bond.past(stencil.offset(positions).norm(), *past);
        }
        false
    }

    fn dissipated(&self, internal: &[f64]) -> f64 {
        let pasts = self.stiffness.iter().zip(internal);
        pasts.map(|(k, past)| k * self.bond.dissipated(*past)).sum()
    }

    fn constraints(&self) -> Option<&dyn Constraints> {
        Some(self)
    }
}

impl Constraints for Coupling {
    /// One for each component of d.
    fn multipliers(&self) -> usize {
        3
    }

    fn project(
        &self,
        element: usize,
        positions: &mut [Vector3<f64>],
        _previous: &[Vector3<f64>],
        inverse_masses: &[f64],
        internal: &[f64],
        multipliers: &mut [f64],
        h: f64,
    ) {
        let stencil = &self.stencils[element];
        let distance = stencil.offset(positions).norm();
        let stiffness = self.stiffness[element] * self.pull(element, distance, internal).secant;
        if stiffness == 0.0 {
            return;
        }
        let compliance = 1.0 / (stiffness * h * h);
        let mut resistance = compliance;
        for (node, weight) in stencil.weighted() {
            resistance += weight * weight * inverse_masses[node];
        }
        let before = Vector3::from_column_slice(&multipliers[..3]);
        let change = -(stencil.offset(positions) + before * compliance) / resistance;
        for (multiplier, change) in multipliers.iter_mut().zip(change.iter()) {
            *multiplier += change;
        }
        for (node, weight) in stencil.weighted() {
            positions[node] += change * (weight * inverse_masses[node]);
        }
    }
}

#[cfg(test)]
mod tests;
