//! Soft couplings between parts: a node tied to a point of another part (adventitia on media, NUMERICS 6).
//!
//! The point is given by barycentric weights of the nodes of a triangle or a tetrahedron. With d = x − Σ b_i x_i the energy
//! is ½ k |d|²: its forces are opposite on the two sides and act along d, so momentum and angular momentum are conserved, and
//! its tangent is constant and positive. A tie breaks for ever when |d| grows beyond a distance, or when the element that
//! owns its point is removed. Whether it is broken is an internal variable: 0 whole, 1 broken.
//!
//! Ties are elastic alone: a viscous force along the rate of d would turn the two parts. The parts bring their viscosity.

mod follow;
mod pairing;

pub(crate) use follow::Followed;
use follow::coordinates;
pub use pairing::{CoupleError, couple};

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
    /// Distance at which a tie breaks \[m\], ≥ 0; infinite for one that holds.
    pub break_distance: f64,
}

impl CouplingConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("stiffness_per_area", self.stiffness_per_area, "> 0 N/m³")?;
        if self.break_distance == f64::INFINITY {
            return Ok(());
        }
        not_negative("break_distance", self.break_distance, ">= 0 m")
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

/// A set of ties that break at one distance.
#[derive(Clone, Debug)]
pub struct Coupling {
    stencils: Vec<Stencil>,
    stiffness: Vec<f64>,
    elements: Vec<u32>,
    break_distance: f64,
}

impl Coupling {
    /// The coupling by these ties; `break_distance` \[m\] may be infinite.
    pub fn new(ties: &[Tie], break_distance: f64) -> Self {
        Self {
            stencils: ties.iter().map(Stencil::of).collect(),
            stiffness: ties.iter().map(|tie| tie.stiffness).collect(),
            elements: ties.iter().map(|tie| tie.element).collect(),
            break_distance,
        }
    }

    /// Number of whole ties.
    pub fn whole(internal: &[f64]) -> usize {
        internal.iter().filter(|&&broken| broken == 0.0).count()
    }

    /// k of a tie now: 0 when it is broken. Without internal variables all are whole.
    fn stiffness_now(&self, element: usize, internal: &[f64]) -> f64 {
        match internal.get(element) {
            None | Some(0.0) => self.stiffness[element],
            Some(_) => 0.0,
        }
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
            let stiffness = self.stiffness_now(element, at.internal);
            0.5 * stiffness * stencil.offset(at.positions).norm_squared()
        });
        energies.sum()
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        for element in range {
            let stencil = &self.stencils[element];
            let stiffness = self.stiffness_now(element, at.internal);
            let pull = stencil.offset(at.positions) * -stiffness;
            for (node, weight) in stencil.weighted() {
                forces.add(node as u32, pull * weight);
            }
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        _tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let stencil = &self.stencils[element];
        out.reset(stencil.count);
        let stiffness = self.stiffness_now(element, at.internal);
        for i in 0..stencil.count {
            for j in 0..stencil.count {
                let factor = stiffness * stencil.weights[i] * stencil.weights[j];
                *out.block_mut(i, j) = Matrix3::identity() * factor;
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

    /// Whether it is broken is that of the tie it was.
    fn inherited(&self, _added: &dyn Elements, ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        let same = ancestors.iter().map(|from| Inherited {
            constant: 0.0,
            terms: from.iter().take(1).map(|&old| (old, 1.0)).collect(),
        });
        same.collect()
    }

    fn flow(&self, positions: &[Vector3<f64>], internal: &mut [f64], _h: f64) -> bool {
        for (stencil, broken) in self.stencils.iter().zip(internal) {
            if stencil.offset(positions).norm() > self.break_distance {
                *broken = 1.0;
            }
        }
        false
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
        let stiffness = self.stiffness_now(element, internal);
        if stiffness == 0.0 {
            return;
        }
        let stencil = &self.stencils[element];
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
