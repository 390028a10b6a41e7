//! The work of a step by the count of its operations: nominal seconds of a core of a usual kind.
//!
//! No clock is read, so the same run has the same work on every machine, and what is bounded by it replays to the bit. The numbers were
//! measured on one core (AMD EPYC, `perf`) with the levels that ship; they are right to a factor of two, which laws and discretisations
//! differ by. Of the augmented Lagrangian method the solutions of linear systems and the steps of its reduced problem count, not its searches.

use crate::model::TissueModel;

/// An operation of the kernels of a factor \[s\].
pub(crate) const OPERATION: f64 = 5e-11;

/// An element in an iteration of Newton's method: its tangent, and forces and energies four times \[s\].
const IMPLICIT: f64 = 1e-6;

/// An element in a step of an explicit method \[s\].
const EXPLICIT: f64 = 2e-8;

fn elements(model: &TissueModel) -> f64 {
    model.sets().iter().map(|set| set.count()).sum::<usize>() as f64
}

/// What the elements take in an iteration of Newton's method \[s\].
pub(crate) fn of_iteration(model: &TissueModel) -> f64 {
    IMPLICIT * elements(model)
}

/// What they take in a step of an explicit method \[s\].
pub(crate) fn of_explicit_step(model: &TissueModel) -> f64 {
    EXPLICIT * elements(model)
}
