//! Plastic flow of a continuum: its constants, what has flowed in an element, and the return mapping of one step.
//!
//! The deformation gradient is divided in F = F_e F_p (Lee 1969; Simo & Hughes 1998, ch. 9): a law sees F_e = F F_p⁻¹, and F_p is the shape
//! that an element has taken for good. Flow has no volume, det F_p = 1. Of F_p only the stretch counts: F_p is symmetric, so that fibres lie in
//! it as they do at rest, and no spin is made up.
//!
//! F is that from the natural state: residual strain counts. A body that would yield by it as it lies cannot be built
//! ([`BuildError::YieldsAtRest`](crate::BuildError::YieldsAtRest)), as its residual stress would be gone after one step.
//!
//! An element yields by its logarithmic elastic strain, whatever its law is: with the principal stretches s_i of F_e and the deviator
//! d_i = ln s_i − ⅓ ln J, the equivalent strain is e = √(2/3) |d| (in uniaxial stretch at constant volume the strain along it). Beyond
//!
//! ```text
//! e_y(p) = yield_strain + yield_growth p
//! ```
//!
//! with the accumulated equivalent plastic strain p, d shrinks along itself (radial return; Simo & Hughes 1998, 9.4): ṗ = r (e − e_y(p)) for
//! the rate r, e = e_y(p) at the end of each step where there is none. For an element that stands still the return is exact for any step:
//!
//! ```text
//! Δp = (e − e_y(p)) (1 − exp(−r (1 + yield_growth) h)) / (1 + yield_growth)     p ≤ max_strain
//! ```
//!
//! What has flowed is stiffer: the isochoric part of the energy, shear stiffness and fibres, grows by the factor g = 1 + β p up to a bound. The
//! volumetric part does not, as flow has no volume; so the discretisations that carry it apart have the same body.
//!
//! Flow dissipates. Its energy density is counted; g grows only as far as the energy does not rise, and what is held back comes with later
//! flow. A flow that would raise the energy does not happen: of a law whose stress falls while the strain grows (strongly compressed
//! St Venant–Kirchhoff), or of fibres that the return would stretch. An element that is flat or inverted has no logarithm and does not flow.

use crate::lanes::{Lanes, lanes};
use crate::law::decomposition::{SignedSvd, symmetric_eigen};
use crate::law::{Constants, Law};
use crate::number::{Columns, columns};
use crate::range::{MaterialError, not_negative, require};
use nalgebra::{Matrix3, Vector3};

/// Constants of the plastic flow of a continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuumPlasticity {
    /// Equivalent elastic strain from which on it flows, ≥ 0.
    pub yield_strain: f64,
    /// Growth of that strain per plastic strain, ≥ 0: isotropic hardening.
    pub yield_growth: f64,
    /// Rate r of the flow \[1/s\], ≥ 0; without it flow takes no time.
    pub creep_rate: Option<f64>,
    /// Largest accumulated equivalent plastic strain, ≥ 0.
    pub max_strain: f64,
    /// Growth β of the isochoric stiffness per plastic strain, ≥ 0.
    pub hardening: f64,
    /// Largest factor of the isochoric stiffness, ≥ 1.
    pub max_stiffening: f64,
}

/// What has flowed in an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticState {
    /// F_p⁻¹: symmetric, with positive eigenvalues and determinant 1.
    pub inverse: Matrix3<f64>,
    /// Accumulated equivalent plastic strain p.
    pub strain: f64,
    /// Factor g ≥ 1 of the isochoric part of the energy.
    pub stiffening: f64,
    /// Energy that flow has dissipated, per volume at rest \[J/m³\].
    pub dissipated: f64,
}

/// The flow of one step.
pub(super) struct ContinuumFlow {
    constants: ContinuumPlasticity,
    /// Fraction of e − e_y(p) that flows.
    fraction: f64,
    /// See [`elastic_bound`], at p = 0.
    first_bound: f64,
}

/// What came of the flow of an element in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flowed {
    /// Nothing.
    Not,
    /// Its shape, at the stiffness of before.
    Shape,
    /// Its shape, and it is stiffer.
    Stiffer,
}

impl ContinuumPlasticity {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        not_negative("yield_strain", self.yield_strain, ">= 0")?;
        not_negative("yield_growth", self.yield_growth, ">= 0")?;
        if let Some(rate) = self.creep_rate {
            not_negative("creep_rate", rate, ">= 0 1/s")?;
        }
        not_negative("max_strain", self.max_strain, ">= 0")?;
        not_negative("hardening", self.hardening, ">= 0")?;
        let most = self.max_stiffening;
        require(
            most.is_finite() && most >= 1.0,
            "max_stiffening",
            most,
            ">= 1",
        )
    }

    /// The flow of a step of `h` \[s\].
    pub(super) fn over(&self, h: f64) -> ContinuumFlow {
        let slope = 1.0 + self.yield_growth;
        let part = self
            .creep_rate
            .map_or(1.0, |rate| -libm::expm1(-rate * slope * h));
        ContinuumFlow {
            constants: *self,
            fraction: part / slope,
            first_bound: elastic_bound(self.yield_strain),
        }
    }
}

/// What the forces of four elements take of their states.
#[derive(Clone, Copy, Debug)]
pub(super) struct FourStates {
    /// F_p⁻¹, by its columns.
    pub inverse: Columns<Lanes>,
    /// g.
    pub stiffening: Lanes,
}

impl FourStates {
    /// Those of four elements from `first` on, as [`PlasticState::read`]; beyond the end those of the last one.
    #[inline(always)]
    pub fn read(internal: &[f64], count: usize, first: usize) -> Self {
        if internal.is_empty() {
            let identity = columns(|k, i| Lanes::splat(f64::from(u8::from(k == i))));
            return Self {
                inverse: identity,
                stiffening: Lanes::splat(1.0),
            };
        }
        let elements = lanes(|lane| (count - 1).min(first + lane));
        let at = |block: usize| {
            let block = &internal[block * count..(block + 1) * count];
            Lanes(lanes(|lane| block[elements[lane]]))
        };
        let [xx, yy, zz, yz, zx, xy] = [at(0), at(1), at(2), at(3), at(4), at(5)];
        Self {
            inverse: [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]],
            stiffening: at(7),
        }
    }
}

/// Constants of a law with which g times energy, stress and tangent is the law whose isochoric part alone is g times as stiff.
#[inline(always)]
pub(super) fn constants_of<C: Constants>(constants: C, stiffening: f64) -> C {
    constants.with_volumetric(1.0 / stiffening)
}

impl PlasticState {
    /// Before any flow.
    pub const START: Self = Self {
        inverse: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        strain: 0.0,
        stiffening: 1.0,
        dissipated: 0.0,
    };

    /// As [`constants_of`].
    #[inline(always)]
    pub(crate) fn constants<C: Constants>(&self, constants: C) -> C {
        constants_of(constants, self.stiffening)
    }

    /// Energy density \[J/m³\] at F_e.
    #[inline(always)]
    pub(super) fn energy<L: Law>(&self, elastic: &Matrix3<f64>, constants: &L::Constants) -> f64 {
        self.stiffening * L::energy(elastic, &self.constants(*constants))
    }

    /// First Piola–Kirchhoff stress \[Pa\] at F: P_e F_p⁻ᵀ.
    #[inline(always)]
    pub(crate) fn stress<L: Law>(
        &self,
        f: &Matrix3<f64>,
        constants: &L::Constants,
    ) -> Matrix3<f64> {
        let stress = L::stress(&(f * self.inverse), &self.constants(*constants));
        stress * self.inverse * self.stiffening
    }
}

/// The cube of the least tr C_e J^(−2/3) of an equivalent strain e, that of uniaxial compression: up to it nothing yields, and no logarithm is
/// needed to see that.
///
/// At a given Σ d_i², Σ d_i = 0, a sum Σ exp(2 d_i) is stationary only where two of the d_i are equal (three different ones cannot solve
/// 2 exp(2 d_i) = α + β d_i, as an exponential meets a line twice at most); of these, extension and compression, the latter is less.
fn elastic_bound(strain: f64) -> f64 {
    let least = libm::exp(-2.0 * strain) + 2.0 * libm::exp(strain);
    least * least * least
}

impl ContinuumFlow {
    /// Lets an element flow at F.
    pub fn apply<L: Law>(
        &self,
        f: &Matrix3<f64>,
        constants: &L::Constants,
        state: &mut PlasticState,
    ) -> Flowed {
        let elastic = f * state.inverse;
        let limit = self.constants.yield_strain + self.constants.yield_growth * state.strain;
        let bound = match limit > self.constants.yield_strain {
            true => elastic_bound(limit),
            false => self.first_bound,
        };
        let (trace, volume) = (elastic.norm_squared(), elastic.determinant());
        if trace * trace * trace <= bound * volume * volume {
            return Flowed::Not;
        }
        match self.returned(&elastic, state, limit) {
            None => Flowed::Not,
            Some(next) => accepted::<L>(f, &elastic, constants, state, next, &self.constants),
        }
    }

    /// F_p⁻¹ and p after the return from F_e beyond an equivalent strain of `limit`; none while it is elastic.
    fn returned(
        &self,
        elastic: &Matrix3<f64>,
        state: &PlasticState,
        limit: f64,
    ) -> Option<(Matrix3<f64>, f64)> {
        let svd = SignedSvd::new(elastic);
        let deviator = deviator(&svd.stretches)?;
        let equivalent = equivalent(&deviator);
        let room = self.constants.max_strain - state.strain;
        let flow = ((equivalent - limit) * self.fraction).min(room);
        if flow <= 0.0 || equivalent <= 0.0 {
            return None;
        }
        // C_p⁻¹ = F_p⁻¹ V exp(−2 Δp d/e) Vᵀ F_p⁻¹, and its root.
        let shrinking = deviator.map(|d| libm::exp(-2.0 * flow / equivalent * d));
        let along = state.inverse * svd.v;
        let square = along * Matrix3::from_diagonal(&shrinking) * along.transpose();
        Some((isochoric_root(&square), state.strain + flow))
    }
}

/// d_i of these principal stretches; none unless all are positive and finite.
fn deviator(stretches: &Vector3<f64>) -> Option<Vector3<f64>> {
    if !stretches.iter().all(|s| *s > 0.0 && s.is_finite()) {
        return None;
    }
    let logs = stretches.map(libm::log);
    Some(logs.add_scalar(-logs.sum() / 3.0))
}

/// e of d.
fn equivalent(deviator: &Vector3<f64>) -> f64 {
    (deviator.norm_squared() * (2.0 / 3.0)).sqrt()
}

/// The equivalent strain e of a deformation gradient; none of one that is flat, inverted or not finite.
pub(crate) fn equivalent_strain(f: &Matrix3<f64>) -> Option<f64> {
    deviator(&SignedSvd::new(f).stretches).map(|deviator| equivalent(&deviator))
}

/// The symmetric root of a symmetric matrix with positive eigenvalues, scaled to determinant 1.
fn isochoric_root(square: &Matrix3<f64>) -> Matrix3<f64> {
    let (values, vectors) = symmetric_eigen(square);
    let root = vectors * Matrix3::from_diagonal(&values.map(f64::sqrt)) * vectors.transpose();
    // Symmetric but for rounding.
    let root = (root + root.transpose()) * 0.5;
    root / libm::cbrt(root.determinant())
}

/// Takes over a flow unless the energy would rise, and stiffens as far as it does not.
fn accepted<L: Law>(
    f: &Matrix3<f64>,
    elastic: &Matrix3<f64>,
    constants: &L::Constants,
    state: &mut PlasticState,
    (inverse, strain): (Matrix3<f64>, f64),
    plasticity: &ContinuumPlasticity,
) -> Flowed {
    let next = f * inverse;
    let freed = state.energy::<L>(elastic, constants) - state.energy::<L>(&next, constants);
    if freed.is_nan() || freed < 0.0 {
        return Flowed::Not;
    }
    state.inverse = inverse;
    state.strain = strain;
    let isochoric = L::energy(&next, &constants.with_volumetric(0.0));
    let before = state.stiffening;
    let mut stiffening = (1.0 + plasticity.hardening * strain).min(plasticity.max_stiffening);
    if isochoric > 0.0 {
        stiffening = stiffening.min(before + freed / isochoric);
    }
    let grown = (stiffening - before).max(0.0);
    state.stiffening = before + grown;
    // All of it may have gone into stiffness, but for rounding.
    state.dissipated += (freed - grown * isochoric).max(0.0);
    match grown > 0.0 {
        true => Flowed::Stiffer,
        false => Flowed::Shape,
    }
}

/// Internal variables of an element: six entries of F_p⁻¹, p, g, dissipated energy density.
pub(crate) const BLOCKS: usize = 9;

/// The entries of a symmetric matrix that are held.
pub(super) const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];

impl PlasticState {
    /// That of an element among the internal variables of `count` elements, of which each has its place in every block; before any flow where
    /// there are none.
    #[inline(always)]
    pub(super) fn read(internal: &[f64], count: usize, element: usize) -> Self {
        if internal.is_empty() {
            return Self::START;
        }
        let at = |block: usize| internal[block * count + element];
        Self {
            inverse: Matrix3::new(
                at(0),
                at(5),
                at(4),
                at(5),
                at(1),
                at(3),
                at(4),
                at(3),
                at(2),
            ),
            strain: at(6),
            stiffening: at(7),
            dissipated: at(8),
        }
    }

    /// Its internal variables, one for each block.
    pub(crate) fn blocks(&self) -> [f64; BLOCKS] {
        let mut blocks = [0.0; BLOCKS];
        for (block, entry) in blocks.iter_mut().zip(ENTRIES) {
            *block = self.inverse[entry];
        }
        blocks[6..].copy_from_slice(&[self.strain, self.stiffening, self.dissipated]);
        blocks
    }

    /// Writes it back.
    pub(super) fn write(&self, internal: &mut [f64], count: usize, element: usize) {
        for (block, value) in self.blocks().into_iter().enumerate() {
            internal[block * count + element] = value;
        }
    }

    /// Whether flow can have come to this: see the fields.
    pub(super) fn is_possible(&self) -> bool {
        let inverse = &self.inverse;
        let minor = inverse[(0, 0)] * inverse[(1, 1)] - inverse[(0, 1)] * inverse[(1, 0)];
        let is_positive = inverse[(0, 0)] > 0.0 && minor > 0.0 && inverse.determinant() > 0.0;
        is_positive
            && self.blocks().iter().all(|value| value.is_finite())
            && self.strain >= 0.0
            && self.stiffening >= 1.0
            && self.dissipated >= 0.0
    }

    /// The state of which these are the internal variables, after means were taken of them: with a determinant of 1 again. A mean of matrices
    /// with positive eigenvalues and a determinant of 1 has positive ones too, and a determinant of 1 or more (Minkowski): nothing but its
    /// size has to be corrected.
    pub(crate) fn of_means(blocks: &[f64; BLOCKS]) -> Self {
        let mut state = Self::read(blocks, 1, 0);
        state.inverse /= libm::cbrt(state.inverse.determinant());
        // A mean of ones is one, but for rounding of its weights.
        state.stiffening = state.stiffening.max(1.0);
        state
    }

    /// The mean of some; none of none.
    pub(crate) fn mean(of: impl Iterator<Item = Self>) -> Option<Self> {
        let (mut sums, mut count) = ([0.0; BLOCKS], 0.0);
        for state in of {
            for (sum, value) in sums.iter_mut().zip(state.blocks()) {
                *sum += value;
            }
            count += 1.0;
        }
        (count > 0.0).then(|| Self::of_means(&sums.map(|sum| sum / count)))
    }
}

#[cfg(test)]
mod tests;
