//! A continuum that flows: a set of a law on its domains with plastic flow in each of them.
//!
//! Energy, forces and tangents are those of the law at F_e = F F_p⁻¹ with F_p held; [`Elements::flow`] changes F_p between two steps
//! ([`plastic_flow`](super::plastic_flow)). The viscosity is that of the whole deformation F and does not change by flow.

use super::continuum::{ContinuumSet, TangentsOfFour};
use super::continuum_matrix::{FourMatrices, set_tangent};
use super::domains::{Domains, FourTetrahedra};
use super::key::Key;
use super::plastic_flow::{
    BLOCKS, ContinuumPlasticity, Flowed, FourStates, PlasticState, constants_of,
};
use super::splice::{Blend, Inherited};
use crate::elements::{
    Configuration, ElementMatrix, Elements, EnergyKind, MatrixWindow, NodeWindow, Tangent,
};
use crate::lanes::{FourTangents, LANES, Lanes, lanes, matrix_of, put_tangent};
use crate::law::decomposition::{FourSvds, SignedSvd};
use crate::law::{Law, viscosity};
use crate::number::{
    Columns, Columns9, Number, columns, columns_of, product, three, transposed_product,
};
use nalgebra::{Matrix3, Vector3};
use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

/// Domains of one law with the same constants, which flow.
///
/// # Limitations
/// Position-based methods cannot treat it: their constraints know no F_p.
#[derive(Clone, Debug)]
pub struct PlasticSet<L: Law, D> {
    elastic: ContinuumSet<L, D>,
    plasticity: ContinuumPlasticity,
}

impl<L: Law, D: Domains> PlasticSet<L, D> {
    /// The domains of a set, with plastic flow. The volumetric part of the law, where it is not in this set, must be a function of J
    /// alone: [`LawName::is_volumetric_of_j`](crate::law::LawName::is_volumetric_of_j).
    pub fn new(elastic: ContinuumSet<L, D>, plasticity: ContinuumPlasticity) -> Self {
        Self {
            elastic,
            plasticity,
        }
    }

    #[inline(always)]
    fn state(&self, internal: &[f64], element: usize) -> PlasticState {
        PlasticState::read(internal, self.elastic.domains.count(), element)
    }

    #[inline(always)]
    fn states_of_four(&self, internal: &[f64], first: usize) -> FourStates {
        FourStates::read(internal, self.elastic.domains.count(), first)
    }

    /// F_e of four elements at F, and the constants of the law there.
    #[inline(always)]
    fn elastic_of_four(
        &self,
        first: usize,
        f: &Columns<Lanes>,
        states: &FourStates,
    ) -> (Columns<Lanes>, [L::Constants; LANES]) {
        let elastic = three(|k| product(f, &states.inverse[k]));
        let given = self.elastic.constants_of_four(first);
        let constants = lanes(|lane| constants_of(given[lane], states.stiffening.0[lane]));
        (elastic, constants)
    }

    #[inline(always)]
    fn gradient(&self, element: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
        self.elastic.domains.deformation(element, positions)
    }
}

/// ∂P/∂F of P = g P_e(F F_p⁻¹) F_p⁻ᵀ from the tangent of the law: Σ F_p⁻¹_jm T_imkn F_p⁻¹_nl, times g. Of one element or of four.
#[inline(always)]
fn pull_back<N: Number>(tangent: &mut Columns9<N>, inverse: &Columns<N>, stiffening: N) {
    let mut half = [[N::of(0.0); 9]; 9];
    for (half, column) in half.iter_mut().zip(&*tangent) {
        for (j, m) in (0..9).map(|q| (q % 3, q / 3)) {
            let factor = inverse[m][j] * stiffening;
            for i in 0..3 {
                half[i + 3 * j] = column[i + 3 * m].mul_add(factor, half[i + 3 * j]);
            }
        }
    }
    for (k, l) in (0..9).map(|q| (q % 3, q / 3)) {
        let mut column = [N::of(0.0); 9];
        for n in 0..3 {
            for (entry, half) in column.iter_mut().zip(&half[k + 3 * n]) {
                *entry = half.mul_add(inverse[l][n], *entry);
            }
        }
        tangent[k + 3 * l] = column;
    }
}

/// Those of four elements.
///
/// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers.
#[inline(never)]
fn pull_four_back(tangents: &mut FourTangents, states: &FourStates) {
    pull_back(tangents, &states.inverse, states.stiffening);
}

/// The tangents of a [`PlasticSet`].
struct PlasticTangents<'a, L: Law, D> {
    of: &'a PlasticSet<L, D>,
    positions: &'a [Vector3<f64>],
    internal: &'a [f64],
    tangent: Tangent,
    /// Factor of the moduli of viscosity \[s\]; zero without.
    viscous_time: f64,
}

/// Sets the exact tangents of a law.
#[inline(always)]
fn set_exact<L: Law>(
    f: &Columns<Lanes>,
    constants: &[L::Constants; LANES],
    tangents: &mut FourTangents,
) {
    for (lane, constants) in constants.iter().enumerate() {
        put_tangent(tangents, lane, &L::tangent(&matrix_of(f, lane), constants));
    }
}

impl<L: Law, D: Domains> TangentsOfFour for PlasticTangents<'_, L, D> {
    #[inline(always)]
    fn set_tangents(&self, first: usize, tangents: &mut FourTangents) {
        let set = &self.of.elastic;
        let states = self.of.states_of_four(self.internal, first);
        let f = set.domains.deformations_of_four(first, self.positions);
        let (elastic, constants) = self.of.elastic_of_four(first, &f, &states);
        match self.tangent {
            Tangent::Exact => set_exact::<L>(&elastic, &constants, tangents),
            Tangent::Positive => {
                L::set_positive_tangents_of_each(&FourSvds::new(&elastic), &constants, tangents);
            }
        }
        pull_four_back(tangents, &states);
        if self.viscous_time > 0.0 {
            let (lame, families) = set.viscous_moduli(first);
            viscosity::add_tangent(&f, &lame, &families, self.viscous_time, tangents);
        }
    }

    /// δF_e of a node is δx ⊗ F_p⁻ᵀ b: the matrix is that of the law alone for these gradients.
    #[inline(always)]
    fn add_matrices(&self, first: usize, shapes: &FourTetrahedra, matrices: &mut FourMatrices) {
        let set = &self.of.elastic;
        let states = self.of.states_of_four(self.internal, first);
        let f = set.domains.deformations_of_four(first, self.positions);
        let (elastic, constants) = self.of.elastic_of_four(first, &f, &states);
        let pulled = FourTetrahedra {
            gradients: three(|i| transposed_product(&states.inverse, &shapes.gradients[i])),
            volumes: shapes.volumes * states.stiffening,
        };
        match self.tangent {
            Tangent::Exact => {
                let mut tangents = [[Lanes::splat(0.0); 9]; 9];
                set_exact::<L>(&elastic, &constants, &mut tangents);
                matrices.add_tangents(&tangents, &pulled);
            }
            Tangent::Positive => matrices.add_positive::<L>(&elastic, &constants, &pulled),
        }
        if self.viscous_time > 0.0 {
            let (lame, families) = set.viscous_moduli(first);
            matrices.add_viscous(&f, &lame, &families, self.viscous_time, shapes);
        }
    }
}

impl<L: Law, D: Domains> Elements for PlasticSet<L, D> {
    fn kind(&self) -> EnergyKind {
        self.elastic.kind()
    }

    fn count(&self) -> usize {
        self.elastic.count()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        self.elastic.nodes(element)
    }

    /// All elements in each block.
    fn initial_internal(&self) -> Vec<f64> {
        let start = PlasticState::START.blocks();
        let blocks = start.map(|value| std::iter::repeat_n(value, self.count()));
        blocks.into_iter().flatten().collect()
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let mut sum = 0.0;
        for first in (0..self.count()).step_by(LANES) {
            let states = self.states_of_four(at.internal, first);
            let f = self
                .elastic
                .domains
                .deformations_of_four(first, at.positions);
            let (elastic, constants) = self.elastic_of_four(first, &f, &states);
            let densities = states.stiffening * L::energy_of_each(&elastic, &constants);
            for (element, density) in (first..self.count()).zip(densities.0) {
                sum += self.elastic.domains.volume(element) * density;
            }
        }
        sum
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        let domains = &self.elastic.domains;
        for first in (range.start / LANES * LANES..range.end).step_by(LANES) {
            let states = self.states_of_four(at.internal, first);
            let f = domains.deformations_of_four(first, at.positions);
            let (elastic, constants) = self.elastic_of_four(first, &f, &states);
            let elastic = L::stress_of_each(&elastic, &constants);
            // P_e F_p⁻ᵀ.
            let rows = columns(|j, k| states.inverse[k][j] * states.stiffening);
            let mut stress = three(|j| product(&elastic, &rows[j]));
            if self.is_viscous() {
                let rate = domains.deformations_of_four(first, at.velocities);
                let (lame, families) = self.elastic.viscous_moduli(first);
                let time = self.elastic.relaxation_time;
                let viscous = viscosity::stress_of(&f, &rate, &lame, &families, time);
                stress = columns(|k, i| stress[k][i] + viscous[k][i]);
            }
            domains.add_forces_of_four(first, &range, &stress, forces);
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let domains = &self.elastic.domains;
        out.reset(domains.nodes(element).len());
        let state = self.state(at.internal, element);
        let elastic = self.gradient(element, at.positions) * state.inverse;
        let constants = state.constants(self.elastic.constants(element));
        let tangent = match tangent {
            Tangent::Exact => L::tangent(&elastic, &constants),
            Tangent::Positive => L::positive_tangent(&SignedSvd::new(&elastic), &constants),
        };
        let gradient = |corner| domains.gradient(element, corner);
        let mut tangent = tangent.data.0;
        pull_back(&mut tangent, &columns_of(&state.inverse), state.stiffening);
        set_tangent(&tangent.into(), domains.volume(element), gradient, out);
    }

    fn add_tangent(
        &self,
        at: &Configuration<'_>,
        tangent: Tangent,
        damping: f64,
        matrix: &mut MatrixWindow<'_>,
    ) {
        let tangents = PlasticTangents {
            of: self,
            positions: at.positions,
            internal: at.internal,
            tangent,
            viscous_time: damping * self.elastic.relaxation_time,
        };
        self.elastic.add_tangents(&tangents, matrix);
    }

    fn is_viscous(&self) -> bool {
        self.elastic.is_viscous()
    }

    fn damping(&self, element: usize, at: &Configuration<'_>, out: &mut ElementMatrix) {
        self.elastic.damping(element, at, out);
    }

    fn relaxation_time(&self, element: usize) -> f64 {
        self.elastic.relaxation_time(element)
    }

    fn is_natural(&self, element: usize, rest_positions: &[Vector3<f64>]) -> bool {
        self.elastic.is_natural(element, rest_positions)
    }

    fn rest_norms(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        self.elastic.rest_norms(element, rest_positions, out);
    }

    fn rest_traces(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        self.elastic.rest_traces(element, rest_positions, out);
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.elastic.scale(element, factor);
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let mut shifted = self.clone();
        shifted.elastic.domains.shift_nodes(nodes);
        Arc::new(shifted)
    }

    /// Stiffer counts what the factor of the stiffness has grown. What has flowed is also thinner: how far is a matter of its shape, which is looked
    /// at as that of tissue that stretches ([`most_thinning`](Elements::most_thinning)).
    fn flow(&self, positions: &[Vector3<f64>], internal: &mut [f64], h: f64) -> bool {
        let flow = self.plasticity.over(h);
        let mut stiffer = false;
        for element in 0..self.count() {
            let mut state = self.state(internal, element);
            let f = self.gradient(element, positions);
            let flowed = flow.apply::<L>(&f, &self.elastic.constants(element), &mut state);
            if flowed != Flowed::Not {
                state.write(internal, self.count(), element);
            }
            stiffer |= flowed == Flowed::Stiffer;
        }
        stiffer
    }

    fn admits(&self, internal: &[f64]) -> bool {
        (0..self.count()).all(|element| self.state(internal, element).is_possible())
    }

    /// A plastic strain p is at most a compression to e^−p along one axis.
    fn most_thinning(&self) -> f64 {
        libm::exp(self.plasticity.max_strain)
    }

    fn dissipated(&self, internal: &[f64]) -> f64 {
        let energies = (0..self.count()).map(|element| {
            self.elastic.domains.volume(element) * self.state(internal, element).dissipated
        });
        energies.sum()
    }

    fn plastic_state(&self, element: usize, internal: &[f64]) -> Option<PlasticState> {
        Some(self.state(internal, element))
    }

    fn keys(&self, element: usize, visit: &mut dyn FnMut(Key)) {
        self.elastic.keys(element, visit);
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let added = (added as &dyn Any).downcast_ref::<Self>();
        added.is_some_and(|added| self.elastic.splice(removed, &added.elastic))
    }

    fn make_room(&mut self) {
        self.elastic.make_room();
    }

    /// The mean of what has flowed in the ancestors, by their volumes: a part of a tetrahedron has what its parent has, what is around a new
    /// edge or node the mean of what is around those of the elements in which it is.
    fn inherited(&self, added: &dyn Elements, ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        let start = PlasticState::START.blocks();
        let domains = &self.elastic.domains;
        let mut all = Vec::with_capacity(BLOCKS * added.count());
        for (block, start) in start.into_iter().enumerate() {
            let first = (block * self.count()) as u32;
            all.extend(ancestors.iter().map(|from| {
                let volumes = from.iter().map(|&old| domains.volume(old as usize));
                let sum: f64 = volumes.clone().sum();
                let terms = from.iter().zip(volumes);
                Inherited {
                    constant: if from.is_empty() { start } else { 0.0 },
                    terms: terms.map(|(&old, v)| (first + old, v / sum)).collect(),
                }
            }));
        }
        all
    }

    fn blend(&self) -> Blend {
        Blend::PlasticState
    }
}

#[cfg(test)]
mod tests;
