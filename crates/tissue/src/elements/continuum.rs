//! A continuum of a material law: E = Σ V Ψ(F) over domains in each of which the deformation gradient is constant.
//!
//! A domain is a tetrahedron ([`Continuum`]) or a smoothing domain ([`Smoothed`]); the law and the kind of domain are types,
//! so the loop over the elements has no calls through pointers. Forces are −V P b_i with the gradients b_i of the domain;
//! viscosity is that of [`law::viscosity`](crate::law::viscosity).

use super::continuum_matrix::{CORNERS, CornerTangent, DomainTangent, FourMatrices, set_tangent};
use super::domains::{Domains, FourTetrahedra, Tetrahedra};
use super::key::Key;
use super::quadratic::QuadraturePoints;
use super::smoothed::SmoothingDomains;
use crate::elements::{
    Configuration, Constraints, ElementMatrix, Elements, EnergyKind, MatrixWindow, NodeWindow,
    Tangent, rest_stiffness, set_norms,
};
use crate::lanes::{FourTangents, LANES, Lanes, lanes, tangent_of};
use crate::law::decomposition::{FourSvds, SignedSvd};
use crate::law::{Constants, FourFamilies, Lame, Law, viscosity};
use crate::number::columns;
use nalgebra::{Matrix3, Vector3};
use std::any::Any;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

/// Multipliers of the elastic constraints C_D and C_H (`continuum_constraints`).
pub(super) const ELASTIC: usize = 2;

/// Multipliers of the viscous constraints.
const VISCOUS: usize = 7;

/// Strain below which an element counts as natural: far above the rounding of a flat one, and far below what changes a stiffness.
const NATURAL: f64 = 1e-6;

/// Linear tetrahedra.
///
/// # Limitations
/// Nearly incompressible tissue locks: see [`Discretisation`](crate::Discretisation).
pub type Continuum<L> = ContinuumSet<L, Tetrahedra>;

/// Smoothing domains around edges or nodes.
///
/// # Limitations
/// Only the means over the domains are held near 1: volumes of single tetrahedra scatter around them (0.93–1.07 in the
/// cantilever M at ν = 0.49 with the discretisation selective). Matrices couple the neighbours of neighbours: a static solution
/// of M takes six times as long as with tetrahedra.
pub type Smoothed<L> = ContinuumSet<L, SmoothingDomains>;

/// Points of quadrature of quadratic tetrahedra, or one mean of each.
///
/// # Limitations
/// It does not follow edits of the mesh.
pub type Quadratic<L> = ContinuumSet<L, QuadraturePoints>;

/// Domains of one law with the same constants.
#[derive(Clone, Debug)]
pub struct ContinuumSet<L: Law, D> {
    pub(super) domains: D,
    pub(super) constants: L::Constants,
    pub(super) relaxation_time: f64,
    law: PhantomData<L>,
}

impl<L: Law, D: Domains> ContinuumSet<L, D> {
    /// These domains with the constants `constants`, which take the fibre directions of the domains, and the relaxation time τ \[s\] of
    /// Kelvin–Voigt viscosity.
    pub fn new(domains: D, constants: L::Constants, relaxation_time: f64) -> Self {
        Self {
            domains,
            constants,
            relaxation_time,
            law: PhantomData,
        }
    }

    /// The constants in a domain.
    #[inline(always)]
    pub(super) fn constants(&self, domain: usize) -> L::Constants {
        match L::Constants::DIRECTIONS {
            0 => self.constants,
            _ => self.constants.along(self.domains.directions(domain)),
        }
    }

    /// The moduli of the viscosity of four elements, and the families of fibres where the law has any.
    #[inline(always)]
    pub(super) fn viscous_moduli(&self, first: usize) -> (Lame, Option<FourFamilies>) {
        let directions = self.domains.directions_for::<L::Constants>(first);
        let families = self.constants.families_of_four(&directions);
        (self.constants.elasticity().lame, families)
    }

    /// The constants in four elements from `first` on; beyond the end those in the last one.
    #[inline(always)]
    pub(super) fn constants_of_four(&self, first: usize) -> [L::Constants; LANES] {
        let last = self.domains.count() - 1;
        lanes(|lane| self.constants(last.min(first + lane)))
    }

    /// Adds the tangents of all elements to a matrix, in ascending order.
    #[inline(always)]
    pub(super) fn add_tangents(&self, of: &impl TangentsOfFour, matrix: &mut MatrixWindow<'_>) {
        let count = self.domains.count();
        let mut tangents = [[Lanes::splat(0.0); 9]; 9];
        let mut corners = Vec::new();
        let mut matrices = FourMatrices::zero();
        for first in (0..count).step_by(LANES) {
            let four = first..count.min(first + LANES);
            if let Some(shapes) = self.domains.tetrahedra_of_four(first) {
                matrices.clear();
                of.add_matrices(first, &shapes, &mut matrices);
                matrices.complete();
                for (lane, element) in four.enumerate() {
                    matrix.add_pairs(element, CORNERS, |i, j| matrices.block(lane, i, j));
                }
                continue;
            }
            of.set_tangents(first, &mut tangents);
            for (lane, element) in four.enumerate() {
                let one = tangent_of(&tangents, lane).data.0;
                let tangent = DomainTangent::new(&one, self.domains.volume(element));
                let nodes = self.domains.nodes(element).len();
                corners.resize(nodes, CornerTangent::zero());
                for (node, corner) in corners.iter_mut().enumerate() {
                    let gradient = self.domains.gradient(element, node);
                    tangent.set_corner(gradient.into(), corner);
                }
                matrix.add_pairs(element, nodes, |row, column| {
                    Matrix3::from_column_slice(&corners[row].block(&corners[column]))
                });
            }
        }
    }
}

/// What elements do to the matrix of their set, four at once from `first` on, a multiple of four; what is set for those beyond the end means nothing.
pub(super) trait TangentsOfFour {
    /// Sets their tangents ∂P/∂F \[Pa\].
    fn set_tangents(&self, first: usize, tangents: &mut FourTangents);

    /// Adds the matrices of tetrahedra of these shapes, for nodes other than the first one.
    fn add_matrices(&self, first: usize, shapes: &FourTetrahedra, matrices: &mut FourMatrices);
}

/// The tangents of a [`ContinuumSet`].
struct ContinuumTangents<'a, L: Law, D> {
    of: &'a ContinuumSet<L, D>,
    positions: &'a [Vector3<f64>],
    tangent: Tangent,
    /// Factor of the moduli of viscosity \[s\]; zero without.
    viscous_time: f64,
}

impl<L: Law, D: Domains> TangentsOfFour for ContinuumTangents<'_, L, D> {
    #[inline(always)]
    fn set_tangents(&self, first: usize, tangents: &mut FourTangents) {
        let f = self.of.domains.deformations_of_four(first, self.positions);
        match self.tangent {
            Tangent::Exact => {
                let directions = self.of.domains.directions_for::<L::Constants>(first);
                L::set_tangents_of_four(&f, &directions, &self.of.constants, tangents);
            }
            Tangent::Positive => {
                let constants = self.of.constants_of_four(first);
                L::set_positive_tangents_of_each(&FourSvds::new(&f), &constants, tangents);
            }
        }
        if self.viscous_time > 0.0 {
            let (lame, families) = self.of.viscous_moduli(first);
            viscosity::add_tangent(&f, &lame, &families, self.viscous_time, tangents);
        }
    }

    #[inline(always)]
    fn add_matrices(&self, first: usize, shapes: &FourTetrahedra, matrices: &mut FourMatrices) {
        let f = self.of.domains.deformations_of_four(first, self.positions);
        match self.tangent {
            Tangent::Exact => {
                let mut tangents = [[Lanes::splat(0.0); 9]; 9];
                let directions = self.of.domains.directions_for::<L::Constants>(first);
                L::set_tangents_of_four(&f, &directions, &self.of.constants, &mut tangents);
                matrices.add_tangents(&tangents, shapes);
            }
            Tangent::Positive => {
                matrices.add_positive::<L>(&f, &self.of.constants_of_four(first), shapes);
            }
        }
        if self.viscous_time > 0.0 {
            let (lame, families) = self.of.viscous_moduli(first);
            matrices.add_viscous(&f, &lame, &families, self.viscous_time, shapes);
        }
    }
}

impl<L: Law, D: Domains> Elements for ContinuumSet<L, D> {
    fn kind(&self) -> EnergyKind {
        EnergyKind::Strain
    }

    fn count(&self) -> usize {
        self.domains.count()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        self.domains.nodes(element)
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let count = self.domains.count();
        let mut sum = 0.0;
        for first in (0..count).step_by(LANES) {
            let f = self.domains.deformations_of_four(first, at.positions);
            let directions = self.domains.directions_for::<L::Constants>(first);
            let densities = L::energy_of_four(&f, &directions, &self.constants);
            for (element, density) in (first..count).zip(densities.0) {
                sum += self.domains.volume(element) * density;
            }
        }
        sum
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        if self.is_viscous() {
            for first in (range.start / LANES * LANES..range.end).step_by(LANES) {
                let f = self.domains.deformations_of_four(first, at.positions);
                let rate = self.domains.deformations_of_four(first, at.velocities);
                let directions = self.domains.directions_for::<L::Constants>(first);
                let elastic = L::stress_of_four(&f, &directions, &self.constants);
                let (lame, families) = self.viscous_moduli(first);
                let viscous =
                    viscosity::stress_of(&f, &rate, &lame, &families, self.relaxation_time);
                let stress = columns(|k, i| elastic[k][i] + viscous[k][i]);
                self.domains
                    .add_forces_of_four(first, &range, &stress, forces);
            }
        } else {
            self.domains
                .add_elastic_forces::<L>(range, at.positions, &self.constants, forces);
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        out.reset(self.domains.nodes(element).len());
        let f = self.domains.deformation(element, at.positions);
        let constants = self.constants(element);
        let tangent = match tangent {
            Tangent::Exact => L::tangent(&f, &constants),
            Tangent::Positive => L::positive_tangent(&SignedSvd::new(&f), &constants),
        };
        let gradient = |corner| self.domains.gradient(element, corner);
        set_tangent(&tangent, self.domains.volume(element), gradient, out);
    }

    fn add_tangent(
        &self,
        at: &Configuration<'_>,
        tangent: Tangent,
        damping: f64,
        matrix: &mut MatrixWindow<'_>,
    ) {
        let tangents = ContinuumTangents {
            of: self,
            positions: at.positions,
            tangent,
            viscous_time: damping * self.relaxation_time,
        };
        self.add_tangents(&tangents, matrix);
    }

    fn is_viscous(&self) -> bool {
        self.relaxation_time > 0.0
    }

    fn damping(&self, element: usize, at: &Configuration<'_>, out: &mut ElementMatrix) {
        out.reset(self.domains.nodes(element).len());
        if !self.is_viscous() {
            return;
        }
        let f = self.domains.deformation(element, at.positions);
        let elasticity = self.constants(element).elasticity();
        let tangent = viscosity::tangent(&f, &elasticity, self.relaxation_time);
        let gradient = |corner| self.domains.gradient(element, corner);
        set_tangent(&tangent, self.domains.volume(element), gradient, out);
    }

    fn relaxation_time(&self, _: usize) -> f64 {
        self.relaxation_time
    }

    fn is_natural(&self, element: usize, rest_positions: &[Vector3<f64>]) -> bool {
        let f = self.domains.deformation(element, rest_positions);
        (f - Matrix3::identity()).amax() < NATURAL
    }

    /// Every law is linear elasticity in its natural state: K_ij = V (λ b_i b_jᵀ + μ b_j b_iᵀ + μ b_i·b_j 1), with the square of its norm
    /// V² ((λ² + μ²) |b_i|² |b_j|² + (4 λ μ + 5 μ²) (b_i·b_j)²). With fibres the blocks themselves are formed.
    fn rest_norms(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        if !self.is_natural(element, rest_positions) {
            set_norms(&rest_stiffness(self, element, rest_positions), out);
            return;
        }
        let nodes = self.domains.nodes(element).len();
        let volume = self.domains.volume(element);
        let elasticity = self.constants(element).elasticity();
        if elasticity.families.is_some() {
            let gradients: Vec<_> = (0..nodes)
                .map(|i| self.domains.gradient(element, i))
                .collect();
            let pairs = gradients
                .iter()
                .flat_map(|a| gradients.iter().map(move |b| (a, b)));
            out.clear();
            out.extend(pairs.map(|(a, b)| elasticity.block(volume, a, b).norm()));
            return;
        }
        let Lame { mu, lambda } = elasticity.lame;
        let sizes = (lambda * lambda + mu * mu) * volume * volume;
        let product = (4.0 * lambda * mu + 5.0 * mu * mu) * volume * volume;
        out.clear();
        out.resize(nodes * nodes, 0.0);
        for i in 0..nodes {
            let a = self.domains.gradient(element, i);
            for j in 0..=i {
                let b = self.domains.gradient(element, j);
                let along = a.dot(&b);
                let square = sizes * a.norm_squared() * b.norm_squared() + product * along * along;
                // With λ < 0 the sum may be 0 but for rounding.
                let norm = square.max(0.0).sqrt();
                out[i * nodes + j] = norm;
                out[j * nodes + i] = norm;
            }
        }
    }

    /// That of K_ii is V ((λ + 4 μ) |b_i|² + Σ m |H b_i|²), m = 0 without fibres.
    fn rest_traces(&self, element: usize, _rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        let elasticity = self.constants(element).elasticity();
        let volume = self.domains.volume(element);
        let nodes = 0..self.domains.nodes(element).len();
        if let Some(families) = elasticity.families {
            let Lame { mu, lambda } = elasticity.lame;
            let gradients = nodes.map(|i| self.domains.gradient(element, i));
            let traces = gradients.map(|b| {
                let of_fibres: f64 = families
                    .iter()
                    .map(|family| family.stiffness * (family.structure * b).norm_squared())
                    .sum();
                volume * ((lambda + 4.0 * mu) * b.norm_squared() + of_fibres)
            });
            out.clear();
            out.extend(traces);
            return;
        }
        let stiffness = (elasticity.lame.lambda + 4.0 * elasticity.lame.mu) * volume;
        let squares = nodes.map(|i| self.domains.gradient(element, i).norm_squared());
        out.clear();
        out.extend(squares.map(|square| stiffness * square));
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.domains.scale_volume(element, factor);
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let mut shifted = self.clone();
        shifted.domains.shift_nodes(nodes);
        Arc::new(shifted)
    }

    fn keys(&self, element: usize, visit: &mut dyn FnMut(Key)) {
        self.domains.keys(element, visit);
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let added = (added as &dyn Any).downcast_ref::<Self>();
        added.is_some_and(|added| self.domains.splice(removed, &added.domains))
    }

    fn make_room(&mut self) {
        self.domains.make_room();
    }

    fn constraints(&self) -> Option<&dyn Constraints> {
        if L::IS_SUM_OF_SQUARES {
            Some(self)
        } else {
            None
        }
    }
}

impl<L: Law, D: Domains> Constraints for ContinuumSet<L, D> {
    fn multipliers(&self) -> usize {
        if self.is_viscous() {
            ELASTIC + VISCOUS
        } else {
            ELASTIC
        }
    }

    fn project(
        &self,
        element: usize,
        positions: &mut [Vector3<f64>],
        previous: &[Vector3<f64>],
        inverse_masses: &[f64],
        _internal: &[f64],
        multipliers: &mut [f64],
        h: f64,
    ) {
        self.project_domain(element, positions, previous, inverse_masses, multipliers, h);
    }
}

#[cfg(test)]
mod tests;
