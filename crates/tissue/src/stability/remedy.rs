//! What makes a given step stable (NUMERICS 3.5 c and d): more mass, or less stiffness, where a node needs it.
//!
//! Both hold S_i h² ≤ 4 s² m_i at every node, so that h·√λ_max ≤ 2 s by Gershgorin. Viscosity is not counted.

use super::{Part, row_sums};
use crate::model::TissueModel;
use crate::state::State;

/// Inertia to be added at each node [kg], with which the step `h` [s] is stable at the share `safety` of the limit:
/// max(0, S_i h²/(4 s²) − m_i), for [`TissueModel::with_added_inertia`]. It must be reported.
pub fn mass_floor(model: &TissueModel, state: &State, h: f64, safety: f64) -> Vec<f64> {
    let sums = row_sums(model, state, Part::Stiffness);
    let room = 4.0 * safety * safety / (h * h);
    let floor = |(node, mass): (usize, &f64)| match model.is_clamped(node) {
        true => 0.0,
        false => (sums[node] / room - mass).max(0.0),
    };
    model.masses().iter().enumerate().map(floor).collect()
}

/// Factors ≤ 1 of the stiffness of each element, set after set, with which the step `h` [s] is stable at the share `safety` of
/// the limit: φ_i = min(1, 4 s² m_i/(h² S_i)) of a node, the smallest of its free nodes for an element. Masses stay.
pub fn stiffness_cap(model: &TissueModel, state: &State, h: f64, safety: f64) -> Vec<Vec<f64>> {
    let sums = row_sums(model, state, Part::Stiffness);
    let room = 4.0 * safety * safety / (h * h);
    // A clamped node (w = 0) needs nothing; a node without stiffness neither.
    let factor = |node: u32| match sums[node as usize] * model.inverse_masses()[node as usize] {
        rate if rate > room => room / rate,
        _ => 1.0,
    };
    let of_element = |nodes: &[u32]| nodes.iter().copied().map(factor).fold(1.0, f64::min);
    let sets = model.sets().iter();
    sets.map(|set| (0..set.count()).map(|e| of_element(set.nodes(e))).collect())
        .collect()
}
