//! A continuum for position-based methods: the neo-Hookean law as constraints with compliance (after Macklin & Müller 2021).
//!
//! With the square completed ([`NeoHookeanPolynomial`](crate::law::NeoHookeanPolynomial)) the energy of a domain is
//!
//! ```text
//! ½ μV ‖C_D‖² + ½ (λ+μ)V C_H²     C_D = F     C_H = det F − 1 − μ/(λ+μ)
//! ```
//!
//! Macklin & Müller take the norm of F for C_D, one number. At rest its gradient is parallel to that of C_H, so shear at constant
//! volume meets no compliance at all: it is treated explicitly, and the two together either leave the rest shape (one after the
//! other) or diverge with a stiff step (as a 2×2 system). Here C_D is F itself, nine linear constraints of one compliance, and
//! all ten are solved together: the rest shape stays where it is in one projection, and shear is implicit.
//!
//! Viscosity is the dissipation of an implicit Euler step, τV/h (μ ε:ε + λ/2 tr²ε) with ε = sym(F_nᵀ ΔF), F_n at the start of the
//! step: one linear constraint for each entry of ε and one for its trace.
//!
//! All constraints of a domain move its nodes by w_i T b_i with a matrix T, which changes F by T W, W = Σ w_i b_i b_iᵀ: so
//! everything is solved in 3×3 matrices and nodes are touched once.

use super::continuum::ContinuumSet;
use super::domains::Domains;
use crate::law::Law;
use crate::law::decomposition::cofactor;
use nalgebra::{Matrix3, Vector3};

/// Multipliers of C_D and C_H.
pub(super) const ELASTIC: usize = 10;

/// Multipliers of viscosity.
pub(super) const VISCOUS: usize = 7;

impl<L: Law, D: Domains> ContinuumSet<L, D> {
    /// Projects one domain.
    pub(super) fn project_domain(
        &self,
        domain: usize,
        positions: &mut [Vector3<f64>],
        previous: &[Vector3<f64>],
        inverse_masses: &[f64],
        multipliers: &mut [f64],
        h: f64,
    ) {
        let nodes = self.domains.nodes(domain);
        let volume = self.domains.volume(domain);
        let mut mobility = Matrix3::zeros();
        for (i, node) in nodes.iter().enumerate() {
            let b = self.domains.gradient(domain, i);
            mobility += b * b.transpose() * inverse_masses[*node as usize];
        }
        let f = self.domains.deformation(domain, positions);
        let (elastic, viscous) = multipliers.split_at_mut(ELASTIC);
        let mut moves = self.project_elastic(&f, &mobility, volume, elastic, h);
        if !viscous.is_empty() {
            let start = self.domains.deformation(domain, previous);
            let change = f + moves * mobility - start;
            moves += self.project_viscous(&start, change, &mobility, volume, viscous, h);
        }
        for (i, node) in nodes.iter().enumerate() {
            let node = *node as usize;
            positions[node] += moves * self.domains.gradient(domain, i) * inverse_masses[node];
        }
    }

    /// T of C_D and C_H.
    fn project_elastic(
        &self,
        f: &Matrix3<f64>,
        mobility: &Matrix3<f64>,
        volume: f64,
        multipliers: &mut [f64],
        h: f64,
    ) -> Matrix3<f64> {
        let (mu, bulk) = (self.lame.mu, self.lame.lambda + self.lame.mu);
        let (volume_gradient, j) = cofactor(f);
        let volume_compliance = 1.0 / (bulk * volume * h * h);
        let (shape_multipliers, volume_multiplier) = multipliers.split_at_mut(9);
        let volume_rest = j - 1.0 - mu / bulk + volume_compliance * volume_multiplier[0];
        if mu <= 0.0 {
            let resistance = volume_gradient.dot(&(volume_gradient * mobility));
            let change = -volume_rest / (resistance + volume_compliance);
            volume_multiplier[0] += change;
            return volume_gradient * change;
        }
        // With Λ the multipliers of F, g = ∂C_H/∂F, R = F + α_D Λ, r = C_H + α_H λ, T = ΔΛ + g Δλ:
        //   R + T W + α_D ΔΛ = 0        ΔΛ = −(R + g W Δλ)(W + α_D)⁻¹
        //   r + g:(T W) + α_H Δλ = 0    T W = −R N + α_D g N Δλ,  N = W (W + α_D)⁻¹
        let compliance = 1.0 / (mu * volume * h * h);
        let shape = Matrix3::from_column_slice(shape_multipliers);
        let rest = f + shape * compliance;
        // W has no negative eigenvalue and α_D is positive.
        let (adjugate, determinant) = cofactor(&(mobility + Matrix3::identity() * compliance));
        let inverse = adjugate / determinant;
        let share = mobility * inverse;
        let pull = volume_rest - volume_gradient.dot(&(rest * share));
        let resistance = compliance * volume_gradient.dot(&(volume_gradient * share));
        let change = -pull / (resistance + volume_compliance);
        let shape_change = (rest + volume_gradient * mobility * change) * -inverse;
        volume_multiplier[0] += change;
        for (multiplier, change) in shape_multipliers.iter_mut().zip(&shape_change) {
            *multiplier += change;
        }
        shape_change + volume_gradient * change
    }

    /// T of the rates of strain; `change` is ΔF.
    fn project_viscous(
        &self,
        start: &Matrix3<f64>,
        mut change: Matrix3<f64>,
        mobility: &Matrix3<f64>,
        volume: f64,
        multipliers: &mut [f64],
        h: f64,
    ) -> Matrix3<f64> {
        // ½ k C² with k = τV/h · 2μ for a diagonal entry, 4μ for the two equal ones off it, λ for the trace.
        let scale = self.relaxation_time * volume / h;
        let mut moves = Matrix3::zeros();
        let mut project = |gradient: &Matrix3<f64>, stiffness: f64, multiplier: &mut f64| {
            if stiffness <= 0.0 {
                return;
            }
            let compliance = 1.0 / (stiffness * h * h);
            let moved = gradient * mobility;
            let step = -(gradient.dot(&change) + compliance * *multiplier)
                / (gradient.dot(&moved) + compliance);
            *multiplier += step;
            moves += gradient * step;
            change += moved * step;
        };
        let entries = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];
        for ((a, b), multiplier) in entries.into_iter().zip(multipliers.iter_mut()) {
            let mut gradient = Matrix3::zeros();
            for i in 0..3 {
                gradient[(i, b)] += 0.5 * start[(i, a)];
                gradient[(i, a)] += 0.5 * start[(i, b)];
            }
            let factor = if a == b { 2.0 } else { 4.0 };
            project(&gradient, scale * factor * self.lame.mu, multiplier);
        }
        project(start, scale * self.lame.lambda, &mut multipliers[6]);
        moves
    }
}

#[cfg(test)]
mod tests;
