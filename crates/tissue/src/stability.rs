//! How large a step may be.
//!
//! For M x'' + K x = 0 Störmer–Verlet is stable while h·√λ_max < 2, λ_max the largest eigenvalue of M⁻¹K; the exact drag
//! factor does not lower the limit (NUMERICS 3.1). λ_max is that of a shape: of the rest shape, or of a state with its
//! deformation and its internal variables. What the deformation to come adds is covered by the safety factor (NUMERICS 3.1: at
//! 0.6 random offsets of 20 % of a cell stay bounded).

mod limit;
mod local;
mod matrix;
mod remedy;
mod rows;

pub use limit::{delingette_stiffness, limit};
pub use local::{Remedied, floor_nodes};
pub use remedy::{mass_floor, stiffness_cap};
pub(crate) use rows::RowSums;

use crate::elements::{Configuration, ElementMatrix, Tangent};
use crate::model::TissueModel;
use crate::state::State;
use matrix::BlockMatrix;
use nalgebra::Vector3;

/// Recommended fraction of the stability limit (NUMERICS 3.1).
pub const SAFETY: f64 = 0.6;

/// Steps of the power iteration in [`stable_step`]. From 20 on the estimate stays within 3 % of λ_max (NUMERICS 3.2).
const POWER_STEPS: usize = 40;

/// The power iteration approaches λ_max from below; this factor covers what is missing (NUMERICS 3.2).
const POWER_MARGIN: f64 = 1.1;

/// Which matrix of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The stiffness K.
    Stiffness,
    /// The damping matrix D of Kelvin–Voigt viscosity.
    Damping,
}

/// Upper bound of the largest eigenvalue of M⁻¹K \[1/s²\] or M⁻¹D \[1/s\] at rest: the largest over the free nodes of S_i/m_i,
/// S_i = Σ_e Σ_j ‖K^e_ij‖ (Frobenius). For an element ½ k C² the terms are k |g_i| |g_j|: this is (G) of NUMERICS 3.2.
/// Clamped nodes do not move: they have no row and no column.
pub fn gershgorin_bound(model: &TissueModel, part: Part) -> f64 {
    gershgorin_bound_at(model, &State::at_rest(model), part)
}

/// [`gershgorin_bound`] at the positions and internal variables of `state`; it bounds the sizes of negative eigenvalues too.
pub fn gershgorin_bound_at(model: &TissueModel, state: &State, part: Part) -> f64 {
    let sums = row_sums(model, state, part);
    let bounds = sums.iter().zip(model.inverse_masses()).map(|(s, w)| s * w);
    bounds.fold(0.0, f64::max)
}

/// Largest eigenvalue of M⁻¹K \[1/s²\] or M⁻¹D \[1/s\] at rest by `steps` steps of power iteration, from below.
pub fn power_iteration(model: &TissueModel, part: Part, steps: usize) -> f64 {
    power_iteration_at(model, &State::at_rest(model), part, steps)
}

/// [`power_iteration`] at the positions and internal variables of `state`; the eigenvalue of the largest size, as a size: under
/// compression it can be a negative one.
pub fn power_iteration_at(model: &TissueModel, state: &State, part: Part, steps: usize) -> f64 {
    BlockMatrix::new(model, state, part).largest_eigenvalue(model.inverse_masses(), steps)
}

/// The longest step \[s\] at the fraction `safety` of the stability limit of explicit methods that take viscous forces from a known
/// velocity: h²λ + 2hΛ = 4·safety² (NUMERICS 3.1, q < 4 − 2δ), λ and Λ of stiffness and damping the smaller of the Gershgorin
/// bound and the estimate by power iteration with its margin. Infinite for a body without stiffness or without a free node.
/// It does not hold for explicit Euler ([`limit`]). Up to `safety` = √½ it does for the lagged Verlet, and for velocity Verlet with
/// viscous forces, whose limit is q = 4 − 4δ.
pub fn stable_step(model: &TissueModel, safety: f64) -> f64 {
    stable_step_at(model, &State::at_rest(model), safety)
}

/// [`stable_step`] at the positions and internal variables of `state`: the check to repeat when a stiffness has grown.
pub fn stable_step_at(model: &TissueModel, state: &State, safety: f64) -> f64 {
    let largest = |part| {
        let estimate = POWER_MARGIN * power_iteration_at(model, state, part, POWER_STEPS);
        gershgorin_bound_at(model, state, part).min(estimate)
    };
    let viscous = model.sets().iter().any(|set| set.is_viscous());
    let damping = if viscous { largest(Part::Damping) } else { 0.0 };
    let stiffness = largest(Part::Stiffness);
    // The positive root, in the form that does not cancel.
    let room = 4.0 * safety * safety;
    room / (damping + (damping * damping + room * stiffness).sqrt())
}

/// S_i of every node \[N/m or N·s/m\].
fn row_sums(model: &TissueModel, state: &State, part: Part) -> Vec<f64> {
    let w = model.inverse_masses();
    let mut sums = vec![0.0; model.node_count()];
    each_matrix(model, state, part, |nodes, matrix| {
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                if w[column as usize] > 0.0 {
                    sums[row as usize] += matrix.block(i, j).norm();
                }
            }
        }
    });
    sums
}

/// Calls `visit` with nodes and matrix of every element, set after set in ascending order.
fn each_matrix(
    model: &TissueModel,
    state: &State,
    part: Part,
    mut visit: impl FnMut(&[u32], &ElementMatrix),
) {
    let still = vec![Vector3::zeros(); model.node_count()];
    let mut matrix = ElementMatrix::new();
    for (index, set) in model.sets().iter().enumerate() {
        if part == Part::Damping && !set.is_viscous() {
            continue;
        }
        let at = Configuration {
            velocities: &still,
            ..state.configuration(model, index)
        };
        for element in 0..set.count() {
            match part {
                Part::Stiffness => set.stiffness(element, &at, Tangent::Exact, &mut matrix),
                Part::Damping => set.damping(element, &at, &mut matrix),
            }
            visit(set.nodes(element), &matrix);
        }
    }
}

#[cfg(test)]
mod tests;
