//! How large a step may be.
//!
//! For M x'' + K x = 0 Störmer–Verlet is stable while h·√λ_max < 2, λ_max the largest eigenvalue of M⁻¹K; the exact drag
//! factor does not lower the limit (NUMERICS 3.1). λ_max is that of a shape: of the rest shape, or of a state with its
//! deformation and its internal variables. What the deformation to come adds is covered by the safety factor (NUMERICS 3.1: at
//! 0.6 random offsets of 20 % of a cell stay bounded). Tissue that stiffens further than that as it stretches needs the limit of a
//! [`stretched`] shape, and a look at its own while it runs.

mod limit;
mod local;
mod matrix;
mod remedy;
mod stretched;

pub use limit::{delingette_stiffness, limit};
pub use local::{Remedied, floor_nodes};
pub use remedy::{mass_floor, stiffness_cap};
pub use stretched::{WORKING_STRETCH, stretched};

pub use crate::gershgorin::{Part, gershgorin_bound, gershgorin_bound_at};

use crate::model::TissueModel;
use crate::state::State;
use matrix::BlockMatrix;

/// Recommended fraction of the stability limit (NUMERICS 3.1).
pub const SAFETY: f64 = 0.6;

/// Steps of the power iteration in [`stable_step`]. From 20 on the estimate stays within 3 % of λ_max (NUMERICS 3.2).
const POWER_STEPS: usize = 40;

/// The power iteration approaches λ_max from below; this factor covers what is missing (NUMERICS 3.2).
const POWER_MARGIN: f64 = 1.1;

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

#[cfg(test)]
mod tests;
