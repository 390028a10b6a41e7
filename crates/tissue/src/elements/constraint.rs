//! Sets of elements with the energy ½ k (q − q0)²: springs (q a length), triangles (an area), tetrahedra (a volume).
//!
//! Forces are −(k C + k_d Ċ) g with C = q − q0, g = ∂q/∂x (3.4, 3.8 as corrected in NUMERICS 1.1). The constants here are the
//! plain ones (4.1, 4.2); the normalised form of THMG04 (3.5–3.8) and the volume-scaled form of NUMERICS 1.1 are other forms
//! of them, and are converted when a set is made.

use super::measure::{Area, Length, Measure, Volume};
use super::plasticity::Plasticity;
use super::splice::{Inherited, make_room, splice};
use crate::elements::{
    Configuration, Constraints, ElementMatrix, Elements, EnergyKind, NodeWindow, Tangent,
};
use nalgebra::Vector3;
use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

/// Springs along edges: q is the length.
pub type Springs = ConstraintSet<Length, 2>;
/// Triangles: q is the area.
pub type Areas = ConstraintSet<Area, 3>;
/// Tetrahedra: q is the signed volume.
pub type Volumes = ConstraintSet<Volume, 4>;

/// One element, as it is given to a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint<const N: usize> {
    /// Its nodes.
    pub nodes: [u32; N],
    /// q0 \[m, m² or m³\].
    pub rest: f64,
    /// Plain k \[N/m, N/m³ or N/m⁵\].
    pub stiffness: f64,
    /// Plain k_d \[N·s/m, N·s/m³ or N·s/m⁵\].
    pub damping: f64,
}

/// A set of such elements, as arrays.
#[derive(Clone, Debug)]
pub struct ConstraintSet<M, const N: usize> {
    nodes: Vec<[u32; N]>,
    rest: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    viscous: bool,
    plasticity: Option<Plasticity>,
    measure: std::marker::PhantomData<M>,
}

impl<M: Measure<N>, const N: usize> ConstraintSet<M, N> {
    /// A set of these elements.
    pub fn new(constraints: impl IntoIterator<Item = Constraint<N>>) -> Self {
        let mut set = Self {
            nodes: Vec::new(),
            rest: Vec::new(),
            stiffness: Vec::new(),
            damping: Vec::new(),
            viscous: false,
            plasticity: None,
            measure: std::marker::PhantomData,
        };
        for constraint in constraints {
            set.nodes.push(constraint.nodes);
            set.rest.push(constraint.rest);
            set.stiffness.push(constraint.stiffness);
            set.damping.push(constraint.damping);
            set.viscous |= constraint.damping > 0.0;
        }
        set
    }

    /// The same set with rest values that flow.
    pub fn with_plasticity(mut self, plasticity: Plasticity) -> Self {
        self.plasticity = Some(plasticity);
        self
    }

    /// Rest values q0 at the start.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Plain stiffnesses at the start.
    pub fn stiffnesses(&self) -> &[f64] {
        &self.stiffness
    }

    /// Rest value, stiffness and damping of an element now. Damping grows with the stiffness.
    #[inline]
    fn constants(&self, element: usize, internal: &[f64]) -> (f64, f64, f64) {
        let (rest, stiffness, damping) = (
            self.rest[element],
            self.stiffness[element],
            self.damping[element],
        );
        if internal.is_empty() {
            return (rest, stiffness, damping);
        }
        let factor = internal[self.nodes.len() + element];
        (internal[element], stiffness * factor, damping * factor)
    }

    /// The loop of all forces: what a set does not have costs nothing, and the arrays are walked as slices of one length.
    #[inline]
    fn add<const VISCOUS: bool, const PLASTIC: bool>(
        &self,
        range: Range<usize>,
        at: &Configuration<'_>,
        forces: &mut NodeWindow<'_>,
    ) {
        let nodes = &self.nodes[range.clone()];
        let stiffness = &self.stiffness[range.clone()][..nodes.len()];
        let damping = &self.damping[range.clone()][..nodes.len()];
        let (rest, factors) = match PLASTIC {
            true => at.internal.split_at(self.nodes.len()),
            false => (&self.rest[..], &self.stiffness[..]),
        };
        let rest = &rest[range.clone()][..nodes.len()];
        let factors = &factors[range][..nodes.len()];
        for element in 0..nodes.len() {
            let nodes = &nodes[element];
            let (value, g) = M::gradient(nodes.map(|node| &at.positions[node as usize]));
            let mut pull = stiffness[element] * (value - rest[element]);
            if VISCOUS {
                pull += damping[element] * rate(nodes, &g, at.velocities);
            }
            if PLASTIC {
                pull *= factors[element];
            }
            for (node, g) in nodes.iter().zip(&g) {
                forces.add(*node, g * -pull);
            }
        }
    }

    #[inline]
    fn corners<'a>(&self, element: usize, positions: &'a [Vector3<f64>]) -> [&'a Vector3<f64>; N] {
        self.nodes[element].map(|node| &positions[node as usize])
    }
}

impl<M: Measure<N>, const N: usize> Elements for ConstraintSet<M, N> {
    fn kind(&self) -> EnergyKind {
        M::KIND
    }

    fn count(&self) -> usize {
        self.nodes.len()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        &self.nodes[element]
    }

    /// Rest values, then factors of the stiffness.
    fn initial_internal(&self) -> Vec<f64> {
        match self.plasticity {
            None => Vec::new(),
            Some(_) => {
                let factors = std::iter::repeat_n(1.0, self.rest.len());
                self.rest.iter().copied().chain(factors).collect()
            }
        }
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let energies = (0..self.nodes.len()).map(|element| {
            let (rest, stiffness, _) = self.constants(element, at.internal);
            let c = M::value(self.corners(element, at.positions)) - rest;
            0.5 * stiffness * c * c
        });
        energies.sum()
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        match (self.viscous, !at.internal.is_empty()) {
            (false, false) => self.add::<false, false>(range, at, forces),
            (true, false) => self.add::<true, false>(range, at, forces),
            (false, true) => self.add::<false, true>(range, at, forces),
            (true, true) => self.add::<true, true>(range, at, forces),
        }
    }

    fn stiffness(
        &self,
        element: usize,
        at: &Configuration<'_>,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        out.reset(N);
        let (rest, stiffness, _) = self.constants(element, at.internal);
        let corners = self.corners(element, at.positions);
        let (value, g) = M::gradient(corners);
        out.add_outer(&g, stiffness);
        M::add_curvature(corners, stiffness * (value - rest), tangent, out);
    }

    fn is_viscous(&self) -> bool {
        self.viscous
    }

    fn damping(&self, element: usize, at: &Configuration<'_>, out: &mut ElementMatrix) {
        out.reset(N);
        let (_, _, damping) = self.constants(element, at.internal);
        let (_, g) = M::gradient(self.corners(element, at.positions));
        out.add_outer(&g, damping);
    }

    fn relaxation_time(&self, element: usize) -> f64 {
        match self.stiffness[element] {
            stiffness if stiffness > 0.0 => self.damping[element] / stiffness,
            _ => 0.0,
        }
    }

    /// k |g_i| |g_j|.
    fn rest_norms(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        let (_, g) = M::gradient(self.corners(element, rest_positions));
        let sizes = g.map(|g| g.norm());
        out.clear();
        for a in &sizes {
            out.extend(sizes.iter().map(|b| self.stiffness[element] * a * b));
        }
    }

    /// k |g_i|².
    fn rest_traces(&self, element: usize, rest_positions: &[Vector3<f64>], out: &mut Vec<f64>) {
        let (_, g) = M::gradient(self.corners(element, rest_positions));
        out.clear();
        out.extend(g.iter().map(|g| self.stiffness[element] * g.norm_squared()));
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.stiffness[element] *= factor;
        self.damping[element] *= factor;
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let mut shifted = self.clone();
        shifted.nodes.iter_mut().flatten().for_each(|n| *n += nodes);
        Arc::new(shifted)
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let Some(added) = (added as &dyn Any).downcast_ref::<Self>() else {
            return false;
        };
        splice(&mut self.nodes, removed, &added.nodes);
        splice(&mut self.rest, removed, &added.rest);
        splice(&mut self.stiffness, removed, &added.stiffness);
        splice(&mut self.damping, removed, &added.damping);
        self.viscous |= added.viscous;
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.nodes);
        make_room(&mut self.rest);
        make_room(&mut self.stiffness);
        make_room(&mut self.damping);
    }

    /// The mean plastic stretch of rest values, and the mean factor of the stiffness, of the ancestors: a part of an edge has its part
    /// of the rest length, a part of a tetrahedron its part of the rest volume (NUMERICS 1.4).
    fn inherited(&self, added: &dyn Elements, ancestors: &[Vec<u32>]) -> Vec<Inherited> {
        let added = (added as &dyn Any).downcast_ref::<Self>();
        let (Some(_), Some(added)) = (self.plasticity, added) else {
            return Vec::new();
        };
        let rest = added.rest.iter().zip(ancestors).map(|(&rest, from)| {
            let share = rest / from.len() as f64;
            let stretch = |&old: &u32| (old, share / self.rest[old as usize]);
            Inherited {
                constant: if from.is_empty() { rest } else { 0.0 },
                terms: from.iter().map(stretch).collect(),
            }
        });
        let first = self.rest.len() as u32;
        let factors = ancestors.iter().map(|from| {
            let share = 1.0 / from.len() as f64;
            Inherited {
                constant: if from.is_empty() { 1.0 } else { 0.0 },
                terms: from.iter().map(|&old| (first + old, share)).collect(),
            }
        });
        rest.chain(factors).collect()
    }

    fn flow(&self, positions: &[Vector3<f64>], internal: &mut [f64], h: f64) -> bool {
        let Some(plasticity) = &self.plasticity else {
            return false;
        };
        let flow = plasticity.over(M::EXPONENT, h);
        let (rest_values, factors) = internal.split_at_mut(self.nodes.len());
        let mut stiffer = false;
        for (element, (rest, factor)) in rest_values.iter_mut().zip(factors).enumerate() {
            let value = M::value(self.corners(element, positions));
            stiffer |= flow.apply(value, self.rest[element], rest, factor);
        }
        stiffer
    }

    fn constraints(&self) -> Option<&dyn Constraints> {
        Some(self)
    }
}

impl<M: Measure<N>, const N: usize> Constraints for ConstraintSet<M, N> {
    fn multipliers(&self) -> usize {
        1
    }

    /// One constraint C = q − q0 with compliance 1/k and, for damping, γ = k_d/(k h) (Macklin et al. 2016, eq. 26), times k h², so
    /// that it holds for damping alone too (k = 0).
    fn project(
        &self,
        element: usize,
        positions: &mut [Vector3<f64>],
        previous: &[Vector3<f64>],
        inverse_masses: &[f64],
        internal: &[f64],
        multipliers: &mut [f64],
        h: f64,
    ) {
        let (rest, stiffness, damping) = self.constants(element, internal);
        if stiffness <= 0.0 && damping <= 0.0 {
            return;
        }
        let nodes = &self.nodes[element];
        let (value, g) = M::gradient(self.corners(element, positions));
        let (elastic, viscous) = (stiffness * h * h, damping * h);
        let (mut resistance, mut motion) = (0.0, 0.0);
        for (node, g) in nodes.iter().zip(&g) {
            let node = *node as usize;
            resistance += inverse_masses[node] * g.norm_squared();
            motion += g.dot(&(positions[node] - previous[node]));
        }
        let change = (elastic * (rest - value) - viscous * motion - multipliers[0])
            / ((elastic + viscous) * resistance + 1.0);
        multipliers[0] += change;
        for (node, g) in nodes.iter().zip(&g) {
            positions[*node as usize] += g * (inverse_masses[*node as usize] * change);
        }
    }
}

/// Ċ = Σ g·v.
#[inline]
fn rate<const N: usize>(
    nodes: &[u32; N],
    g: &[Vector3<f64>; N],
    velocities: &[Vector3<f64>],
) -> f64 {
    let mut rate = 0.0;
    for (node, g) in nodes.iter().zip(g) {
        rate += g.dot(&velocities[*node as usize]);
    }
    rate
}

#[cfg(test)]
mod tests;
