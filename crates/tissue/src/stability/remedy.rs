//! What makes a given step stable (NUMERICS 3.5 c and d): more mass, or less stiffness, where a node needs it.
//!
//! Both hold S_i h² + 2 D_i h ≤ 4 s² m_i at every node, S_i of stiffness and D_i of damping, so that h²λ_max + 2hΛ_max ≤ 4 s² by
//! Gershgorin (NUMERICS 3.1).

use super::Part;
use crate::gershgorin::row_sums;
use crate::model::TissueModel;
use crate::state::State;

/// Inertia to be added at each node \[kg\], with which the step `h` \[s\] is stable at the fraction `safety` of the limit:
/// max(0, (S_i h² + 2 D_i h)/(4 s²) − m_i), for [`TissueModel::with_added_inertia`]. It must be reported.
pub fn mass_floor(model: &TissueModel, state: &State, h: f64, safety: f64) -> Vec<f64> {
    let sums = sums(model, state, h);
    let room = 4.0 * safety * safety / (h * h);
    let floor = |(node, mass): (usize, &f64)| match model.is_clamped(node) {
        true => 0.0,
        false => (sums[node] / room - mass).max(0.0),
    };
    model.masses().iter().enumerate().map(floor).collect()
}

/// Factors ≤ 1 of the stiffness of each element, set after set, with which the step `h` \[s\] is stable at the fraction `safety` of
/// the limit: φ_i = min(1, 4 s² m_i/(h² S_i + 2 h D_i)) of a node, the smallest of its free nodes for an element. Masses stay.
pub fn stiffness_cap(model: &TissueModel, state: &State, h: f64, safety: f64) -> Vec<Vec<f64>> {
    let sums = sums(model, state, h);
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

/// S_i + 2 D_i/h of every node \[N/m\].
fn sums(model: &TissueModel, state: &State, h: f64) -> Vec<f64> {
    let mut sums = row_sums(model, state, Part::Stiffness);
    let damping = row_sums(model, state, Part::Damping);
    for (sum, damping) in sums.iter_mut().zip(damping) {
        *sum += 2.0 * damping / h;
    }
    sums
}
